//! Input files of View3D (`.vs3`): surfaces, obstructions and controls of a calculation of view factors.
//!
//! | line | contents |
//! |---|---|
//! | `T` | title |
//! | `C` | controls, `word = value` |
//! | `F 3`, `F 3a` | form of the surfaces: by vertices, or by origin, azimuth and tilt |
//! | `V` | number and coordinates of a vertex |
//! | `S`, `M`, `N`, `O` | radiating surface, mask, null surface, obstruction |
//! | `E`, `*` | end |
//! | `!`, `/` | comment, also at the end of a line |
//!
//! Lines are read one by one; letters and words have any case. The checks are those of View3D: numbers in sequence, obstructions last, plane and convex
//! surfaces, bases and combinations. Beyond them every number is finite, a mask has a base, and a rectangle has positive sides. The format of uDALES's
//! version of View3D is read too (`out = 2`, `maxD`).
//!
//! | module | contents |
//! |---|---|
//! | `model` | the contents of a file |
//! | `read` | the lines of a file |
//! | `fields` | the words of a line |
//! | `controls` | `C` lines |
//! | `surface_lines` | `V`, `S`, `M`, `N`, `O` lines of both forms |
//! | `checks` | planes, convexity, bases and combinations |
//!
//! Reference: G. N. Walton, Calculation of Obstructed View Factors by Adaptive Integration, NISTIR 6925 (2002); the manual of View3D 4.

mod checks;
mod controls;
mod fields;
mod model;
mod read;
mod surface_lines;

pub use model::{View3dControls, View3dFile, View3dOutput, View3dSurface, View3dSurfaceKind};
pub use read::{read_view3d, read_view3d_from_bytes};
