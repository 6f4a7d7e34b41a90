//! A church of our own building: nave and aisles under ribbed vaults, an apse, lancets of many coloured panes, a rose.
//!
//! ```text
//!            y = L + 3.65  ___            plan, metres: the nave is 7.3 wide between its walls, the aisles 3.85; bays are 5 long.
//!                        /     \          z: arcades and aisle vaults spring at 5.2 and rise to 7.8, the nave's vault springs at 9.6
//!     y = L   __________|  apse |________ and rises to 14. The sun falls in from the side of large x and from the west.
//!            | aisle : o| nave  |o: aisle
//!            |       :  o       o  :     |
//!     y = 0  |_______:__|_rose__|__:_____|
//!           -8.2   -4.35 -3.65 3.65 4.35 8.2
//! ```
//!
//! | module | what |
//! |---|---|
//! | `model` | meshes by material, boxes, bodies of revolution, swept bars |
//! | `body` | these cut flush with the walls they stand at |
//! | `arch` | pointed arches, vaults, ribs |
//! | `plane` | convex polygons cut by one another |
//! | `wall` | walls with openings |
//! | `glass` | tracery, panes, cames, the rose |
//! | `furniture` | columns, benches, altar, candles |
//! | `roof` | roofs, gables: what keeps the light out |
//! | `mesh` | the GLB |
//! | `textures` | stone, tiles, oak |
//! | `scene` | the scene file |

mod arch;
mod body;
mod furniture;
mod glass;
mod mesh;
mod model;
mod plane;
mod roof;
mod scene;
mod textures;
mod wall;

pub use glass::HUES;
pub use mesh::glb_model;
pub use model::{Mesh, Model, Stuff};
pub use scene::{look, scene_text};

use arch::{Arch, Vault, rib};
use furniture::CAPITAL;
use glass::{SCHEMES, Window};
use std::f64::consts::PI;
use wall::{Frame, Line, Opening, Wall};
use zonal_math::{Vec3, vec3};

/// How large and how fine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Bays of the nave.
    pub bays: usize,
    /// Pieces from the springing of a vault to its crown.
    pub pieces: usize,
    /// Sides of a column.
    pub sides: usize,
    /// Straight pieces of half an arch.
    pub arc: usize,
    /// Side of a cell of glass, m.
    pub cell: f64,
    /// True with the cames and bars of the windows, and all mouldings.
    pub fine: bool,
}

impl Plan {
    /// The church of the pictures.
    pub const FULL: Plan = Plan { bays: 6, pieces: 10, sides: 20, arc: 8, cell: 0.24, fine: true };
    /// Two bays with larger panes, for tests.
    pub const SMALL: Plan = Plan { bays: 2, pieces: 4, sides: 8, arc: 3, cell: 0.5, fine: false };

    /// Length of the nave L, m.
    pub fn length(&self) -> f64 {
        BAY * self.bays as f64
    }
}

const BAY: f64 = 5.0;
/// Half width of the nave between its walls, and of the outer faces of these, m.
const NAVE: (f64, f64) = (3.65, 4.35);
/// Outer walls, m from the axis.
const OUTER: f64 = 8.2;
/// Springing and rise of the nave's vault, m.
const HIGH: (f64, f64) = (9.6, 4.4);
/// Rise of the aisles' vaults, m.
const LOW: f64 = 2.6;
/// Arches of the arcades: half span and rise, m.
const ARCADE: (f64, f64) = (2.1, 2.3);
const SIDES: [f64; 2] = [-1.0, 1.0];

/// Builds the church.
pub fn build(plan: &Plan) -> Model {
    let mut m = Model::default();
    let church = Church { plan };
    church.floor(&mut m);
    for bay in 0..plan.bays {
        church.nave_bay(&mut m, bay);
        for s in SIDES {
            church.aisle_bay(&mut m, s, bay);
            church.arcade(&mut m, s, bay);
        }
    }
    church.supports(&mut m);
    church.west(&mut m);
    SIDES.iter().for_each(|s| church.aisle_east(&mut m, *s));
    church.apse(&mut m);
    church.furnish(&mut m);
    roof::build(&mut m, &church);
    m
}

struct Church<'a> {
    plan: &'a Plan,
}

impl Church<'_> {
    fn end(&self) -> f64 {
        self.plan.length()
    }
    /// An arch of masonry.
    fn head(&self, half: f64, rise: f64) -> Arch {
        Arch::new(half, rise, self.plan.arc)
    }
    fn border(&self, bay: usize) -> f64 {
        BAY * bay as f64
    }

    fn floor(&self, m: &mut Model) {
        let l = self.end();
        let up = vec3(0.0, 0.0, 5.0);
        for (a, b, stuff) in
            [(-OUTER, -0.75, Stuff::Tiles), (-0.75, 0.75, Stuff::Carpet), (0.75, OUTER, Stuff::Tiles)]
        {
            m.polygon(stuff, &[vec3(a, 0.0, 0.0), vec3(b, 0.0, 0.0), vec3(b, l, 0.0), vec3(a, l, 0.0)], up);
        }
        m.polygon(Stuff::Tiles, &self.choir(NAVE.0, 0.0), up);
    }

    /// The apse's corners in plan at a radius, from large x to small.
    fn choir(&self, radius: f64, z: f64) -> Vec<Vec3> {
        (0..=5)
            .map(|k| {
                let (sin, cos) = (PI * k as f64 / 5.0).sin_cos();
                vec3(radius * cos, self.end() + radius * sin, z)
            })
            .collect()
    }

    /// The half-spaces within the walls of nave and apse.
    fn nave(&self) -> Vec<(Vec3, f64)> {
        let corners = self.choir(NAVE.0, 0.0);
        let mut plan = vec![vec3(-NAVE.0, 0.0, 0.0), vec3(NAVE.0, 0.0, 0.0)];
        plan.extend(corners);
        plan.push(plan[0]);
        let inward = |p: &[Vec3]| {
            let d = (p[1] - p[0]).normalized();
            let n = vec3(-d.y, d.x, 0.0);
            (n, n.dot(p[0]))
        };
        plan.windows(2).map(inward).collect()
    }

    /// The half-spaces within the walls of an aisle.
    fn aisle(&self, s: f64) -> [(Vec3, f64); 4] {
        let (across, along) = (vec3(s, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        [(across, NAVE.1), (-across, -OUTER), (along, 0.0), (-along, -self.end())]
    }

    fn vault(&self, bay: usize, x: (f64, f64), spring: f64, rise: f64) -> Vault {
        let (y0, y1) = (self.border(bay), self.border(bay + 1));
        Vault { lo: vec3(x.0, y0, spring), hi: vec3(x.1, y1, spring), rise, pieces: self.plan.pieces }
    }

    /// The wall of a bay at `x` from the axis, on the side `s`, seen from the axis.
    fn side(&self, s: f64, x: f64, bay: usize) -> Frame {
        let middle = vec3(s * x, self.border(bay) + 0.5 * BAY, 0.0);
        Frame::new(middle, vec3(0.0, 1.0, 0.0), vec3(-s, 0.0, 0.0))
    }

    /// The end wall of an aisle at `y`, and the arch of the vault over it.
    fn end_of_aisle(&self, s: f64, y: f64, inward: Vec3) -> (Frame, Arch) {
        let middle = vec3(s * 0.5 * (NAVE.1 + OUTER), y, 0.0);
        let arch = Arch::new(0.5 * (OUTER - NAVE.1), LOW, self.plan.pieces);
        (Frame::new(middle, vec3(1.0, 0.0, 0.0), inward), arch)
    }

    fn nave_bay(&self, m: &mut Model, bay: usize) {
        let vault = self.vault(bay, (-NAVE.0, NAVE.0), HIGH.0, HIGH.1);
        vault.webs(m);
        m.within(&self.nave(), |m| {
            vault.diagonals(m, &rib(0.22, 0.24));
            vault.transverse(m, self.border(bay + 1), &rib(0.34, 0.32));
        });
        for s in SIDES {
            let frame = self.side(s, NAVE.0, bay);
            let head = self.head(0.85, 1.3);
            let window = Window {
                frame,
                centre: 0.0,
                sill: 9.75,
                spring: 11.35,
                head,
                lights: 2,
                cell: self.plan.cell,
                leaded: self.plan.fine,
                scheme: &SCHEMES[(bay + if s > 0.0 { 0 } else { 3 }) % SCHEMES.len()],
            };
            let arcade = self.head(ARCADE.0, ARCADE.1);
            let wall = Wall {
                frame,
                ends: (-0.5 * BAY, 0.5 * BAY),
                lower: Line::arch(&arcade, CAPITAL),
                upper: Line(vault.edge()),
                opening: Some(window.opening()),
            };
            wall.build(m);
            window.build(m);
            let (y0, y1, x) = (self.border(bay), self.border(bay + 1), NAVE.0);
            let (a, b) = ((s * (x - 0.09)).min(s * x), (s * (x - 0.09)).max(s * x));
            m.block(Stuff::Dressed, vec3(a, y0, 8.98), vec3(b, y1, 9.14));
        }
    }

    fn aisle_bay(&self, m: &mut Model, s: f64, bay: usize) {
        let x = if s > 0.0 { (NAVE.1, OUTER) } else { (-OUTER, -NAVE.1) };
        let vault = self.vault(bay, x, CAPITAL, LOW);
        vault.webs(m);
        m.within(&self.aisle(s), |m| {
            vault.diagonals(m, &rib(0.16, 0.18));
            if bay + 1 < self.plan.bays {
                vault.transverse(m, self.border(bay + 1), &rib(0.26, 0.24));
            }
        });
        let frame = self.side(s, OUTER, bay);
        let window = Window {
            frame,
            centre: 0.0,
            sill: 1.5,
            spring: 4.6,
            head: self.head(1.0, 1.6),
            lights: 2,
            cell: self.plan.cell,
            leaded: self.plan.fine,
            scheme: &SCHEMES[(2 * bay + if s > 0.0 { 1 } else { 2 }) % SCHEMES.len()],
        };
        let wall = Wall {
            frame,
            ends: (-0.5 * BAY, 0.5 * BAY),
            lower: Line::level(0.0),
            upper: Line(vault.edge()),
            opening: Some(window.opening()),
        };
        wall.build(m);
        window.build(m);
    }

    /// The arcade's wall on the side of the aisle, the soffit of its arch, and the moulding towards the nave.
    fn arcade(&self, m: &mut Model, s: f64, bay: usize) {
        let middle = self.border(bay) + 0.5 * BAY;
        let frame = Frame::new(vec3(s * NAVE.1, middle, 0.0), vec3(0.0, 1.0, 0.0), vec3(s, 0.0, 0.0));
        let arch = self.head(ARCADE.0, ARCADE.1);
        let vault = self.vault(bay, (NAVE.1, OUTER), CAPITAL, LOW);
        let wall = Wall {
            frame,
            ends: (-0.5 * BAY, 0.5 * BAY),
            lower: Line::arch(&arch, CAPITAL),
            upper: Line(vault.edge()),
            opening: None,
        };
        wall.build(m);
        let points = arch.points();
        let depth = NAVE.1 - NAVE.0;
        for w in points.windows(2) {
            let at = |p: [f64; 2], d: f64| frame.at(p[0], CAPITAL + p[1], d);
            m.polygon(
                Stuff::Dressed,
                &[at(w[0], 0.0), at(w[1], 0.0), at(w[1], depth), at(w[0], depth)],
                frame.at(0.0, CAPITAL, 0.5 * depth),
            );
        }
        let line: Vec<Vec3> =
            points.iter().map(|p| frame.at(p[0] * 1.03, CAPITAL + p[1] * 1.03, depth)).collect();
        let profile = [[-0.06, -0.05], [0.02, -0.05], [0.02, 0.09], [-0.03, 0.09], [-0.06, 0.05]];
        m.within(&self.nave(), |m| m.sweep(Stuff::Dressed, &line, frame.inward, &profile));
    }

    /// Columns, shafts before the walls, and the half piers at both ends of the arcades.
    fn supports(&self, m: &mut Model) {
        let (l, sides) = (self.end(), self.plan.sides);
        for s in SIDES {
            for bay in 1..self.plan.bays {
                let y = self.border(bay);
                furniture::column(m, vec3(s * 0.5 * (NAVE.0 + NAVE.1), y, 0.0), sides);
                m.within(&self.nave(), |m| {
                    furniture::shaft(m, vec3(s * NAVE.0, y, 0.0), (CAPITAL + 0.4, HIGH.0), sides / 2);
                });
                m.within(&self.aisle(s), |m| {
                    furniture::shaft(m, vec3(s * OUTER, y, 0.0), (0.35, CAPITAL), sides / 2);
                });
            }
            let (x0, x1) = ((s * NAVE.0).min(s * NAVE.1), (s * NAVE.0).max(s * NAVE.1));
            m.block(Stuff::Dressed, vec3(x0, 0.0, 0.0), vec3(x1, 0.4, CAPITAL));
            m.block(Stuff::Dressed, vec3(x0, l - 0.4, 0.0), vec3(x1, l, CAPITAL));
        }
        m.within(&self.nave(), |m| {
            for corner in self.choir(NAVE.0, 0.0) {
                furniture::shaft(m, corner, (0.35, HIGH.0), sides / 2);
            }
        });
    }

    fn west(&self, m: &mut Model) {
        let frame = Frame::new(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let rose = Opening::Round { centre: 0.0, height: 10.3, radius: 2.4, sides: 4 * self.plan.arc };
        let top = Arch::new(NAVE.0, HIGH.1, self.plan.pieces);
        let door = self.head(1.15, 1.5);
        let portal = Opening::Pointed { centre: 0.0, sill: 0.0, spring: 2.4, head: door };
        let (above, crown) = (Line::level(5.0), Line::arch(&top, HIGH.0));
        for (lower, upper, opening) in
            [(Line::level(0.0), above.clone(), portal), (above.clone(), crown.clone(), rose)]
        {
            Wall { frame, ends: (-NAVE.0, NAVE.0), lower, upper, opening: Some(opening) }.build(m);
        }
        glass::rose(m, &frame, &rose, self.plan.fine);
        SIDES.iter().for_each(|s| self.aisle_end(m, *s, 0.0, vec3(0.0, 1.0, 0.0), None));
        let mut leaf = vec![[-1.15, 0.0], [1.15, 0.0]];
        leaf.extend(door.points().into_iter().rev().map(|[x, z]| [x, 2.4 + z]));
        let base: Vec<Vec3> = leaf.iter().map(|p| vec3(p[0], 0.0, p[1])).collect();
        m.prism(Stuff::Oak, &base, vec3(0.0, 0.1, 0.0));
        let arch: Vec<Vec3> = leaf[2..].iter().map(|p| vec3(p[0], 0.0, p[1])).collect();
        let mut jambs = vec![vec3(1.15, 0.0, 0.0)];
        jambs.extend(arch);
        jambs.push(vec3(-1.15, 0.0, 0.0));
        m.sweep(
            Stuff::Dressed,
            &jambs,
            vec3(0.0, 1.0, 0.0),
            &[[0.0, -0.2], [0.2, -0.2], [0.2, -0.12], [0.12, 0.0], [0.0, 0.0]],
        );
    }

    /// The end wall of an aisle.
    fn aisle_end(&self, m: &mut Model, s: f64, y: f64, inward: Vec3, window: Option<Window>) {
        let (frame, top) = self.end_of_aisle(s, y, inward);
        let wall = Wall {
            frame,
            ends: (-top.half, top.half),
            lower: Line::level(0.0),
            upper: Line::arch(&top, CAPITAL),
            opening: window.as_ref().map(Window::opening),
        };
        wall.build(m);
        if let Some(w) = window {
            w.build(m);
        }
    }

    fn aisle_east(&self, m: &mut Model, s: f64) {
        let inward = vec3(0.0, -1.0, 0.0);
        let window = Window {
            frame: self.end_of_aisle(s, self.end(), inward).0,
            centre: 0.0,
            sill: 1.6,
            spring: 4.3,
            head: self.head(0.6, 1.0),
            lights: 1,
            cell: self.plan.cell,
            leaded: self.plan.fine,
            scheme: &SCHEMES[if s > 0.0 { 4 } else { 0 }],
        };
        self.aisle_end(m, s, self.end(), inward, Some(window));
    }

    fn apse(&self, m: &mut Model) {
        let corners = self.choir(NAVE.0, 0.0);
        let axis = vec3(0.0, self.end(), 0.0);
        for k in 0..5 {
            let (a, b) = (corners[k], corners[k + 1]);
            let middle = (a + b) * 0.5;
            let frame = Frame::new(middle, b - a, axis - middle);
            let half = 0.5 * (b - a).length();
            let window = Window {
                frame,
                centre: 0.0,
                sill: 2.4,
                spring: 7.5,
                head: self.head(0.66, 1.3),
                lights: 1,
                cell: self.plan.cell,
                leaded: self.plan.fine,
                scheme: &SCHEMES[[1, 3, 0, 2, 5][k]],
            };
            let wall = Wall {
                frame,
                ends: (-half, half),
                lower: Line::level(0.0),
                upper: Line::level(HIGH.0),
                opening: Some(window.opening()),
            };
            wall.build(m);
            window.build(m);
        }
        self.apse_vault(m);
    }

    fn apse_vault(&self, m: &mut Model) {
        let profile = Arch::new(NAVE.0, HIGH.1, self.plan.pieces);
        let levels: Vec<f64> = profile.points()[..=self.plan.pieces].iter().map(|p| p[1]).collect();
        let below = vec3(0.0, self.end() + 1.0, HIGH.0 - 1.0);
        let rings: Vec<Vec<Vec3>> =
            levels.iter().map(|z| self.choir(profile.width(*z), HIGH.0 + z)).collect();
        let mut course = 0.0;
        for w in rings.windows(2) {
            let step = (w[1][2] - w[0][2]).length();
            for k in 0..5 {
                let side = |i: usize, r: usize| {
                    (w[r][i], [w[r][i].x + w[r][i].y, course + if r == 0 { 0.0 } else { step }])
                };
                m.textured(Stuff::Web, &[side(k, 0), side(k + 1, 0), side(k + 1, 1), side(k, 1)], below);
            }
            course += step;
        }
        for k in 1..5 {
            let line: Vec<Vec3> = rings.iter().map(|r| r[k]).collect();
            let out = line[0] - vec3(0.0, self.end(), line[0].z);
            let side = vec3(out.y, -out.x, 0.0).normalized();
            m.within(&self.nave(), |m| m.sweep(Stuff::Dressed, &line, side, &rib(0.22, 0.24)));
        }
        m.turned(
            Stuff::Dressed,
            vec3(0.0, self.end(), HIGH.0 + HIGH.1),
            &[(0.12, -0.42), (0.3, -0.32), (0.32, -0.1), (0.25, 0.01)],
            12,
        );
    }

    fn furnish(&self, m: &mut Model) {
        let l = self.end();
        for (scale, z) in [(0.86, 0.0), (0.64, 0.17)] {
            let mut plan = self.choir(scale * NAVE.0, z);
            plan.push(vec3(-scale * NAVE.0, l - 1.6 * scale, z));
            plan.push(vec3(scale * NAVE.0, l - 1.6 * scale, z));
            m.prism(Stuff::Dressed, &plan, vec3(0.0, 0.0, 0.17));
        }
        furniture::altar(m, vec3(0.0, l + 0.5, 0.34));
        SIDES.iter().for_each(|s| furniture::candelabrum(m, vec3(s * 1.75, l - 0.3, 0.34)));
        let rows = ((l - 7.0) / 0.98).floor().max(0.0) as usize;
        for row in 0..rows {
            let y = 4.0 + 0.98 * row as f64;
            furniture::bench(m, (-3.1, -0.95), y);
            furniture::bench(m, (0.95, 3.1), y);
        }
        for bay in (1..self.plan.bays).step_by(2) {
            let y = self.border(bay) + 0.5 * BAY;
            furniture::chandelier(m, vec3(0.0, y, 4.9), HIGH.0 + HIGH.1, 8);
        }
    }
}
