//! Where cases run: scenes as texts that a user could run, solved and measured.

use crate::Failure;
use crate::commands::solve::signed;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zonal_io::{input, output};
use zonal_scene::{Progress, Scene, Solution};
use zonal_solve::Job;

/// The largest memory of a solve, bytes.
const MEMORY: u64 = 12 << 30;

/// The bench that cases are given.
pub struct Bench<'a> {
    /// The folder of reference files.
    pub reference: &'a Path,
    /// Where pictures for the page go; `None` where no page is written.
    pub pictures: Option<&'a Path>,
    /// Listener.
    pub progress: &'a dyn Progress,
    work: PathBuf,
    keep: bool,
}

impl<'a> Bench<'a> {
    /// A bench; scenes and their arrays are written into `scenes` and stay there, or into a folder that goes with the bench.
    pub fn new(
        reference: &'a Path,
        pictures: Option<&'a Path>,
        scenes: Option<&Path>,
        progress: &'a dyn Progress,
    ) -> Result<Bench<'a>, Failure> {
        let own = || std::env::temp_dir().join(format!("zonal-validate-{}", std::process::id()));
        let work = scenes.map_or_else(own, Path::to_path_buf);
        std::fs::create_dir_all(&work).map_err(|e| {
            Failure::new(format!("{}: the folder cannot be made ({e}); choose another", work.display()))
        })?;
        Ok(Bench { reference, pictures, progress, work, keep: scenes.is_some() })
    }

    /// Solves a scene of this name.
    pub fn solve(&self, name: &str, text: &str) -> Result<Solution, Failure> {
        let file = self.work.join(format!("{name}.toml"));
        if self.keep {
            output::write_bytes(&file, text.as_bytes())?;
        }
        self.solve_scene(self.scene(name, text)?)
    }

    /// Reads a scene of this name.
    pub fn scene(&self, name: &str, text: &str) -> Result<Scene, Failure> {
        let file = self.work.join(format!("{name}.toml"));
        Ok(input::parse_scene(text, Some(&self.work), &file.display().to_string())?)
    }

    /// Solves a scene; what its zones cost is seen from finer ones here, and estimated only where it says so.
    pub fn solve_scene(&self, scene: Scene) -> Result<Solution, Failure> {
        let mut options = scene.options().clone();
        options.zoning_error.get_or_insert(false);
        let scene = scene.with_options(options)?;
        signed(scene, &Job::new(MEMORY, self.progress))
    }

    /// Writes an array that scenes name by the file that comes back.
    pub fn array(&self, name: &str, shape: &[usize], values: &[f64]) -> Result<String, Failure> {
        let file = format!("{name}.npy");
        output::write_array(&self.work.join(&file), shape, values)?;
        Ok(file)
    }
}

impl Drop for Bench<'_> {
    fn drop(&mut self) {
        if !self.keep {
            let _ = std::fs::remove_dir_all(&self.work);
        }
    }
}

/// The walls of a box, by name.
pub(super) const FACES: [&str; 6] = ["x0", "x1", "y0", "y1", "z0", "z1"];

/// A box of one medium between walls, as a scene file.
#[derive(Clone, Debug)]
pub(super) struct Room {
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

impl Room {
    /// A box with black cold walls.
    pub(super) fn new(size: [f64; 3], cells: [usize; 3], extinction: f64) -> Room {
        Room {
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
    pub(super) fn layer(depth: f64, cells: usize) -> Room {
        let mut room = Room::new([1.0; 3], [1, 1, cells], depth);
        room.walls[..4].fill(None);
        room
    }

    /// The same in thermal mode: all walls that there are with this emissivity and temperature, K.
    pub(super) fn warm(mut self, emissivity: f64, kelvin: f64) -> Room {
        self.warm = true;
        self.walls.iter_mut().flatten().for_each(|w| *w = (emissivity, kelvin));
        self
    }

    /// Lines of the medium.
    pub(super) fn medium(mut self, lines: &str) -> Room {
        self.medium = lines.into();
        self
    }

    /// One wall's reflectance and emission, or emissivity and temperature.
    pub(super) fn wall(mut self, face: usize, first: f64, second: f64) -> Room {
        self.walls[face] = Some((first, second));
        self
    }

    /// Lines of `[solve]`.
    pub(super) fn solve(mut self, lines: &str) -> Room {
        self.solve = lines.into();
        self
    }

    /// The scene file: axes without walls are periodic.
    pub(super) fn text(&self, name: &str) -> String {
        let mode = if self.warm { "mode = \"thermal\"\n" } else { "" };
        let mut t = format!(
            "name = \"{name}\"\n{mode}\n[solve]\npatch_rule = \"voxels\"\nresidual = 1e-12\ngroups = \"all\"\n"
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
            (0..6).filter(|&f| self.walls[f].is_none()).map(|f| format!("\"{}\"", FACES[f])).collect();
        if !gone.is_empty() {
            let _ = writeln!(t, "omit = [{}]", gone.join(", "));
        }
        for (face, wall) in FACES.iter().zip(&self.walls) {
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

/// Means over a wall, weighted by area: irradiance and radiosity, W/m².
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    /// Irradiance H.
    pub incident: f64,
    /// Radiosity B.
    pub radiosity: f64,
}

impl Wall {
    /// The mean over the surfaces whose name ends in `face`, in the first band.
    pub(super) fn of(s: &Solution, face: &str) -> Wall {
        let (mut area, mut h, mut b) = (0.0, 0.0, 0.0);
        for (i, p) in s.zones.patches.iter().enumerate() {
            if s.scene.surfaces()[p.surface].name.ends_with(face) {
                area += p.area;
                h += p.area * s.fields.incident[i][0];
                b += p.area * s.fields.radiosity[i][0];
            }
        }
        Wall { incident: h / area, radiosity: b / area }
    }

    /// Net flux out of the wall, W/m².
    pub(super) fn net(&self) -> f64 {
        self.radiosity - self.incident
    }
}

/// Net flux out of the walls whose name ends in `face`, of a solution in thermal mode, W/m².
pub(super) fn net(s: &Solution, face: &str) -> f64 {
    let rows = s.report.heat.iter().flat_map(|h| &h.rows).filter(|r| r.name.ends_with(face));
    let (power, size) = rows.fold((0.0, 0.0), |(p, a), r| (p + r.power, a + r.size));
    power / size
}

/// The temperature of a voxel, K, of a solution in thermal mode.
pub(super) fn temperature(s: &Solution, c: [usize; 3]) -> f64 {
    let index = s.scene.voxmap().map_or(0, |m| m.index(c));
    let heat = s.fields.heat.as_ref();
    heat.and_then(|h| h.temperature.get(s.zones.voxel_offset() + index)).map_or(f64::NAN, |t| *t)
}

/// The values of a field of voxels, by the coordinates of the cell, in the first band.
pub(super) fn voxel(s: &Solution, field: &[[f64; 3]], c: [usize; 3]) -> f64 {
    let index = s.scene.voxmap().map_or(0, |m| m.index(c));
    field.get(s.zones.voxel_offset() + index).map_or(f64::NAN, |v| v[0])
}
