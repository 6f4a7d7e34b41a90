//! The same scene on zones twice as large, or on smaller ones, for the discretization error.
//!
//! Patches may be twice as long. An axis of n cells gets ⌈n/2⌉ over the same extent; with w_c the share that an old cell c has of a new one,
//!
//! ```text
//!     κ' = Σ w κ      κ'Ω' = Σ w κΩ      κ'(1−Ω')E' = Σ w κ(1−Ω)E      q' = Σ w q
//! ```
//!
//! and likewise T⁴ with the weight w κ(1−Ω), heat with w. Every mean is held between the least and the largest of its terms, so that equal values
//! stay what they are to the bit: of weights such as 0.6 and 0.4 rounding alone would make one extinction many. Where cells that absorb
//! would meet in one, some of known temperature and some of known heat, the medium stays as it is: neither can be both.
//!
//! On zones an m-th as large an axis of n cells gets mn, each with the values of the cell that it is a part of; an axis of one cell along which the
//! scene repeats itself stays as it is, since nothing changes along it. Patches are at most an m-th as large as the largest of their surface.

use crate::scene::PatchRule;
use crate::{Bands, Known, Plate, PlateKind, Scene, SceneError, Voxmap, Zones, bands};
use zonal_math::vec3;

impl Scene {
    /// The scene on zones about twice as large: patches and cells as far as the geometry lets them.
    pub fn coarser(&self) -> Result<Scene, SceneError> {
        let default = self.patch_size();
        let mut parts = self.clone().into_parts();
        parts.options.patch_size = Some(2.0 * default);
        for surface in &mut parts.surfaces {
            surface.patch_size = surface.patch_size.map(|p| 2.0 * p);
        }
        if let Some(coarser) = self.voxmap().map(Voxmap::coarser).transpose()?.flatten() {
            parts.voxmap = Some(coarser);
        }
        Scene::new(parts)
    }
}

impl Scene {
    /// The scene on zones that are at most an `n`-th as large across as the largest of `zones`, which are its own.
    pub fn finer(&self, zones: &Zones, n: usize) -> Result<Scene, SceneError> {
        let rule = self.options().patch_rule;
        let mut largest = vec![0.0f64; self.surfaces().len()];
        zones.patches.iter().for_each(|p| largest[p.surface] = largest[p.surface].max(size(&p.plate, rule)));
        let sheets = zones.panes.iter().fold(f64::INFINITY, |s, p| s.min(size(&p.plate, rule)));
        let default = self.patch_size();
        let share = |own: f64, set: f64| if own > 0.0 { own.min(set) } else { set } / n as f64;
        let mut parts = self.clone().into_parts();
        parts.options.patch_size = Some(share(if sheets.is_finite() { sheets } else { 0.0 }, default));
        for (surface, largest) in parts.surfaces.iter_mut().zip(largest) {
            surface.patch_size = Some(share(largest, surface.patch_size.unwrap_or(default)));
        }
        parts.voxmap = self.voxmap().map(|m| m.finer(self.periodic(), n)).transpose()?;
        Scene::new(parts)
    }
}

/// The size of a patch that a rule limits, m.
fn size(p: &Plate, rule: PatchRule) -> f64 {
    let longest = p.e1.length().max(p.e2.length());
    match (rule, p.kind) {
        (PatchRule::Area, PlateKind::Triangle) => p.area().sqrt(),
        (_, PlateKind::Triangle) => {
            let longest = longest.max((p.e2 - p.e1).length());
            (2.0 * p.area()).sqrt().max(longest * std::f64::consts::FRAC_1_SQRT_2)
        }
        (_, PlateKind::Parallelogram) => longest,
    }
}

/// For each new cell of an axis, the old cells that it covers and their shares of it.
fn shares(old: usize, new: usize) -> Vec<Vec<(usize, f64)>> {
    let edge = old as f64 / new as f64;
    let one = |k: usize| {
        let (from, to) = (k as f64 * edge, ((k + 1) as f64 * edge).min(old as f64));
        let covered = from.floor() as usize..(to.ceil() as usize).min(old);
        let share = |c: usize| ((to.min((c + 1) as f64) - from.max(c as f64)) / edge).max(0.0);
        covered.map(|c| (c, share(c))).filter(|x| x.1 > 0.0).collect()
    };
    (0..new).map(one).collect()
}

/// A mean without the rounding that would put it outside what it is the mean of; as it is where there is nothing.
fn between(mean: f64, terms: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = terms.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    if low <= high { mean.clamp(low, high) } else { mean }
}

/// What is known of a cell that holds others, each with its share and with what it absorbs; `None` where that is temperatures and heat.
fn merged(cells: &[(Known, f64, f64)]) -> Option<Known> {
    let absorbed = cells.iter().map(|c| c.2).sum::<f64>();
    let weight = |c: &(Known, f64, f64)| if absorbed > 0.0 { c.2 } else { c.1 };
    let (mut warm, mut fourth, mut heat, mut given) = (0.0, 0.0, 0.0, 0.0);
    for c in cells {
        match c.0 {
            Known::Temperature(t) => (warm, fourth) = (warm + weight(c), fourth + weight(c) * t.powi(4)),
            Known::Flux(q) | Known::Power(q) => (heat, given) = (heat + weight(c), given + c.1 * q),
        }
    }
    match (warm > 0.0, heat > 0.0) {
        // What does not absorb has no say.
        (true, true) if absorbed > 0.0 => None,
        (true, _) => {
            let kelvin = cells.iter().filter_map(|c| match c.0 {
                Known::Temperature(t) if weight(c) > 0.0 => Some(t),
                _ => None,
            });
            Some(Known::Temperature(between((fourth / warm).sqrt().sqrt(), kelvin)))
        }
        (false, _) => {
            let heat = cells.iter().map(|c| match c.0 {
                Known::Flux(q) | Known::Power(q) => q,
                Known::Temperature(_) => 0.0,
            });
            Some(Known::Flux(between(given, heat)))
        }
    }
}

impl Voxmap {
    /// The same medium on half as many cells along each axis, at least one; `None` where temperatures and heat would be known of one cell.
    fn coarser(&self) -> Result<Option<Voxmap>, SceneError> {
        let (old, extent) = (self.dims(), self.max() - self.min());
        let dims = old.map(|n| n.div_ceil(2));
        let edge = vec3(extent.x / dims[0] as f64, extent.y / dims[1] as f64, extent.z / dims[2] as f64);
        let mut out = Voxmap::new(self.min(), edge, dims)?;
        if self.is_uniform() {
            out.fill(self.extinction(0), self.albedo(0), self.emission(0), self.source(0));
            self.heat(0).into_iter().for_each(|k| out.fill_heat(k));
            return out.seal().map(Some);
        }
        let axes = [0, 1, 2].map(|a| shares(old[a], dims[a]));
        for index in 0..out.len() {
            let [i, j, k] = out.coordinates(index);
            let mut covered = Vec::new();
            for &(x, u) in &axes[0][i] {
                for &(y, v) in &axes[1][j] {
                    covered.extend(axes[2][k].iter().map(|&(z, w)| (self.index([x, y, z]), u * v * w)));
                }
            }
            if !self.merge(&covered, &mut out, index) {
                return Ok(None);
            }
        }
        out.seal().map(Some)
    }

    /// The same medium on `n` times as many cells along each axis but those of one cell along which the scene is `periodic`.
    fn finer(&self, periodic: [bool; 3], n: usize) -> Result<Voxmap, SceneError> {
        let (old, extent) = (self.dims(), self.max() - self.min());
        let split: [usize; 3] = std::array::from_fn(|a| if old[a] == 1 && periodic[a] { 1 } else { n });
        let dims: [usize; 3] = std::array::from_fn(|a| old[a].saturating_mul(split[a]));
        let edge = vec3(extent.x / dims[0] as f64, extent.y / dims[1] as f64, extent.z / dims[2] as f64);
        let mut out = Voxmap::new(self.min(), edge, dims)?;
        out.fill(self.extinction(0), self.albedo(0), self.emission(0), self.source(0));
        self.heat(0).into_iter().for_each(|k| out.fill_heat(k));
        if self.is_uniform() {
            return out.seal();
        }
        for index in 0..out.len() {
            let at = out.coordinates(index);
            let c = self.index(std::array::from_fn(|a| at[a] / split[a]));
            out.set(index, self.extinction(c), self.albedo(c), self.emission(c), self.source(c));
            self.heat(c).into_iter().for_each(|k| out.set_heat(index, k, Known::Flux(0.0)));
        }
        out.seal()
    }

    /// Sets cell `index` of `out` to what the cells `covered` of this map are together, each with its share; false where they cannot be one.
    fn merge(&self, covered: &[(usize, f64)], out: &mut Voxmap, index: usize) -> bool {
        let sum = |of: &dyn Fn(usize) -> Bands| {
            covered.iter().fold([0.0; 3], |s, &(c, w)| {
                let x = of(c);
                bands(|b| s[b] + w * x[b])
            })
        };
        let absorbs = |c: usize| {
            let (k, o) = (self.extinction(c), self.albedo(c));
            bands(|b| k[b] * (1.0 - o[b]))
        };
        // Means of what `has` it, by their sums and the sums of their weights.
        let mean =
            |of: &dyn Fn(usize) -> Bands, has: &dyn Fn(usize) -> Bands, total: Bands, weight: Bands| {
                bands(|b| {
                    let terms = covered.iter().filter(|&&(c, _)| has(c)[b] > 0.0).map(|&(c, _)| of(c)[b]);
                    if weight[b] > 0.0 { between(total[b] / weight[b], terms) } else { 0.0 }
                })
            };
        let scatters = |c: usize| {
            let (k, o) = (self.extinction(c), self.albedo(c));
            bands(|b| k[b] * o[b])
        };
        let emits = |c: usize| {
            let (a, e) = (absorbs(c), self.emission(c));
            bands(|b| a[b] * e[b])
        };
        let (all, one) = (&|_: usize| [1.0; 3], [1.0; 3]);
        let plain = |of: &dyn Fn(usize) -> Bands| mean(of, all, sum(of), one);
        let (extinction, absorption) = (sum(&|c| self.extinction(c)), sum(&absorbs));
        let weighted = mean(&|c| self.albedo(c), &|c| self.extinction(c), sum(&scatters), extinction);
        let even = plain(&|c| self.albedo(c));
        let albedo = bands(|b| if extinction[b] > 0.0 { weighted[b] } else { even[b] });
        let emission = mean(&|c| self.emission(c), &absorbs, sum(&emits), absorption);
        let source = plain(&|c| self.source(c));
        out.set(index, plain(&|c| self.extinction(c)), albedo, emission, source);
        let known: Vec<_> = covered
            .iter()
            .filter_map(|&(c, w)| Some((self.heat(c)?, w, w * absorbs(c).iter().sum::<f64>())))
            .collect();
        if known.is_empty() {
            return true;
        }
        let one = merged(&known);
        one.into_iter().for_each(|k| out.set_heat(index, k, Known::Flux(0.0)));
        one.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::Vec3;

    #[test]
    fn shares_of_a_cell_sum_to_one_and_cover_all() {
        for (old, new) in [(9, 5), (4, 2), (3, 2), (1, 1), (7, 4), (115, 58)] {
            let all = shares(old, new);
            for list in &all {
                assert!((list.iter().map(|x| x.1).sum::<f64>() - 1.0).abs() < 1e-12, "{old} {list:?}");
            }
            let covered: f64 = all.iter().flatten().map(|x| x.1).sum::<f64>() * old as f64 / new as f64;
            assert!((covered - old as f64).abs() < 1e-9);
        }
    }

    #[test]
    fn a_larger_cell_has_the_powers_of_those_in_it() {
        let mut map = Voxmap::new(Vec3::ZERO, vec3(0.5, 0.25, 1.0), [3, 5, 2]).unwrap();
        for i in 0..map.len() {
            let x = i as f64;
            map.set(i, [0.1 * x, 0.2, 1.0], [0.01 * x, 0.5, 0.9], [x, 1.0, 2.0 + x], [0.0, 0.1 * x, 1.0]);
            map.set_heat(i, Known::Flux(x), Known::Flux(0.0));
        }
        let map = map.seal().unwrap();
        let half = map.coarser().unwrap().unwrap();
        assert_eq!(half.dims(), [2, 3, 1]);
        let totals = |m: &Voxmap| {
            let volume = m.cell().x * m.cell().y * m.cell().z;
            let mut out = [0.0; 13];
            for i in 0..m.len() {
                let (k, o, e, q) = (m.extinction(i), m.albedo(i), m.emission(i), m.source(i));
                for b in 0..3 {
                    out[b] += volume * k[b];
                    out[3 + b] += volume * k[b] * o[b];
                    out[6 + b] += volume * k[b] * (1.0 - o[b]) * e[b];
                    out[9 + b] += volume * q[b];
                }
                let Some(Known::Flux(q)) = m.heat(i) else { panic!("heat") };
                out[12] += volume * q;
            }
            out
        };
        for (a, b) in totals(&map).into_iter().zip(totals(&half)) {
            assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}");
        }
    }

    #[test]
    fn equal_values_stay_equal_to_the_bit() {
        for n in [3, 5, 7, 11, 13] {
            let mut map = Voxmap::new(Vec3::ZERO, vec3(0.4, 0.3, 0.1), [n, n, 2 * n]).unwrap();
            for i in 0..map.len() {
                // One value varies, so that cells are merged one by one.
                map.set(i, [0.1, 0.7, 1.3], [0.3, 0.1, 0.9], [10.0 / 3.0; 3], [0.7; 3]);
                map.set_heat(i, Known::Temperature(300.0 + i as f64), Known::Flux(0.0));
            }
            let half = map.seal().unwrap().coarser().unwrap().unwrap();
            assert_eq!(half.uniform_extinction(), Some([0.1, 0.7, 1.3]), "{n}");
            for i in 0..half.len() {
                assert_eq!(half.albedo(i), [0.3, 0.1, 0.9]);
                assert_eq!(half.emission(i), [10.0 / 3.0; 3]);
                assert_eq!(half.source(i), [0.7; 3]);
            }
        }
    }

    #[test]
    fn a_finer_medium_has_the_values_of_the_cells_it_divides() {
        let mut map = Voxmap::new(Vec3::ZERO, vec3(0.5, 0.25, 1.0), [3, 1, 1]).unwrap();
        for i in 0..map.len() {
            map.set(i, [0.1 * i as f64; 3], [0.5; 3], [1.0; 3], [0.0; 3]);
            map.set_heat(i, Known::Flux(i as f64), Known::Flux(0.0));
        }
        let fine = map.seal().unwrap().finer([true, true, false], 2).unwrap();
        assert_eq!((fine.dims(), fine.max()), ([6, 1, 2], vec3(1.5, 0.25, 1.0)));
        for i in 0..fine.len() {
            let x = fine.coordinates(i)[0] / 2;
            assert_eq!(fine.extinction(i), [0.1 * x as f64; 3]);
            assert_eq!(fine.heat(i), Some(Known::Flux(x as f64)));
        }
    }

    #[test]
    fn what_absorbs_decides_what_is_known() {
        let hot = (Known::Temperature(1000.0), 0.25, 2.0);
        let clear = (Known::Flux(0.0), 0.75, 0.0);
        assert_eq!(merged(&[hot, clear]), Some(Known::Temperature(1000.0)));
        assert_eq!(merged(&[clear, clear]), Some(Known::Flux(0.0)));
        let source = (Known::Flux(8.0), 0.75, 3.0);
        assert_eq!(merged(&[source, (Known::Temperature(300.0), 0.25, 0.0)]), Some(Known::Flux(6.0)));
        assert_eq!(merged(&[hot, source]), None);
        let Some(Known::Temperature(t)) = merged(&[hot, (Known::Temperature(500.0), 0.5, 2.0)]) else {
            panic!()
        };
        assert!((t.powi(4) - 0.5 * (1e12 + 6.25e10)).abs() < 1.0);
    }
}
