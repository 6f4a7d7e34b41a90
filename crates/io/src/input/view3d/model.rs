//! The contents of an input file of View3D.

use zonal_math::Vec3;

/// An input file of View3D.
#[derive(Clone, Debug, PartialEq)]
pub struct View3dFile {
    /// The last title; empty without one.
    pub title: String,
    /// The controls, with View3D's defaults.
    pub controls: View3dControls,
    /// All surfaces in the order of their numbers, obstructions last; lengths in the file's unit (m).
    pub surfaces: Vec<View3dSurface>,
    /// What was replaced or ignored.
    pub notes: Vec<String>,
}

/// Controls of View3D that concern its results. Those of its method of integration (`maxU`, `maxO`, `minO`, `list`, `prjD`, `maxV`) are checked only.
#[derive(Clone, Debug, PartialEq)]
pub struct View3dControls {
    /// `out`: format of the results.
    pub output: View3dOutput,
    /// `encl`: the surfaces form an enclosure, and every row sums to 1.
    pub enclosure: bool,
    /// `emit`: the factors include reflections between grey surfaces (script F).
    pub emittances: bool,
    /// `eps`: View3D's criterion of convergence, above 0.
    pub eps: f64,
    /// `maxD` of uDALES's version: factors beyond this distance between surfaces are left out; in the file's unit, above 0.
    pub max_distance: Option<f64>,
    /// `row`: the only row wanted, as an index of a surface.
    pub row: Option<usize>,
    /// `col`: the only column wanted, as an index of a surface.
    pub column: Option<usize>,
}

impl Default for View3dControls {
    fn default() -> View3dControls {
        View3dControls {
            output: View3dOutput::Text,
            enclosure: false,
            emittances: false,
            eps: 1e-4,
            max_distance: None,
            row: None,
            column: None,
        }
    }
}

/// Format of View3D's results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View3dOutput {
    /// `out = 0`: all factors as text.
    Text,
    /// `out = 1`: all factors in single precision.
    Binary,
    /// `out = 2` of uDALES's version: factors above zero as text.
    SparseText,
}

/// A surface of View3D.
#[derive(Clone, Debug, PartialEq)]
pub struct View3dSurface {
    /// Three or four, plane, convex, counter-clockwise from the front; in the file's unit (m).
    pub corners: Vec<Vec3>,
    /// Its part in the exchange.
    pub kind: View3dSurfaceKind,
    /// Index of the surface in whose plane it lies: a part of it where it radiates; turned away from it where it is a mask or null.
    pub base: Option<usize>,
    /// Index of the earlier surface with which its results are combined.
    pub combined_with: Option<usize>,
    /// From 0.001 to 0.999, as in View3D; 0.999 for obstructions, which have none.
    pub emissivity: f64,
    /// Its name; its number where the file has none.
    pub name: String,
}

/// The part of a surface in the exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View3dSurfaceKind {
    /// `S`: it has view factors.
    Radiating,
    /// `O`: it blocks views and has no factors.
    Obstruction,
    /// `M`: it covers a part of its base.
    Mask,
    /// `N`: it removes a part of its base.
    Null,
}
