//! Mitsuba's Cornell boxes; lengths in millimetres as in the meshes.

use std::fmt::Write as _;
use std::path::Path;

const WHITE_REFLECTANCE: &str = "[0.885809, 0.698859, 0.666422]";
const RED_REFLECTANCE: &str = "[0.570068, 0.0430135, 0.0443706]";
const GREEN_REFLECTANCE: &str = "[0.105421, 0.37798, 0.076425]";
/// Radiance of the lamp, W/(m² sr).
const LAMP_RADIANCE: [f64; 3] = [18.387, 13.9873, 6.75357];

/// Medium in the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BoxMedium {
    Vacuum,
    /// Extinction in 1/mm and albedo.
    Haze(f64, &'static str),
    /// The smoke of `data/smoke-vdb`, in an empty box.
    Smoke,
}

/// The boxes of which Mitsuba's pictures lie in `data/mitsuba-refs`, by the names of the files.
pub(crate) const CORNELL_BOXES: [(&str, BoxMedium); 4] = [
    ("cbox_vacuum", BoxMedium::Vacuum),
    ("cbox_homog_st0.002_a08", BoxMedium::Haze(0.002, "0.8")),
    ("cbox_homog_st0.001_argb", BoxMedium::Haze(0.001, "[0.95, 0.6, 0.3]")),
    ("cbox_smoke", BoxMedium::Smoke),
];

/// The upper rows of Mitsuba's `cbox_smoke` that are not compared. A band under the ceiling is dark in it, 0.03 beside 0.11, where
/// the way to the lamp cuts an upper edge of the medium's box; the smoke has no density there, so nothing can cast that shadow, and
/// walks that ask every facet see none either.
pub(crate) const SMOKE_ROWS: usize = 40;

/// The walls, the two boxes unless the medium is smoke, the lamp and the camera, with `[solve]` as given. The lines `walls` follow each wall.
pub(crate) fn room(name: &str, data: &Path, medium: BoxMedium, settings: &str, walls: &str) -> String {
    let mut t = format!("name = \"{name}\"\n[solve]\n{settings}\n");
    let boxes = ["smallbox", "largebox"].into_iter().filter(|_| medium != BoxMedium::Smoke);
    for name in
        ["back", "ceiling", "floor", "greenwall", "redwall"].into_iter().chain(boxes).chain(["luminaire"])
    {
        let file = data.join(format!("cornell/mitsuba-cbox/meshes/cbox_{name}.obj")).display().to_string();
        let (place, more) = match name {
            "luminaire" => {
                let emission = LAMP_RADIANCE.map(|l| l * std::f64::consts::PI);
                (", translate = [0, -0.5, 0]", format!("sides = \"front\"\nemission = {emission:?}"))
            }
            _ => ("", walls.to_string()),
        };
        let reflectance = match name {
            "greenwall" => GREEN_REFLECTANCE,
            "redwall" => RED_REFLECTANCE,
            _ => WHITE_REFLECTANCE,
        };
        let _ = writeln!(
            t,
            "[[surface]]\nname = \"{name}\"\nmesh = {{ file = {file:?}{place} }}\nreflectance = {reflectance}\n{more}"
        );
    }
    t + "[[camera]]\nname = \"front\"\norigin = [278, 273, -800]\ntarget = [278, 273, -799]\nup = [0, 1, 0]\nfov = 39.3077\n"
}

/// Walls of one side, and the lamp as a light of its own.
pub(crate) const FRONT_WALLS: &str = "sides = \"front\"";
/// The light of the lamp.
pub(crate) const LAMP: &str = "[[light]]\nkind = \"emitter\"\nsurface = \"luminaire\"\n";

/// The medium of a box; haze has this number of cells along an edge, smoke as many cells as given.
pub(crate) fn medium(medium: BoxMedium, data: &Path, haze_cells: usize, smoke_cells: [usize; 3]) -> String {
    match medium {
        BoxMedium::Vacuum => String::new(),
        BoxMedium::Haze(extinction, albedo) => format!(
            "[medium]\nmin = [-2, -1.6, -0.4]\nmax = [558, 550.4, 559.6]\ncells = {:?}\nextinction = {extinction}\nalbedo = {albedo}\n",
            [haze_cells; 3]
        ),
        BoxMedium::Smoke => format!(
            "[medium]\nmin = [141, 5, 145]\nmax = [411, 535, 415]\ncells = {smoke_cells:?}\n[[medium.region]]\n\
             density = {{ file = {:?}, min = [141, 5, 145], max = [411, 535, 415], scale = 0.01 }}\nalbedo = 0.9\n",
            data.join("smoke-vdb/smoke_28x56x29.vol").display().to_string()
        ),
    }
}

/// The cells of the file of the smoke, of which Mitsuba takes the nearest.
pub(crate) const SMOKE_FILE_CELLS: [usize; 3] = [28, 56, 29];
