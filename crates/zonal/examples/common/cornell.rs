//! The text of Mitsuba's Cornell box, for the examples that solve it.

use std::fmt::Write as _;
use std::path::Path;

const WHITE: &str = "[0.885809, 0.698859, 0.666422]";
const RED: &str = "[0.570068, 0.0430135, 0.0443706]";
const GREEN: &str = "[0.105421, 0.37798, 0.076425]";
/// Radiance of the lamp, W/(m² sr).
const LAMP: [f64; 3] = [18.387, 13.9873, 6.75357];

/// The walls, the two boxes where wanted, the lamp and the camera, with `[solve]` as given; lengths in millimetres as in the meshes.
pub(super) fn cornell(name: &str, meshes: &Path, boxes: bool, solve: &str) -> String {
    let mut t = format!("name = \"{name}\"\n[solve]\n{solve}\n");
    let mut walls =
        vec![("back", WHITE), ("ceiling", WHITE), ("floor", WHITE), ("greenwall", GREEN), ("redwall", RED)];
    if boxes {
        walls.extend([("smallbox", WHITE), ("largebox", WHITE)]);
    }
    walls.push(("luminaire", WHITE));
    for (name, rho) in walls {
        let file = meshes.join(format!("cbox_{name}.obj")).display().to_string();
        let lamp = name == "luminaire";
        let place = if lamp { ", translate = [0, -0.5, 0]" } else { "" };
        let _ = write!(
            t,
            "[[surface]]\nname = \"{name}\"\nmesh = {{ file = {file:?}{place} }}\nreflectance = {rho}\nsides = \"front\"\n"
        );
        if lamp {
            let e = LAMP.map(|l| l * std::f64::consts::PI);
            let _ = writeln!(t, "emission = [{}, {}, {}]", e[0], e[1], e[2]);
        }
    }
    t.push_str("[[light]]\nkind = \"emitter\"\nsurface = \"luminaire\"\n");
    t.push_str("[[camera]]\nname = \"front\"\norigin = [278, 273, -800]\ntarget = [278, 273, -799]\nup = [0, 1, 0]\nfov = 39.3077\n");
    t
}

/// The haze that fills the box: extinction in 1/mm, cells along an edge.
pub(super) fn haze(extinction: f64, albedo: &str, cells: usize) -> String {
    format!(
        "[medium]\nmin = [-2, -1.6, -0.4]\nmax = [558, 550.4, 559.6]\ncells = [{cells}, {cells}, {cells}]\nextinction = {extinction}\nalbedo = {albedo}\n"
    )
}
