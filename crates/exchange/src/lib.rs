//! Exchange areas of pairs of zones.
