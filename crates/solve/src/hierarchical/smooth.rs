//! Light that arrives, smoothed over the zones around: linear fits as wide as the light itself allows.
//!
//! What the rays of one zone say is noisy; light that comes from other zones varies little from a zone to the next. At zone i, over a
//! window of zones j around it,
//!
//! ```text
//! Σ_j (R_j − a − g·(x_j − x_i))² → min      a = Σ_j l_j R_j      e_a² = ē² Σ_j l_j²      ē² the mean of e_j² over the window
//! ```
//!
//! and a is the value. Windows grow; the widest is taken whose interval a ± Γ e_a still meets those of all narrower ones (the rule of the
//! intersection of confidence intervals), and, wider, that of the zone's own rays. The weights l_j are the same for all bands and light groups, so sums stay sums.
//!
//! **Windows.** Volume zones: cells up to so many steps away that can be walked to from face to face without a wall between the centres.
//! Patches: those that lie in one plane with it, face the same way, and are near in terms of its own size.

use super::views::Measured;
use rayon::prelude::*;
use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::{Bands, Scene, Voxmap, Zones, bands};
use zonal_transport::Transport;

/// Γ: half width of the intervals over their standard error.
const WIDTH: f64 = 0.5;
/// The same of what the rays of the zone itself say: few, but its own.
const ALONE: f64 = 2.0;
/// Share of the error of the next narrower window by which a fit may be bent without showing.
const UNSEEN: f64 = 0.35;
/// What fits leave out, and what the light that rays meet errs by itself: the errors told are larger by this.
pub const CAUTION: f64 = 2.2;
/// Zones of one task.
const BLOCK: usize = 1024;
/// Steps from cell to cell of the windows of a volume zone.
const STEPS: [usize; 2] = [1, 2];
/// Radii of the windows of a patch, in square roots of its area.
const RADII: [f64; 3] = [1.6, 3.2, 6.4];
/// Patches of a window at most, the nearest.
const MOST: usize = 96;
/// Cosine between normals of patches that are alike, and height over the plane relative to distance.
const ALIKE: f64 = 0.97;
const HEIGHT: f64 = 0.12;
/// The finest grid of patches has cells of this share of the largest.
const LEVELS: usize = 8;

/// Whom to ask about each zone.
pub struct Smoother<'a> {
    zones: &'a Zones,
    map: Option<&'a Voxmap>,
    /// Zones that can be walked to through the six faces of the cell: `doors[first[z]..first[z + 1]]`.
    first: Vec<u32>,
    doors: Vec<u32>,
    grids: Vec<Grid>,
}

/// Patches by the cells of a grid.
struct Grid {
    cell: f64,
    first: HashMap<[i32; 3], (u32, u32)>,
    order: Vec<u32>,
}

impl Grid {
    fn new(zones: &Zones, cell: f64) -> Grid {
        let mut keyed: Vec<([i32; 3], u32)> =
            (0..).zip(&zones.patches).map(|(i, p)| (key(p.plate.centre(), cell), i)).collect();
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

/// The window chosen for a zone.
struct Chosen {
    /// Zones and their weights l.
    weights: Vec<(u32, f64)>,
    error: Bands,
    /// Squares of the guide's error and value.
    guide: [f64; 2],
}

/// A zone of a window.
struct Member {
    zone: u32,
    /// x_j − x_i.
    away: Vec3,
}

impl<'a> Smoother<'a> {
    /// Finds what is connected.
    pub fn new(scene: &'a Scene, zones: &'a Zones, transport: &Transport) -> Smoother<'a> {
        let map = scene.voxmap();
        let lists: Vec<Vec<u32>> = match map {
            Some(map) => {
                (0..zones.voxels.len()).into_par_iter().map(|z| doors(zones, map, transport, z)).collect()
            }
            None => Vec::new(),
        };
        let mut first = vec![0u32];
        let mut all = Vec::new();
        for l in lists {
            all.extend(l);
            first.push(all.len() as u32);
        }
        let largest = zones.patches.iter().fold(0.0f64, |m, p| m.max(p.area)).sqrt();
        let grids = match zones.patches.is_empty() {
            true => Vec::new(),
            false => (0..LEVELS)
                .into_par_iter()
                .map(|l| Grid::new(zones, RADII[RADII.len() - 1] * largest / (1u32 << l) as f64))
                .collect(),
        };
        Smoother { zones, map, first, doors: all, grids }
    }

    /// The columns smoothed by windows that suit `guide`, the error of what all of them bring together, and the relative error of the guide
    /// itself over patches and over volumes.
    pub fn smooth(
        &self,
        guide: &[Measured],
        all: &[Measured],
        columns: &[Vec<Bands>],
    ) -> (Vec<Vec<Bands>>, Vec<Bands>, [f64; 2]) {
        let n = all.len();
        let mut squares = [[0.0; 2]; 2];
        let mut out: Vec<Vec<Bands>> = columns.iter().map(|_| vec![[0.0; 3]; n]).collect();
        let mut error = vec![[0.0; 3]; n];
        let blocks = n.div_ceil(BLOCK);
        let done: Vec<Vec<(Chosen, Vec<Bands>)>> = (0..blocks)
            .into_par_iter()
            .map(|block| {
                let range = block * BLOCK..((block + 1) * BLOCK).min(n);
                range.map(|i| self.one(i, guide, all, columns)).collect()
            })
            .collect();
        for (i, (chosen, values)) in done.into_iter().flatten().enumerate() {
            error[i] = chosen.error.map(|e| CAUTION * e);
            let kind = &mut squares[usize::from(i >= self.zones.voxel_offset())];
            *kind = [kind[0] + chosen.guide[0], kind[1] + chosen.guide[1]];
            out.iter_mut().zip(values).for_each(|(o, v)| o[i] = v);
        }
        let over = squares.map(|[e, v]| if v > 0.0 { CAUTION * (e / v).sqrt() } else { 0.0 });
        (out, error, over)
    }

    fn one(
        &self,
        i: usize,
        guide: &[Measured],
        all: &[Measured],
        columns: &[Vec<Bands>],
    ) -> (Chosen, Vec<Bands>) {
        let chosen = self.choose(i, guide, all);
        let value = |c: &Vec<Bands>| {
            let sum = chosen.weights.iter().fold([0.0; 3], |s, (j, l)| {
                let v = c[*j as usize];
                bands(|b| s[b] + l * v[b])
            });
            sum.map(|v| v.max(0.0))
        };
        let values = columns.iter().map(value).collect();
        (Chosen { weights: Vec::new(), ..chosen }, values)
    }

    fn choose(&self, i: usize, guide: &[Measured], all: &[Measured]) -> Chosen {
        let whole = |v: &Bands| v.iter().sum::<f64>();
        let own = [whole(&guide[i].error).powi(2), whole(&guide[i].value).powi(2)];
        let mut best = Chosen { weights: vec![(i as u32, 1.0)], error: all[i].error, guide: own };
        if i >= self.zones.pane_offset() {
            return best;
        }
        let mut narrower = best.error;
        let mut interval = [f64::NEG_INFINITY, f64::INFINITY];
        let surface = i < self.zones.voxel_offset();
        let levels = if surface { RADII.len() } else { STEPS.len() };
        for level in 0..levels {
            let window = self.window(i, level);
            if window.len() < 4 {
                continue;
            }
            let Some(weights) = fit(&window, surface) else { continue };
            let (mut value, mut spread) = ([0.0; 3], 0.0);
            for (m, l) in window.iter().zip(&weights) {
                let v = guide[m.zone as usize].value;
                value = bands(|b| value[b] + l * v[b]);
                spread += l * l;
            }
            let noise = pooled(&window, guide);
            let error = if std::ptr::eq(guide, all) { noise } else { pooled(&window, all) };
            if interval[1] == f64::INFINITY {
                let (v, e) = (whole(&guide[i].value), ALONE * whole(&noise));
                interval = [v - e, v + e];
                best.error = bands(|b| best.error[b].max(error[b]));
                narrower = best.error;
                // What none of its own rays found lit lies in the dark; light around it is that of another room.
                if v == 0.0 {
                    break;
                }
            }
            let (v, e) = (whole(&value), WIDTH * whole(&noise) * spread.sqrt());
            interval = [interval[0].max(v - e), interval[1].min(v + e)];
            if interval[0] > interval[1] {
                break;
            }
            let error = error.map(|p| p * spread.sqrt());
            let told = bands(|b| error[b].hypot(UNSEEN * narrower[b]));
            narrower = error;
            let weights = window.iter().zip(weights).map(|(m, l)| (m.zone, l)).collect();
            let guide = [(whole(&noise) * spread.sqrt()).powi(2), v * v];
            best = Chosen { weights, error: told, guide };
        }
        best
    }

    fn window(&self, i: usize, level: usize) -> Vec<Member> {
        match i.checked_sub(self.zones.voxel_offset()) {
            Some(z) => self.cells(z, STEPS[level] as i64),
            None => self.patches(i, RADII[level]),
        }
    }

    /// Volume zones up to `reach` cells away that can be walked to.
    fn cells(&self, z: usize, reach: i64) -> Vec<Member> {
        let Some(map) = self.map else { return Vec::new() };
        let (zones, offset) = (self.zones, self.zones.voxel_offset());
        let at = |z: usize| map.coordinates(zones.voxels[z].cell).map(|c| c as i64);
        let (here, x) = (at(z), zones.voxels[z].centre);
        let side = (2 * reach + 1) as usize;
        let mut visited = [0u64; 6];
        let slot = |c: [i64; 3]| {
            let d = [0, 1, 2].map(|k| c[k] - here[k] + reach);
            let inside = d.iter().all(|d| (0..side as i64).contains(d));
            inside.then(|| (d[0] as usize * side + d[1] as usize) * side + d[2] as usize)
        };
        let mut out = vec![Member { zone: (z + offset) as u32, away: Vec3::ZERO }];
        if let Some(s) = slot(here) {
            visited[s / 64] |= 1 << (s % 64);
        }
        let mut next = 0;
        while next < out.len() {
            let from = out[next].zone as usize - offset;
            next += 1;
            for &to in &self.doors[self.first[from] as usize..self.first[from + 1] as usize] {
                let Some(s) = slot(at(to as usize)) else { continue };
                if visited[s / 64] >> (s % 64) & 1 == 0 {
                    visited[s / 64] |= 1 << (s % 64);
                    let away = zones.voxels[to as usize].centre - x;
                    out.push(Member { zone: to + offset as u32, away });
                }
            }
        }
        out
    }

    /// Patches alike within `radius` of its own size.
    fn patches(&self, i: usize, radius: f64) -> Vec<Member> {
        let (zones, p) = (self.zones, &self.zones.patches[i]);
        let (x, r) = (p.plate.centre(), radius * p.area.sqrt());
        let fits = self.grids.iter().rposition(|g| g.cell >= r);
        let Some(grid) = fits.map(|l| &self.grids[l]) else { return Vec::new() };
        let home = key(x, grid.cell);
        let mut out: Vec<(f64, Member)> = Vec::new();
        for c in 0..27 {
            let cell = [home[0] + c / 9 - 1, home[1] + c / 3 % 3 - 1, home[2] + c % 3 - 1];
            let Some(&(a, b)) = grid.first.get(&cell) else { continue };
            for &j in &grid.order[a as usize..b as usize] {
                let q = &zones.patches[j as usize];
                let away = q.plate.centre() - x;
                let d2 = away.length2();
                let level = p.normal.dot(away).abs() <= HEIGHT * d2.sqrt();
                if d2 <= r * r && level && p.normal.dot(q.normal) > ALIKE {
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

/// Root mean square of the errors over a window.
fn pooled(window: &[Member], of: &[Measured]) -> Bands {
    let square = window.iter().fold([0.0; 3], |s, m| {
        let e = of[m.zone as usize].error;
        bands(|b| s[b] + e[b] * e[b])
    });
    square.map(|s| (s / window.len() as f64).sqrt())
}

/// Volume zones across the faces of the cell of `z` whose centre its own sees.
fn doors(zones: &Zones, map: &Voxmap, transport: &Transport, z: usize) -> Vec<u32> {
    let (c, x, dims) = (map.coordinates(zones.voxels[z].cell), zones.voxels[z].centre, map.dims());
    let mut out = Vec::new();
    for face in 0..6 {
        let (k, up) = (face / 2, face % 2 == 1);
        if if up { c[k] + 1 >= dims[k] } else { c[k] == 0 } {
            continue;
        }
        let mut to = c;
        to[k] = if up { c[k] + 1 } else { c[k] - 1 };
        for other in zones.of_cell(map.index(to)) {
            if !transport.blocked(x, zones.voxels[other].centre) {
                out.push(other as u32);
            }
        }
    }
    out
}

/// Weights l of a linear fit at the origin; `None` where the members do not span.
fn fit(window: &[Member], plane: bool) -> Option<Vec<f64>> {
    // Lengths in units of the window's own size.
    let size = window.iter().fold(0.0f64, |m, x| m.max(x.away.length2())).sqrt();
    if size <= 0.0 {
        return None;
    }
    let n = window.len() as f64;
    let mean = window.iter().fold(Vec3::ZERO, |s, m| s + m.away) / (n * size);
    let mut c = [[0.0; 3]; 3];
    for m in window {
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
    Some(window.iter().map(|m| (1.0 - (m.away / size - mean).dot(g)) / n).collect())
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
        let mut window = Vec::new();
        for k in 0..20 {
            let [x, y, z] = zonal_math::sequence::r3(k, [0.3, 0.1, 0.7]);
            window.push(Member { zone: k as u32, away: vec3(x - 0.2, 2.0 * y, z - 1.0) });
        }
        let weights = fit(&window, false).unwrap();
        let field = |p: Vec3| 3.0 + 2.0 * p.x - p.y + 0.5 * p.z;
        let found: f64 = window.iter().zip(&weights).map(|(m, l)| l * field(m.away)).sum();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((found - 3.0).abs() < 1e-4, "{found}");
    }
}
