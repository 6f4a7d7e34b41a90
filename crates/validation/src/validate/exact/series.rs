//! Section 10: the Gegenbauer series of the paper, order by order.

use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_math::{Vec3, vec3};
use zonal_paper::voxel_strips::single_reference_strip;
use zonal_report::Failure;

/// Errors below this are rounding and quadrature, here and in the table.
const ROUNDING_LEVEL: f64 = 1e-12;

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "gegenbauer",
    group: "10 Gegenbauer series",
    title: "the error of N terms along strips of voxels",
    about: "The paper's series about a reference voxel, against the exact factor: the *error itself* must be the printed one, to half a unit of its last place; printed errors below 10⁻¹² are rounding, and ours must \
        then be below 10⁻¹². The proved radius must hold the exact factor in every row.",
    quick: true,
    needs: None,
    run,
}];

fn cube(u: Vec3) -> Cuboid {
    Cuboid::voxel(u, u + Vec3::splat(1.0))
}

fn run(_: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let origin = cube(Vec3::ZERO);
    let mut reach: f64 = 0.0;
    for row in table!("gegenbauer.csv")?.rows() {
        let (u0, j, along) = (row.number("u0")?, row.number("j")? as usize, row.text("axis")?);
        let axis = usize::from(along.ends_with('y'));
        let forth = along.starts_with('+');
        let mut at = vec3(u0, 0.0, 0.0).array();
        at[axis] += if forth { j as f64 } else { -(j as f64) };
        let exact = geometric_factor(&origin, &cube(vec3(at[0], at[1], at[2])), 0.0, 1e-13).bounded.value;
        for order in [5, 10, 20, 30] {
            let Some(p) = row.optional(&format!("n{order}"))? else { continue };
            let (back, ahead, index) = if forth { (0, j, j) } else { (j, 0, 0) };
            let f = single_reference_strip(&origin, &cube(vec3(u0, 0.0, 0.0)), axis, back, ahead, order)
                .get(index);
            let error = (f.value / exact - 1.0).abs();
            reach = reach.max((f.value - exact).abs() / f.radius);
            let name = format!("u₀ = {u0}, {along}, j = {j}, N = {order}: relative error");
            if p.value < ROUNDING_LEVEL {
                out.error(format!("{name} (printed {:e})", p.value), error, ROUNDING_LEVEL);
            } else {
                out.check(name, p.value, error, AcceptanceLimit::Absolute(p.half));
            }
        }
    }
    out.error("largest error as a share of its proved radius", reach, 1.0);
    Ok(out)
}
