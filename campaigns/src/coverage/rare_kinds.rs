//! Random scenes of the kinds that ordinary scenes seldom have: patches outside the box of the medium, media that fill a part of a room, white media, suns
//! wider than their height above a plate, mesh files with flaws, panes between symmetry planes, small emitters in haze, and many small solids.

use super::generate::{SceneGenerator, box_area, edges};
use super::model::{
    Block, FrontSide, HeatCondition, MeshFlaw, ModelLight, ModelMedium, ModelPane, ModelShape, ModelSurface,
    SceneModel, SurfaceProperties, quads, sub, times,
};
use zonal_scene::Bands;

/// Optical depths of white media across their least edge.
const WHITE_DEPTHS: [f64; 2] = [1.0, 100.0];
/// The largest optical depth across the edge of a cell of a white medium.
const MAX_WHITE_CELL_DEPTH: f64 = 8.0;
/// Angular diameters of wide suns, degrees.
const WIDE_SUN_DEGREES: [f64; 2] = [20.0, 170.0];
/// Ratio of length to width of a needle.
const NEEDLE_RATIOS: [f64; 2] = [100.0, 3000.0];

impl SceneGenerator<'_> {
    /// A scene of a rare kind.
    pub(super) fn rare(&mut self) -> SceneModel {
        match self.whole(0, 8) {
            0 => self.cloud_beside_plates(),
            1 => self.partial_grid(),
            2 => self.white_medium(),
            3 => self.wide_sun(),
            4 => self.flawed_mesh(),
            5 => self.inside_out_room(),
            6 => self.pane_between_symmetry_planes(),
            7 => self.emitter_in_haze(),
            _ => self.many_solids(),
        }
    }

    fn plate(&mut self, name: &str, corner: Block, edges: [Block; 2]) -> ModelSurface {
        let look = self.look(0.1);
        let shape = ModelShape::Plate {
            corner: corner.map(Self::short),
            edges: edges.map(|e| e.map(Self::short)),
            triangle: false,
        };
        ModelSurface { name: name.into(), shape, look }
    }

    /// A box of medium in open surroundings, and plates outside it.
    fn cloud_beside_plates(&mut self) -> SceneModel {
        self.features.extend(["patch outside the medium", "open"]);
        let size = self.size();
        let mut m = self.empty();
        if m.surroundings.is_none() {
            (m.radiance, m.surroundings) = (Bands::splat(10.0), Some(700.0));
            m.radiance = if self.thermal { Bands::ZERO } else { m.radiance };
            m.surroundings = m.surroundings.filter(|_| self.thermal);
        }
        for k in 0..self.whole(1, 3) {
            let side = self.whole(0, 2);
            let mut corner = [0, 1, 2].map(|a| size[a] * self.rng.uniform_in(-0.5, 1.0));
            corner[side] = size[side]
                * if self.chance(0.5) {
                    self.rng.uniform_in(1.1, 3.0)
                } else {
                    self.rng.uniform_in(-2.0, -0.3)
                };
            let edge = self.log(0.02, 0.8);
            let edges = [(side + 1) % 3, (side + 2) % 3].map(|axis| {
                let mut e = [0.0; 3];
                e[axis] = edge * size[axis];
                e
            });
            let mut s = self.plate(&format!("plate{}", k + 1), corner, edges);
            s.look.both = self.chance(0.5);
            m.surfaces.push(s);
        }
        let cells = self.cells(2, 4);
        let depth = self.depth();
        let mut whole = self.part([0.0; 3], size, edges(size, cells), depth);
        if !self.thermal && self.chance(0.4) {
            whole.albedo = Bands::splat(1.0);
        }
        m.medium = ModelMedium::even(whole, cells);
        m.patch_size = self.patch_in(size);
        self.finished(m)
    }

    /// A room whose medium fills a part of it, with a plate beside the medium.
    fn partial_grid(&mut self) -> SceneModel {
        self.features.push("partial grid");
        let size = self.size();
        let (mut m, open) = self.in_room(size, 0.3, 0.2);
        let (mut lo, mut hi) = ([0.0; 3], size);
        for k in 0..3 {
            if k == 2 || self.chance(0.4) {
                if self.chance(0.5) {
                    lo[k] = Self::short(size[k] * self.rng.uniform_in(0.2, 0.6));
                } else {
                    hi[k] = Self::short(size[k] * self.rng.uniform_in(0.4, 0.8));
                }
            }
        }
        let cells = self.cells(2, 4);
        let depth = self.depth();
        let mut whole = self.part(lo, hi, edges(sub(hi, lo), cells), depth.min(6.0));
        whole.source = Bands::ZERO;
        m.medium = ModelMedium::even(whole, cells);
        m.patch_size = self.patch_in(size);
        self.lights(&mut m, open, times(size, 0.5), times(size, 0.5));
        self.finished(m)
    }

    /// A box of a medium that absorbs nothing, or little.
    fn white_medium(&mut self) -> SceneModel {
        self.features.push("white medium");
        let (size, cells) = (self.size(), self.cells(3, 6));
        let (mut m, open) = self.in_room(size, 0.6, 0.3);
        if !self.chance(0.7) {
            m.surfaces.clear();
            self.features.push("open");
            m.surfaces.push(self.plate(
                "ground",
                [-0.5 * size[0], -0.5 * size[1], 0.0],
                [[2.0 * size[0], 0.0, 0.0], [0.0, 2.0 * size[1], 0.0]],
            ));
            if !self.thermal {
                m.radiance = Bands::splat(self.between(1.0, 30.0));
            }
        }
        let depth = self.log(WHITE_DEPTHS[0], WHITE_DEPTHS[1]);
        let cell = edges(size, cells);
        let most = MAX_WHITE_CELL_DEPTH / cell.iter().fold(0.0f64, |m, c| m.max(*c));
        let mut whole = self.part([0.0; 3], size, cell, depth);
        let least = size.iter().fold(f64::INFINITY, |m, c| m.min(*c));
        whole.extinction = Bands::splat(Self::short((depth / least).min(most)));
        whole.albedo = Bands::splat(if self.chance(0.5) { 1.0 } else { 1.0 - self.log(1e-5, 0.05) });
        (whole.emission, whole.source) = (Bands::ZERO, Bands::ZERO);
        if self.thermal {
            // A white medium has no temperature: of known heat it is white as well.
            whole.albedo = Bands::splat(self.between(0.0, 0.9));
            // The reference has weights by temperature for given temperatures alone.
            if !self.given {
                whole.heat = HeatCondition::Flux(0.0);
            }
        }
        m.medium = ModelMedium::even(whole, cells);
        self.lights(&mut m, open, times(size, 0.5), size);
        self.finished(m)
    }

    /// Plates under a sun, a part of whose disc may be below their horizon.
    fn wide_sun(&mut self) -> SceneModel {
        self.thermal = false;
        self.features.retain(|f| !["thermal", "weights by temperature"].contains(f));
        self.features.extend(["wide sun", "light", "vacuum", "open"]);
        let mut m = self.empty();
        m.shares = String::new();
        let size = self.size();
        for k in 0..self.whole(1, 3) {
            let corner = [0, 1, 2].map(|a| size[a] * self.rng.uniform_in(0.0, 2.0));
            let (a, b) = (self.rng.unit_vector(), self.rng.unit_vector());
            let n = a.cross(b).normalized();
            let edges = [a, n.cross(a)].map(|d| times(d.array(), self.rng.uniform_in(0.3, 1.0) * size[0]));
            let mut s = self.plate(&format!("plate{}", k + 1), corner, edges);
            s.look.both = self.chance(0.3);
            m.surfaces.push(s);
        }
        for _ in 0..self.whole(1, 2) {
            let d = self.rng.unit_vector();
            let direction = [d.x, d.y, d.z].map(Self::short);
            let irradiance = self.spread(|m| m.between(10.0, 300.0));
            let degrees = self.between(WIDE_SUN_DEGREES[0], WIDE_SUN_DEGREES[1]);
            m.lights.push(ModelLight::Sun { direction, irradiance, degrees });
        }
        m.patch_size = self.patch(size[0]);
        self.finished(m)
    }

    /// A room with a solid whose mesh file has a flaw that must not change the solution, or a needle beside the solid.
    fn flawed_mesh(&mut self) -> SceneModel {
        self.features.extend(["flawed mesh", "mesh", "solids"]);
        let size = self.size();
        let (mut m, open) = self.in_room(size, 0.3, 0.3);
        let at = |m: &mut Self, lo: f64, hi: f64| {
            [0, 1, 2].map(|k| Self::short(size[k] * m.rng.uniform_in(lo, hi)))
        };
        let (lo, hi) = (at(self, 0.2, 0.35), at(self, 0.5, 0.7));
        let look = self.look(box_area(lo, hi));
        let shape = ModelShape::Mesh { quads: quads(lo, hi, FrontSide::Outside) };
        m.add("solid", shape, look);
        match self.whole(0, 4) {
            0 => self.flaw(&mut m, "repeated faces", MeshFlaw::RepeatedFaces),
            1 => self.flaw(&mut m, "repeated faces", MeshFlaw::RepeatedFacesRotated),
            2 => self.flaw(&mut m, "loose corners", MeshFlaw::LooseCorners),
            3 => self.opposite_faces(&mut m, size),
            _ => {
                self.features.push("needle");
                let ratio = self.log(NEEDLE_RATIOS[0], NEEDLE_RATIOS[1]);
                let length = 0.7 * size[0];
                let mut s = self.plate(
                    "needle",
                    [0.1 * size[0], 0.1 * size[1], 0.8 * size[2]],
                    [[0.0, length / ratio, 0.0], [length, 0.0, 0.0]],
                );
                if let ModelShape::Plate { triangle, .. } = &mut s.shape {
                    *triangle = self.chance(0.5);
                }
                s.look.heat = HeatCondition::Temperature(900.0);
                s.look.both = true;
                m.surfaces.push(s);
            }
        }
        let filled = self.chance(0.5);
        m.medium = self.even_medium(filled, size, 2, 3);
        m.patch_size = self.patch_in(size);
        self.lights(&mut m, open, [0.5 * size[0], 0.5 * size[1], 0.85 * size[2]], times(size, 0.3));
        self.finished(m)
    }

    fn flaw(&mut self, m: &mut SceneModel, feature: &'static str, flaw: MeshFlaw) {
        self.features.push(feature);
        m.flaws.push(("solid".into(), flaw));
    }

    /// A plate of two sides, as two opposite faces of a file.
    fn opposite_faces(&mut self, m: &mut SceneModel, size: Block) {
        self.features.push("opposite faces");
        let mut s = self.plate(
            "sheet",
            [0.1 * size[0], 0.1 * size[1], 0.8 * size[2]],
            [[0.5 * size[0], 0.0, 0.0], [0.0, 0.6 * size[1], 0.0]],
        );
        if let HeatCondition::Power(_) = s.look.heat {
            s.look.heat = HeatCondition::Flux(0.0);
        }
        s.look.both = true;
        m.surfaces.push(s);
        m.flaws.push(("sheet".into(), MeshFlaw::OppositeFaces));
    }

    /// A closed mesh full of medium whose faces point outward: every solution must warn.
    fn inside_out_room(&mut self) -> SceneModel {
        self.features.extend(["inside-out room", "mesh"]);
        let size = self.size();
        let mut m = self.empty();
        let quads = quads([0.0; 3], size, FrontSide::Outside);
        let look = self.look(box_area([0.0; 3], size));
        m.add("hull", ModelShape::Mesh { quads }, look);
        let cells = self.cells(2, 3);
        let depth = self.depth();
        let whole = self.part([0.0; 3], size, edges(size, cells), depth.clamp(0.1, 4.0));
        m.medium = ModelMedium::even(whole, cells);
        m.patch_size = self.patch_in(size);
        m.expected_warning = Some("inside out");
        self.finished(m)
    }

    /// Endless plates with panes between them: the cross-section lies between symmetry planes; the reference repeats it.
    fn pane_between_symmetry_planes(&mut self) -> SceneModel {
        self.features.extend(["pane between symmetry planes", "panes"]);
        let size = self.size();
        let mut m = self.empty();
        (m.radiance, m.surroundings) = (Bands::ZERO, None);
        self.room(&mut m, size, 0.0);
        if let ModelShape::Room { walls, .. } = &mut m.surfaces[0].shape {
            walls[..4].fill(None);
        }
        for k in 0..self.whole(1, 2) {
            let z =
                Self::short(size[2] * self.rng.uniform_in(0.15 + 0.45 * k as f64, 0.45 + 0.45 * k as f64));
            let polygon = vec![[0.0, 0.0, z], [size[0], 0.0, z], [size[0], size[1], z], [0.0, size[1], z]];
            let thickness = Self::short(0.005 * size[2]);
            let depth = self.log(0.05, 2.0);
            m.panes.push(ModelPane {
                name: format!("pane{}", k + 1),
                polygon,
                thickness,
                extinction: Bands::splat(Self::short(depth / thickness)),
                albedo: if self.chance(0.5) { Bands::ZERO } else { Bands::splat(self.between(0.1, 0.9)) },
                emission: Bands::ZERO,
                temperature: Some(self.between(300.0, 1200.0).round()),
            });
        }
        let cells = [1, 1, self.whole(2, 5)];
        let depth = if self.chance(0.5) { self.log(0.1, 2.0) } else { 0.0 };
        let mut whole = self.part([0.0; 3], size, edges(size, cells), depth);
        if depth == 0.0 {
            (whole.extinction, whole.albedo) = (Bands::ZERO, Bands::ZERO);
            (whole.emission, whole.source) = (Bands::ZERO, Bands::ZERO);
            whole.heat = HeatCondition::Temperature(500.0);
        }
        m.medium = ModelMedium::even(whole, cells);
        let mut out = self.finished(m);
        let mut truth = out.clone();
        truth.periodic = [true, true, false];
        out.mirrored = [true, true, false];
        out.truth = Some(Box::new(truth));
        out
    }

    /// A small emitter in a room of haze.
    fn emitter_in_haze(&mut self) -> SceneModel {
        self.features.push("emitter in haze");
        let (size, cells) = (self.size(), self.cells(2, 4));
        let (mut m, open) = self.in_room(size, 0.4, 0.3);
        let edge = self.log(0.01, 0.1);
        let at = [0, 1, 2].map(|k| size[k] * self.rng.uniform_in(0.2, 0.8));
        let mut s = self.plate("lamp", at, [[0.0, edge * size[1], 0.0], [edge * size[0], 0.0, 0.0]]);
        s.look.emission = self.spread(|m| m.between(300.0, 3000.0));
        s.look.heat = HeatCondition::Temperature(self.between(1500.0, 2500.0).round());
        m.surfaces.push(s);
        if !self.thermal {
            m.lights.push(ModelLight::Emitter { surface: "lamp".into() });
        }
        let depth = self.log(0.05, 2.0);
        let mut whole = self.part([0.0; 3], size, edges(size, cells), depth);
        whole.albedo = Bands::splat(self.between(0.5, 0.99));
        (whole.emission, whole.source) = (Bands::ZERO, Bands::ZERO);
        m.medium = ModelMedium::even(whole, cells);
        m.patch_size = self.patch_in(size);
        let lights = std::mem::take(&mut m.lights);
        if !self.thermal && open && self.chance(0.3) {
            m.lights.push(ModelLight::Sky { radiance: self.spread(|m| m.between(1.0, 30.0)) });
        }
        m.lights.extend(lights);
        self.finished(m)
    }

    /// A room with many small solids, as one mesh or as boxes.
    fn many_solids(&mut self) -> SceneModel {
        self.features.extend(["many small solids", "solids"]);
        let size = self.size();
        let (mut m, open) = self.in_room(size, 0.3, 0.3);
        let columns = self.whole(2, 3);
        let mut all = Vec::new();
        let mut look: Option<SurfaceProperties> = None;
        let as_mesh = self.chance(0.5);
        for k in 0..columns * columns {
            let cell = [size[0] / columns as f64, size[1] / columns as f64];
            let (i, j) = ((k % columns) as f64, (k / columns) as f64);
            let edge = [0, 1].map(|a| cell[a] * self.rng.uniform_in(0.1, 0.4));
            let lo = [cell[0] * (i + 0.3), cell[1] * (j + 0.3), size[2] * self.rng.uniform_in(0.1, 0.5)]
                .map(Self::short);
            let hi = [lo[0] + edge[0], lo[1] + edge[1], lo[2] + size[2] * self.rng.uniform_in(0.05, 0.3)]
                .map(Self::short);
            all.extend(quads(lo, hi, FrontSide::Outside));
            if !as_mesh {
                let own = self.look(box_area(lo, hi));
                let shape = ModelShape::Box { min: lo, max: hi, degrees: 0.0 };
                m.add(&format!("box{}", k + 1), shape, own);
            } else if look.is_none() {
                look = Some(self.look(box_area(lo, hi)));
            }
        }
        if let Some(mut look) = look {
            self.features.push("mesh");
            if let HeatCondition::Power(_) = look.heat {
                look.heat = HeatCondition::Flux(0.0);
            }
            let shape = ModelShape::Mesh { quads: all };
            m.add("solids", shape, look);
        }
        let filled = self.chance(0.5);
        m.medium = self.even_medium(filled, size, 2, 3);
        m.patch_size = self.patch_in(size);
        self.lights(&mut m, open, [0.5 * size[0], 0.5 * size[1], 0.95 * size[2]], times(size, 0.3));
        self.finished(m)
    }
}
