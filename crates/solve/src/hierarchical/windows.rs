//! Windows: the zones over which light is alike, and a linear fit over them.
//!
//! Volume zones: cells up to so many steps away that can be walked to from face to face without a wall between the centres. Where all of
//! them are open they form a cube, over which by symmetry a linear fit at the middle is the mean. Patches: those that lie in one plane
//! with it, face the same way, and are near in terms of its own size.

use crate::open::Open;
use rayon::prelude::*;
use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::{Scene, Voxmap, Zones};
use zonal_transport::Transport;

/// Steps from cell to cell of the windows of a volume zone.
const STEPS: [usize; 2] = [1, 2];
/// Radii of the windows of a patch, in square roots of its area.
const RADII: [f64; 3] = [1.6, 3.2, 6.4];
/// Zones of a window at least: fewer say nothing about a slope.
const LEAST: usize = 4;
/// Patches of a window at most, the nearest.
const MOST: usize = 96;
/// Cosine between normals of patches that are alike, and height over the plane relative to distance.
const ALIKE: f64 = 0.97;
const HEIGHT: f64 = 0.12;
/// The finest grid of patches has cells of this share of the largest.
const LEVELS: usize = 8;
/// Volume zones of one task.
const BLOCK: usize = 1024;

/// Zones and their weights in a linear fit at the zone in the middle; they add up to one.
pub(super) enum Window {
    /// Each with its own.
    Listed(Vec<(u32, f64)>),
    /// Runs of zones, all with the same.
    Cube(Vec<std::ops::Range<usize>>),
}

impl Window {
    /// Number of zones.
    pub(super) fn len(&self) -> usize {
        match self {
            Window::Listed(list) => list.len(),
            Window::Cube(rows) => rows.iter().map(|r| r.len()).sum(),
        }
    }

    /// Shows `f` every zone and its weight.
    #[inline]
    pub(super) fn each(&self, mut f: impl FnMut(usize, f64)) {
        match self {
            Window::Listed(list) => list.iter().for_each(|(j, l)| f(*j as usize, *l)),
            Window::Cube(rows) => {
                let l = 1.0 / self.len() as f64;
                rows.iter().cloned().flatten().for_each(|j| f(j, l));
            }
        }
    }
}

/// Whom to ask about each zone.
pub(super) struct Windows<'a> {
    zones: &'a Zones,
    rooms: Option<Rooms<'a>>,
    /// Centre and normal of every patch.
    patches: Vec<[Vec3; 2]>,
    grids: Vec<Grid>,
}

impl<'a> Windows<'a> {
    /// Finds what is connected.
    pub(super) fn new(scene: &'a Scene, zones: &'a Zones, transport: &Transport) -> Windows<'a> {
        let patches: Vec<[Vec3; 2]> = zones.patches.iter().map(|p| [p.plate.centre(), p.normal]).collect();
        let largest = zones.patches.iter().fold(0.0f64, |m, p| m.max(p.area)).sqrt();
        let cell = |l: usize| RADII[RADII.len() - 1] * largest / (1u32 << l) as f64;
        let levels = if patches.is_empty() { 0 } else { LEVELS };
        Windows {
            zones,
            rooms: scene.voxmap().map(|map| Rooms::new(map, zones, transport)),
            grids: (0..levels).into_par_iter().map(|l| Grid::new(&patches, cell(l))).collect(),
            patches,
        }
    }

    /// Number of windows of zone `i`.
    pub(super) fn levels(&self, i: usize) -> usize {
        if i < self.zones.voxel_offset() { RADII.len() } else { STEPS.len() }
    }

    /// A window of zone `i`, the wider the higher `level`; `None` where too few zones are alike.
    pub(super) fn window(&self, i: usize, level: usize) -> Option<Window> {
        match i.checked_sub(self.zones.voxel_offset()) {
            Some(z) => self.rooms.as_ref()?.window(z, STEPS[level]),
            None => fitted(&self.around(i, RADII[level]), true),
        }
    }

    /// Patches alike within `radius` of its own size.
    fn around(&self, i: usize, radius: f64) -> Vec<Member> {
        let ([x, normal], r) = (self.patches[i], radius * self.zones.patches[i].area.sqrt());
        let fits = self.grids.iter().rposition(|g| g.cell >= r);
        let Some(grid) = fits.map(|l| &self.grids[l]) else { return Vec::new() };
        let home = key(x, grid.cell);
        let mut out: Vec<(f64, Member)> = Vec::new();
        for c in 0..27 {
            let cell = [home[0] + c / 9 - 1, home[1] + c / 3 % 3 - 1, home[2] + c % 3 - 1];
            let Some(&(a, b)) = grid.first.get(&cell) else { continue };
            for &j in &grid.order[a as usize..b as usize] {
                let [at, towards] = self.patches[j as usize];
                let away = at - x;
                let d2 = away.length2();
                let level = normal.dot(away).abs() <= HEIGHT * d2.sqrt();
                if d2 <= r * r && level && normal.dot(towards) > ALIKE {
                    out.push((d2, Member { zone: j, away }));
                }
            }
        }
        if out.len() > MOST {
            out.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.zone.cmp(&b.1.zone)));
            out.truncate(MOST);
        }
        out.into_iter().map(|x| x.1).collect()
    }
}

/// Patches by the cells of a grid.
struct Grid {
    cell: f64,
    first: HashMap<[i32; 3], (u32, u32)>,
    order: Vec<u32>,
}

impl Grid {
    fn new(patches: &[[Vec3; 2]], cell: f64) -> Grid {
        let mut keyed: Vec<([i32; 3], u32)> = (0..).zip(patches).map(|(i, p)| (key(p[0], cell), i)).collect();
        keyed.sort_unstable();
        let mut first = HashMap::new();
        let mut at = 0;
        for run in keyed.chunk_by(|a, b| a.0 == b.0) {
            first.insert(run[0].0, (at, at + run.len() as u32));
            at += run.len() as u32;
        }
        Grid { cell, first, order: keyed.into_iter().map(|x| x.1).collect() }
    }
}

fn key(p: Vec3, cell: f64) -> [i32; 3] {
    [0, 1, 2].map(|k| (p[k] / cell).floor().clamp(-1e9, 1e9) as i32)
}

/// Volume zones and the doors between them.
struct Rooms<'a> {
    open: Open<'a>,
    offset: usize,
    /// Cell and centre of each: the zones themselves are large.
    places: Vec<([u32; 3], Vec3)>,
    /// Zones that can be walked to through the six faces of the cell: `doors[first[z]..first[z + 1]]`.
    first: Vec<u32>,
    doors: Vec<u32>,
}

impl<'a> Rooms<'a> {
    fn new(map: &'a Voxmap, zones: &'a Zones, transport: &Transport) -> Rooms<'a> {
        let open = Open::new(map, zones, transport);
        let n = zones.voxels.len();
        let blocks: Vec<(Vec<u32>, Vec<u32>)> = (0..n.div_ceil(BLOCK))
            .into_par_iter()
            .map(|b| {
                let (mut ends, mut all) = (Vec::new(), Vec::new());
                for z in b * BLOCK..((b + 1) * BLOCK).min(n) {
                    doors(zones, map, transport, &open, z, &mut all);
                    ends.push(all.len() as u32);
                }
                (ends, all)
            })
            .collect();
        let (mut first, mut all) = (vec![0u32], Vec::new());
        for (ends, list) in blocks {
            first.extend(ends.iter().map(|e| e + all.len() as u32));
            all.extend(list);
        }
        let at = |cell: usize| map.coordinates(cell).map(|c| c as u32);
        let places = zones.voxels.par_iter().map(|v| (at(v.cell), v.centre)).collect();
        Rooms { open, offset: zones.voxel_offset(), places, first, doors: all }
    }

    fn window(&self, z: usize, reach: usize) -> Option<Window> {
        if let Some(rows) = self.open.cube(z, reach) {
            let run = |r: std::ops::Range<usize>| r.start + self.offset..r.end + self.offset;
            return Some(Window::Cube(rows.map(|row| run(row.zones)).collect()));
        }
        fitted(&self.reached(z, reach as i32), false)
    }

    /// Volume zones up to `reach` cells away that can be walked to.
    fn reached(&self, z: usize, reach: i32) -> Vec<Member> {
        let (here, x) = self.places[z];
        let side = 2 * reach + 1;
        // Of 5³ cells at most.
        let mut visited = [0u64; 2];
        let slot = |c: [u32; 3]| {
            let d = [0, 1, 2].map(|k| c[k] as i32 - here[k] as i32 + reach);
            let inside = d.iter().all(|d| (0..side).contains(d));
            inside.then(|| ((d[0] * side + d[1]) * side + d[2]) as usize)
        };
        let mut out = vec![Member { zone: z as u32, away: Vec3::ZERO }];
        if let Some(s) = slot(here) {
            visited[s / 64] |= 1 << (s % 64);
        }
        let mut next = 0;
        while next < out.len() {
            let from = out[next].zone as usize;
            next += 1;
            for &to in &self.doors[self.first[from] as usize..self.first[from + 1] as usize] {
                let (cell, centre) = self.places[to as usize];
                let Some(s) = slot(cell) else { continue };
                if visited[s / 64] >> (s % 64) & 1 == 0 {
                    visited[s / 64] |= 1 << (s % 64);
                    out.push(Member { zone: to, away: centre - x });
                }
            }
        }
        out.iter_mut().for_each(|m| m.zone += self.offset as u32);
        out
    }
}

/// Appends the volume zones across the faces of the cell of `z` whose centre its own sees.
fn doors(zones: &Zones, map: &Voxmap, transport: &Transport, open: &Open, z: usize, out: &mut Vec<u32>) {
    let (own, dims) = (&zones.voxels[z], map.dims());
    let c = map.coordinates(own.cell);
    for face in 0..6 {
        let (k, up) = (face / 2, face % 2 == 1);
        if if up { c[k] + 1 >= dims[k] } else { c[k] == 0 } {
            continue;
        }
        let mut to = c;
        to[k] = if up { c[k] + 1 } else { c[k] - 1 };
        for other in zones.of_cell(map.index(to)) {
            let next = &zones.voxels[other];
            let passes = if own.part.is_empty() && next.part.is_empty() {
                open.leads_on(if up { z } else { other }, k)
            } else {
                !transport.parted_inside(own.centre, next.centre)
            };
            if passes {
                out.push(other as u32);
            }
        }
    }
}

/// A zone of a window.
struct Member {
    zone: u32,
    /// x_j − x_i.
    away: Vec3,
}

/// The weights of a linear fit at the origin; `None` where the members are few or do not span.
fn fitted(members: &[Member], plane: bool) -> Option<Window> {
    // Lengths in units of the window's own size.
    let size = members.iter().fold(0.0f64, |m, x| m.max(x.away.length2())).sqrt();
    if members.len() < LEAST || size <= 0.0 {
        return None;
    }
    let n = members.len() as f64;
    let mean = members.iter().fold(Vec3::ZERO, |s, m| s + m.away) / (n * size);
    let mut c = [[0.0; 3]; 3];
    for m in members {
        let d = m.away / size - mean;
        for (r, row) in c.iter_mut().enumerate() {
            (0..3).for_each(|k| row[k] += d[r] * d[k] / n);
        }
    }
    // The plane of patches has no extent along its normal: a little stiffness there, and against members in a line.
    let trace = c[0][0] + c[1][1] + c[2][2];
    let stiff = if plane { 1e-3 } else { 1e-6 } * trace;
    (0..3).for_each(|k| c[k][k] += stiff);
    let g = solve(c, mean)?;
    let weight = |m: &Member| (m.zone, (1.0 - (m.away / size - mean).dot(g)) / n);
    Some(Window::Listed(members.iter().map(weight).collect()))
}

/// C⁻¹ v of a symmetric positive matrix.
fn solve(c: [[f64; 3]; 3], v: Vec3) -> Option<Vec3> {
    let row = |k: usize| Vec3::from_array(c[k]);
    let (a, b, d) = (row(0), row(1), row(2));
    let det = a.dot(b.cross(d));
    if det.is_nan() || det <= 0.0 {
        return None;
    }
    Some((b.cross(d) * v.x + d.cross(a) * v.y + a.cross(b) * v.z) / det)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn a_fit_returns_linear_fields_exactly() {
        let mut members = Vec::new();
        for k in 0..20 {
            let [x, y, z] = zonal_math::sequence::r3(k, [0.3, 0.1, 0.7]);
            members.push(Member { zone: k as u32, away: vec3(x - 0.2, 2.0 * y, z - 1.0) });
        }
        let window = fitted(&members, false).unwrap();
        let field = |p: Vec3| 3.0 + 2.0 * p.x - p.y + 0.5 * p.z;
        let (mut found, mut sum) = (0.0, 0.0);
        window.each(|j, l| {
            found += l * field(members[j].away);
            sum += l;
        });
        assert!((sum - 1.0).abs() < 1e-12);
        assert!((found - 3.0).abs() < 1e-4, "{found}");
        assert!(fitted(&members[..3], false).is_none());
    }
}
