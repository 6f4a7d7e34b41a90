//! The methods of the 1996 paper (Arquès and Michelin), one module each, with error bounds and corrections, for comparison with exact factors.
//!
//! | module | what | zones | e^{−κr} | grade |
//! |---|---|---|---|---|
//! | [`point`] | formula (3): the kernel at the centres | any aligned pair | inside | proved |
//! | [`gauss_6d`] | the paper's baseline: Gauss–Legendre in all directions of both zones | any aligned pair apart | inside | proved |
//! | [`hemicube`] | the hemi-cube of Rushmeier and Torrance | a patch and any plate or box | inside, by pixels | estimated |
//! | [`proposition1`] | the transmittance at the centres times the geometric factor, corrected by −κℓ C(u) | any aligned pair; sharp for two voxels | outside, bounded | proved |
//! | [`gegenbauer_series`], [`voxel_strips`] | Proposition 2 and the algorithm `Formfact` | a voxel and a voxel grid | outside | proved |
//! | [`patch_strips`] | the same for patches, λ = 3/2 and 2 | rows of zones in front of a patch | outside | proved |
//! | [`chebyshev`] | interpolation in place of Taylor | lattices of zones | inside | proved |
//!
//! **Attenuation outside the series.** Proposition 2 uses the generating function of the Gegenbauer polynomials: 1/(1 − 2p cosθ + p²)^λ is algebraic, and
//! its Taylor coefficients obey a recurrence of three terms with bounded solutions, hence its speed and its exact remainder. e^{−κr} with
//! r = √(r₀² − 2sr₀cosθ + s²) satisfies a linear differential equation in s only of second order with an apparent singularity where t_e + s = 0,
//! so a recurrence for it divides by the cosine and has no closed remainder. The strip function is still
//! analytic: [`chebyshev`] interpolates it with the attenuation inside and an ellipse bound; [`proposition1`] serves thin media.

pub mod chebyshev;
mod clipped_pair;
pub mod gauss_6d;
pub mod gegenbauer_series;
pub mod hemicube;
pub mod mean_inverse_distance;
pub mod patch_strips;
pub mod point;
pub mod proposition1;
mod rounding;
mod strip_plan;
mod tensor_nodes;
mod trapezoid_gauss;
mod uniform_grid;
mod voxel_formula;
pub mod voxel_strips;

pub use voxel_formula::VoxelFormula;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::vec3;
use zonal_scene::Plate;

/// Returns the geometric factor of two aligned zones by one of the paper's methods, for extinction `kappa` (1/m).
///
/// [`Method::Point`], [`Method::SixGauss`], [`Method::Proposition1`], [`Method::Series`], [`Method::Chebyshev`], [`Method::HemiCube`] (where one of the zones
/// is a patch; its radius is estimated); any other method, and a hemi-cube without a patch, returns the exact
/// integral of [`zonal_exchange::aligned`]. The radius is proved and exceeds the request where the method cannot meet it. `Series` uses the
/// neighbour of `b` one extent farther off as reference and e^{−κd} outside the series, with the neglected part inside the radius; it returns
/// the exact integral where no reference is admissible. The modules hold the methods for many zones at once.
///
/// # Panics
/// On invalid boxes, a negative extinction, a tolerance that is not positive.
pub fn factor(method: Method, a: &Cuboid, b: &Cuboid, kappa: f64, demand: &AccuracyRequest) -> Factor {
    match method {
        Method::Point => point::factor(a, b, kappa),
        Method::SixGauss => gauss_6d::factor(a, b, kappa, demand),
        Method::Proposition1 => proposition1::factor(a, b, kappa, demand),
        Method::Series => patch_strips::pair_by_series(a, b, kappa, demand),
        Method::Chebyshev => chebyshev::pair_by_interpolation(a, b, kappa, demand),
        Method::HemiCube => hemicube_factor(a, b, kappa, demand),
        _ => geometric_factor(a, b, kappa, demand.tolerance),
    }
}

/// The hemi-cube factor of a pair with a patch.
fn hemicube_factor(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &AccuracyRequest) -> Factor {
    assert!(a.is_valid() && b.is_valid(), "not a box or rectangle: {a:?}, {b:?}");
    let target = |c: &Cuboid| {
        plate(c).map_or(hemicube::HemicubeTarget::Cuboid(c.lo, c.hi), hemicube::HemicubeTarget::Plate)
    };
    match (plate(a), plate(b)) {
        (Some(p), _) => hemicube::pair_factor(&p, &target(b), kappa, demand),
        (_, Some(p)) => hemicube::pair_factor(&p, &target(a), kappa, demand),
        _ => geometric_factor(a, b, kappa, demand.tolerance),
    }
}

/// Converts a patch to a plate with the same front.
fn plate(c: &Cuboid) -> Option<Plate> {
    let (axis, sign) = c.normal?;
    let edge = |k: usize| {
        let mut e = [0.0; 3];
        e[k] = c.extent()[k];
        vec3(e[0], e[1], e[2])
    };
    let plate = Plate::parallelogram(c.lo, edge((axis + 1) % 3), edge((axis + 2) % 3));
    Some(if sign > 0 { plate } else { plate.flipped() })
}
