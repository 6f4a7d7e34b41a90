//! `[[surface]]`, `[[pane]]`, `[boundary]`.
//!
//! | module | contents |
//! |---|---|
//! | `surface`, `pane`, `boundary` | the sections |
//! | `tube` | tubes about a line |
//! | `white_walls` | the warning about walls that absorb nothing |

pub(crate) mod boundary;
pub(crate) mod pane;
pub(crate) mod surface;
pub(crate) mod tube;
pub(crate) mod white_walls;
