//! How much larger the zones of one of two solves are, and what keeps that from telling the discretization error.
//!
//! Cells grow by the least of the axes that have more than one; patches of a surface, and pieces of a pane, by the root of how many times
//! fewer they are. What does not grow is as rough in both solves, and their distance says nothing of it: it is named. So is what is so large that
//! the larger zones are not yet on their way to the answer: cells that are few or thick, patches far wider than the gap before them.

use crate::forecast::thickness;
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, HeatKind, HeatReport, HeatRow, Note, Patch, Scene, Voxmap, Zones};
use zonal_transport::Transport;

/// Zones that grow by less than this are as large as before.
const GROWN: f64 = 1.2;

/// The fewest of the larger cells along an axis, where it has more than one, and the most optical depths across them, that a fair estimate
/// without slopes takes: with fewer, or thicker ones, known errors were up to ten times what was estimated.
const FEWEST: usize = 3;
/// The fewest of smaller cells.
const FEWEST_SMALL: usize = 4;
const THICKEST: f64 = 1.0;

/// Patches that are more than so many times as wide as the gap before them, on so large a share of the area, are not fine enough.
const WIDE: f64 = 2.0;
const SHARE: f64 = 0.1;

/// What an estimate from few or thick zones, or from patches wider than the gap before them, is multiplied by: known errors were up to
/// ten times as large.
const CAUTION: f64 = 10.0;
/// The same of an estimate from smaller zones.
const CAUTION_SMALL: f64 = 3.0;

/// Where patches on so large a share of the area are as large in both solves, nothing is known of the rest either: it receives what they send.
const MOST_STUCK: f64 = 0.1;

/// Names that a note has.
const NAMES: usize = 4;

/// What a comparison of two sets of zones says.
pub(super) struct Grown {
    /// How much larger they are across, or why they are not.
    pub ratio: Result<f64, String>,
    /// What their errors do not tell.
    pub notes: Vec<Note>,
    /// Of whom they do not tell it.
    pub stuck: Stuck,
    /// What the estimate is to be multiplied by: 1, or more where zones are few or thick.
    pub caution: f64,
}

/// What is as large in both solves.
#[derive(Clone, Debug, Default)]
pub(super) struct Stuck {
    /// Surfaces and panes, in the scene's order.
    surfaces: Vec<bool>,
    panes: Vec<bool>,
    /// The cells, or a large share of the patches: then nothing is known of anything.
    all: bool,
}

impl Stuck {
    /// Of each row of a table by name, whether its error is unknown.
    pub(super) fn of_rows(&self, table: &HeatReport) -> Vec<bool> {
        let (mut surfaces, mut panes) = (self.surfaces.iter(), self.panes.iter());
        let one = |row: &HeatRow| {
            let own = match row.kind {
                HeatKind::Surface => surfaces.next().is_none_or(|s| *s),
                HeatKind::Medium => false,
                HeatKind::Pane => panes.next().is_none_or(|s| *s),
            };
            own || self.all
        };
        table.rows.iter().map(one).collect()
    }

    /// Makes the errors of powers infinite that are unknown.
    pub(super) fn widen(&self, energy: &mut Energy) {
        let unknown = |x: &mut Bands| *x = x.map(|_| f64::INFINITY);
        if self.all {
            *energy = energy.compared(energy, |_, _| f64::INFINITY);
            return;
        }
        let named = energy.absorbed_surfaces.iter_mut().zip(&self.surfaces);
        named.filter(|x| *x.1).for_each(|x| unknown(&mut x.0.1));
        if self.panes.iter().any(|s| *s) {
            unknown(&mut energy.absorbed_panes);
        }
    }
}

impl Grown {
    /// True where it keeps nothing back.
    pub(super) fn tells_all(&self) -> bool {
        self.ratio.is_ok() && self.notes.is_empty()
    }

    /// Compares zones with larger ones, in which radiosity has slopes or not; facets are the same. If `finer`, the larger ones are the scene's own,
    /// else the smaller ones.
    pub(super) fn between(
        (scene, zones): (&Scene, &Zones),
        (other, others): (&Scene, &Zones),
        transport: &Transport,
        slopes: bool,
        finer: bool,
    ) -> Grown {
        let real = |r: &f64| *r >= GROWN;
        let mut notes: Vec<Note> = Vec::new();
        let cells = grown_cells(scene, other).filter(real);
        if let Some(map) = scene.voxmap() {
            let stuck = stuck_cells(scene, map, cells.is_none());
            notes.extend(stuck.map(|text| Note::warning("discretization", text)));
        }
        let mut whom = Stuck { all: !notes.is_empty(), ..Stuck::default() };
        let (mut before, mut after, mut stuck) = (0, 0, Vec::new());
        for (k, (name, old, new, free)) in sheets(scene, zones, others).into_iter().enumerate() {
            let list = if k < scene.surfaces().len() { &mut whom.surfaces } else { &mut whom.panes };
            list.push(false);
            if real(&(old as f64 / new.max(1) as f64).sqrt()) {
                (before, after) = (before + old, after + new);
            } else if old > 0 && !free {
                list.iter_mut().last().into_iter().for_each(|s| *s = true);
                stuck.push(name);
            }
        }
        let area = |of: &dyn Fn(usize) -> bool| -> f64 {
            zones.patches.iter().filter(|p| of(p.surface)).map(|p| p.area).sum()
        };
        whom.all |= area(&|s| whom.surfaces[s]) > MOST_STUCK * area(&|_| true);
        if !stuck.is_empty() {
            let (named, rest) = stuck.split_at(stuck.len().min(NAMES));
            let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
            let text = format!(
                "the second solve has zones as large as the first on {}{more}, and their errors are unknown: give them a smaller patch_size",
                named.join(", ")
            );
            notes.push(Note::warning("discretization", text));
        }
        let patches = (after > 0).then(|| (before as f64 / after as f64).sqrt());
        let none = || notes.first().map_or_else(|| "there are no zones".into(), |n| n.text.clone());
        let ratio = [cells, patches].into_iter().flatten().min_by(f64::total_cmp).ok_or_else(none);
        let why = if finer {
            rough(scene, zones, FEWEST_SMALL, slopes, false)
        } else {
            let few = stuck.is_empty()
                && scene.voxmap().is_none()
                && others.patches.len() < 2 * other.facets().len();
            rough(other, others, FEWEST, slopes, few)
        };
        let why = why.or_else(|| wide(zones, transport));
        let caution = match why {
            Some(_) if finer => CAUTION_SMALL,
            Some(_) => CAUTION,
            None => 1.0,
        };
        notes.extend(why.map(|why| {
            let text = format!(
                "errors of zones are themselves rough, and are multiplied by {caution}: {why}; smaller zones tell more"
            );
            // The error that is stated has it.
            Note::new("rough-discretization", text)
        }));
        Grown { ratio, notes, stuck: whom, caution }
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
            "cells of known temperature lie beside cells of known heat, which cannot be one: the discretization errors are unknown"
                .into(),
        );
    }
    single.then(|| "the medium has one cell across an axis: the discretization errors are unknown".into())
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

/// Why zones are not yet on their way to the answer, by their number and thickness.
fn rough(other: &Scene, others: &Zones, fewest: usize, slopes: bool, few: bool) -> Option<&'static str> {
    let few_cells = |map: &Voxmap| (0..3).any(|k| map.dims()[k] < fewest && !other.periodic()[k]);
    match () {
        () if few || other.voxmap().is_some_and(few_cells) => Some("zones are few"),
        () if !slopes && thickness(other, others) > THICKEST => Some("voxels are thick"),
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
