//! The text of Mitsuba's Cornell box, for the examples that solve it.

use std::fmt::Write as _;
use std::path::Path;

const WHITE_REFLECTANCE: &str = "[0.885809, 0.698859, 0.666422]";
const RED_REFLECTANCE: &str = "[0.570068, 0.0430135, 0.0443706]";
const GREEN_REFLECTANCE: &str = "[0.105421, 0.37798, 0.076425]";
/// Radiance of the lamp, W/(m² sr).
const LAMP_RADIANCE: [f64; 3] = [18.387, 13.9873, 6.75357];

/// Contents of the Cornell box.
#[allow(dead_code, reason = "shared by examples that use one variant")]
#[derive(Clone, Copy, PartialEq)]
pub(super) enum BoxContents {
    Boxes,
    Empty,
}

/// The walls, the two boxes where wanted, the lamp and the camera, with `[solve]` as given; lengths in millimetres as in the meshes.
pub(super) fn cornell(name: &str, meshes: &Path, contents: BoxContents, solve: &str) -> String {
    let mut t = format!("name = \"{name}\"\n[solve]\n{solve}\n");
    let mut walls = vec![
        ("back", WHITE_REFLECTANCE),
        ("ceiling", WHITE_REFLECTANCE),
        ("floor", WHITE_REFLECTANCE),
        ("greenwall", GREEN_REFLECTANCE),
        ("redwall", RED_REFLECTANCE),
    ];
    if contents == BoxContents::Boxes {
        walls.extend([("smallbox", WHITE_REFLECTANCE), ("largebox", WHITE_REFLECTANCE)]);
    }
    walls.push(("luminaire", WHITE_REFLECTANCE));
    for (name, rho) in walls {
        let file = meshes.join(format!("cbox_{name}.obj")).display().to_string();
        let lamp = name == "luminaire";
        let place = if lamp { ", translate = [0, -0.5, 0]" } else { "" };
        let _ = write!(
            t,
            "[[surface]]\nname = \"{name}\"\nmesh = {{ file = {file:?}{place} }}\nreflectance = {rho}\nsides = \"front\"\n"
        );
        if lamp {
            let e = LAMP_RADIANCE.map(|l| l * std::f64::consts::PI);
            let _ = writeln!(t, "emission = [{}, {}, {}]", e[0], e[1], e[2]);
        }
    }
    t.push_str("[[light]]\nkind = \"emitter\"\nsurface = \"luminaire\"\n");
    t.push_str("[[camera]]\nname = \"front\"\norigin = [278, 273, -800]\ntarget = [278, 273, -799]\nup = [0, 1, 0]\nfov = 39.3077\n");
    t
}

/// The haze that fills the box: extinction in 1/mm, cells along an edge.
#[allow(dead_code, reason = "shared by examples of which some have no haze")]
pub(super) fn haze(extinction: f64, albedo: &str, cells: usize) -> String {
    format!(
        "[medium]\nmin = [-2, -1.6, -0.4]\nmax = [558, 550.4, 559.6]\ncells = [{cells}, {cells}, {cells}]\nextinction = {extinction}\nalbedo = {albedo}\n"
    )
}
