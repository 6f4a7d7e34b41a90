//! A scene as a model that can be moved, turned, scaled and split, and the TOML and OBJ texts that it is read from.

use std::fmt::Write as _;
use zonal_scene::{Band, Bands};

/// A point or vector, m.
pub(crate) type Block = [f64; 3];

pub(crate) fn add(a: Block, b: Block) -> Block {
    [0, 1, 2].map(|k| a[k] + b[k])
}
pub(crate) fn sub(a: Block, b: Block) -> Block {
    [0, 1, 2].map(|k| a[k] - b[k])
}
/// The last band, which differs from the others in scenes of two bands.
pub(crate) fn last_band() -> Band {
    Band::all().last().unwrap_or(Band::first())
}
pub(crate) fn times(a: Block, s: f64) -> Block {
    a.map(|x| x * s)
}

/// Thermal boundary condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HeatCondition {
    /// K.
    Temperature(f64),
    /// W/m² or W/m³.
    Flux(f64),
    /// W.
    Power(f64),
}

/// How a surface looks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceProperties {
    pub reflectance: Bands,
    pub emission: Bands,
    pub heat: HeatCondition,
    pub both: bool,
}

/// A shape.
#[derive(Clone, Debug)]
pub(crate) enum ModelShape {
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
pub(crate) enum MeshFlaw {
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
pub(crate) struct ModelSurface {
    pub name: String,
    pub shape: ModelShape,
    pub look: SurfaceProperties,
}

/// A pane.
#[derive(Clone, Debug)]
pub(crate) struct ModelPane {
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
pub(crate) struct MediumPart {
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
pub(crate) struct ModelMedium {
    pub whole: MediumPart,
    pub cells: [usize; 3],
    pub regions: Vec<MediumPart>,
}

/// A light.
#[derive(Clone, Debug)]
pub(crate) enum ModelLight {
    Sun { direction: Block, irradiance: Bands, degrees: f64 },
    Sky { radiance: Bands },
    Emitter { surface: String },
}

/// A scene.
#[derive(Clone, Debug)]
pub(crate) struct SceneModel {
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

pub(crate) const FACES: [&str; 6] = ["x0", "x1", "y0", "y1", "z0", "z1"];

/// The wall of a box: corner and edges with the front inward.
pub(crate) fn wall(min: Block, max: Block, face: usize) -> (Block, [Block; 2]) {
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

/// Size of the scenes of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CampaignSize {
    /// Few zones, each scene by one engine.
    Small,
    Full,
}

/// Side of a box that its faces show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrontSide {
    Inside,
    Outside,
}

/// The quadrilaterals of a box, with its normals outward or inward; equal corners are equal to the bit.
pub(crate) fn quads(min: Block, max: Block, front: FrontSide) -> Vec<[Block; 4]> {
    (0..6)
        .map(|face| {
            let (axis, high) = (face / 2, face % 2 == 1);
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            let at = |i: bool, j: bool| {
                let mut p = min;
                p[axis] = if high { max[axis] } else { min[axis] };
                p[a] = if i { max[a] } else { min[a] };
                p[b] = if j { max[b] } else { min[b] };
                p
            };
            let mut quad = [at(false, false), at(true, false), at(true, true), at(false, true)];
            if high == (front == FrontSide::Inside) {
                quad.reverse();
            }
            quad
        })
        .collect()
}

fn turned(p: Block, centre: Block, degrees: f64) -> Block {
    let (s, c) = degrees.to_radians().sin_cos();
    let d = sub(p, centre);
    [centre[0] + c * d[0] - s * d[1], centre[1] + s * d[0] + c * d[1], p[2]]
}

/// x ↦ M x + t.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidMotion {
    pub rows: [Block; 3],
    pub shift: Block,
}

impl RigidMotion {
    pub(crate) fn point(&self, p: Block) -> Block {
        add(self.vector(p), self.shift)
    }
    pub(crate) fn vector(&self, p: Block) -> Block {
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
    /// Rooms and boxes as single plates and meshes, which any motion can take.
    pub(crate) fn lowered(&self) -> SceneModel {
        let mut out = self.clone();
        out.surfaces.clear();
        for s in &self.surfaces {
            match &s.shape {
                ModelShape::Room { min, max, walls } => {
                    for (face, look) in walls.iter().enumerate() {
                        let Some(look) = look else { continue };
                        let (corner, edges) = wall(*min, *max, face);
                        out.surfaces.push(ModelSurface {
                            name: format!("{}.{}", s.name, FACES[face]),
                            shape: ModelShape::Plate { corner, edges, triangle: false },
                            look: look.clone(),
                        });
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
    pub(crate) fn moved(&self, m: &RigidMotion) -> SceneModel {
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
    pub(crate) fn scaled(&self, s: f64) -> SceneModel {
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

    /// The TOML text, with `lines` in `[solve]`, and the meshes that it names: file and text.
    pub(crate) fn texts(&self, lines: &str) -> (String, Vec<(String, String)>) {
        let (mut t, mut files) = (String::new(), Vec::new());
        if self.thermal {
            t += "mode = \"thermal\"\n";
        }
        self.write_boundary(&mut t);
        let _ =
            writeln!(t, "[solve]\ntolerance = {:?}\ndiscretization_error = true\n{lines}", self.tolerance);
        match self.patch_size {
            Some(p) => _ = writeln!(t, "patch_size = {p:?}"),
            None => t += "patch_rule = \"voxels\"\n",
        }
        for s in &self.surfaces {
            self.surface(s, &mut t, &mut files);
        }
        self.write_panes(&mut t);
        self.write_medium(&mut t);
        self.write_lights(&mut t);
        (t, files)
    }

    /// Surroundings, periodic axes and bands of heat.
    fn write_boundary(&self, t: &mut String) {
        let mut around = String::new();
        if self.radiance != Bands::ZERO {
            let _ = writeln!(around, "radiance = {:?}", self.radiance.to_rgb());
        }
        if let Some(k) = self.surroundings {
            let _ = writeln!(around, "temperature = {k:?}");
        }
        if !around.is_empty() {
            let _ = write!(t, "[surroundings]\n{around}");
        }
        if self.periodic != [false; 3] || self.mirrored != [false; 3] {
            *t += "[boundary]\n";
            for (axes, word) in [(self.periodic, "periodic"), (self.mirrored, "symmetry")] {
                for k in (0..3).filter(|&k| axes[k]) {
                    let _ = writeln!(t, "{} = \"{word}\"", ["x", "y", "z"][k]);
                }
            }
        }
        if !self.shares.is_empty() {
            let _ = writeln!(t, "[thermal]\n{}", self.shares);
        }
    }

    fn write_panes(&self, t: &mut String) {
        for p in &self.panes {
            let _ = writeln!(
                t,
                "[[pane]]\nname = \"{}\"\npolygon = {:?}\nthickness = {:?}\nextinction = {:?}\nalbedo = {:?}",
                p.name,
                p.polygon,
                p.thickness,
                p.extinction.to_rgb(),
                p.albedo.to_rgb()
            );
            match (self.thermal, p.temperature) {
                (true, Some(k)) => _ = writeln!(t, "temperature = {k:?}"),
                (true, None) => {}
                (false, _) => _ = writeln!(t, "emission = {:?}", p.emission.to_rgb()),
            }
        }
    }

    fn write_medium(&self, t: &mut String) {
        if let Some(m) = &self.medium {
            let _ = writeln!(
                t,
                "[medium]\nmin = {:?}\nmax = {:?}\ncells = {:?}",
                m.whole.min, m.whole.max, m.cells
            );
            *t += &self.part(&m.whole);
            for r in &m.regions {
                let _ = writeln!(t, "[[medium.region]]\nbox = {{ min = {:?}, max = {:?} }}", r.min, r.max);
                *t += &self.part(r);
            }
        }
    }

    fn write_lights(&self, t: &mut String) {
        for l in &self.lights {
            let _ = match l {
                ModelLight::Sun { direction, irradiance, degrees } => writeln!(
                    t,
                    "[[light]]\nkind = \"sun\"\ndirection = {direction:?}\nirradiance = {:?}\nangular_diameter = {degrees:?}",
                    irradiance.to_rgb()
                ),
                ModelLight::Sky { radiance } => {
                    writeln!(t, "[[light]]\nkind = \"sky\"\nradiance = {:?}", radiance.to_rgb())
                }
                ModelLight::Emitter { surface } => {
                    writeln!(t, "[[light]]\nkind = \"emitter\"\nsurface = \"{surface}\"")
                }
            };
        }
    }

    fn part(&self, p: &MediumPart) -> String {
        let mut t = format!("extinction = {:?}\nalbedo = {:?}\n", p.extinction.to_rgb(), p.albedo.to_rgb());
        if self.thermal {
            let _ = match p.heat {
                HeatCondition::Temperature(k) => writeln!(t, "temperature = {k:?}"),
                HeatCondition::Flux(q) | HeatCondition::Power(q) => writeln!(t, "heat_source = {q:?}"),
            };
        } else {
            let _ = writeln!(t, "emission = {:?}\nsource = {:?}", p.emission.to_rgb(), p.source.to_rgb());
        }
        t
    }

    fn look(&self, l: &SurfaceProperties) -> Vec<String> {
        let mut out = Vec::new();
        if self.thermal {
            out.push(format!("emissivity = {:?}", (1.0 - l.reflectance).to_rgb()));
            out.push(match l.heat {
                HeatCondition::Temperature(k) => format!("temperature = {k:?}"),
                HeatCondition::Flux(q) => format!("heat_flux = {q:?}"),
                HeatCondition::Power(p) => format!("net_power = {p:?}"),
            });
        } else {
            out.push(format!("reflectance = {:?}", l.reflectance.to_rgb()));
            out.push(format!("emission = {:?}", l.emission.to_rgb()));
        }
        if l.both {
            out.push("sides = \"both\"".into());
        }
        out
    }

    fn surface(&self, s: &ModelSurface, t: &mut String, files: &mut Vec<(String, String)>) {
        let _ = writeln!(t, "[[surface]]\nname = \"{}\"", s.name);
        let flaw = self.flaws.iter().find(|f| f.0 == s.name).map(|f| f.1);
        match &s.shape {
            ModelShape::Plate { corner: o, edges: [a, b], .. } if flaw == Some(MeshFlaw::OppositeFaces) => {
                let quad = [*o, add(*o, *a), add(add(*o, *a), *b), add(*o, *b)];
                let file = format!("{}.obj", s.name);
                let _ = writeln!(t, "mesh = {{ file = \"{file}\" }}");
                files.push((file, obj(&[quad], flaw)));
                let look = SurfaceProperties { both: false, ..s.look.clone() };
                let _ = writeln!(t, "{}", self.look(&look).join("\n"));
                return;
            }
            ModelShape::Plate { corner: o, edges: [a, b], triangle } => {
                let _ = match triangle {
                    true => writeln!(
                        t,
                        "triangle = {{ corners = [{o:?}, {:?}, {:?}] }}",
                        add(*o, *a),
                        add(*o, *b)
                    ),
                    false => writeln!(t, "rectangle = {{ origin = {o:?}, edge1 = {a:?}, edge2 = {b:?} }}"),
                };
            }
            ModelShape::Box { min, max, degrees } => {
                let _ =
                    writeln!(t, "box = {{ min = {min:?}, max = {max:?}, rotate_z_degrees = {degrees:?} }}");
            }
            ModelShape::Mesh { quads } => {
                let file = format!("{}.obj", s.name);
                let _ = writeln!(t, "mesh = {{ file = \"{file}\" }}");
                if quads.len() == 1 {
                    t.push_str("sides = \"front\"\n");
                }
                files.push((file, obj(quads, flaw)));
            }
            ModelShape::Room { min, max, walls } => {
                let _ = writeln!(t, "room = {{ min = {min:?}, max = {max:?} }}");
                let missing: Vec<&str> = (0..6).filter(|&k| walls[k].is_none()).map(|k| FACES[k]).collect();
                let _ = writeln!(t, "omit = {missing:?}");
                for (k, look) in walls.iter().enumerate() {
                    if let Some(look) = look {
                        let _ = writeln!(t, "faces.{} = {{ {} }}", FACES[k], self.look(look).join(", "));
                    }
                }
                return;
            }
        }
        let _ = writeln!(t, "{}", self.look(&s.look).join("\n"));
    }
}

/// An OBJ text; equal corners are one. A flaw is written into it.
pub(crate) fn obj(quads: &[[Block; 4]], flaw: Option<MeshFlaw>) -> String {
    let (mut points, mut t): (Vec<Block>, String) = (Vec::new(), String::new());
    let mut faces = String::new();
    let mut face = |q: &[Block; 4]| {
        faces += "f";
        for p in q {
            let known = points.iter().position(|x| x == p && flaw != Some(MeshFlaw::LooseCorners));
            let k = known.unwrap_or_else(|| {
                points.push(*p);
                points.len() - 1
            });
            let _ = write!(faces, " {}", k + 1);
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
    for (k, p) in points.iter().enumerate() {
        // A unit in the last place, up and down.
        let rounded =
            |x: f64| if flaw == Some(MeshFlaw::LooseCorners) && k % 2 == 1 { x.next_up() } else { x };
        let _ = writeln!(t, "v {:?} {:?} {:?}", rounded(p[0]), rounded(p[1]), rounded(p[2]));
    }
    t + &faces
}
