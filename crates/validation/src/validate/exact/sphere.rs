//! The emissivity of a sphere from the voxels of a cube around it.
//!
//! Paths between points of a convex body stay inside it: with the share w_i of the voxel i that the sphere fills,
//!
//! ```text
//! ε A = Σ_i 4κ V_i w_i − Σ_ij w_i w_j F_ij,        Σ_j w_j F_ij = κ V_i G_i of a medium that emits w_j.
//! ```

use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::measures::voxel_value;
use crate::validate::richardson::ResolutionSequence;
use std::f64::consts::PI;
use zonal_report::Failure;
use zonal_scene::{Bands, Scene};

/// Voxels across.
const RESOLUTIONS: [usize; 5] = [16, 24, 36, 54, 81];
/// Points along an edge of a voxel by which its share is found.
const POINTS_PER_EDGE: usize = 8;

/// The share of the voxel at `c` that lies in the sphere that the unit cube of n³ voxels holds.
fn share(c: [usize; 3], n: usize) -> f64 {
    let at = |k: usize, i: usize| (c[k] as f64 + (i as f64 + 0.5) / POINTS_PER_EDGE as f64) / n as f64 - 0.5;
    let inside = (0..POINTS_PER_EDGE.pow(3)).filter(|p| {
        let (x, y, z) = (
            at(0, p % POINTS_PER_EDGE),
            at(1, p / POINTS_PER_EDGE % POINTS_PER_EDGE),
            at(2, p / (POINTS_PER_EDGE * POINTS_PER_EDGE)),
        );
        x * x + y * y + z * z < 0.25
    });
    inside.count() as f64 / POINTS_PER_EDGE.pow(3) as f64
}

fn emissivity(bench: &CaseContext, depth: f64, n: usize) -> Result<f64, Failure> {
    let name = format!("sphere-{depth}-{n}");
    let text = BoxScene::new([1.0; 3], [n; 3], depth).solve("engine = \"spectral\"").text(&name);
    let mut parts = bench.scene(&name, &text)?.into_parts();
    let Some(mut map) = parts.voxel_grid.take() else { return Err(Failure::new("the sphere has no medium")) };
    let cells = n.pow(3);
    let shares: Vec<f64> = (0..cells).map(|i| share(map.coordinates(i), n)).collect();
    for (i, w) in shares.iter().enumerate() {
        map.set(i, Bands::splat(depth), Bands::ZERO, Bands::splat(*w), Bands::ZERO);
    }
    parts.voxel_grid = Some(map.seal()?);
    let s = bench.solve_scene(Scene::new(parts)?)?;
    let Some(map) = s.scene.voxel_grid() else { return Err(Failure::new("the sphere has no medium")) };
    let volume = 1.0 / cells as f64;
    let leaves = shares.iter().enumerate().map(|(i, w)| {
        let g = voxel_value(&s, &s.fields.incident, map.coordinates(i));
        w * depth * volume * (4.0 - g)
    });
    Ok(leaves.sum::<f64>() / PI)
}

/// The rows of the table.
pub(crate) fn check(bench: &CaseContext, out: &mut CaseOutcome) -> Result<(), Failure> {
    for row in table!("sphere.csv")?.rows() {
        let (depth, p) = (row.number("KD")?, row.printed("value")?);
        let steps: Vec<(f64, f64)> = RESOLUTIONS
            .iter()
            .map(|&n| Ok((n as f64, emissivity(bench, depth, n)?)))
            .collect::<Result<_, Failure>>()?;
        let sequence = ResolutionSequence::new(
            format!("sphere, KD = {depth}: emissivity"),
            steps,
            Some((p.value, p.half)),
        );
        out.check(
            format!("sphere, KD = {depth}, extrapolated: emissivity"),
            p.value,
            sequence.value(),
            AcceptanceLimit::Relative(2e-3),
        );
        out.sequences.push(sequence);
    }
    Ok(())
}
