//! Slow independent oracles, for tests.
