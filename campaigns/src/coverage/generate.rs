//! Random valid scenes: number `index` of a seed, small enough for every engine. The kinds of scenes are in `ordinary_kinds` and `rare_kinds`.

use super::model::{
    Block, HeatCondition, MediumPart, ModelLight, ModelMedium, ModelShape, ModelSurface, SceneModel,
    SurfaceProperties, add, sub,
};
use zonal_reference::Rng;
use zonal_scene::Bands;

/// The model of a scene, and the random numbers that follow it.
pub(super) fn model(seed: u64, index: u64, small: bool) -> (SceneModel, Rng) {
    let mut rng = Rng::new(seed.wrapping_mul(0x9E37_79B9).wrapping_add(index.wrapping_mul(0xD1B5_4A33)));
    let mut g = SceneGenerator::new(&mut rng, small);
    if g.chance(RARE_SHARE) {
        let model = g.rare();
        return (model, rng);
    }
    let u = g.rng.uniform();
    let model = match u {
        _ if u < 0.36 => g.furnace(),
        _ if u < 0.48 => g.periodic(),
        _ if u < 0.66 => g.solids(),
        _ if u < 0.76 => g.panes(),
        _ if u < 0.88 => g.plates(),
        _ if u < 0.95 => g.turned_room(),
        _ => g.shell(),
    };
    (model, rng)
}

/// The least and the largest residual at which an iteration is made to end.
const RESIDUALS: [f64; 2] = [1e-6, 1e-2];
/// The least and the largest tolerance of a scene.
const TOLERANCES: [f64; 2] = [0.003, 0.05];
/// Share of the kinds of `rare_kinds`.
const RARE_SHARE: f64 = 0.4;

/// Surface of an axis-aligned box.
pub(super) fn box_area(lo: Block, hi: Block) -> f64 {
    let d = sub(hi, lo);
    2.0 * (d[0] * d[1] + d[1] * d[2] + d[2] * d[0])
}

/// Edges of the cells of a box, m.
pub(super) fn edges(size: Block, cells: [usize; 3]) -> Block {
    [0, 1, 2].map(|k| size[k] / cells[k] as f64)
}

/// The largest optical depth across an edge of a cell: thicker ones are the matter of `zonal validate`, cases `thick`.
const MAX_CELL_DEPTH: f64 = 1.0;

pub(super) struct SceneGenerator<'a> {
    pub(super) rng: &'a mut Rng,
    pub(super) thermal: bool,
    /// Number of bands that differ.
    pub(super) bands: usize,
    /// Shares that depend on temperature: only given temperatures then.
    pub(super) given: bool,
    small: bool,
    pub(super) features: Vec<&'static str>,
}

impl<'a> SceneGenerator<'a> {
    fn new(rng: &'a mut Rng, small: bool) -> SceneGenerator<'a> {
        let thermal = rng.uniform() < 0.5;
        let u = rng.uniform();
        let bands = 1 + [0.6, 0.75].iter().filter(|limit| u >= **limit).count();
        let given = thermal && bands > 1 && rng.uniform() < 0.4;
        let mut features = vec![if thermal { "thermal" } else { "light" }];
        features.push(["one band", "two bands", "three bands"][bands - 1]);
        if given {
            features.push("weights by temperature");
        }
        SceneGenerator { rng, thermal, bands, given, small, features }
    }

    pub(super) fn chance(&mut self, p: f64) -> bool {
        self.rng.uniform() < p
    }
    pub(super) fn whole(&mut self, lo: usize, hi: usize) -> usize {
        lo + (self.rng.uniform() * (hi - lo + 1) as f64) as usize
    }
    /// A number of few digits.
    pub(super) fn short(x: f64) -> f64 {
        format!("{x:.2e}").parse().unwrap_or(x)
    }
    pub(super) fn between(&mut self, lo: f64, hi: f64) -> f64 {
        SceneGenerator::short(self.rng.uniform_in(lo, hi))
    }
    /// Evenly spread logarithms.
    pub(super) fn log(&mut self, lo: f64, hi: f64) -> f64 {
        SceneGenerator::short(self.rng.uniform_in(lo.ln(), hi.ln()).exp())
    }
    /// The same in all bands, or not.
    pub(super) fn spread(&mut self, mut draw: impl FnMut(&mut Self) -> f64) -> Bands {
        let first = draw(self);
        match self.bands {
            1 => Bands::splat(first),
            2 => Bands::from_rgb([first, first, draw(self)]),
            _ => Bands::from_rgb([first, draw(self), draw(self)]),
        }
    }

    pub(super) fn heat(&mut self, area: f64) -> HeatCondition {
        if self.given || self.chance(0.6) {
            return HeatCondition::Temperature(self.between(300.0, 1500.0).round());
        }
        self.features.push("known power");
        match self.whole(0, 3) {
            0 | 1 => HeatCondition::Flux(0.0),
            2 => HeatCondition::Flux(self.between(100.0, 5000.0)),
            _ => HeatCondition::Power(SceneGenerator::short(area * self.rng.uniform_in(100.0, 5000.0))),
        }
    }

    pub(super) fn look(&mut self, area: f64) -> SurfaceProperties {
        let black = self.chance(0.25);
        let reflectance = if black { Bands::ZERO } else { self.spread(|m| m.between(0.05, 0.9)) };
        let shines = self.chance(0.4);
        let emission = if shines { self.spread(|m| m.between(1.0, 100.0)) } else { Bands::ZERO };
        SurfaceProperties { reflectance, emission, heat: self.heat(area), both: false }
    }

    /// A medium of this optical depth across its least edge, and of at most [`MAX_CELL_DEPTH`] across an edge of a cell.
    pub(super) fn part(&mut self, min: Block, max: Block, cell: Block, depth: f64) -> MediumPart {
        let length = (0..3).map(|k| max[k] - min[k]).fold(f64::INFINITY, f64::min);
        let most = MAX_CELL_DEPTH / cell.iter().fold(0.0f64, |m, c| m.max(*c));
        let kappa = (depth / length).min(most);
        let extinction = self.spread(|m| {
            let factor = if m.bands == 1 { 1.0 } else { m.log(0.1, 3.0) };
            SceneGenerator::short((kappa * factor).min(most))
        });
        let albedo = match self.whole(0, 2) {
            0 => Bands::ZERO,
            1 => self.spread(|m| m.between(0.1, 0.9)),
            _ => {
                self.features.push("bright medium");
                self.spread(|m| m.between(0.9, 0.99))
            }
        };
        let shines = self.chance(0.5);
        let emission = if shines { self.spread(|m| m.between(1.0, 100.0)) } else { Bands::ZERO };
        let heat = if self.given || self.chance(0.5) {
            HeatCondition::Temperature(self.between(400.0, 1600.0).round())
        } else {
            self.features.push("medium of known heat");
            HeatCondition::Flux(if self.chance(0.5) { 0.0 } else { self.between(100.0, 20000.0) })
        };
        let source = if self.chance(0.15) { self.spread(|m| m.between(1.0, 50.0)) } else { Bands::ZERO };
        let source = if kappa > 1e-3 { source } else { Bands::ZERO };
        MediumPart { min, max, extinction, albedo, emission, source, heat }
    }

    /// Optical depth across the least edge of a medium.
    pub(super) fn depth(&mut self) -> f64 {
        let (word, depth) = match self.whole(0, 5) {
            0 => ("very thin medium", self.log(1e-10, 1e-4)),
            1 => ("thin medium", self.log(1e-3, 0.1)),
            2 | 3 => ("medium of depth one", self.log(0.1, 3.0)),
            _ => ("thick medium", self.log(3.0, 15.0)),
        };
        self.features.push(word);
        depth
    }

    pub(super) fn empty(&mut self) -> SceneModel {
        let shares = match (self.thermal && self.bands > 1, self.given) {
            (false, _) => String::new(),
            (true, false) => "band_fractions = [0.25, 0.25, 0.5]".into(),
            (true, true) => "weights = [[0.2, 1e-4], [0.1, 1e-4], \"rest\"]\nrange = [300, 2000]".into(),
        };
        let tolerance = self.log(TOLERANCES[0], TOLERANCES[1]);
        let (mut radiance, mut surroundings) = (Bands::ZERO, None);
        if self.chance(0.3) {
            radiance = self.spread(|m| m.between(1.0, 30.0));
            surroundings = Some(self.between(280.0, 1000.0).round());
        }
        SceneModel {
            thermal: self.thermal,
            shares,
            radiance: if self.thermal { Bands::ZERO } else { radiance },
            surroundings: surroundings.filter(|_| self.thermal),
            tolerance,
            ..SceneModel::default()
        }
    }

    /// Something that fixes the temperatures' level, and something that shines.
    pub(super) fn finished(&mut self, mut m: SceneModel) -> SceneModel {
        // Closed walls hide the surroundings.
        let open = |s: &ModelSurface| match &s.shape {
            ModelShape::Room { walls, .. } => walls.iter().any(Option::is_none),
            _ => true,
        };
        let mut warm = m.surroundings.is_some() && !m.closed_room && m.surfaces.first().is_none_or(open);
        let mut lit = !m.lights.is_empty() || m.radiance != Bands::ZERO;
        let mut visit = |l: &mut SurfaceProperties| {
            warm |= matches!(l.heat, HeatCondition::Temperature(_));
            lit |= l.emission != Bands::ZERO;
        };
        for s in &mut m.surfaces {
            match &mut s.shape {
                ModelShape::Room { walls, .. } => walls.iter_mut().flatten().for_each(&mut visit),
                _ => visit(&mut s.look),
            }
        }
        let fix = |l: &mut SurfaceProperties| {
            if !warm {
                l.heat = HeatCondition::Temperature(1000.0);
            }
            if !lit {
                l.emission = Bands::splat(50.0);
            }
        };
        if let Some(s) = m.surfaces.first_mut() {
            match &mut s.shape {
                ModelShape::Room { walls, .. } => walls.iter_mut().flatten().take(1).for_each(fix),
                _ => fix(&mut s.look),
            }
        }
        if self.thermal {
            m.lights.clear();
        }
        // The last draw, so that the rest of a scene does not depend on it.
        if self.chance(0.2) {
            self.features.push("large residual");
            m.residual = Some(self.log(RESIDUALS[0], RESIDUALS[1]));
        }
        self.features.sort_unstable();
        self.features.dedup();
        m.features = std::mem::take(&mut self.features);
        m
    }

    /// Lights of scenes that light can enter, or that have room for an emitter.
    pub(super) fn lights(&mut self, m: &mut SceneModel, open: bool, centre: Block, size: Block) {
        if self.thermal || m.periodic != [false; 3] {
            return;
        }
        if open && self.chance(0.35) {
            self.features.push("sun");
            let d = [self.between(-1.0, 1.0), self.between(-1.0, 1.0), -self.between(0.2, 1.0)];
            let irradiance = self.spread(|m| m.between(10.0, 300.0));
            let degrees = if self.chance(0.5) { 0.53 } else { self.between(2.0, 20.0) };
            m.lights.push(ModelLight::Sun { direction: d, irradiance, degrees });
        }
        if open && self.chance(0.25) {
            self.features.push("sky");
            m.lights.push(ModelLight::Sky { radiance: self.spread(|m| m.between(1.0, 30.0)) });
        }
        if self.chance(0.35) {
            self.features.push("emitter");
            let edge = self.between(0.08, 0.3);
            let corner = add(
                centre,
                [0, 1, 2].map(|k| size[k] * self.rng.uniform_in(-0.3, 0.1)).map(SceneGenerator::short),
            );
            let mut look = self.look(1.0);
            look.emission = self.spread(|m| m.between(100.0, 1000.0));
            let edges = [[0.0, edge * size[1], 0.0], [edge * size[0], 0.0, 0.0]];
            let shape = ModelShape::Plate { corner, edges, triangle: false };
            m.add("lamp", shape, look);
            m.lights.push(ModelLight::Emitter { surface: "lamp".into() });
        }
    }

    /// Adds a room, each of whose walls but the first is missing with a probability; returns whether one is.
    pub(super) fn room(&mut self, m: &mut SceneModel, size: Block, missing: f64) -> bool {
        let mut open = false;
        let walls: [Option<SurfaceProperties>; 6] = std::array::from_fn(|k| {
            if self.chance(missing) && k != 0 {
                open = true;
                return None;
            }
            let area = (0..3).filter(|a| *a != k / 2).map(|a| size[a]).product();
            Some(self.look(area))
        });
        if open {
            self.features.push("open");
        }
        let (reflectance, emission) = (Bands::splat(0.5), Bands::ZERO);
        let look = SurfaceProperties { reflectance, emission, heat: HeatCondition::Flux(0.0), both: false };
        m.add("room", ModelShape::Room { min: [0.0; 3], max: size, walls: Box::new(walls) }, look);
        open
    }

    /// A scene in a room; in this share of the scenes walls are missing, each with a probability.
    pub(super) fn in_room(&mut self, size: Block, share: f64, missing: f64) -> (SceneModel, bool) {
        let mut m = self.empty();
        let missing = if self.chance(share) { missing } else { 0.0 };
        let open = self.room(&mut m, size, missing);
        (m, open)
    }

    /// A size of patches in a room of this mean edge.
    pub(super) fn patch(&mut self, mean: f64) -> Option<f64> {
        let [lo, hi] = if self.small { [0.5, 0.8] } else { [0.35, 0.65] };
        Some(SceneGenerator::short(mean * self.rng.uniform_in(lo, hi)))
    }

    /// A size of patches in a room.
    pub(super) fn patch_in(&mut self, size: Block) -> Option<f64> {
        self.patch((size[0] + size[1] + size[2]) / 3.0)
    }

    pub(super) fn size(&mut self) -> Block {
        let scale = if self.chance(0.2) { self.log(0.1, 10.0) } else { 1.0 };
        [0; 3].map(|_| SceneGenerator::short(scale * self.rng.uniform_in(0.5, 2.0)))
    }

    /// A medium without sources that is the same everywhere, or none.
    pub(super) fn even_medium(
        &mut self,
        filled: bool,
        size: Block,
        lo: usize,
        hi: usize,
    ) -> Option<ModelMedium> {
        if !filled {
            self.features.push("vacuum");
            return None;
        }
        let depth = self.depth();
        let cells = self.cells(lo, hi);
        let mut whole = self.part([0.0; 3], size, edges(size, cells), depth.min(4.0));
        whole.source = Bands::ZERO;
        ModelMedium::even(whole, cells)
    }

    pub(super) fn cells(&mut self, lo: usize, hi: usize) -> [usize; 3] {
        let hi = if self.small { lo + 1 } else { hi };
        let cells = [0; 3].map(|_| self.whole(lo, hi));
        self.features.push(match cells.iter().filter(|c| **c % 2 == 1).count() {
            0 => "even cells",
            3 => "odd cells",
            _ => "odd and even cells",
        });
        cells
    }
}
