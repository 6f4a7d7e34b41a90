//! Radiative exchange between surfaces and participating media by the zonal method.
//!
//! A scene is cut into zones (patches of surfaces, voxels of the medium), the exchange area of every pair of zones is computed with an error bound, and
//! one linear system gives the radiosity of all zones. The solution does not depend on a view. It serves thermal engineers (heat fluxes,
//! temperatures and exchange areas with errors) and pictures of light in smoke, dust and glass.
//!
//! ```
//! use zonal::prelude::*;
//!
//! fn main() -> Result<(), Error> {
//!     // A room of 4 x 3 x 2.5 m with a lamp under its ceiling and thin smoke.
//!     let (min, max) = ([0.0; 3], [4.0, 3.0, 2.5]);
//!     let lamp = Mesh::rectangle([1.8, 1.3, 2.4], [0.0, 0.4, 0.0], [0.4, 0.0, 0.0]);
//!     let scene = Scene::builder()
//!         .surface(Mesh::room(min, max).name("walls").reflectance(0.5).patch_size(1.0))
//!         .surface(lamp.name("lamp").emission(500.0).sides(Sides::Front))
//!         .medium(Medium::grid(min, max, [4, 3, 3]).extinction(0.1).albedo(0.9))
//!         .build()?; // validated once; an error names the part
//!     let solution = Solver::new(&scene).tolerance(0.05).solve()?;
//!     for row in solution.surfaces() {
//!         println!("{}: {:.1} ± {:.1} W", row.name, row.net_power, row.exchange_error);
//!     }
//!     let walls = solution.surface("walls").ok_or("no walls").unwrap();
//!     assert!(walls.net_power < 0.0 && walls.exchange_error < 0.2 * walls.net_power.abs());
//!     Ok(())
//! }
//! ```
//!
//! | module or type | content |
//! |---|---|
//! | [`prelude`] | everything that most programs need |
//! | [`Scene::builder`](prelude::SceneBuilder) | scenes from arrays: [`Mesh`](prelude::Mesh), [`Medium`](prelude::Medium), [`Sun`](prelude::Sun), … |
//! | [`Solver`] | tolerance, engine, memory limit, checkpoint, progress |
//! | [`Solution`] | radiosity, irradiance, fluence and their errors on all zones; [results by name](prelude::SurfaceResult); the report |
//! | [`ExchangeAreas`](prelude::ExchangeAreas) | direct and total exchange areas with error radii |
//! | [`StateSolver`](prelude::StateSolver) | thermal states of one geometry for other temperatures, powers and emissivities |
//! | [`relight()`] | other strengths of the lights, without another solve |
//! | [`render`] | pictures |
//! | [`io`] | scenes from TOML files; solutions as npz, CSV, VTK; pictures as PNG and EXR |
//! | [`Error`] | one error type with predicates |
//!
//! Units: metres; 1/m for extinction; W/m² for radiosity, irradiance, fluence and emission; W/(m² sr) for radiance; W/m³ for sources; kelvin.
//!
//! Results are identical to the bit for any number of threads. The command `zonal` is the crate `zonal-cli`; the manual explains scenes, theory and
//! accuracy.

mod solver;

pub use solver::{Bytes, Solver};
pub use zonal_io::Error;

use zonal_scene::{Bands, Solution};

/// Everything that most programs need.
pub mod prelude {
    pub use crate::{Bytes, Error, Solver};
    pub use zonal_render::{Image, RenderOptions};
    pub use zonal_scene::{
        Band, BandFractions, Bands, Camera, Engine, GlassPane, LightGrouping, Medium, Mesh, NoProgress,
        PatchRule, Progress, Scene, SceneBuilder, Sides, Sky, Solution, SolveOptions, SolveStatus, Sun,
        SurfaceResult, ThermalCondition, VoxelValues, ZoneBasis,
    };
    pub use zonal_solve::areas::exchange_areas::{ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas};
    pub use zonal_solve::state::{ExchangeData, StatePart, StateSolver, ThermalState};
}

/// Scales the light groups of a solution by factors, in all bands; no equation is solved.
///
/// # Errors
/// If the solution has no group of a name.
///
/// ```
/// use zonal::prelude::*;
/// # let lamp = Mesh::rectangle([0.4, 0.4, 0.9], [0.0, 0.2, 0.0], [0.2, 0.0, 0.0]);
/// # let scene = Scene::builder()
/// #     .surface(Mesh::room([0.0; 3], [1.0; 3]).name("walls").patch_size(0.5))
/// #     .surface(lamp.name("lamp").emission(100.0).sides(Sides::Front)).build()?;
/// let bright = Solver::new(&scene).solve()?;
/// let dim = zonal::relight(bright.clone(), &[("lamp", 0.5)])?;
/// let absorbed = |s: &Solution| s.surface("walls").unwrap().absorbed.mean();
/// assert!((absorbed(&dim) - 0.5 * absorbed(&bright)).abs() < 1e-6 * absorbed(&bright));
/// # Ok::<(), Error>(())
/// ```
pub fn relight(solution: Solution, factors: &[(&str, f64)]) -> Result<Solution, Error> {
    let factors: Vec<_> = factors.iter().map(|(name, f)| (name.to_string(), Bands::splat(*f))).collect();
    let mut solution = zonal_solve::relight::relight(solution, &factors)?;
    solution.scene_hash = zonal_io::output::scene_hash(&solution.scene);
    Ok(solution)
}

/// Pictures of a solution.
pub mod render {
    pub use zonal_render::{bloom, render};
}

/// Files: scenes in, solutions and pictures out. A file is written beside its target and renamed when it is complete.
///
/// ```
/// use zonal::prelude::*;
/// # let scene = Scene::builder().surface(Mesh::room([0.0; 3], [1.0; 3]).emission(1.0).patch_size(1.0)).build()?;
/// let solution = Solver::new(&scene).solve()?;
/// let path = std::env::temp_dir().join(format!("zonal-doctest-{}.npz", std::process::id()));
/// zonal::io::write_npz(&path, &solution)?;
/// assert_eq!(zonal::io::read_npz(&path)?.fields.radiosity, solution.fields.radiosity);
/// # std::fs::remove_file(path).unwrap();
/// # Ok::<(), Error>(())
/// ```
pub mod io {
    pub use zonal_io::input::read_scene;
    pub use zonal_io::output::{read_solution as read_npz, write_solution as write_npz};
    pub use zonal_io::output::{write_vti, write_vtu, write_zones_csv as write_csv};

    use crate::Error;
    use std::path::Path;
    use zonal_io::output::{self, ToneMapping};
    use zonal_render::Image;

    /// Writes a picture as PNG, with automatic exposure and the filmic tone curve.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_png(path: impl AsRef<Path>, image: &Image) -> Result<(), Error> {
        let tone = ToneMapping::filmic(output::auto_exposure(&image.pixels));
        Ok(output::write_png(path.as_ref(), image.width, image.height, &image.pixels, &tone)?)
    }

    /// Writes the radiance of a picture as OpenEXR, W/(m² sr), in single precision.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_exr(path: impl AsRef<Path>, image: &Image) -> Result<(), Error> {
        Ok(output::write_exr(path.as_ref(), image.width, image.height, &image.pixels)?)
    }
}
