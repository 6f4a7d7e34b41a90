//! A scene as a model that can be moved, turned, scaled and split, and the TOML and OBJ texts that it is read from.

use std::path::Path;
use zonal_scene::{Band, Bands};

/// A point or vector, m.
pub(super) type Block = [f64; 3];

pub(super) fn add(a: Block, b: Block) -> Block {
    [0, 1, 2].map(|k| a[k] + b[k])
}
pub(super) fn sub(a: Block, b: Block) -> Block {
    [0, 1, 2].map(|k| a[k] - b[k])
}
/// The corners of a parallelogram.
pub(super) fn quad(corner: Block, [a, b]: [Block; 2]) -> [Block; 4] {
    [corner, add(corner, a), add(add(corner, a), b), add(corner, b)]
}
/// The last band, which differs from the others in scenes of two bands.
pub(super) fn last_band() -> Band {
    Band::all().last().unwrap_or(Band::first())
}
pub(super) fn times(a: Block, s: f64) -> Block {
    a.map(|x| x * s)
}

/// Thermal boundary condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum HeatCondition {
    /// K.
    Temperature(f64),
    /// W/m² or W/m³.
    Flux(f64),
    /// W.
    Power(f64),
}

/// How a surface looks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SurfaceProperties {
    pub reflectance: Bands,
    pub emission: Bands,
    pub heat: HeatCondition,
    pub both: bool,
}

/// A shape.
#[derive(Clone, Debug)]
pub(super) enum ModelShape {
    /// A parallelogram, or a triangle: origin and two edges.
    Plate { corner: Block, edges: [Block; 2], triangle: bool },
    /// Walls of an axis-aligned room; those without a look are left out. The look of the surface itself is not used.
    Room { min: Block, max: Block, walls: Box<[Option<SurfaceProperties>; 6]> },
    /// A closed mesh of quadrilaterals, counter-clockwise from the front.
    Mesh { quads: Vec<[Block; 4]> },
    /// A box with its normals outward, turned about the vertical.
    Box { min: Block, max: Block, degrees: f64 },
}

/// A flaw of a mesh file that must not change the solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeshFlaw {
    /// Every other face stands twice in the file.
    RepeatedFaces,
    /// Every face stands twice, the second time with its corners in another order.
    RepeatedFacesRotated,
    /// Faces share no corner; each corner is off by a rounding error.
    LooseCorners,
    /// A plate of two sides is two opposite faces of one side each.
    OppositeFaces,
}

/// A named surface.
#[derive(Clone, Debug)]
pub(super) struct ModelSurface {
    pub name: String,
    pub shape: ModelShape,
    pub look: SurfaceProperties,
}

/// A pane.
#[derive(Clone, Debug)]
pub(super) struct ModelPane {
    pub name: String,
    pub polygon: Vec<Block>,
    pub thickness: f64,
    pub extinction: Bands,
    pub albedo: Bands,
    pub emission: Bands,
    /// In thermal mode; none for radiative equilibrium.
    pub temperature: Option<f64>,
}

/// A medium, or a box of it.
#[derive(Clone, Debug)]
pub(super) struct MediumPart {
    pub min: Block,
    pub max: Block,
    pub extinction: Bands,
    pub albedo: Bands,
    pub emission: Bands,
    pub source: Bands,
    pub heat: HeatCondition,
}

/// The medium.
#[derive(Clone, Debug)]
pub(super) struct ModelMedium {
    pub whole: MediumPart,
    pub cells: [usize; 3],
    pub regions: Vec<MediumPart>,
}

/// A light.
#[derive(Clone, Debug)]
pub(super) enum ModelLight {
    Sun { direction: Block, irradiance: Bands, degrees: f64 },
    Sky { radiance: Bands },
    Emitter { surface: String },
}

impl ModelMedium {
    /// A medium that is the same everywhere.
    pub(super) fn even(whole: MediumPart, cells: [usize; 3]) -> Option<ModelMedium> {
        Some(ModelMedium { whole, cells, regions: Vec::new() })
    }
}

/// A scene.
#[derive(Clone, Debug, Default)]
pub(super) struct SceneModel {
    pub thermal: bool,
    /// Lines of `[thermal]`.
    pub shares: String,
    pub radiance: Bands,
    pub surroundings: Option<f64>,
    pub periodic: [bool; 3],
    pub surfaces: Vec<ModelSurface>,
    pub panes: Vec<ModelPane>,
    pub medium: Option<ModelMedium>,
    pub lights: Vec<ModelLight>,
    pub tolerance: f64,
    /// The residual of the iteration, where it is not the default.
    pub residual: Option<f64>,
    /// None for `patch_rule = "voxels"`.
    pub patch_size: Option<f64>,
    /// True where a closed mesh surrounds all.
    pub closed_room: bool,
    /// Axes between symmetry planes.
    pub mirrored: [bool; 3],
    /// Flaws of mesh files, each with the name of its surface.
    pub flaws: Vec<(String, MeshFlaw)>,
    /// The model that the reference traces, where it is another one of the same solution.
    pub truth: Option<Box<SceneModel>>,
    /// Words of a warning that every solution must have; its numbers are not compared.
    pub expected_warning: Option<&'static str>,
    /// Features of the scene, for the tables.
    pub features: Vec<&'static str>,
}

pub(super) const FACES: [&str; 6] = ["x0", "x1", "y0", "y1", "z0", "z1"];

/// The wall of a box: corner and edges with the front inward.
pub(super) fn wall(min: Block, max: Block, face: usize) -> (Block, [Block; 2]) {
    let (axis, high) = (face / 2, face % 2 == 1);
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let unit = |k: usize| {
        let mut v = [0.0; 3];
        v[k] = max[k] - min[k];
        v
    };
    let mut corner = min;
    if high {
        corner[axis] = max[axis];
        // e_b × e_a points down the axis.
        (corner, [unit(b), unit(a)])
    } else {
        (corner, [unit(a), unit(b)])
    }
}

/// Side of a box that its faces show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrontSide {
    Inside,
    Outside,
}

/// The quadrilaterals of a box, with its normals outward or inward; equal corners are equal to the bit.
pub(super) fn quads(min: Block, max: Block, front: FrontSide) -> Vec<[Block; 4]> {
    let face = |face: usize| {
        let (axis, high) = (face / 2, face % 2 == 1);
        let at = |i: bool, j: bool| {
            let mut p = min;
            for (k, upper) in [(axis, high), ((axis + 1) % 3, i), ((axis + 2) % 3, j)] {
                p[k] = if upper { max[k] } else { min[k] };
            }
            p
        };
        let mut quad = [at(false, false), at(true, false), at(true, true), at(false, true)];
        if high == (front == FrontSide::Inside) {
            quad.reverse();
        }
        quad
    };
    (0..6).map(face).collect()
}

fn turned(p: Block, centre: Block, degrees: f64) -> Block {
    let (s, c) = degrees.to_radians().sin_cos();
    let d = sub(p, centre);
    [centre[0] + c * d[0] - s * d[1], centre[1] + s * d[0] + c * d[1], p[2]]
}

/// x ↦ M x + t.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigidMotion {
    pub rows: [Block; 3],
    pub shift: Block,
}

impl RigidMotion {
    pub(super) fn point(&self, p: Block) -> Block {
        add(self.vector(p), self.shift)
    }
    pub(super) fn vector(&self, p: Block) -> Block {
        self.rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2])
    }
    fn symmetry_planes(&self) -> bool {
        let [a, b, c] = self.rows;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
            < 0.0
    }
    /// For each axis the one that it goes to.
    fn axes(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| {
            let column = [0, 1, 2].map(|r| self.rows[r][k].abs());
            (0..3).fold(0, |b, r| if column[r] > column[b] { r } else { b })
        })
    }
}

impl SceneModel {
    /// Adds a surface.
    pub(super) fn add(&mut self, name: &str, shape: ModelShape, look: SurfaceProperties) {
        self.surfaces.push(ModelSurface { name: name.into(), shape, look });
    }

    /// Rooms and boxes as single plates and meshes, which any motion can take.
    pub(super) fn lowered(&self) -> SceneModel {
        let mut out = self.clone();
        out.surfaces.clear();
        for s in &self.surfaces {
            match &s.shape {
                ModelShape::Room { min, max, walls } => {
                    for (face, look) in walls.iter().enumerate() {
                        let Some(look) = look else { continue };
                        let (corner, edges) = wall(*min, *max, face);
                        let shape = ModelShape::Plate { corner, edges, triangle: false };
                        out.add(&format!("{}.{}", s.name, FACES[face]), shape, look.clone());
                    }
                }
                ModelShape::Box { min, max, degrees } => {
                    let centre = times(add(*min, *max), 0.5);
                    let quads = quads(*min, *max, FrontSide::Outside);
                    let quads = quads.into_iter().map(|q| q.map(|p| turned(p, centre, *degrees))).collect();
                    out.surfaces.push(ModelSurface { shape: ModelShape::Mesh { quads }, ..s.clone() });
                }
                _ => out.surfaces.push(s.clone()),
            }
        }
        out
    }

    /// The model moved; turns of a medium go by quarters.
    pub(super) fn moved(&self, m: &RigidMotion) -> SceneModel {
        let mut out = self.lowered();
        let flip = m.symmetry_planes();
        for s in &mut out.surfaces {
            match &mut s.shape {
                ModelShape::Plate { corner, edges, .. } => {
                    *corner = m.point(*corner);
                    *edges = edges.map(|e| m.vector(e));
                    if flip {
                        edges.swap(0, 1);
                    }
                }
                ModelShape::Mesh { quads } => {
                    for q in quads {
                        *q = q.map(|p| m.point(p));
                        if flip {
                            q.reverse();
                        }
                    }
                }
                ModelShape::Room { .. } | ModelShape::Box { .. } => {}
            }
        }
        for p in &mut out.panes {
            p.polygon.iter_mut().for_each(|c| *c = m.point(*c));
        }
        let corners = |p: &mut MediumPart| {
            let (a, b) = (m.point(p.min), m.point(p.max));
            p.min = [0, 1, 2].map(|k| a[k].min(b[k]));
            p.max = [0, 1, 2].map(|k| a[k].max(b[k]));
        };
        let to = m.axes();
        if let Some(medium) = &mut out.medium {
            corners(&mut medium.whole);
            medium.regions.iter_mut().for_each(corners);
            let old = medium.cells;
            (0..3).for_each(|k| medium.cells[to[k]] = old[k]);
        }
        (0..3).for_each(|k| out.periodic[to[k]] = self.periodic[k]);
        (0..3).for_each(|k| out.mirrored[to[k]] = self.mirrored[k]);
        for l in &mut out.lights {
            if let ModelLight::Sun { direction, .. } = l {
                *direction = m.vector(*direction);
            }
        }
        out
    }

    /// The model `s` times as large, with extinctions that keep all optical depths.
    pub(super) fn scaled(&self, s: f64) -> SceneModel {
        let rows = [[s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]];
        let mut out = self.moved(&RigidMotion { rows, shift: [0.0; 3] });
        out.patch_size = self.patch_size.map(|p| p * s);
        let weaker = |p: &mut MediumPart| {
            p.extinction *= 1.0 / s;
            p.source *= 1.0 / s;
            if let HeatCondition::Flux(q) = &mut p.heat {
                *q /= s;
            }
        };
        if let Some(m) = &mut out.medium {
            weaker(&mut m.whole);
            m.regions.iter_mut().for_each(weaker);
        }
        for p in &mut out.panes {
            p.thickness *= s;
            p.extinction *= 1.0 / s;
        }
        for x in &mut out.surfaces {
            if let HeatCondition::Power(q) = &mut x.look.heat {
                *q *= s * s;
            }
        }
        out
    }

    /// Writes the scene with its meshes.
    pub(super) fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let text = self.write_meshes("", folder)?;
        std::fs::write(folder.join("scene.toml"), text)
    }

    /// Writes the meshes and gives the TOML text, with `lines` in `[solve]`.
    pub(super) fn write_meshes(&self, lines: &str, folder: &Path) -> std::io::Result<String> {
        let mut t = String::from(if self.thermal { "mode = \"thermal\"\n" } else { "" });
        self.write_boundary(&mut t);
        t += &format!("[solve]\ntolerance = {:?}\ndiscretization_error = true\n{lines}\n", self.tolerance);
        t += &self.residual.map_or(String::new(), |r| format!("residual = {r:?}\n"));
        t += &self.patch_size.map_or("patch_rule = \"voxels\"\n".into(), |p| format!("patch_size = {p:?}\n"));
        for s in &self.surfaces {
            self.surface(s, &mut t, folder)?;
        }
        self.write_panes(&mut t);
        if let Some(m) = &self.medium {
            let (MediumPart { min, max, .. }, cells) = (&m.whole, m.cells);
            t += &format!(
                "[medium]\nmin = {min:?}\nmax = {max:?}\ncells = {cells:?}\n{}",
                self.part(&m.whole)
            );
            for r @ MediumPart { min, max, .. } in &m.regions {
                t +=
                    &format!("[[medium.region]]\nbox = {{ min = {min:?}, max = {max:?} }}\n{}", self.part(r));
            }
        }
        self.write_lights(&mut t);
        Ok(t)
    }

    /// Surroundings, periodic axes and bands of heat.
    fn write_boundary(&self, t: &mut String) {
        if self.radiance != Bands::ZERO || self.surroundings.is_some() {
            *t += "[surroundings]\n";
        }
        if self.radiance != Bands::ZERO {
            *t += &format!("radiance = {:?}\n", self.radiance.to_rgb());
        }
        if let Some(k) = self.surroundings {
            *t += &format!("temperature = {k:?}\n");
        }
        if self.periodic != [false; 3] || self.mirrored != [false; 3] {
            *t += "[boundary]\n";
            for (axes, word) in [(self.periodic, "periodic"), (self.mirrored, "symmetry")] {
                (0..3)
                    .filter(|&k| axes[k])
                    .for_each(|k| *t += &format!("{} = \"{word}\"\n", ["x", "y", "z"][k]));
            }
        }
        if !self.shares.is_empty() {
            *t += &format!("[thermal]\n{}\n", self.shares);
        }
    }

    fn write_panes(&self, t: &mut String) {
        for ModelPane { name, polygon, thickness, extinction, albedo, emission, temperature } in &self.panes {
            let [extinction, albedo, emission] = [extinction, albedo, emission].map(|b| b.to_rgb());
            *t += &format!(
                "[[pane]]\nname = \"{name}\"\npolygon = {polygon:?}\nthickness = {thickness:?}\nextinction = {extinction:?}\nalbedo = {albedo:?}\n"
            );
            match (self.thermal, temperature) {
                (true, Some(k)) => *t += &format!("temperature = {k:?}\n"),
                (true, None) => {}
                (false, _) => *t += &format!("emission = {emission:?}\n"),
            }
        }
    }

    fn write_lights(&self, t: &mut String) {
        for l in &self.lights {
            *t += "[[light]]\nkind = ";
            *t += &match l {
                ModelLight::Sun { direction, irradiance, degrees } => format!(
                    "\"sun\"\ndirection = {direction:?}\nirradiance = {:?}\nangular_diameter = {degrees:?}\n",
                    irradiance.to_rgb()
                ),
                ModelLight::Sky { radiance } => format!("\"sky\"\nradiance = {:?}\n", radiance.to_rgb()),
                ModelLight::Emitter { surface } => format!("\"emitter\"\nsurface = \"{surface}\"\n"),
            };
        }
    }

    fn part(&self, p: &MediumPart) -> String {
        let [extinction, albedo, emission, source] =
            [p.extinction, p.albedo, p.emission, p.source].map(|b| b.to_rgb());
        let more = match (self.thermal, p.heat) {
            (true, HeatCondition::Temperature(k)) => format!("temperature = {k:?}"),
            (true, HeatCondition::Flux(q) | HeatCondition::Power(q)) => format!("heat_source = {q:?}"),
            (false, _) => format!("emission = {emission:?}\nsource = {source:?}"),
        };
        format!("extinction = {extinction:?}\nalbedo = {albedo:?}\n{more}\n")
    }

    /// The lines of a look, separated by `between`.
    fn look(&self, l: &SurfaceProperties, between: &str) -> String {
        let mut lines = if self.thermal {
            let heat = match l.heat {
                HeatCondition::Temperature(k) => format!("temperature = {k:?}"),
                HeatCondition::Flux(q) => format!("heat_flux = {q:?}"),
                HeatCondition::Power(p) => format!("net_power = {p:?}"),
            };
            vec![format!("emissivity = {:?}", (1.0 - l.reflectance).to_rgb()), heat]
        } else {
            let [reflectance, emission] = [l.reflectance, l.emission].map(|b| b.to_rgb());
            vec![format!("reflectance = {reflectance:?}"), format!("emission = {emission:?}")]
        };
        if l.both {
            lines.push("sides = \"both\"".into());
        }
        lines.join(between)
    }

    fn surface(&self, s: &ModelSurface, t: &mut String, folder: &Path) -> std::io::Result<()> {
        *t += &format!("[[surface]]\nname = \"{}\"\n", s.name);
        let flaw = self.flaws.iter().find(|f| f.0 == s.name).map(|f| f.1);
        let (file, mut look) = (format!("{}.obj", s.name), s.look.clone());
        let write_mesh = |quads: &[[Block; 4]]| std::fs::write(folder.join(&file), obj(quads, flaw));
        match &s.shape {
            ModelShape::Plate { corner, edges, .. } if flaw == Some(MeshFlaw::OppositeFaces) => {
                *t += &format!("mesh = {{ file = \"{file}\" }}\n");
                write_mesh(&[quad(*corner, *edges)])?;
                look.both = false;
            }
            ModelShape::Plate { corner: o, edges: [a, b], triangle: true } => {
                *t += &format!("triangle = {{ corners = [{o:?}, {:?}, {:?}] }}\n", add(*o, *a), add(*o, *b));
            }
            ModelShape::Plate { corner: o, edges: [a, b], .. } => {
                *t += &format!("rectangle = {{ origin = {o:?}, edge1 = {a:?}, edge2 = {b:?} }}\n");
            }
            ModelShape::Box { min, max, degrees } => {
                *t += &format!("box = {{ min = {min:?}, max = {max:?}, rotate_z_degrees = {degrees:?} }}\n");
            }
            ModelShape::Mesh { quads } => {
                let sides = if quads.len() == 1 { "sides = \"front\"\n" } else { "" };
                *t += &format!("mesh = {{ file = \"{file}\" }}\n{sides}");
                write_mesh(quads)?;
            }
            ModelShape::Room { min, max, walls } => {
                let missing: Vec<&str> = (0..6).filter(|&k| walls[k].is_none()).map(|k| FACES[k]).collect();
                *t += &format!("room = {{ min = {min:?}, max = {max:?} }}\nomit = {missing:?}\n");
                for (face, look) in FACES.iter().zip(walls.iter()).filter_map(|(f, l)| Some((f, l.as_ref()?)))
                {
                    *t += &format!("faces.{face} = {{ {} }}\n", self.look(look, ", "));
                }
                return Ok(());
            }
        }
        *t += &(self.look(&look, "\n") + "\n");
        Ok(())
    }
}

/// An OBJ text; equal corners are one. A flaw is written into it.
pub(super) fn obj(quads: &[[Block; 4]], flaw: Option<MeshFlaw>) -> String {
    let (mut points, mut faces): (Vec<Block>, String) = (Vec::new(), String::new());
    let mut face = |q: &[Block; 4]| {
        faces += "f";
        for p in q {
            let known = points.iter().position(|x| x == p && flaw != Some(MeshFlaw::LooseCorners));
            let k = known.unwrap_or(points.len());
            if known.is_none() {
                points.push(*p);
            }
            faces += &format!(" {}", k + 1);
        }
        faces += "\n";
    };
    for (k, q) in quads.iter().enumerate() {
        face(q);
        match flaw {
            Some(MeshFlaw::RepeatedFaces) if k % 2 == 0 => face(q),
            Some(MeshFlaw::RepeatedFacesRotated) => face(&[q[1], q[2], q[3], q[0]]),
            Some(MeshFlaw::OppositeFaces) => face(&[q[3], q[2], q[1], q[0]]),
            _ => {}
        }
    }
    let mut t = String::new();
    for (k, p) in points.iter().enumerate() {
        // A unit in the last place, up and down.
        let rounded =
            |x: f64| if flaw == Some(MeshFlaw::LooseCorners) && k % 2 == 1 { x.next_up() } else { x };
        let [x, y, z] = p.map(rounded);
        t += &format!("v {x:?} {y:?} {z:?}\n");
    }
    t + &faces
}
