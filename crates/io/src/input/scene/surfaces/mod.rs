//! `[[surface]]`, `[[pane]]`, `[boundary]`: inline shapes, and what they enclose.
//!
//! | module | contents |
//! |---|---|
//! | `surface`, `pane`, `boundary` | the sections |
//! | `shapes`, `tube` | inline geometry |
//! | `region`, `interior` | media that surfaces enclose |
//! | `white_walls` | the warning about walls that absorb nothing |

pub(crate) mod boundary;
pub(crate) mod interior;
pub(crate) mod pane;
pub(crate) mod region;
pub(crate) mod shapes;
pub(crate) mod surface;
pub(crate) mod tube;
pub(crate) mod white_walls;
