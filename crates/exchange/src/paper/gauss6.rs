//! The integration that the paper measures against: Gauss–Legendre in every direction of both zones.
