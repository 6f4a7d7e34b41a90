//! Gas in closed meshes in radiative equilibrium, and smoke in a Cornell box.
//!
//! A thermal scene has a twin in light mode with the same zones and the same H and G: a surface of temperature T and emissivity ε emits εσT⁴
//! and reflects 1 − ε, and gas in radiative equilibrium of absorption κ is a medium of extinction κ and albedo 1. Path tracing takes the twin.

use super::SceneFolder;
use super::mesh::{BodySide, MeshText};
use crate::harness::Error;
use crate::scenes::cornell::{self, BoxMedium};
use std::fmt::Write as _;

/// Stefan-Boltzmann constant, W/(m² K⁴).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// The formulation of a scene with temperatures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RadiationMode {
    /// Temperatures and heat.
    Thermal,
    /// The twin.
    Light,
}

impl RadiationMode {
    fn header(self, name: &str) -> String {
        let mode = if self == RadiationMode::Thermal { "mode = \"thermal\"\n" } else { "" };
        format!("name = \"{name}\"\n{mode}[solve]\ntolerance = 0.05\n")
    }

    /// The keys of a surface of temperature T (K) and an emissivity; `prefix` precedes each key.
    fn surface(self, prefix: &str, temperature: f64, emissivity: f64) -> String {
        match self {
            RadiationMode::Thermal => {
                format!("{prefix}temperature = {temperature}\n{prefix}emissivity = {emissivity}\n")
            }
            RadiationMode::Light => format!(
                "{prefix}emission = {}\n{prefix}reflectance = {}\n",
                emissivity * STEFAN_BOLTZMANN * temperature.powi(4),
                1.0 - emissivity
            ),
        }
    }

    /// The keys of gas in radiative equilibrium.
    fn gas(self, absorption: f64) -> String {
        match self {
            RadiationMode::Thermal => format!("absorption = {absorption}\nheat_source = 0\n"),
            RadiationMode::Light => format!("extinction = {absorption}\nalbedo = 1\n"),
        }
    }
}

/// Gas in a sphere of 320 triangles, its upper half hot, on 8³ cells.
pub(super) fn sphere(folder: &SceneFolder, mode: RadiationMode) -> Result<String, Error> {
    let (mut whole, cuts) = (MeshText::default(), [16, 11]);
    whole.sphere([0.0; 3], 1.0, cuts, BodySide::Inside);
    let mut t = mode.header("gas-sphere") + "patch_size = 1\n";
    whole.text = halves(&whole.text, cuts);
    t += &folder.mesh_surface("gas-sphere", "shell", &whole)?;
    t += &mode.surface("materials.\"hot\".", 1200.0, 0.8);
    t += &mode.surface("materials.\"cold\".", 500.0, 0.6);
    let _ = write!(t, "[medium]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\ncells = [8, 8, 8]\n{}", mode.gas(0.8));
    Ok(t)
}

/// The text of a sphere with a material for its faces below the middle and one for those above: a face is hot where its last corner, or
/// any other, lies above the equator.
fn halves(text: &str, [segments, bands]: [usize; 2]) -> String {
    let middle = 1 + segments * (bands / 2);
    let mut out = String::new();
    for line in text.lines() {
        if let Some(corners) = line.strip_prefix("f ") {
            let lowest = corners.split(' ').filter_map(|k| k.parse::<usize>().ok()).min().unwrap_or(0);
            let name = if lowest > middle { "hot" } else { "cold" };
            let _ = writeln!(out, "usemtl {name}");
        }
        let _ = writeln!(out, "{line}");
    }
    out
}

/// Gas in a closed mesh of a box with four obstacles, about 1,800 zones.
pub(super) fn obstacles(folder: &SceneFolder, mode: RadiationMode) -> Result<String, Error> {
    let (lo, hi) = ([0.0, 0.0, 0.0], [3.0, 2.0, 2.0]);
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { hi[axis] } else { lo[axis] });
    let corners: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let mut room = MeshText::default();
    let walls = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    room.material("hot").part(&corners, &walls[..1]);
    room.material("walls").part(&[], &[] as &[[usize; 4]]);
    for wall in &walls[1..] {
        let _ = writeln!(room.text, "f {}", wall.map(|k| (k + 1).to_string()).join(" "));
    }
    let mut bodies = MeshText::default();
    bodies.cuboid([0.7, 0.4, 0.0], [1.0, 0.8, 1.3], 0.0).cuboid([1.7, 1.1, 0.0], [2.1, 1.5, 0.9], 0.5);
    bodies.cylinder([1.4, 0.9], 0.18, [0.55, 1.7], 12).sphere(
        [2.4, 0.55, 1.3],
        0.3,
        [12, 8],
        BodySide::Outside,
    );
    let mut t = mode.header("gas-obstacles") + "patch_size = 0.3\n";
    t += &folder.mesh_surface("gas-obstacles", "furnace", &room)?;
    t += &mode.surface("materials.\"hot\".", 1300.0, 0.8);
    t += &mode.surface("materials.\"walls\".", 700.0, 0.7);
    t += &folder.mesh_surface("gas-obstacles", "load", &bodies)?;
    t += &mode.surface("", 500.0, 0.9);
    let _ = write!(t, "[medium]\nmin = [0, 0, 0]\nmax = [3, 2, 2]\ncells = [12, 8, 8]\n{}", mode.gas(0.4));
    Ok(t)
}

/// A column of smoke in a Cornell box, its density from measured data; lengths in millimetres.
pub(super) fn varying_smoke(folder: &SceneFolder) -> Result<String, Error> {
    let data = folder.shared.join("data").canonicalize()?;
    let settings = "tolerance = 0.05\npatch_size = 56";
    let room = cornell::room("varying-smoke", &data, BoxMedium::Smoke, settings, cornell::FRONT_WALLS);
    Ok(room + cornell::LAMP + &cornell::medium(BoxMedium::Smoke, &data, 0, [14, 28, 14]))
}
