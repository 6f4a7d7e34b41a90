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
//! | two plates in any position | contours in closed form, Gauss rules, **proved** | moments of the distance, estimated |
//! | a plate in any position and a voxel | closed solid angle inside, Gauss points outside, estimated | the same |
//! | a voxel cut by walls | sums over its samples | the same, ray by ray |
//! | a pane | as a plate that is seen from both sides, times (1 − e^{−κt/c})/κ, c the cosine | the same |
//!
//! Where the scene repeats itself, an axis-aligned pair in a uniform medium has the sum over the images of one of its zones.
//!
//! **Visibility** multiplies: the mean over rays between points of both zones, weighted by the kernel. Few rays first; where
//! they disagree, more. The points differ from pair to pair, so that the errors of neighbours do not add up.

mod agree;
mod geometry;
mod images;
mod parts;
mod rays;
mod spread;
mod strips;
mod zone;

use crate::aligned::{Cuboid, FactorCache};
use crate::general::{self, Moments};
use crate::paper::strip::Voxels;
use crate::polygon::Plates;
use agree::Agreement;
use images::Images;
use parts::subcell_table;
pub use rays::SUCCESSION;
use rays::pane_own;
use std::f64::consts::PI;
use zonal_math::{Bounded, Grade, Vec3, sequence};
use zonal_scene::zones::SUBCELLS;
use zonal_scene::{Bands, Plate, Scene, Zones, bands};
use zonal_transport::Transport;
use zone::{Items, Shape, Zone, aligned_rectangle, behind};

/// The share of the smaller area that is a radius small enough in any case.
const PLATE_ABSOLUTE: f64 = 1e-12;
/// A side of a pane has no part of a cuboid that is thinner than this share of it.
const LEAST_SIDE: f64 = 1e-12;

/// Which formula gives the exchange of two whole voxels. Every other pair has its exact factor always: the paper has no formula of its own
/// for them. Nor can formula (3) serve a voxel with itself, which is exact there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VoxelFactors {
    /// The reduced integral with the attenuation inside.
    #[default]
    Exact,
    /// The paper's algorithm `Formfact`, a Gegenbauer series a strip, times the transmittance of the distance between the centres.
    Series,
    /// Proposition 1: the exact geometric factor times that transmittance.
    Proposition1,
    /// Formula (3): everything at the centres.
    Point,
}

/// How the exchange of pairs is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Relative radius of the axis-aligned factors. The default, 1e-11, is exact for every purpose of a solve.
    pub aligned_tolerance: f64,
    /// Relative radius of the factors of two plates in a general position, before anything that stands between them.
    pub plate_tolerance: f64,
    /// The formula for two voxels.
    pub voxels: VoxelFactors,
    /// Keep every zone ready for its pairs, about 500 bytes each: worth it where most pairs are asked for, not where few are.
    pub keep_zones: bool,
    /// Which sample rays take their points from: any other gives an independent answer of the same quality.
    pub sample: u64,
}

impl Settings {
    /// What the points of the pair of zones `i` and `j` are drawn by.
    fn seed(&self, i: usize, j: usize) -> u64 {
        ((i as u64) << 32 | j as u64) ^ sample_seed(self.sample)
    }
}

/// What sets the points of one sample apart from those of others; nought for the first.
pub fn sample_seed(sample: u64) -> u64 {
    if sample == 0 { 0 } else { sequence::hash(sample) }
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            aligned_tolerance: 1e-11,
            plate_tolerance: 1e-9,
            voxels: VoxelFactors::Exact,
            keep_zones: true,
            sample: 0,
        }
    }
}

/// What was counted while pairs were computed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Pairs of axis-aligned zones by exact factors.
    pub aligned: u64,
    /// Pairs of voxels by a formula of the paper.
    pub paper: u64,
    /// Pairs with a plate in a general position.
    pub general: u64,
    /// Pairs whose geometric factor has an estimated radius.
    pub estimated: u64,
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
        self.paper += o.paper;
        self.general += o.general;
        self.estimated += o.estimated;
        self.cut += o.cut;
        self.pane += o.pane;
        self.facing_away += o.facing_away;
        self.partial += o.partial;
        self.rays += o.rays;
    }

    /// True where every radius is proved: no ray and no estimate took part.
    pub fn all_proved(&self) -> bool {
        self.rays + self.estimated == 0
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

/// A zone whose pairs are asked for, with what they share.
pub struct Row {
    i: usize,
    /// 𝓕 with every cell of the voxmap by the paper's algorithm, where it is asked for.
    series: Vec<Bounded>,
}

/// Exchange of the zones of a scene.
pub struct Exchange<'a> {
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    items: Items<'a>,
    cache: FactorCache,
    settings: Settings,
    /// The patches, ready for pairs in any position.
    plates: Plates,
    /// The voxmap as the paper's algorithm wants it.
    grid: Option<Voxels>,
    tolerance: f64,
    /// κ where every zone lies in one uniform medium (zero in vacuum) and no pane can stand between two zones.
    uniform: Option<Bands>,
    occluders: bool,
    /// Extinction varies inside the voxmap, or a pane can stand between two zones: a few rays do not tell the attenuation.
    varied: bool,
    /// Some pane can stand between two zones.
    panes_between: bool,
    /// Images of the scene, where it repeats itself.
    images: Option<Images>,
    /// What pairs may hide whose rays agree.
    agreement: Agreement,
    /// Factors of sub-cells by their offset, with the means of r, r² and r³.
    subcells: Vec<[f64; 4]>,
}

impl<'a> Exchange<'a> {
    /// Prepares the exchange of `zones`, which were built from `scene`.
    pub fn new(scene: &'a Scene, zones: &'a Zones, transport: &'a Transport<'a>) -> Exchange<'a> {
        Exchange::with_settings(scene, zones, transport, Settings::default())
    }

    /// The same with settings of one's own.
    pub fn with_settings(
        scene: &'a Scene,
        zones: &'a Zones,
        transport: &'a Transport<'a>,
        settings: Settings,
    ) -> Exchange<'a> {
        let cell = scene.voxmap().map_or(Vec3::ZERO, |v| v.cell());
        let cache = FactorCache::new(settings.aligned_tolerance);
        let subcells = if zones.voxels.iter().any(|z| !z.part.is_empty()) {
            subcell_table(cell * (1.0 / SUBCELLS as f64), &cache)
        } else {
            Vec::new()
        };
        let mut exchange = Exchange {
            zones,
            transport,
            items: Items::new(scene, zones, settings.keep_zones),
            cache,
            settings,
            plates: Plates::new(&zones.patches.iter().map(|p| p.plate).collect::<Vec<_>>()),
            grid: scene.voxmap().map(Voxels::of),
            tolerance: scene.options().tolerance,
            uniform: uniform_medium(scene, zones, transport),
            varied: transport.has_panes_between()
                || scene.voxmap().is_some_and(|v| v.uniform_extinction().is_none())
                || uniform_medium(scene, zones, transport).is_none(),
            occluders: transport.has_occluders(),
            panes_between: transport.has_panes_between(),
            images: Images::of(scene),
            agreement: Agreement::default(),
            subcells,
        };
        exchange.agreement = exchange.agreement();
        exchange
    }

    /// g_ij; symmetric to the bit.
    pub fn pair(&self, i: usize, j: usize, counts: &mut Counts) -> PairFactor {
        let (i, j) = if i < j { (j, i) } else { (i, j) };
        self.pair_in(&self.row(i), j, counts)
    }

    /// What the pairs of zone `i` with those up to itself share: asked once for a row, it spares work.
    pub fn row(&self, i: usize) -> Row {
        let whole = matches!(self.items.get(i).shape, Shape::Cuboid);
        let series = whole && self.settings.voxels == VoxelFactors::Series;
        Row { i, series: if series { self.strips(i) } else { Vec::new() } }
    }

    /// g_ij of the row's zone i and j ≤ i.
    pub fn pair_in(&self, row: &Row, j: usize, counts: &mut Counts) -> PairFactor {
        let i = row.i;
        assert!(j <= i, "a row has the zones up to its own");
        let (a, b) = (&*self.items.get(i), &*self.items.get(j));
        if i == j {
            return self.own(i, counts);
        }
        if behind(a, b) || behind(b, a) {
            counts.facing_away += 1;
            return PairFactor::default();
        }
        let seed = self.settings.seed(i, j);
        match (&a.shape, &b.shape) {
            (Shape::Part(_), _) | (_, Shape::Part(_)) => {
                counts.cut += 1;
                counts.estimated += 1;
                self.with_part(a, b, seed, counts)
            }
            (Shape::Plate { pane: Some(_), .. }, _) | (_, Shape::Plate { pane: Some(_), .. }) => {
                counts.pane += 1;
                counts.estimated += 1;
                self.pane_pair(a, b, seed, self.pane_splits(a, b), counts)
            }
            (Shape::Cuboid, Shape::Cuboid) if self.settings.voxels != VoxelFactors::Exact => {
                counts.paper += 1;
                counts.estimated += 1;
                let m = self.at_centres(row, j);
                self.attenuated(a, b, m, self.uniform, seed, counts)
            }
            _ => self.simple((i, j), seed, counts),
        }
    }

    /// A formula of the paper for two voxels: its geometric factor, all of it at the distance of the centres.
    fn at_centres(&self, row: &Row, j: usize) -> Moments {
        let (a, b) = (&*self.items.get(row.i), &*self.items.get(j));
        let r = (a.centre - b.centre).length();
        let factor = match (self.settings.voxels, &a.aligned, &b.aligned) {
            (VoxelFactors::Point, ..) => {
                let f = a.measure * b.measure / (PI * r * r);
                Bounded::estimated(f, 0.0)
            }
            (VoxelFactors::Series, ..) => row.series[self.zones.voxels[j - self.zones.voxel_offset()].cell],
            (_, Some(p), Some(q)) => self.cache.get(p, q, 0.0),
            _ => unreachable!("voxels are aligned"),
        };
        Moments { factor, mean: r, ..Moments::ZERO }
    }

    /// Pairs of patches and whole voxels.
    fn simple(&self, (i, j): (usize, usize), seed: u64, counts: &mut Counts) -> PairFactor {
        let (a, b) = (&*self.items.get(i), &*self.items.get(j));
        if let (Some(p), Some(q)) = (&a.aligned, &b.aligned) {
            counts.aligned += 1;
            if let Some(kappa) = self.uniform {
                let mut out = PairFactor::default();
                for k in 0..3 {
                    if let Some(same) = (0..k).find(|&m| kappa[m] == kappa[k]) {
                        (out.value[k], out.radius[k]) = (out.value[same], out.radius[same]);
                    } else {
                        let f = self.aligned(p, q, kappa[k]);
                        (out.value[k], out.radius[k]) = (f.value, f.radius);
                    }
                }
                return if self.occluders { self.times_visibility(a, b, out, seed, counts) } else { out };
            }
        } else {
            counts.general += 1;
            if i < self.zones.voxel_offset() {
                return self.two_plates((i, j), seed, counts);
            }
        }
        counts.estimated += u64::from(a.aligned.is_none() || b.aligned.is_none());
        let m = self.moments(a, b);
        self.attenuated(a, b, m, self.uniform.filter(|_| !self.is_thick(a, b)), seed, counts)
    }

    /// Two boxes or rectangles along the axes in a uniform medium, with all images of one of them.
    fn aligned(&self, p: &Cuboid, q: &Cuboid, kappa: f64) -> Bounded {
        match &self.images {
            Some(images) => images.sum(p, q, kappa),
            None => self.cache.get(p, q, kappa),
        }
    }

    /// Two patches, one at least in a general position: the factor proved, its moments of distance, where they are wanted, estimated.
    fn two_plates(&self, (i, j): (usize, usize), seed: u64, counts: &mut Counts) -> PairFactor {
        let (a, b) = (&*self.items.get(i), &*self.items.get(j));
        let factor = self.plates.pair(i, j, self.settings.plate_tolerance, PLATE_ABSOLUTE).bounded;
        if self.uniform != Some([0.0; 3]) {
            let m = Moments { factor, ..self.moments(a, b) };
            counts.estimated += 1;
            return self.attenuated(a, b, m, self.uniform.filter(|_| !self.is_thick(a, b)), seed, counts);
        }
        counts.estimated += u64::from(factor.grade != Grade::Proved);
        let out = PairFactor { value: [factor.value; 3], radius: [factor.radius; 3] };
        if self.occluders { self.times_visibility(a, b, out, seed, counts) } else { out }
    }

    /// A geometric factor with what lies between: a `uniform` medium, or whatever rays meet.
    fn attenuated(
        &self,
        a: &Zone,
        b: &Zone,
        m: Moments,
        uniform: Option<Bands>,
        seed: u64,
        counts: &mut Counts,
    ) -> PairFactor {
        match uniform {
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
            return self.cache.get_cumulants(p, q).into();
        }
        let tolerance = self.tolerance;
        match (&a.shape, &b.shape) {
            (Shape::Plate { plate: p, pane: u }, Shape::Plate { plate: q, pane: v }) => {
                general::plate_plate(p, q, [u.is_some(), v.is_some()], tolerance)
            }
            (Shape::Plate { plate, pane }, _) => self.plate_cuboid(plate, pane.is_some(), b),
            (_, Shape::Plate { plate, pane }) => self.plate_cuboid(plate, pane.is_some(), a),
            _ => unreachable!("two cuboids are aligned"),
        }
    }

    /// The same of a plate, with both its sides if it is a pane, and a cuboid. The sides of an axis-aligned pane are two axis-aligned patches, each
    /// before its part of the cuboid.
    fn plate_cuboid(&self, plate: &Plate, both: bool, b: &Zone) -> Moments {
        let Some(rectangle) = (if both { aligned_rectangle(plate, plate.normal()) } else { None }) else {
            return general::plate_cuboid(plate, b.lo, b.hi, both, self.tolerance);
        };
        let axis = rectangle.normal.map_or(0, |(axis, _)| axis);
        let level = rectangle.lo[axis];
        let side = |sign: i8| {
            let (mut lo, mut hi) = (b.lo.array(), b.hi.array());
            if sign > 0 {
                lo[axis] = lo[axis].max(level);
            } else {
                hi[axis] = hi[axis].min(level);
            }
            if hi[axis] - lo[axis] <= LEAST_SIDE * (b.hi[axis] - b.lo[axis]) {
                return Moments::ZERO;
            }
            let part = Cuboid { lo: Vec3::from_array(lo), hi: Vec3::from_array(hi), normal: None };
            self.cache.get_cumulants(&Cuboid { normal: Some((axis, sign)), ..rectangle }, &part).into()
        };
        side(1).beside(&side(-1))
    }

    /// Exchange of a zone with itself.
    fn own(&self, i: usize, counts: &mut Counts) -> PairFactor {
        let z = &*self.items.get(i);
        match &z.shape {
            Shape::Plate { pane: None, .. } => PairFactor::default(),
            Shape::Plate { pane: Some(k), .. } => {
                let p = &self.zones.panes[*k];
                let value =
                    p.extinction.map(|k| if k > 0.0 { pane_own(k, p.thickness) * z.measure } else { 0.0 });
                PairFactor { value, radius: [0.0; 3] }
            }
            Shape::Cuboid => {
                let kappa = self.kappa(i);
                let c = z.aligned.as_ref().expect("a voxel is aligned");
                // Proposition 1 has the transmittance of the distance between the centres, which is none here.
                let outside =
                    matches!(self.settings.voxels, VoxelFactors::Series | VoxelFactors::Proposition1);
                let f = kappa.map(|k| self.aligned(c, c, if outside { 0.0 } else { k }));
                let all = PairFactor { value: f.map(|f| f.value), radius: f.map(|f| f.radius) };
                self.own_visible(i, all, counts)
            }
            Shape::Part(samples) => {
                counts.cut += 1;
                counts.estimated += 1;
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
        let seed = self.settings.seed(i, i);
        let z = self.items.get(i);
        self.times_visibility(&z, &z, all, seed, counts)
    }

    fn kappa(&self, i: usize) -> Bands {
        self.zones.voxels[i - self.zones.voxel_offset()].extinction
    }
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
