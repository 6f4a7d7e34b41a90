//! Every method of the paper (Arquès and Michelin), one file each, restated and corrected.
//!
//! | module | what | zones | e^{−κr} | grade |
//! |---|---|---|---|---|
//! | [`point`] | formula (3): the kernel at the centres | any aligned pair | inside | proved |
//! | [`gauss6`] | the integration that the paper measures against: all directions of both zones | any aligned pair apart | inside | proved |
//! | [`hemicube`] | Rushmeier and Torrance's hemi-cube | a patch and anything | inside, by pixels | estimated |
//! | [`proposition1`] | the transmittance at the centres times the geometric factor, corrected by −κℓ C(u) | any aligned pair; sharp for two voxels | outside, bounded | proved |
//! | [`series`], [`strip`] | Proposition 2 and the algorithm `Formfact` | a voxel and a voxel grid | outside | proved |
//! | [`analogous`] | the same for patches, λ = 3/2 and 2 | rows of zones in front of a patch | outside | proved |
//! | [`proximity`] | the development of section 3.1: a patch and the mesh of a smooth surface | a patch and a surface | outside | as its page says |
//! | [`chebyshev`] | interpolation in place of Taylor | lattices of zones | inside | proved |
//!
//! **Why attenuation is not inside the series.** Proposition 2 lives on the generating function of the Gegenbauer polynomials: 1/(1 − 2p cosθ + p²)^λ is algebraic, and
//! its Taylor coefficients obey a recurrence of three terms with bounded solutions, which gives both the speed and the exact remainder. e^{−κr} with
//! r = √(r₀² − 2sr₀cosθ + s²) satisfies a linear differential equation in s only of second order with an apparent singularity where t_e + s = 0,
//! so that a recurrence for it divides by the cosine, and there is no closed remainder. The strip function stays
//! analytic, though: [`chebyshev`] interpolates it with the attenuation inside and a bound from the ellipse; a thin medium takes [`proposition1`].

pub mod analogous;
pub mod chebyshev;
pub mod gauss6;
pub mod hemicube;
pub mod inverse;
mod kernel;
mod nodes;
pub mod point;
pub mod proposition1;
pub mod proximity;
pub mod series;
pub mod strip;
mod trapezoid;

use crate::aligned::{Cuboid, geometric_factor};
use crate::{Demand, Factor, Method};
use zonal_math::vec3;
use zonal_scene::Plate;

/// The geometric factor of two aligned zones by one of the paper's methods, for extinction `kappa` (1/m).
///
/// [`Method::Point`], [`Method::SixGauss`], [`Method::Proposition1`], [`Method::Series`], [`Method::Chebyshev`], [`Method::HemiCube`] (where one of the zones
/// is a patch; its radius is estimated); a method that is not the paper's, and a hemi-cube without a patch, take the exact
/// integral of [`crate::aligned`]. The radius is proved and may miss the demand where the method cannot do better. `Series` takes the
/// neighbour of `b` one extent farther off as reference, e^{−κd} outside with what that neglects inside the radius; it takes
/// the exact integral where no reference serves. The methods for many zones at once are in the modules.
///
/// # Panics
/// On invalid boxes, a negative extinction, a tolerance that is not positive.
pub fn factor(method: Method, a: &Cuboid, b: &Cuboid, kappa: f64, demand: &Demand) -> Factor {
    match method {
        Method::Point => point::factor(a, b, kappa),
        Method::SixGauss => gauss6::factor(a, b, kappa, demand),
        Method::Proposition1 => proposition1::factor(a, b, kappa, demand),
        Method::Series => analogous::one(a, b, kappa, demand),
        Method::Chebyshev => chebyshev::one(a, b, kappa, demand),
        Method::HemiCube => by_hemicube(a, b, kappa, demand),
        _ => geometric_factor(a, b, kappa, demand.tolerance),
    }
}

/// The hemi-cube stands on the patch of the pair.
fn by_hemicube(a: &Cuboid, b: &Cuboid, kappa: f64, demand: &Demand) -> Factor {
    assert!(a.is_valid() && b.is_valid(), "not a box or rectangle: {a:?}, {b:?}");
    let target = |c: &Cuboid| plate(c).map_or(hemicube::Target::Cuboid(c.lo, c.hi), hemicube::Target::Plate);
    match (plate(a), plate(b)) {
        (Some(p), _) => hemicube::pair(&p, &target(b), kappa, demand),
        (_, Some(p)) => hemicube::pair(&p, &target(a), kappa, demand),
        _ => geometric_factor(a, b, kappa, demand.tolerance),
    }
}

/// A patch as a plate with the same front.
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
