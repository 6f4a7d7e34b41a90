//! Geometric factors of axis-aligned boxes and rectangles, with proved radii.
//!
//! For two voxels, a patch and a voxel, two patches (extinction κ in 1/m, all edges along the axes):
//!
//! ```text
//! 𝓕 = (1/π) ∬ e^{−κr} [max(0, cosθ_a)] [max(0, cosθ_b)] / r²       in m⁴, m³, m²
//! ```
//!
//! **Six dimensions are three.** The integrand depends on t = x_b − x_a alone, whose density is a product of
//! trapezoids, one an axis (constant 1 where one box is flat, a fixed t where both are); cosθ = |t_n|/r on the side that a
//! patch with normal axis n sees. With m patches and p_k of them flat on axis k
//!
//! ```text
//! 𝓕 = (1/π) ∫ ω_x(t_x) ω_y(t_y) ω_z(t_z) |t_x|^{p_x} |t_y|^{p_y} |t_z|^{p_z} e^{−κ|t|} / |t|^{2+m} dt,   t_k > 0 seen where p_k > 0.
//! ```
//!
//! **Cells.** Every axis is cut at the trapezoid's breakpoints and at zero and folded onto t ≥ 0: ω is then linear on each
//! cell (`reduced.rs`). A cell with a corner at t = 0 takes pyramid coordinates, which cancel the singularity (`pyramid.rs`); any
//! other takes tensor Gauss–Legendre (`apart.rs`). Cells large against their distance from 0, or many mean free paths thick,
//! are halved first; those that cannot matter go into the radius (`cells.rs`).
//!
//! **Cheaper ways.** The cells serve every pair. Far pairs without a medium take the moments of the densities (`moments.rs`, for cubes in
//! two invariants: `cube.rs`), two rectangles without a medium a closed form (`closed.rs`), far pairs of equal boxes Gauss rules made for
//! the densities (`density.rs`): each with a proof of its own in its header. One function chooses: `judge::admissible`.
//!
//! **Proof of the cells.** The number of points in each direction follows from the Bernstein-ellipse bound of Gauss–Legendre
//! ([`zonal_math::gauss::error_bound`]) with the supremum of the complexified kernel derived in closed form (`ellipse.rs`,
//! `apart.rs`, `pyramid.rs`). All terms are positive: rounding is relative and counted (`integrate.rs`). So the radius is
//! truncation + left-out cells + rounding, grade proved, for boxes whose edges and offsets are those computed
//! with one subtraction from the given corners (lengths a relative 2⁻⁵³ apart from the real differences).
//!
//! Reference: `shared/THEORY.md` section 3. Whole grids ask the same few offsets again and again: [`FactorCache`]
//! keeps what was asked, [`lattice`] makes the table at once, eight offsets side by side.

mod apart;
mod cache;
mod cells;
mod closed;
mod cube;
mod cuboid;
mod density;
mod ellipse;
mod integrate;
mod judge;
pub mod lattice;
mod moments;
mod pyramid;
mod radial;
mod reduced;

pub use cache::{Cumulants, FactorCache};
pub use cuboid::Cuboid;

use crate::Factor;
use judge::factor_of;

/// The smallest tolerance that is asked for; below, rounding is all there is.
const FINEST: f64 = 1e-13;

/// The geometric factor of a pair for extinction `kappa` ≥ 0 (1/m).
///
/// The radius is at most `tolerance` · value for tolerances down to 1e-12; where rounding forbids (κ·distance in the
/// thousands), it says so by being larger. Exactly zero when one of the boxes lies behind the other or in its plane.
///
/// # Panics
/// On an invalid box ([`Cuboid::is_valid`]), a negative or non-finite `kappa`, a tolerance that is not positive.
pub fn geometric_factor(a: &Cuboid, b: &Cuboid, kappa: f64, tolerance: f64) -> Factor {
    assert!(a.is_valid() && b.is_valid(), "not a box or rectangle: {a:?}, {b:?}");
    assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
    assert!(tolerance > 0.0, "tolerance {tolerance}");
    match reduced::reduce(a, b) {
        None => Factor::UNSEEN,
        Some(pair) => factor_of(&pair, kappa, tolerance),
    }
}
