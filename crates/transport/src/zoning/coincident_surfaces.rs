//! Coincident surfaces: exchanging sides of two facets at one place and in one direction.
//!
//! A patch is tested at one point p with its normal n. Another facet coincides with it there if p lies on the facet, and the facet's side
//! towards n exchanges: its front if the normals agree, its back if they oppose and both sides of its surface exchange. Both then emit
//! and absorb in the same half-space, and the area counts twice.

use crate::intersect::PreparedPlate;
use crate::transport::Transport;
use std::collections::BTreeMap;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{Diagnostic, Patch, PlateKind, Scene, Sides, Zones};

/// Most patches that are tested.
const MAX_TESTED_PATCHES: usize = 1 << 18;
/// Facets nearer to the plane of a patch than this multiple of [`Transport::epsilon`] lie in it: meshes come in single precision.
const IN_PLANE_EPSILONS: f64 = 100.0;
/// Normals whose cosine is within this distance of ±1 are parallel.
const PARALLEL_COSINE_TOLERANCE: f64 = 1e-9;
/// Parameters of a point on a facet lie inside by this much.
const INSIDE_MARGIN: f64 = 1e-6;
/// Coincident area of two surfaces that counts as rounding, as a fraction of the smaller surface.
const MIN_SHARE: f64 = 1e-6;
/// Most pairs that are reported one by one.
const MAX_REPORTED_PAIRS: usize = 3;

/// Warnings about surfaces that coincide, those of large areas first.
pub(super) fn coincident_surfaces(scene: &Scene, transport: &Transport, zones: &Zones) -> Vec<Diagnostic> {
    let step = zones.patches.len().div_ceil(MAX_TESTED_PATCHES).max(1);
    let tested: Vec<&Patch> = zones.patches.iter().step_by(step).collect();
    let found: Vec<Vec<usize>> = parallel::map(&tested, |p| coincident_with(scene, transport, p));
    // Area by ordered pair of surfaces, and the first place of each.
    let mut area: BTreeMap<(usize, usize), (f64, Vec3)> = BTreeMap::new();
    let mut of_surface = vec![0.0; scene.surfaces().len()];
    for (p, others) in tested.iter().zip(&found) {
        of_surface[p.surface] += p.area;
        for other in others {
            let entry = area.entry((p.surface, *other)).or_insert((0.0, p.plate.centre()));
            entry.0 += p.area;
        }
    }
    let mut pairs: Vec<(f64, usize, usize, Vec3)> = Vec::new();
    for (&(a, b), &(own, place)) in &area {
        let back = area.get(&(b, a)).map_or(0.0, |x| x.0);
        let first = a <= b || back == 0.0;
        let larger = if a == b { 0.5 * own } else { own.max(back) };
        if first && larger > MIN_SHARE * of_surface[a].min(of_surface[b].max(larger)) {
            pairs.push((larger * step as f64, a, b, place));
        }
    }
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let name = |k: usize| &scene.surfaces()[k].name;
    let mut out: Vec<Diagnostic> = pairs.iter().take(MAX_REPORTED_PAIRS).map(|(area, a, b, place)| {
        let with = if a == b { "itself".to_string() } else { format!("surface '{}'", name(*b)) };
        let [x, y, z] = place.array();
        let text = format!(
            "coincides with {with} on about {area:.3e} m2, at ({x:.4}, {y:.4}, {z:.4}) for instance: this area counts twice; remove one of the two, or move them apart"
        );
        Diagnostic::warning("surfaces-coincide", text).at(format!("surface '{}'", name(*a)))
    }).collect();
    if pairs.len() > MAX_REPORTED_PAIRS {
        let n = pairs.len() - MAX_REPORTED_PAIRS;
        out.push(Diagnostic::warning("surfaces-coincide", format!("{n} further pairs of surfaces coincide")));
    }
    out
}

/// The surfaces of other facets that exchange at the tested point of a patch, towards its normal.
fn coincident_with(scene: &Scene, transport: &Transport, patch: &Patch) -> Vec<usize> {
    let p = match patch.plate.kind {
        PlateKind::Triangle => patch.plate.at(0.33, 0.34),
        PlateKind::Parallelogram => patch.plate.at(0.51, 0.49),
    };
    let tolerance = IN_PLANE_EPSILONS * transport.epsilon();
    let pad = Vec3::splat(tolerance);
    let exchanges = |id: &u32| {
        let facet = &scene.facets()[*id as usize];
        let surface = &scene.surfaces()[facet.surface];
        let cosine = facet.plate.normal().dot(patch.normal);
        let both = surface.sides == Sides::Both && !surface.solid;
        let faces =
            cosine > 1.0 - PARALLEL_COSINE_TOLERANCE || both && cosine < -1.0 + PARALLEL_COSINE_TOLERANCE;
        let [u, v] = facet.plate.parameters(p);
        let m = INSIDE_MARGIN;
        let within = match facet.plate.kind {
            PlateKind::Triangle => u > m && v > m && u + v < 1.0 - m,
            PlateKind::Parallelogram => u > m && v > m && u < 1.0 - m && v < 1.0 - m,
        };
        faces && within && PreparedPlate::new(&facet.plate).height(p).abs() <= tolerance
    };
    let near = transport.facets_overlapping(p - pad, p + pad);
    let mut out: Vec<usize> = near
        .into_iter()
        .filter(|id| *id as usize != patch.facet)
        .filter(exchanges)
        .map(|id| scene.facets()[id as usize].surface)
        .collect();
    out.sort_unstable();
    out.dedup();
    out
}
