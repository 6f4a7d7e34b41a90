//! The exchange area of any two zones of a scene: the one place that decides which formula serves a pair.
//!
//! What is kept of a pair is g_ij = F_ij/(c_i c_j) with c = κ for volume zones and 1 for patches, so that a band without
//! extinction keeps its factors: the fluence of an empty voxel is G_i = (1/V_i) Σ_j g_ij c_j B_j.
//!
//! | pair | geometry | attenuation |
//! |---|---|---|
//! | axis-aligned, uniform κ | reduced integral, **proved** | inside the integral |
//! | axis-aligned, varying κ | reduced integral at κ = 0 | three moments of the distance × mean extinction along rays |
//! | the same, optically thick | the same | chords of rays through both voxels |
//! | a plate in any position | closed solid angle inside, Gauss points outside, estimated | the same |
//! | a voxel cut by walls | sums over its samples | the same, ray by ray |
//! | a pane | as a plate that is seen from both sides, times (1 − e^{−κt/c})/κ, c the cosine | the same |
//!
//! **Visibility** multiplies: the mean over rays between points of both zones, weighted by the kernel. Few rays first; where
//! they disagree, more. The points differ from pair to pair, so that the errors of neighbours do not add up.

use crate::aligned::{Cuboid, FactorCache};
use crate::general::{self, Moments};
use zonal_math::{Vec3, sequence, special, vec3};
use zonal_scene::zones::SUBCELLS;
use zonal_scene::{Bands, Plate, Sample, Scene, Zones, bands};
use zonal_transport::Transport;

/// The relative radius of the axis-aligned factors in a solve: they are exact for every purpose of it.
const ALIGNED_TOLERANCE: f64 = 1e-11;
/// Rays of the first look at a pair.
const FIRST_RAYS: usize = 4;
/// Rays of a pair that is partly visible.
const MORE_RAYS: usize = 16;
/// Rays of a pair that is partly visible and carries a large share of a zone's power.
const MOST_RAYS: usize = 64;
/// Optical depth along a voxel's diagonal beyond which cumulants of the distance no longer serve.
const THICK: f64 = 1.7;
/// Mean optical depth of a pair's rays beyond which their ratio to a uniform medium says nothing.
const MOST_DEPTH: f64 = 20.0;
/// How often a pane and a zone close to it are quartered.
const PANE_SPLITS: u32 = 2;
/// Rays of a pair that nearly touches, is partly visible and carries a large share of a zone's power.
const CLOSE_RAYS: usize = 256;
/// Rays of a voxel with a sheet in its middle, to itself.
const OWN_RAYS: usize = 2048;
/// Beyond this many diameters a cut voxel is seen as a point.
const PART_FAR: f64 = 3.0;

/// What was counted while pairs were computed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Pairs of axis-aligned zones by the reduced integral.
    pub aligned: u64,
    /// Pairs with a plate in a general position.
    pub general: u64,
    /// Pairs with a cut voxel.
    pub cut: u64,
    /// Pairs with a pane.
    pub pane: u64,
    /// Pairs that cannot see each other by their orientation.
    pub facing_away: u64,
    /// Pairs resolved by more than the first rays.
    pub partial: u64,
    /// Rays.
    pub rays: u64,
}

impl Counts {
    /// Adds another count.
    pub fn merge(&mut self, o: Counts) {
        self.aligned += o.aligned;
        self.general += o.general;
        self.cut += o.cut;
        self.pane += o.pane;
        self.facing_away += o.facing_away;
        self.partial += o.partial;
        self.rays += o.rays;
    }
}

/// g_ij with its error radius, a band.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairFactor {
    /// g_ij: m² (ss), m³ (sv), m⁴ (vv).
    pub value: Bands,
    /// Error radius: estimated, or proved where no ray and no general quadrature took part.
    pub radius: Bands,
}

/// The shape of a zone.
enum Shape<'a> {
    Plate { plate: Plate, pane: Option<usize> },
    Cuboid,
    Part(&'a [Sample]),
}

struct Zone<'a> {
    shape: Shape<'a>,
    /// The zone as an axis-aligned box or rectangle; of a cut voxel, the whole cell.
    aligned: Option<Cuboid>,
    normal: Vec3,
    centre: Vec3,
    lo: Vec3,
    hi: Vec3,
    size: f64,
    /// Area of a patch, volume of a volume zone.
    measure: f64,
    /// Optical depth along the size of a voxel; zero for any other zone.
    thickness: Bands,
}

impl Zone<'_> {
    /// The samples of a cut voxel.
    fn samples(&self) -> Option<&[Sample]> {
        if let Shape::Part(s) = self.shape { Some(s) } else { None }
    }
}

/// A ray between two zones.
struct Ray {
    /// Weight: the kernel.
    w: f64,
    /// Length, m.
    r: f64,
    /// Optical depth of the medium.
    depth: Bands,
    /// Attenuation by the medium as [`Exchange::chords`] has it, where a zone is thick.
    chords: Bands,
    /// Zero where a facet blocks, else what the panes let pass, and the share of panes at the ends.
    through: Bands,
}

/// Exchange of the zones of a scene.
pub struct Exchange<'a> {
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    items: Vec<Zone<'a>>,
    cache: FactorCache,
    tolerance: f64,
    /// κ where every zone lies in one uniform medium (zero in vacuum) and no pane can stand between two zones.
    uniform: Option<Bands>,
    occluders: bool,
    /// Extinction varies inside the voxmap, or a pane can stand between two zones: a few rays do not tell the attenuation.
    varied: bool,
    /// Some pane can stand between two zones.
    panes_between: bool,
    /// Factors of sub-cells by their offset, with the means of r, r² and r³.
    subcells: Vec<[f64; 4]>,
}

/// Offsets of sub-cells between two cells that touch.
const SUB_SPAN: usize = 2 * SUBCELLS;

impl<'a> Exchange<'a> {
    /// Prepares the exchange of `zones`, which were built from `scene`.
    pub fn new(scene: &'a Scene, zones: &'a Zones, transport: &'a Transport<'a>) -> Exchange<'a> {
        let mut items = Vec::with_capacity(zones.len());
        items.extend(zones.patches.iter().map(|p| plate_zone(p.plate, None)));
        let cell = scene.voxmap().map_or(Vec3::ZERO, |v| v.cell());
        for z in &zones.voxels {
            let map = scene.voxmap().expect("voxel zones come from a voxmap");
            let lo = map.corner(map.coordinates(z.cell));
            let hi = lo + cell;
            let shape = if z.part.is_empty() { Shape::Cuboid } else { Shape::Part(&z.part) };
            items.push(Zone {
                shape,
                aligned: Some(Cuboid { lo, hi, normal: None }),
                normal: Vec3::ZERO,
                centre: z.centre,
                lo,
                hi,
                size: cell.length(),
                measure: z.volume,
                thickness: z.extinction.map(|k| k * cell.length()),
            });
        }
        items.extend(zones.panes.iter().enumerate().map(|(k, p)| plate_zone(p.plate, Some(k))));
        let cache = FactorCache::new(ALIGNED_TOLERANCE);
        let subcells = if zones.voxels.iter().any(|z| !z.part.is_empty()) {
            subcell_table(cell * (1.0 / SUBCELLS as f64), &cache)
        } else {
            Vec::new()
        };
        Exchange {
            zones,
            transport,
            items,
            cache,
            tolerance: scene.options().tolerance,
            uniform: uniform_medium(scene, zones, transport),
            varied: transport.has_panes_between()
                || scene.voxmap().is_some_and(|v| v.uniform_extinction().is_none())
                || uniform_medium(scene, zones, transport).is_none(),
            occluders: transport.has_occluders(),
            panes_between: transport.has_panes_between(),
            subcells,
        }
    }

    /// κ where it is the same all along every path between two zones.
    pub fn uniform(&self) -> Option<Bands> {
        self.uniform
    }

    /// g_ij; symmetric to the bit.
    pub fn pair(&self, i: usize, j: usize, counts: &mut Counts) -> PairFactor {
        let (i, j) = if i < j { (j, i) } else { (i, j) };
        let (a, b) = (&self.items[i], &self.items[j]);
        if i == j {
            return self.own(i, counts);
        }
        if behind(a, b) || behind(b, a) {
            counts.facing_away += 1;
            return PairFactor::default();
        }
        let seed = ((i as u64) << 32) | j as u64;
        match (&a.shape, &b.shape) {
            (Shape::Part(_), _) | (_, Shape::Part(_)) => {
                counts.cut += 1;
                self.with_part(a, b, seed, counts)
            }
            (Shape::Plate { pane: Some(_), .. }, _) | (_, Shape::Plate { pane: Some(_), .. }) => {
                counts.pane += 1;
                self.pane_pair(a, b, seed, PANE_SPLITS, counts)
            }
            _ => self.simple(a, b, seed, counts),
        }
    }

    /// Pairs of patches and whole voxels.
    fn simple(&self, a: &Zone, b: &Zone, seed: u64, counts: &mut Counts) -> PairFactor {
        if let (Some(p), Some(q)) = (&a.aligned, &b.aligned) {
            counts.aligned += 1;
            if let Some(kappa) = self.uniform {
                let mut out = PairFactor::default();
                for k in 0..3 {
                    if let Some(same) = (0..k).find(|&m| kappa[m] == kappa[k]) {
                        (out.value[k], out.radius[k]) = (out.value[same], out.radius[same]);
                    } else {
                        let f = self.cache.get(p, q, kappa[k]);
                        (out.value[k], out.radius[k]) = (f.value, f.radius);
                    }
                }
                return if self.occluders { self.times_visibility(a, b, out, seed, counts) } else { out };
            }
        } else {
            counts.general += 1;
        }
        let m = self.moments(a, b);
        match self.uniform.filter(|_| !self.is_thick(a, b)) {
            Some(kappa) => {
                let t = bands(|k| m.transmittance(kappa[k]));
                let out = PairFactor {
                    value: t.map(|t| m.factor.value * t),
                    radius: t.map(|t| m.factor.radius * t),
                };
                if self.occluders { self.times_visibility(a, b, out, seed, counts) } else { out }
            }
            None => self.by_rays(a, b, m, seed, counts),
        }
    }

    /// The unattenuated factor of two zones, neither of them cut.
    fn moments(&self, a: &Zone, b: &Zone) -> Moments {
        if let (Some(p), Some(q)) = (&a.aligned, &b.aligned)
            && !matches!(a.shape, Shape::Plate { pane: Some(_), .. })
            && !matches!(b.shape, Shape::Plate { pane: Some(_), .. })
        {
            let c = self.cache.get_cumulants(p, q);
            return Moments { factor: c.factor, mean: c.mean_distance, variance: c.variance, third: c.third };
        }
        let tolerance = self.tolerance;
        match (&a.shape, &b.shape) {
            (Shape::Plate { plate: p, pane: u }, Shape::Plate { plate: q, pane: v }) => {
                general::plate_plate(p, q, [u.is_some(), v.is_some()], tolerance)
            }
            (Shape::Plate { plate, pane }, _) => general::plate_cuboid(plate, b.lo, b.hi, pane.is_some(), tolerance),
            (_, Shape::Plate { plate, pane }) => general::plate_cuboid(plate, a.lo, a.hi, pane.is_some(), tolerance),
            _ => unreachable!("two cuboids are aligned"),
        }
    }

    /// Exchange of a zone with itself.
    fn own(&self, i: usize, counts: &mut Counts) -> PairFactor {
        let z = &self.items[i];
        match &z.shape {
            Shape::Plate { pane: None, .. } => PairFactor::default(),
            Shape::Plate { pane: Some(k), .. } => {
                let p = &self.zones.panes[*k];
                let value = p.extinction.map(|k| if k > 0.0 { pane_own(k, p.thickness) * z.measure } else { 0.0 });
                PairFactor { value, radius: [0.0; 3] }
            }
            Shape::Cuboid => {
                let kappa = self.kappa(i);
                let c = z.aligned.as_ref().expect("a voxel is aligned");
                let f = kappa.map(|k| self.cache.get(c, c, k));
                let all = PairFactor { value: f.map(|f| f.value), radius: f.map(|f| f.radius) };
                self.own_visible(i, all, counts)
            }
            Shape::Part(samples) => {
                counts.cut += 1;
                let m = self.subcell_sum([0; 3], samples, samples);
                let kappa = self.kappa(i);
                let value = bands(|k| m.factor.value * m.transmittance(kappa[k]));
                self.own_visible(i, PairFactor { value, radius: value.map(|v| v * self.tolerance) }, counts)
            }
        }
    }

    /// A sheet may stand in the middle of a voxel without dividing it.
    fn own_visible(&self, i: usize, all: PairFactor, counts: &mut Counts) -> PairFactor {
        if !self.occluders {
            return all;
        }
        let seed = ((i as u64) << 32) | i as u64;
        self.times_visibility(&self.items[i], &self.items[i], all, seed, counts)
    }

    fn kappa(&self, i: usize) -> Bands {
        self.zones.voxels[i - self.zones.voxel_offset()].extinction
    }

    /// Pairs with a cut voxel: sums over its samples where it is near, the centres where it is far.
    fn with_part(&self, a: &Zone, b: &Zone, seed: u64, counts: &mut Counts) -> PairFactor {
        let near = (a.centre - b.centre).length() < PART_FAR * (a.size.max(b.size));
        let m = match (&a.shape, &b.shape) {
            (Shape::Plate { plate, pane }, _) => part_plate(b, plate, pane.is_some(), near),
            (_, Shape::Plate { plate, pane }) => part_plate(a, plate, pane.is_some(), near),
            _ => self.part_volume(a, b),
        };
        let rays = if near { MORE_RAYS } else { FIRST_RAYS };
        self.average(a, b, m, seed, rays, counts)
    }

    /// Two volume zones, at least one of them cut.
    fn part_volume(&self, a: &Zone, b: &Zone) -> Moments {
        let cell = a.hi - a.lo;
        let offset = [0, 1, 2].map(|x| ((b.lo[x] - a.lo[x]) / cell[x]).round() as i64);
        if offset.iter().all(|o| o.abs() <= 1) {
            let whole;
            let (sa, sb) = match (a.samples(), b.samples()) {
                (Some(p), Some(q)) => (p, q),
                (Some(p), None) => {
                    whole = whole_samples(cell);
                    (p, &whole[..])
                }
                (None, Some(q)) => {
                    whole = whole_samples(cell);
                    (&whole[..], q)
                }
                (None, None) => unreachable!("one of the two is cut"),
            };
            return self.subcell_sum(offset, sa, sb);
        }
        let (p, q) = (a.aligned.as_ref().expect("aligned"), b.aligned.as_ref().expect("aligned"));
        let c = self.cache.get_cumulants(p, q);
        // The kernel at the centres of the free parts instead of those of the cells.
        let d2 = (a.centre - b.centre).length2();
        let cells = ((a.lo + a.hi) * 0.5 - (b.lo + b.hi) * 0.5).length2();
        let shift = cells / d2;
        let share = a.measure * b.measure / cell.product().powi(2);
        let mean = c.mean_distance / shift.sqrt();
        let value = c.factor.value * share * shift;
        let factor = zonal_math::Bounded::estimated(value, value * (1.0 - shift).abs().min(1.0));
        Moments { factor, mean, variance: c.variance, third: c.third }
    }

    /// Σ over the sub-cells of two parts whose cells lie `offset` apart, at most one cell on an axis.
    fn subcell_sum(&self, offset: [i64; 3], a: &[Sample], b: &[Sample]) -> Moments {
        let s = SUBCELLS as i64;
        let volume = self.sub_volume();
        let at = |k: u8| [k as i64 / (s * s), k as i64 / s % s, k as i64 % s];
        let mut sums = [0.0; 4];
        for p in a {
            let pa = at(p.subcell);
            for q in b {
                let qb = at(q.subcell);
                let d = [0, 1, 2].map(|x| (offset[x] * s + qb[x] - pa[x]).unsigned_abs() as usize);
                let [value, r, rr, rrr] = self.subcells[(d[0] * SUB_SPAN + d[1]) * SUB_SPAN + d[2]];
                let w = value * (p.volume / volume) * (q.volume / volume);
                sums = [sums[0] + w, sums[1] + w * r, sums[2] + w * rr, sums[3] + w * rrr];
            }
        }
        general::moments_of(sums, self.tolerance * sums[0])
    }

    fn sub_volume(&self) -> f64 {
        let z = &self.items[self.zones.voxel_offset()];
        (z.hi - z.lo).product() / (SUBCELLS * SUBCELLS * SUBCELLS) as f64
    }

    fn times_visibility(&self, a: &Zone, b: &Zone, base: PairFactor, seed: u64, counts: &mut Counts) -> PairFactor {
        let share = base.value[0] / weight(a).min(weight(b));
        let v = self.visibility(a, b, seed, share, counts);
        PairFactor {
            value: bands(|k| base.value[k] * v[k].0),
            radius: bands(|k| base.radius[k] * v[k].0 + base.value[k] * v[k].1),
        }
    }

    /// Visible share of the exchange of two zones in one uniform medium, and its standard error, a band.
    fn visibility(&self, a: &Zone, b: &Zone, seed: u64, share: f64, counts: &mut Counts) -> [(f64, f64); 3] {
        let (mut tally, points) = ([Tally::default(); 3], Points::new(seed));
        let kappa = self.uniform.unwrap_or([0.0; 3]);
        let mut shoot = |from: usize, to: usize, tally: &mut [Tally; 3]| {
            for k in from..to {
                let (x, y) = points.both(a, b, k);
                let w = kernel(a, b, x, y);
                let seen = if self.transport.blocked_inside(x, y) { 0.0 } else { 1.0 };
                if kappa == [0.0; 3] {
                    tally[0].add(w, seen);
                } else {
                    let r = (y - x).length();
                    (0..3).for_each(|k| tally[k].add(w * (-kappa[k] * r).exp(), seen));
                }
            }
            counts.rays += (to - from) as u64;
        };
        let close = is_close(a, b);
        let first = if close { MORE_RAYS } else { FIRST_RAYS };
        shoot(0, first, &mut tally);
        if tally[0].mixed() {
            counts.partial += 1;
            let n = match share > self.tolerance * 0.1 {
                true if std::ptr::eq(a, b) => OWN_RAYS,
                true if close => CLOSE_RAYS,
                true => MOST_RAYS,
                false => MORE_RAYS,
            };
            shoot(first, n, &mut tally);
        }
        if kappa == [0.0; 3] { [tally[0].mean_and_error(); 3] } else { tally.map(Tally::mean_and_error) }
    }

    /// A pane and anything not cut. Close to each other their larger plate is quartered: grazing paths through the pane differ much.
    fn pane_pair(&self, a: &Zone, b: &Zone, seed: u64, splits: u32, counts: &mut Counts) -> PairFactor {
        let close = (a.centre - b.centre).length() < a.size.max(b.size);
        let first = matches!(a.shape, Shape::Plate { .. }) && (a.size >= b.size || !matches!(b.shape, Shape::Plate { .. }));
        let (large, small) = if first { (a, b) } else { (b, a) };
        let Shape::Plate { plate, pane } = &large.shape else {
            unreachable!("a pane is a plate");
        };
        if !close || splits == 0 {
            let m = self.moments(a, b);
            return self.by_rays(a, b, m, seed, counts);
        }
        let mut sum = PairFactor::default();
        for (k, quarter) in plate.quarters().into_iter().enumerate() {
            let part = plate_zone(quarter, *pane);
            let f = self.pane_pair(&part, small, sequence::hash(seed + k as u64), splits - 1, counts);
            sum.value = bands(|b| sum.value[b] + f.value[b]);
            sum.radius = bands(|b| sum.radius[b].hypot(f.radius[b]));
        }
        sum
    }

    /// Attenuated and visible exchange by rays, as many as the pair deserves.
    fn by_rays(&self, a: &Zone, b: &Zone, m: Moments, seed: u64, counts: &mut Counts) -> PairFactor {
        let distance = (a.centre - b.centre).length();
        let near = distance < 2.0 * (a.size + b.size);
        let pane = [a, b].iter().any(|z| matches!(z.shape, Shape::Plate { pane: Some(_), .. }));
        let rays = if near && (pane || self.is_thick(a, b)) || self.uniform.is_none() && distance < a.size.max(b.size) {
            MOST_RAYS
        } else if near && self.varied || self.occluders && is_close(a, b) {
            MORE_RAYS
        } else if self.occluders || near {
            FIRST_RAYS
        } else {
            1
        };
        self.average(a, b, m, seed, rays, counts)
    }

    /// m's factor times the mean over rays of visibility, attenuation and the panes' own share.
    ///
    /// With the mean extinction κ of the rays, what the moments say of ⟨e^{−κr}⟩ is corrected by the ratio Σ w τ/Σ w e^{−κr} of the
    /// same rays: exact where the medium is uniform, and right where what is dimmed or hidden lies nearer or farther than the rest.
    fn average(&self, a: &Zone, b: &Zone, m: Moments, seed: u64, rays: usize, counts: &mut Counts) -> PairFactor {
        if m.factor.value <= 0.0 {
            return PairFactor { value: [0.0; 3], radius: [m.factor.radius; 3] };
        }
        let points = Points::new(seed);
        let mut shot: Vec<Ray> = Vec::with_capacity(rays.max(MORE_RAYS));
        let shoot = |from: usize, to: usize, shot: &mut Vec<Ray>| {
            for k in from..to {
                let (x, y) = if rays == 1 { (a.centre, b.centre) } else { points.both(a, b, k) };
                shot.push(self.along(a, b, x, y));
            }
        };
        shoot(0, rays, &mut shot);
        let blocked = shot.iter().filter(|r| r.through == [0.0; 3]).count();
        if rays > 1 && rays < MOST_RAYS && blocked > 0 && blocked < rays {
            counts.partial += 1;
            let share = m.factor.value * self.coupling(a, b);
            let n = if share > self.tolerance * 0.1 { MOST_RAYS } else { MORE_RAYS.max(rays) };
            shoot(rays, n, &mut shot);
        }
        counts.rays += shot.len() as u64;
        let thick = self.is_thick(a, b);
        let length: f64 = shot.iter().map(|r| r.w * r.r).sum();
        let weights: f64 = shot.iter().map(|r| r.w).sum();
        let mut out = PairFactor::default();
        for k in 0..3 {
            let chords = thick && a.thickness[k].max(b.thickness[k]) > THICK;
            let depth: f64 = shot.iter().map(|r| r.w * r.depth[k]).sum();
            let kappa = if chords || length <= 0.0 || depth > MOST_DEPTH * weights { 0.0 } else { depth / length };
            let mut tally = Tally::default();
            for r in &shot {
                let reference = (-kappa * r.r).exp();
                let tau = if chords { r.chords[k] } else { (-r.depth[k]).exp() };
                tally.add(r.w * reference, if reference > 0.0 { r.through[k] * tau / reference } else { 0.0 });
            }
            let (mean, error) = tally.mean_and_error();
            let base = m.transmittance(kappa);
            out.value[k] = m.factor.value * base * mean;
            out.radius[k] = base * (m.factor.radius * mean + m.factor.value * error);
        }
        out
    }

    /// The larger of the two shares of power per unit of g, with extinctions of order one over the size.
    fn coupling(&self, a: &Zone, b: &Zone) -> f64 {
        1.0 / weight(a).min(weight(b))
    }

    /// What a ray from x to y meets.
    fn along(&self, a: &Zone, b: &Zone, x: Vec3, y: Vec3) -> Ray {
        let d = y - x;
        let r = d.length();
        let w = kernel(a, b, x, y);
        let depth = match self.uniform {
            Some(k) => k.map(|k| k * r),
            None => self.transport.medium_depth(x, y),
        };
        let mut ray = Ray { w, r, depth, chords: [0.0; 3], through: [0.0; 3] };
        if self.occluders && self.transport.blocked_inside(x, y) {
            return ray;
        }
        if self.is_thick(a, b) {
            ray.chords = self.chords(a, b, x, y);
        }
        let (pa, pb) = (self.pane_share(a, d / r), self.pane_share(b, d / r));
        ray.through = bands(|k| pa[k] * pb[k]);
        if self.panes_between {
            let all = self.transport.optical_depth_inside(x, y);
            ray.through = bands(|k| ray.through[k] * (depth[k] - all[k]).min(0.0).exp());
        }
        ray
    }

    fn is_thick(&self, a: &Zone, b: &Zone) -> bool {
        let cut = a.samples().or(b.samples()).is_some();
        !cut && (0..3).any(|k| a.thickness[k].max(b.thickness[k]) > THICK)
    }

    /// Attenuation along the line through x and y, averaged over its chords in both zones: for a given line the points of a pair
    /// are uniform on them (dV dV'/r² = dA⊥ dω ds ds'), so each voxel gives (1 − e^{−κℓ})/(κℓ), and what lies between e^{−δ}.
    fn chords(&self, a: &Zone, b: &Zone, x: Vec3, y: Vec3) -> Bands {
        let w = (y - x).normalized();
        let r = (y - x).length();
        let (from, share_a) = chord(a, x, w, r);
        let (to, share_b) = chord(b, y, -w, r);
        let between = match self.uniform {
            Some(k) => k.map(|k| k * (to - from).dot(w).max(0.0)),
            None if (to - from).dot(w) > 0.0 => self.transport.medium_depth(from, to),
            None => [0.0; 3],
        };
        bands(|k| (-between[k]).exp() * share_a[k] * share_b[k])
    }

    /// (1 − e^{−κt/c})/κ of a pane in direction `w`; 1 for any other zone.
    fn pane_share(&self, z: &Zone, w: Vec3) -> Bands {
        let Shape::Plate { pane: Some(k), .. } = z.shape else {
            return [1.0; 3];
        };
        let p = &self.zones.panes[k];
        let path = p.thickness / z.normal.dot(w).abs().max(1e-6);
        p.extinction.map(|k| if k * path > 1e-12 { -(-k * path).exp_m1() / k } else { path })
    }
}

/// Where the line leaves a whole voxel from `x` along `w`, at most `reach` away, with (1 − e^{−κℓ})/(κℓ) of its chord there; of any
/// other zone, `x` and 1.
fn chord(z: &Zone, x: Vec3, w: Vec3, reach: f64) -> (Vec3, Bands) {
    if !matches!(z.shape, Shape::Cuboid) {
        return (x, [1.0; 3]);
    }
    let (mut ahead, mut behind) = (reach, f64::INFINITY);
    for axis in (0..3).filter(|&k| w[k] != 0.0) {
        let (p, q) = ((z.lo[axis] - x[axis]) / w[axis], (z.hi[axis] - x[axis]) / w[axis]);
        ahead = ahead.min(p.max(q).max(0.0));
        behind = behind.min(-p.min(q).min(0.0));
    }
    let length = ahead + behind;
    let mean = |depth: f64| if depth > 1e-9 { -(-depth).exp_m1() / depth } else { 1.0 };
    (x + w * ahead, z.thickness.map(|t| mean(t / z.size * length)))
}

/// F of a pane with itself per area and κ²: (4κt − 2 (1 − 2 E_3(κt)))/κ², what its faces do not let out.
fn pane_own(kappa: f64, thickness: f64) -> f64 {
    let tau = kappa * thickness;
    ((4.0 * tau - 2.0 * (1.0 - 2.0 * special::e3(tau))) / (kappa * kappa)).max(0.0)
}

/// What the shares of a zone's power are relative to: A, or 4V/size so that volumes compare with surfaces.
fn weight(z: &Zone) -> f64 {
    match z.shape {
        Shape::Plate { .. } => z.measure,
        _ => 4.0 * z.measure,
    }
}

fn plate_zone<'a>(plate: Plate, pane: Option<usize>) -> Zone<'a> {
    let (lo, hi) = plate.bounds();
    let normal = plate.normal();
    Zone {
        aligned: if pane.is_none() { aligned_rectangle(&plate, normal) } else { None },
        shape: Shape::Plate { plate, pane },
        normal,
        centre: plate.centre(),
        lo,
        hi,
        size: plate.diameter(),
        measure: plate.area(),
        thickness: [0.0; 3],
    }
}

/// The plate as an axis-aligned rectangle, if it is one to within rounding.
fn aligned_rectangle(p: &Plate, normal: Vec3) -> Option<Cuboid> {
    if p.kind != zonal_scene::PlateKind::Parallelogram {
        return None;
    }
    let along = |v: Vec3| (0..3).find(|&x| v[x].abs() >= v.length() * (1.0 - 1e-14) && others_vanish(v, x));
    let (x, y) = (along(p.e1)?, along(p.e2)?);
    if x == y {
        return None;
    }
    let axis = 3 - x - y;
    let (lo, hi) = p.bounds();
    let level = p.origin[axis];
    let set = |v: Vec3| {
        let mut a = v.array();
        a[axis] = level;
        Vec3::from_array(a)
    };
    Some(Cuboid { lo: set(lo), hi: set(hi), normal: Some((axis, if normal[axis] > 0.0 { 1 } else { -1 })) })
}

fn others_vanish(v: Vec3, axis: usize) -> bool {
    let eps = 1e-12 * v[axis].abs();
    (0..3).all(|x| x == axis || v[x].abs() <= eps)
}

/// True where all of `b` lies behind the plane of the patch `a`, or in it.
fn behind(a: &Zone, b: &Zone) -> bool {
    let Shape::Plate { plate, pane } = &a.shape else {
        return false;
    };
    let n = a.normal;
    let eps = 1e-10 * (a.size + b.size);
    let height = |p: Vec3| n.dot(p - plate.origin);
    if pane.is_some() {
        // Seen from both sides; only its own plane sees nothing of it.
        return matches!(&b.shape, Shape::Plate { plate: q, .. } if { let (c, m) = q.corners(); c[..m].iter().all(|&p| height(p).abs() <= eps) });
    }
    match &b.shape {
        Shape::Plate { plate: q, .. } => {
            let (c, m) = q.corners();
            c[..m].iter().all(|&p| height(p) <= eps)
        }
        _ => {
            let far = vec3(
                if n.x > 0.0 { b.hi.x } else { b.lo.x },
                if n.y > 0.0 { b.hi.y } else { b.lo.y },
                if n.z > 0.0 { b.hi.z } else { b.lo.z },
            );
            height(far) <= eps
        }
    }
}

/// φ^{−m} with φ the root of x⁷ = x + 1: the six-dimensional low-discrepancy sequence.
const ALPHA: [f64; 6] = {
    let phi = 1.112_775_684_278_705_5;
    let mut a = [0.0; 6];
    let mut p = 1.0;
    let mut m = 0;
    while m < 6 {
        p /= phi;
        a[m] = p;
        m += 1;
    }
    a
};

/// The points of a pair: a six-dimensional sequence shifted by a hash of the pair, three coordinates for each zone.
struct Points {
    shift: [f64; 6],
}

impl Points {
    fn new(seed: u64) -> Points {
        Points { shift: std::array::from_fn(|m| sequence::unit(seed.wrapping_mul(6).wrapping_add(m as u64))) }
    }
    /// The `k`-th points on both zones.
    fn both(&self, a: &Zone, b: &Zone, k: usize) -> (Vec3, Vec3) {
        let u: [f64; 6] = std::array::from_fn(|m| sequence::wrap(self.shift[m] + k as f64 * ALPHA[m]));
        (point(a, [u[0], u[1], u[2]]), point(b, [u[3], u[4], u[5]]))
    }
}

/// The point of a zone at coordinates in the unit cube.
fn point(z: &Zone, u: [f64; 3]) -> Vec3 {
    match &z.shape {
        Shape::Plate { plate, .. } => {
            let [s, t] = plate.warp([u[0], u[1]]);
            plate.at(s, t)
        }
        Shape::Cuboid => z.lo + (z.hi - z.lo).scale(Vec3::from_array(u)),
        Shape::Part(samples) => {
            let mut target = u[0] * z.measure;
            for s in samples.iter() {
                target -= s.volume;
                if target <= 0.0 {
                    return s.point;
                }
            }
            samples[samples.len() - 1].point
        }
    }
}

/// True where two zones nearly touch: a first look of few rays would miss what stands between.
fn is_close(a: &Zone, b: &Zone) -> bool {
    (a.centre - b.centre).length() < a.size + b.size
}

/// The kernel between two points, tamed where they come close: only ratios of it are used.
fn kernel(a: &Zone, b: &Zone, x: Vec3, y: Vec3) -> f64 {
    let d = y - x;
    let r2 = d.length2();
    let floor = 0.0025 * (a.size * a.size).min(b.size * b.size);
    let d = d / r2.sqrt().max(1e-300);
    let side = |z: &Zone, c: f64| match &z.shape {
        Shape::Plate { pane: None, .. } => c.max(0.0),
        Shape::Plate { .. } => c.abs(),
        _ => 1.0,
    };
    side(a, a.normal.dot(d)) * side(b, -b.normal.dot(d)) / r2.max(floor)
}

/// Weighted mean of a few samples.
#[derive(Clone, Copy, Default)]
struct Tally {
    w: f64,
    wx: f64,
    wxx: f64,
    ww: f64,
    n: f64,
    blocked: f64,
}

impl Tally {
    fn add(&mut self, w: f64, x: f64) {
        self.w += w;
        self.wx += w * x;
        self.wxx += w * x * x;
        self.ww += w * w;
        self.n += 1.0;
        self.blocked += if x == 0.0 { 1.0 } else { 0.0 };
    }
    fn mixed(&self) -> bool {
        self.blocked > 0.0 && self.blocked < self.n
    }
    fn mean_and_error(self) -> (f64, f64) {
        if self.w <= 0.0 {
            // No ray carried weight: what remains is a sliver of exchange across an edge.
            return ((self.n - self.blocked) / self.n.max(1.0), 0.5);
        }
        let mean = self.wx / self.w;
        let variance = (self.wxx / self.w - mean * mean).max(0.0);
        (mean, (variance * self.ww).sqrt() / self.w)
    }
}

/// A cut voxel and a plate: Σ over samples of the solid angle, or the centre where `near` is false.
fn part_plate(z: &Zone, plate: &Plate, two_sided: bool, near: bool) -> Moments {
    let Shape::Part(samples) = z.shape else {
        return whole_plate(z, plate, two_sided);
    };
    if near {
        general::points_plate(plate, samples.iter().map(|s| (s.point, s.volume)), two_sided)
    } else {
        general::points_plate(plate, std::iter::once((z.centre, z.measure)), two_sided)
    }
}

fn whole_plate(z: &Zone, plate: &Plate, two_sided: bool) -> Moments {
    general::plate_cuboid(plate, z.lo, z.hi, two_sided, 1e-2)
}

/// The samples of a whole cell, at the centres of its sub-cells, relative to its corner.
fn whole_samples(cell: Vec3) -> Vec<Sample> {
    let n = SUBCELLS;
    let volume = cell.product() / (n * n * n) as f64;
    (0..n * n * n)
        .map(|k| {
            let c = [k / (n * n), k / n % n, k % n].map(|c| (c as f64 + 0.5) / n as f64);
            Sample { point: cell.scale(Vec3::from_array(c)), volume, subcell: k as u8 }
        })
        .collect()
}

/// 𝓕, ⟨r⟩, ⟨r²⟩ and ⟨r³⟩ of two sub-cells by their offset, |offset| < 2·SUBCELLS on each axis.
fn subcell_table(cell: Vec3, cache: &FactorCache) -> Vec<[f64; 4]> {
    let n = SUB_SPAN;
    let a = Cuboid { lo: Vec3::ZERO, hi: cell, normal: None };
    (0..n * n * n)
        .map(|k| {
            let d = vec3((k / (n * n)) as f64, (k / n % n) as f64, (k % n) as f64);
            let lo = cell.scale(d);
            let c = cache.get_cumulants(&a, &Cuboid { lo, hi: lo + cell, normal: None });
            let (m, v) = (c.mean_distance, c.variance);
            [c.factor.value, m, m * m + v, c.third + m * (3.0 * v + m * m)]
        })
        .collect()
}

/// κ if it is the same all along every path between two zones, zero in vacuum.
fn uniform_medium(scene: &Scene, zones: &Zones, transport: &Transport) -> Option<Bands> {
    if transport.has_panes_between() {
        return None;
    }
    let Some(map) = scene.voxmap() else {
        return Some([0.0; 3]);
    };
    let kappa = map.uniform_extinction()?;
    if kappa == [0.0; 3] {
        return Some(kappa);
    }
    let slack = Vec3::splat(1e-9 * scene.diagonal());
    let (lo, hi) = (map.min() - slack, map.max() + slack);
    let inside = |p: &Plate| {
        let (a, b) = p.bounds();
        a.max(lo) == a && b.min(hi) == b
    };
    let all = zones.patches.iter().map(|p| &p.plate).chain(zones.panes.iter().map(|p| &p.plate)).all(inside);
    all.then_some(kappa)
}

/// What closure demands of Σ_j g_ij c_j, per unit of c_i: A of a patch, 4V of a voxel, 4At of a pane.
pub fn target(zones: &Zones, i: usize) -> f64 {
    if i < zones.voxel_offset() {
        zones.patches[i].area
    } else if i < zones.pane_offset() {
        4.0 * zones.voxels[i - zones.voxel_offset()].volume
    } else {
        let p = &zones.panes[i - zones.pane_offset()];
        4.0 * p.area * p.thickness
    }
}

/// c_i: 1 for a patch, κ for a volume zone.
pub fn strength(zones: &Zones, i: usize) -> Bands {
    if i < zones.voxel_offset() {
        [1.0; 3]
    } else if i < zones.pane_offset() {
        zones.voxels[i - zones.voxel_offset()].extinction
    } else {
        zones.panes[i - zones.pane_offset()].extinction
    }
}
