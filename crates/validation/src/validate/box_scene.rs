//! A box of one medium between walls, as the text of a scene file.

use std::fmt::Write as _;

/// The walls of a box, by name.
pub(crate) const WALL_NAMES: [&str; 6] = ["x0", "x1", "y0", "y1", "z0", "z1"];

/// A box of one medium between walls, as a scene file.
#[derive(Clone, Debug)]
pub(crate) struct BoxScene {
    /// Its far corner, m; the near one is the origin.
    pub size: [f64; 3],
    /// Cells of its medium, and patches of its walls.
    pub cells: [usize; 3],
    /// Extinction, 1/m.
    pub extinction: f64,
    /// Lines of `[medium]` besides.
    pub medium: String,
    /// Reflectance and emission (W/m²) of the six walls, or emissivity and temperature (K) where the room is warm; `None` for one that is not there.
    pub walls: [Option<(f64, f64)>; 6],
    /// True in thermal mode.
    pub warm: bool,
    /// Lines of `[solve]` besides.
    pub solve: String,
}

impl BoxScene {
    /// A box with black cold walls.
    pub(crate) fn new(size: [f64; 3], cells: [usize; 3], extinction: f64) -> BoxScene {
        BoxScene {
            size,
            cells,
            extinction,
            medium: String::new(),
            walls: [Some((0.0, 0.0)); 6],
            warm: false,
            solve: String::new(),
        }
    }

    /// A layer of the optical thickness `depth` along z between two walls, endless along x and y.
    pub(crate) fn layer(depth: f64, cells: usize) -> BoxScene {
        let mut room = BoxScene::new([1.0; 3], [1, 1, cells], depth);
        room.walls[..4].fill(None);
        room
    }

    /// The same in thermal mode: all walls that there are with this emissivity and temperature, K.
    pub(crate) fn warm(mut self, emissivity: f64, kelvin: f64) -> BoxScene {
        self.warm = true;
        self.walls.iter_mut().flatten().for_each(|w| *w = (emissivity, kelvin));
        self
    }

    /// Lines of the medium.
    pub(crate) fn medium(mut self, lines: &str) -> BoxScene {
        self.medium = lines.into();
        self
    }

    /// One wall's reflectance and emission, or emissivity and temperature.
    pub(crate) fn wall(mut self, face: usize, first: f64, second: f64) -> BoxScene {
        self.walls[face] = Some((first, second));
        self
    }

    /// Lines of `[solve]`.
    pub(crate) fn solve(mut self, lines: &str) -> BoxScene {
        self.solve = lines.into();
        self
    }

    /// The scene file: axes without walls are periodic.
    pub(crate) fn text(&self, name: &str) -> String {
        let mode = if self.warm { "mode = \"thermal\"\n" } else { "" };
        let mut t = format!(
            "name = \"{name}\"\n{mode}\n[solve]\npatch_rule = \"voxels\"\nresidual = 1e-12\nlight_groups = \"all\"\n"
        );
        if !self.solve.is_empty() {
            let _ = writeln!(t, "{}", self.solve.trim_end());
        }
        let [x, y, z] = self.size;
        let _ =
            write!(t, "\n[medium]\nmin = [0, 0, 0]\nmax = [{x:?}, {y:?}, {z:?}]\ncells = {:?}\n", self.cells);
        if self.extinction > 0.0 {
            let _ = writeln!(t, "extinction = {:?}", self.extinction);
        }
        if !self.medium.is_empty() {
            let _ = writeln!(t, "{}", self.medium.trim_end());
        }
        let _ = write!(
            t,
            "\n[[surface]]\nname = \"walls\"\nroom = {{ min = [0, 0, 0], max = [{x:?}, {y:?}, {z:?}] }}\n"
        );
        if !self.warm {
            t.push_str("reflectance = 0\n");
        }
        let gone: Vec<String> =
            (0..6).filter(|&f| self.walls[f].is_none()).map(|f| format!("\"{}\"", WALL_NAMES[f])).collect();
        if !gone.is_empty() {
            let _ = writeln!(t, "omit = [{}]", gone.join(", "));
        }
        for (face, wall) in WALL_NAMES.iter().zip(&self.walls) {
            match wall {
                Some((e, kelvin)) if self.warm => {
                    let _ = writeln!(t, "faces.{face} = {{ emissivity = {e:?}, temperature = {kelvin:?} }}");
                }
                Some((r, e)) if *r != 0.0 || *e != 0.0 => {
                    let _ = writeln!(t, "faces.{face} = {{ reflectance = {r:?}, emission = {e:?} }}");
                }
                _ => {}
            }
        }
        let periodic = |k: usize| self.walls[2 * k].is_none() && self.walls[2 * k + 1].is_none();
        if (0..3).any(periodic) {
            t.push_str("\n[boundary]\n");
            for k in (0..3).filter(|&k| periodic(k)) {
                let _ = writeln!(t, "{} = \"periodic\"", ["x", "y", "z"][k]);
            }
        }
        t
    }
}
