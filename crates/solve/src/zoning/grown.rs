//! How much larger the zones of a second solve are, and what keeps that from telling what their size costs.
//!
//! Cells grow by the least of the axes that have more than one; patches of a surface, and pieces of a pane, by the root of how many times
//! fewer they are. What does not grow is as rough in both solves, and their distance says nothing of it: it is named. So is what is so large that
//! the larger zones are not yet on their way to the answer: cells that are few or thick, patches far wider than the gap before them.

use crate::forecast::thickness;
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Patch, Scene, Voxmap, Zones};
use zonal_transport::Transport;

/// Zones that grow by less than this are as large as before.
const GROWN: f64 = 1.2;

/// The fewest of the larger cells along an axis, where it has more than one, and the most optical depths across them, that a fair estimate
/// without slopes takes: with fewer, or thicker ones, known errors were up to ten times what was estimated.
const FEWEST: usize = 3;
const THICKEST: f64 = 1.0;

/// Patches that are more than so many times as wide as the gap before them, on so large a share of the area, are not fine enough.
const WIDE: f64 = 2.0;
const SHARE: f64 = 0.1;

/// Names that a note has.
const NAMES: usize = 4;

/// What a comparison of two sets of zones says.
pub struct Grown {
    /// The number of the larger zones.
    pub zones: usize,
    /// How much larger they are across, or why they are not.
    pub ratio: Result<f64, String>,
    /// What their errors do not tell.
    pub notes: Vec<String>,
}

impl Grown {
    /// Compares a scene's zones with larger ones, in which radiosity has slopes or not; facets are as they were.
    pub fn between(
        (scene, zones): (&Scene, &Zones),
        (other, others): (&Scene, &Zones),
        transport: &Transport,
        slopes: bool,
    ) -> Grown {
        let real = |r: &f64| *r >= GROWN;
        let mut notes = Vec::new();
        let cells = grown_cells(scene, other).filter(real);
        if let Some(map) = scene.voxmap() {
            notes.extend(stuck_cells(scene, map, cells.is_none()));
        }
        let (mut before, mut after, mut stuck) = (0, 0, Vec::new());
        for (name, old, new, free) in sheets(scene, zones, others) {
            if real(&(old as f64 / new.max(1) as f64).sqrt()) {
                (before, after) = (before + old, after + new);
            } else if old > 0 && !free {
                stuck.push(name);
            }
        }
        if !stuck.is_empty() {
            let (named, rest) = stuck.split_at(stuck.len().min(NAMES));
            let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
            notes.push(format!(
                "the second solve has zones as large as the first on {}{more}, and their errors do not tell what that costs: give them a smaller patch_size",
                named.join(", ")
            ));
        }
        let patches = (after > 0).then(|| (before as f64 / after as f64).sqrt());
        let none = || notes.first().cloned().unwrap_or_else(|| "there are no zones".into());
        let ratio = [cells, patches].into_iter().flatten().min_by(f64::total_cmp).ok_or_else(none);
        let few =
            stuck.is_empty() && scene.voxmap().is_none() && others.patches.len() < 2 * other.facets().len();
        let why = rough(other, others, slopes, few).or_else(|| wide(zones, transport));
        notes.extend(
            why.map(|why| format!("errors of zones are themselves rough: {why}; smaller zones tell more")),
        );
        Grown { zones: others.len(), ratio, notes }
    }
}

/// The least growth of cells along the axes that have more than one.
fn grown_cells(scene: &Scene, other: &Scene) -> Option<f64> {
    let dims = |s: &Scene| s.voxmap().map(Voxmap::dims);
    let (a, b) = (dims(scene)?, dims(other)?);
    let ratios = (0..3).filter(|&k| a[k] > 1).map(|k| a[k] as f64 / b[k] as f64);
    ratios.min_by(f64::total_cmp)
}

/// What to say of cells that did not grow; along axes that repeat themselves one cell is enough.
fn stuck_cells(scene: &Scene, map: &Voxmap, none_grew: bool) -> Option<String> {
    let single = (0..3).any(|k| map.dims()[k] == 1 && !scene.periodic()[k]);
    if none_grew && map.len() > 1 {
        return Some(
            "cells of known temperature lie beside cells of known heat, which cannot be one: what the size of cells costs is not in the errors of zones"
                .into(),
        );
    }
    single.then(|| {
        "the medium has one cell across an axis: what that costs is not in the errors of zones".into()
    })
}

/// Each surface and pane: its name, the number of its zones before and after, and whether it may stay in one piece: across axes that repeat
/// themselves all is even.
fn sheets(scene: &Scene, zones: &Zones, others: &Zones) -> Vec<(String, usize, usize, bool)> {
    let surfaces = |z: &Zones| {
        let mut out = vec![0; scene.surfaces().len()];
        z.patches.iter().for_each(|p| out[p.surface] += 1);
        out
    };
    let panes = |z: &Zones| {
        let mut out = vec![0; scene.panes().len()];
        z.panes.iter().for_each(|p| out[p.pane] += 1);
        out
    };
    let mut free = vec![scene.is_periodic(); scene.surfaces().len()];
    zones.patches.iter().for_each(|p| free[p.surface] &= across(scene, p.normal));
    let names = scene.surfaces().iter().map(|s| &s.name);
    let counts = surfaces(zones).into_iter().zip(surfaces(others)).zip(free);
    let walls = names.zip(counts).map(|(n, ((a, b), free))| (n.clone(), a, b, free));
    let counts = panes(zones).into_iter().zip(panes(others));
    let glass = scene.panes().iter().zip(counts).map(|(p, (a, b))| (p.name.clone(), a, b, false));
    walls.chain(glass).collect()
}

/// True where a scene repeats itself along both axes across a normal.
fn across(scene: &Scene, normal: Vec3) -> bool {
    (0..3).all(|k| scene.periodic()[k] || normal[k].abs() > 1.0 - 1e-9)
}

/// Why the larger zones are not yet on their way to the answer, by their number and thickness.
fn rough(other: &Scene, others: &Zones, slopes: bool, few: bool) -> Option<&'static str> {
    let few_cells = |map: &Voxmap| (0..3).any(|k| map.dims()[k] < FEWEST && !other.periodic()[k]);
    match () {
        () if slopes => None,
        () if few || other.voxmap().is_some_and(few_cells) => Some("zones are few"),
        () if thickness(other, others) > THICKEST => Some("voxels are thick"),
        () => None,
    }
}

/// Whether patches are far wider than the gap before them.
fn wide(zones: &Zones, transport: &Transport) -> Option<&'static str> {
    let width = |p: &Patch| p.plate.e1.length().max(p.plate.e2.length());
    let narrow = |p: &Patch| {
        let reach = width(p) / WIDE;
        transport.nearest(p.plate.centre(), p.normal, 1e-6 * reach, reach).is_some()
    };
    let narrow: Vec<bool> = zones.patches.par_iter().map(narrow).collect();
    let all: f64 = zones.patches.iter().map(|p| p.area).sum();
    let share: f64 = zones.patches.iter().zip(narrow).filter(|x| x.1).map(|x| x.0.area).sum();
    (share > SHARE * all).then_some("patches are wider than twice the gap before them")
}
