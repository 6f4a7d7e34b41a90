//! Random scenes of the ordinary kinds: boxes on the grid of their medium, periodic media, rooms with solids or panes, plates in vacuum, turned rooms and
//! hollow shells.

use super::generate::{SceneGenerator, box_area, edges};
use super::model::{
    Block, FrontSide, HeatCondition, ModelMedium, ModelPane, ModelShape, SceneModel, last_band, quads, sub,
    times,
};
use zonal_scene::Bands;

impl SceneGenerator<'_> {
    /// A box on the grid of its medium.
    pub(super) fn furnace(&mut self) -> SceneModel {
        self.features.push("box");
        let (size, cells) = (self.size(), self.cells(2, 5));
        let (mut m, open) = self.in_room(size, 0.4, 0.2);
        let depth = self.depth();
        let whole = self.part([0.0; 3], size, edges(size, cells), depth);
        let mut regions = Vec::new();
        if self.chance(0.35) {
            self.features.push("varying medium");
            let lo: Block =
                [0, 1, 2].map(|k| size[k] * (self.whole(0, cells[k] - 1) as f64) / cells[k] as f64);
            let depth = depth.max(1e-3) * self.log(0.2, 5.0);
            let mut part = self.part(lo, size, edges(size, cells), depth.min(20.0));
            if self.chance(0.3) {
                part.extinction = whole.extinction;
            }
            regions.push(part);
        }
        m.medium = Some(ModelMedium { whole, cells, regions });
        self.lights(&mut m, open, times(size, 0.5), size);
        self.finished(m)
    }

    pub(super) fn periodic(&mut self) -> SceneModel {
        self.features.push("periodic");
        let (size, cells) = (self.size(), self.cells(1, 5));
        let mut m = self.empty();
        (m.radiance, m.surroundings) = (Bands::ZERO, None);
        self.room(&mut m, size, 0.0);
        let axes = self.whole(1, 2);
        let first = self.whole(0, 2);
        for k in 0..axes {
            let axis = (first + k) % 3;
            m.periodic[axis] = true;
            if let ModelShape::Room { walls, .. } = &mut m.surfaces[0].shape {
                (walls[2 * axis], walls[2 * axis + 1]) = (None, None);
            }
        }
        let depth = self.depth();
        let mut whole = self.part([0.0; 3], size, edges(size, cells), depth);
        if self.bands > 1 && self.chance(0.3) {
            self.features.push("one band very thin");
            whole.extinction[last_band()] = self.log(1e-12, 1e-6);
            whole.source = Bands::ZERO;
        }
        m.medium = ModelMedium::even(whole, cells);
        self.finished(m)
    }

    /// A room with solids in it: boxes and meshes, apart, on the floor, touching or nested.
    pub(super) fn solids(&mut self) -> SceneModel {
        self.features.push("solids");
        let size = self.size();
        let (mut m, open) = self.in_room(size, 0.3, 0.3);
        let at = |m: &mut Self, lo: f64, hi: f64| {
            [0, 1, 2].map(|k| Self::short(size[k] * m.rng.uniform_in(lo, hi)))
        };
        let (mut lo, mut hi) = (at(self, 0.2, 0.35), at(self, 0.5, 0.7));
        if self.chance(0.4) {
            self.features.push("solid on the floor");
            (hi[2], lo[2]) = (Self::short(hi[2] - lo[2]), 0.0);
        }
        let look = self.look(box_area(lo, hi));
        let shape = if self.chance(0.5) {
            self.features.push("mesh");
            ModelShape::Mesh { quads: quads(lo, hi, FrontSide::Outside) }
        } else {
            let degrees = if self.chance(0.4) { self.between(5.0, 80.0).round() } else { 0.0 };
            ModelShape::Box { min: lo, max: hi, degrees }
        };
        let turned = matches!(shape, ModelShape::Box { degrees, .. } if degrees != 0.0);
        m.add("solid", shape, look);
        if !turned && self.chance(0.25) {
            self.touching_solid(&mut m, lo, hi, size);
        }
        let depth = self.depth();
        if self.chance(0.6) {
            let cells = self.cells(2, 4);
            let mut whole = self.part([0.0; 3], size, edges(size, cells), depth.min(6.0));
            whole.source = Bands::ZERO;
            m.medium = ModelMedium::even(whole, cells);
        } else {
            self.features.retain(|f| !f.contains("medium"));
            self.features.push("vacuum");
        }
        m.patch_size = self.patch_in(size);
        self.lights(&mut m, open, [0.5 * size[0], 0.5 * size[1], 0.85 * size[2]], times(size, 0.5));
        self.finished(m)
    }

    /// A lower box on the upper x face of the box between `lo` and `hi`, in a room of this size.
    fn touching_solid(&mut self, m: &mut SceneModel, lo: Block, hi: Block, size: Block) {
        self.features.push("touching solids");
        let (mut a, mut b) = (lo, hi);
        (a[0], b[0]) = (hi[0], Self::short(hi[0] + 0.15 * size[0]));
        b[2] = Self::short(lo[2] + 0.7 * (hi[2] - lo[2]));
        a[1] = lo[1];
        let look = self.look(box_area(a, b));
        m.add("touching", ModelShape::Mesh { quads: quads(a, b, FrontSide::Outside) }, look);
    }

    pub(super) fn panes(&mut self) -> SceneModel {
        self.features.push("panes");
        let filled = self.chance(0.4);
        let size = self.size();
        let (mut m, open) = self.in_room(size, 0.5, 0.3);
        for k in 0..self.whole(1, 2) {
            let x = Self::short(size[0] * self.rng.uniform_in(0.2 + 0.4 * k as f64, 0.5 + 0.4 * k as f64));
            let (y, z) = (Self::short(0.8 * size[1]), Self::short(0.7 * size[2]));
            let lean = if !filled && self.chance(0.5) { Self::short(0.08 * size[0]) } else { 0.0 };
            let polygon = vec![
                [x, 0.1 * size[1], 0.1 * size[2]],
                [x, y, 0.1 * size[2]],
                [x + lean, y, z],
                [x + lean, 0.1 * size[1], z],
            ];
            let thickness = Self::short(0.005 * size[0]);
            let depth = self.log(0.02, 2.0);
            let extinction = self
                .spread(|m| Self::short(depth / thickness * if m.bands > 1 { m.log(0.3, 3.0) } else { 1.0 }));
            let albedo = if self.chance(0.5) { Bands::ZERO } else { self.spread(|m| m.between(0.1, 0.9)) };
            let emission =
                if self.chance(0.3) { self.spread(|m| m.between(1.0, 100.0)) } else { Bands::ZERO };
            let known = self.given || self.chance(0.5);
            let temperature = known.then(|| self.between(300.0, 1200.0).round());
            let name = format!("pane{}", k + 1);
            m.panes.push(ModelPane { name, polygon, thickness, extinction, albedo, emission, temperature });
        }
        m.medium = self.even_medium(filled, size, 2, 3);
        m.patch_size = self.patch_in(size);
        self.lights(&mut m, open, [0.5 * size[0], 0.5 * size[1], 0.85 * size[2]], times(size, 0.5));
        self.finished(m)
    }

    /// Plates in any position, some with two sides, nothing around them.
    pub(super) fn plates(&mut self) -> SceneModel {
        self.features.extend(["plates", "vacuum", "open"]);
        let mut m = self.empty();
        let size = self.size();
        let count = self.whole(2, 5);
        for k in 0..count {
            let centre = [0, 1, 2].map(|a| size[a] * self.rng.uniform_in(0.0, 1.0));
            let layer = size[2] * k as f64 / count as f64;
            let corner = [centre[0], centre[1], layer].map(Self::short);
            let mut edges = [0; 2].map(|_| {
                let d = self.rng.unit_vector();
                [d.x * size[0], d.y * size[1], 0.2 * d.z * size[2] / count as f64].map(Self::short)
            });
            let cross = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0];
            if cross.abs() < 0.1 * size[0] * size[1] {
                edges = [[size[0], 0.0, 0.0], [0.0, size[1], 0.0]];
            }
            let triangle = self.chance(0.4);
            let area = cross.abs().max(0.1 * size[0] * size[1]) * if triangle { 0.5 } else { 1.0 };
            let mut look = self.look(area);
            if self.chance(0.4) {
                look.both = true;
                self.features.push("two sides");
            }
            let shape = ModelShape::Plate { corner, edges, triangle };
            m.add(&format!("plate{}", k + 1), shape, look);
        }
        let mean = (size[0] + size[1] + size[2]) / 3.0;
        m.patch_size = self.patch(0.7 * mean);
        self.lights(&mut m, true, [0.5 * size[0], 0.5 * size[1], 1.5 * size[2]], size);
        self.finished(m)
    }

    /// A closed mesh with its fronts inward, turned, full of a medium whose box is larger.
    pub(super) fn turned_room(&mut self) -> SceneModel {
        self.features.extend(["turned room", "mesh"]);
        let size = self.size();
        let mut m = self.empty();
        (m.radiance, m.surroundings) = (Bands::ZERO, None);
        let degrees: f64 = if self.chance(0.5) { 0.0 } else { self.between(10.0, 80.0).round() };
        let (s, c) = degrees.to_radians().sin_cos();
        let quads: Vec<[Block; 4]> = (quads([0.0; 3], size, FrontSide::Inside).into_iter())
            .map(|q| q.map(|p| [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]))
            .collect();
        let points = || quads.iter().flatten();
        let lo = [0, 1, 2].map(|k| points().map(|p| p[k]).fold(f64::INFINITY, f64::min));
        let hi = [0, 1, 2].map(|k| points().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max));
        let look = self.look(2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]));
        m.add("hull", ModelShape::Mesh { quads }, look);
        let depth = self.depth();
        if self.chance(0.6) {
            let cells = self.cells(3, 4);
            let mut whole = self.part(lo, hi, edges(sub(hi, lo), cells), depth.min(6.0));
            whole.source = Bands::ZERO;
            m.medium = ModelMedium::even(whole, cells);
        } else {
            self.features.retain(|f| !f.contains("medium"));
            self.features.push("vacuum");
        }
        let inside = |f: [f64; 3]| {
            let p = [0, 1, 2].map(|k| f[k] * size[k]);
            [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]].map(Self::short)
        };
        let corner = inside([0.3, 0.35, 0.4]);
        let mut look = self.look(0.04 * size[0] * size[1]);
        look.heat = HeatCondition::Temperature(1300.0);
        look.both = true;
        let edges = [[0.2 * size[0], 0.0, 0.0], [0.0, 0.2 * size[1], 0.0]].map(|e| e.map(Self::short));
        m.add("heater", ModelShape::Plate { corner, edges, triangle: false }, look);
        m.patch_size = self.patch_in(size);
        m.closed_room = true;
        self.finished(m)
    }

    /// A hollow shell: an outward skin, an inward one, and a solid in the cavity.
    pub(super) fn shell(&mut self) -> SceneModel {
        self.features.extend(["hollow shell", "nested", "mesh"]);
        let size = self.size();
        let mut m = self.empty();
        self.room(&mut m, size, 0.2);
        let at = |f: f64| times(size, f).map(Self::short);
        for (name, [lo, hi], front) in [
            ("outside", [0.2, 0.8], FrontSide::Outside),
            ("inside", [0.3, 0.7], FrontSide::Inside),
            ("core", [0.45, 0.6], FrontSide::Outside),
        ] {
            let mut look = self.look(1.0);
            if name == "core" {
                look.heat = HeatCondition::Temperature(1100.0);
                look.emission = self.spread(|m| m.between(10.0, 100.0));
            }
            let shape = ModelShape::Mesh { quads: quads(at(lo), at(hi), front) };
            m.add(name, shape, look);
        }
        let filled = self.chance(0.5);
        m.medium = self.even_medium(filled, size, 3, 4);
        m.patch_size = self.patch_in(size);
        self.finished(m)
    }
}
