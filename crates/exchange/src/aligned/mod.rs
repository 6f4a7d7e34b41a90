//! Geometric factors of axis-aligned boxes and rectangles, with proved radii.
//!
//! For two voxels, a patch and a voxel, two patches (extinction κ in 1/m, all edges along the axes):
//!
//! ```text
//! 𝓕 = (1/π) ∬ e^{−κr} [max(0, cosθ_a)] [max(0, cosθ_b)] / r²       in m⁴, m³, m²
//! ```
//!
//! **Reduction from six dimensions to three.** The integrand depends on t = x_b − x_a alone, whose density is a product of
//! trapezoids, one per axis (constant 1 where one box is flat, a fixed t where both are); cosθ = |t_n|/r on the side that a
//! patch with normal axis n faces. With m patches and p_k of them flat on axis k
//!
//! ```text
//! 𝓕 = (1/π) ∫ ω_x(t_x) ω_y(t_y) ω_z(t_z) |t_x|^{p_x} |t_y|^{p_y} |t_z|^{p_z} e^{−κ|t|} / |t|^{2+m} dt,   t_k > 0 where p_k > 0.
//! ```
//!
//! **Cells.** Every axis is cut at the trapezoid's breakpoints and at zero and folded onto t ≥ 0: ω is then linear on each
//! cell (`reduced_pair.rs`). A cell with a corner at t = 0 takes pyramid coordinates, which cancel the singularity (`pyramid_cells.rs`); any
//! other takes tensor Gauss–Legendre (`separated_cells.rs`). Cells large against their distance from 0, or many mean free paths thick,
//! are halved first; negligible ones are left out and enter the radius (`subdivision.rs`).
//!
//! **Cheaper methods.** The cells apply to every pair. Far pairs without a medium take the moments of the densities (`moment_series.rs`, for cubes in
//! two invariants: `cube_series.rs`), two rectangles without a medium a closed form (`closed_form.rs`), far pairs of equal boxes Gauss rules for
//! the densities (`density_rules.rs`): each is proved in the header of its module. `method_selection::select_method` selects.
//!
//! **Proof of the cells.** The number of points in each direction follows from the Bernstein-ellipse bound of Gauss–Legendre
//! ([`zonal_math::gauss_legendre::error_bound`]) with the supremum of the complexified kernel derived in closed form (`bernstein_ellipse.rs`,
//! `separated_cells.rs`, `pyramid_cells.rs`). All terms are positive: rounding is relative and counted (`cell_integration.rs`). So the radius is
//! truncation + left-out cells + rounding, grade proved, for boxes whose edges and offsets are those computed
//! with one subtraction from the given corners (lengths a relative 2⁻⁵³ apart from the real differences).
//!
//! Pairs of a grid have few distinct offsets: [`FactorCache`] keeps the factors of single pairs by their geometry, [`lattice`] computes
//! whole tables, eight offsets at a time.

mod bernstein_ellipse;
mod cell_integration;
mod closed_form;
mod cube_series;
mod cuboid;
mod density_rules;
mod factor_cache;
pub mod lattice;
mod method_selection;
mod moment_series;
mod pyramid_cells;
mod radial_kernel;
mod reduced_pair;
mod separated_cells;
mod subdivision;

pub use cuboid::Cuboid;
pub use factor_cache::{DistanceCumulants, FactorCache};

use crate::Factor;
use method_selection::factor_of;

/// The geometric factor of a pair for extinction `kappa` ≥ 0 (1/m): m⁴ (two voxels), m³ (voxel and patch), m² (two patches).
///
/// ```
/// use zonal_exchange::aligned::{Cuboid, geometric_factor};
/// use zonal_math::vec3;
/// // Opposite unit squares at distance 1: the view factor of Howell's catalogue, C-11.
/// let floor = Cuboid::patch(vec3(0.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), 2, 1);
/// let top = Cuboid::patch(vec3(0.0, 0.0, 1.0), vec3(1.0, 1.0, 1.0), 2, -1);
/// let f = geometric_factor(&floor, &top, 0.0, 1e-12).bounded;
/// assert!((f.value - 0.199_824_895_698_39).abs() < 1e-12 && f.radius < 1e-12);
/// ```
///
/// The radius is at most `tolerance` · value for tolerances down to 1e-12; where rounding forbids (κ·distance in the
/// thousands), it is larger. The factor is exactly zero when one of the boxes lies behind the other or in its plane.
///
/// # Panics
/// On an invalid box ([`Cuboid::is_valid`]), a negative or non-finite `kappa`, a tolerance that is not positive.
pub fn geometric_factor(a: &Cuboid, b: &Cuboid, kappa: f64, tolerance: f64) -> Factor {
    assert!(a.is_valid() && b.is_valid(), "not a box or rectangle: {a:?}, {b:?}");
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    assert!(tolerance > 0.0, "tolerance {tolerance}");
    match reduced_pair::reduce(a, b) {
        None => Factor::NOT_VISIBLE,
        Some(pair) => factor_of(&pair, kappa, tolerance),
    }
}
