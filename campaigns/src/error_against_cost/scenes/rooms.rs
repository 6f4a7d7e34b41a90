//! Rooms with furniture: boxes and meshes that stand on the floor and lean against walls.

use super::SceneFolder;
use super::mesh::{BodySide, MeshText, SeededNumbers};
use crate::harness::Error;
use std::fmt::Write as _;

fn rectangle(name: &str, [origin, edge1, edge2]: [[f64; 3]; 3], reflectance: &str) -> String {
    format!(
        "[[surface]]\nname = \"{name}\"\nrectangle = {{ origin = {origin:?}, edge1 = {edge1:?}, edge2 = {edge2:?} }}\nreflectance = {reflectance}\n"
    )
}

fn cuboid(name: &str, lo: [f64; 3], hi: [f64; 3], reflectance: &str) -> String {
    format!(
        "[[surface]]\nname = \"{name}\"\nbox = {{ min = {lo:?}, max = {hi:?} }}\nreflectance = {reflectance}\n"
    )
}

/// A lamp that shines downwards, its light direct.
pub(super) fn lamp(origin: [f64; 3], edge: f64, emission: &str) -> String {
    rectangle("lamp", [origin, [0.0, edge, 0.0], [edge, 0.0, 0.0]], "0.5")
        + &format!(
            "emission = {emission}\n[[light]]\nkind = \"emitter\"\nname = \"lamp\"\nsurface = \"lamp\"\n"
        )
}

/// A wall at x with an opening between two y and two z, as four rectangles that face the smaller x.
pub(super) fn wall_with_opening(
    x: f64,
    [width, height]: [f64; 2],
    [y, z]: [[f64; 2]; 2],
    reflectance: &str,
) -> String {
    let part = |name: &str, [y0, y1]: [f64; 2], [z0, z1]: [f64; 2]| {
        rectangle(name, [[x, y0, z0], [0.0, 0.0, z1 - z0], [0.0, y1 - y0, 0.0]], reflectance)
    };
    part("below the window", [0.0, width], [0.0, z[0]])
        + &part("above the window", [0.0, width], [z[1], height])
        + &part("beside the window 1", [0.0, y[0]], z)
        + &part("beside the window 2", [y[1], width], z)
}

/// A table of boxes: its plate 0.05 m thick, legs at the corners.
fn table_top_and_legs(out: &mut String, lo: [f64; 2], hi: [f64; 2], height: f64) {
    let wood = "[0.42, 0.28, 0.16]";
    *out += &cuboid("table top", [lo[0], lo[1], height - 0.05], [hi[0], hi[1], height], wood);
    for (k, [x, y]) in
        [lo, [hi[0] - 0.06, lo[1]], [lo[0], hi[1] - 0.06], [hi[0] - 0.06, hi[1] - 0.06]].iter().enumerate()
    {
        *out += &cuboid(&format!("table leg {k}"), [*x, *y, 0.0], [x + 0.06, y + 0.06, height - 0.05], wood);
    }
}

/// A chair of boxes as a mesh, turned about its centre.
fn chair(mesh: &mut MeshText, [x, y]: [f64; 2], back: f64) {
    mesh.cuboid([x - 0.22, y - 0.22, 0.42], [x + 0.22, y + 0.22, 0.46], 0.0);
    for [dx, dy] in [[-0.2, -0.2], [0.2, -0.2], [-0.2, 0.2], [0.2, 0.2]] {
        mesh.cuboid([x + dx - 0.02, y + dy - 0.02, 0.0], [x + dx + 0.02, y + dy + 0.02, 0.42], 0.0);
    }
    let at = y + 0.2 * back;
    mesh.cuboid([x - 0.22, at - 0.02, 0.46], [x + 0.22, at + 0.02, 0.95], 0.0);
}

/// A shelf against the wall x = 0: two sides, five boards, books.
fn shelf(mesh: &mut MeshText, books: &mut MeshText) {
    let (y, depth) = ([0.4, 2.0], 0.32);
    mesh.cuboid([0.0, y[0] - 0.03, 0.0], [depth, y[0], 2.0], 0.0).cuboid(
        [0.0, y[1], 0.0],
        [depth, y[1] + 0.03, 2.0],
        0.0,
    );
    let mut numbers = SeededNumbers(7);
    for k in 0..5 {
        let z = 0.06 + 0.45 * f64::from(k);
        mesh.cuboid([0.0, y[0], z], [depth, y[1], z + 0.025], 0.0);
        let mut from = y[0] + numbers.between(0.02, 0.3);
        for _ in 0..5 {
            let width = numbers.between(0.03, 0.09);
            if from + width < y[1] {
                let top = z + 0.025 + numbers.between(0.2, 0.34);
                books.cuboid([0.04, from, z + 0.025], [numbers.between(0.2, 0.28), from + width, top], 0.0);
            }
            from += width + if numbers.uniform() < 0.3 { 0.1 } else { 0.004 };
        }
    }
}

/// A room of 5 m × 4 m with a window to the sky, a lamp, a table, four chairs, a shelf with books, and a vase.
pub(super) fn furnished(folder: &SceneFolder) -> Result<String, Error> {
    let mut t = String::from(
        "name = \"furnished-room\"\n[solve]\ntolerance = 0.05\npatch_size = 0.32\n\
         [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [5, 4, 2.7] }\nreflectance = [0.75, 0.73, 0.68]\nomit = [\"x1\"]\n\
         faces.z0 = { reflectance = [0.45, 0.33, 0.22] }\n",
    );
    let plaster = "[0.75, 0.73, 0.68]";
    t += &wall_with_opening(5.0, [4.0, 2.7], [[1.0, 3.0], [0.9, 2.2]], plaster);
    table_top_and_legs(&mut t, [1.9, 1.4], [3.5, 2.3], 0.75);
    let mut chairs = MeshText::default();
    for (at, back) in [([2.3, 1.2], -1.0), ([3.1, 1.2], -1.0), ([2.3, 2.5], 1.0), ([3.1, 2.6], 1.0)] {
        chair(&mut chairs, at, back);
    }
    let (mut boards, mut books, mut vase) = (MeshText::default(), MeshText::default(), MeshText::default());
    shelf(&mut boards, &mut books);
    let profile =
        [[0.0, 0.75], [0.05, 0.75], [0.09, 0.84], [0.08, 0.92], [0.035, 0.99], [0.05, 1.05], [0.0, 1.05]];
    vase.revolution([2.7, 1.85], &profile, 16, BodySide::Outside);
    for (name, mesh, reflectance) in [
        ("chairs", chairs, "[0.5, 0.35, 0.2]"),
        ("shelf", boards, "[0.6, 0.5, 0.38]"),
        ("books", books, "[0.45, 0.25, 0.2]"),
        ("vase", vase, "[0.2, 0.35, 0.6]"),
    ] {
        t += &folder.mesh_surface("furnished-room", name, &mesh)?;
        let _ = writeln!(t, "reflectance = {reflectance}");
    }
    t += &lamp([2.5, 1.7, 2.55], 0.35, "[700, 560, 400]");
    t += "[[light]]\nkind = \"sky\"\nname = \"sky\"\nradiance = [40, 50, 65]\n\
          [[camera]]\nname = \"door\"\norigin = [0.4, 3.7, 1.6]\ntarget = [3.4, 1.4, 0.9]\nfov = 75\n";
    Ok(t)
}

/// A room with a glass table: two panes on a frame of cylinders, with bowls on and below the glass.
pub(super) fn glass_table(folder: &SceneFolder) -> Result<String, Error> {
    let mut t = String::from(
        "name = \"glass-table\"\n[solve]\ntolerance = 0.05\npatch_size = 0.35\n\
         [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [4, 4, 2.6] }\nreflectance = [0.7, 0.7, 0.66]\n\
         faces.z0 = { reflectance = [0.4, 0.3, 0.25] }\n",
    );
    let mut frame = MeshText::default();
    for [x, y] in [[1.3, 1.5], [2.7, 1.5], [1.3, 2.5], [2.7, 2.5]] {
        frame.cylinder([x, y], 0.035, [0.0, 0.7], 10);
    }
    frame.cuboid([1.3, 1.47, 0.66], [2.7, 1.53, 0.7], 0.0).cuboid([1.3, 2.47, 0.66], [2.7, 2.53, 0.7], 0.0);
    let mut bowls = MeshText::default();
    let bowl = |z: f64| {
        [
            [0.0, z],
            [0.08, z],
            [0.17, z + 0.07],
            [0.2, z + 0.13],
            [0.18, z + 0.13],
            [0.15, z + 0.08],
            [0.0, z + 0.03],
        ]
    };
    bowls.revolution([1.7, 2.0], &bowl(0.72), 16, BodySide::Outside);
    bowls.revolution([2.4, 1.9], &bowl(0.35), 16, BodySide::Outside);
    for (name, mesh, reflectance) in
        [("frame", frame, "[0.55, 0.55, 0.58]"), ("bowls", bowls, "[0.7, 0.35, 0.2]")]
    {
        t += &folder.mesh_surface("glass-table", name, &mesh)?;
        let _ = writeln!(t, "reflectance = {reflectance}");
    }
    for (name, z, inset) in [("glass top", 0.71, 0.0), ("glass shelf", 0.34, 0.15)] {
        let (x, y) = ([1.2 + inset, 2.8 - inset], [1.4 + inset, 2.6 - inset]);
        let _ = write!(
            t,
            "[[pane]]\nname = \"{name}\"\npolygon = [[{}, {}, {z}], [{}, {}, {z}], [{}, {}, {z}], [{}, {}, {z}]]\n\
             thickness = 0.012\nextinction = [20, 6, 12]\nalbedo = 0.1\n",
            x[0], y[0], x[1], y[0], x[1], y[1], x[0], y[1]
        );
    }
    t += &lamp([1.8, 1.8, 2.5], 0.4, "[600, 540, 450]");
    t += "[medium]\nmin = [0, 0, 0]\nmax = [4, 4, 2.6]\ncells = [8, 8, 6]\nextinction = 0.04\nalbedo = 0.9\n\
          [[camera]]\nname = \"corner\"\norigin = [0.3, 0.4, 1.6]\ntarget = [2.2, 2.1, 0.5]\nfov = 70\n";
    Ok(t)
}

/// Boxes along each of the four walls, and rows of them in the middle.
const WALL_BOXES: usize = 50;
const FLOOR_BOXES: usize = 200;

/// A room with 600 contacts: 200 small boxes that stand on the floor and touch a wall, and 200 that stand on the floor alone.
pub(super) fn contacts(folder: &SceneFolder) -> Result<String, Error> {
    let edge = 6.0;
    let mut t = format!(
        "name = \"contacts\"\n[solve]\ntolerance = 0.05\npatch_size = 0.3\n\
         [[surface]]\nname = \"room\"\nroom = {{ min = [0, 0, 0], max = [{edge}, {edge}, 2.8] }}\nreflectance = [0.7, 0.68, 0.65]\n"
    );
    let mut numbers = SeededNumbers(600);
    let (mut walls, mut floor) = (MeshText::default(), MeshText::default());
    let pitch = (edge - 0.6) / WALL_BOXES as f64;
    for k in 0..4 * WALL_BOXES {
        let (along, depth, height) =
            (0.3 + pitch * (k % WALL_BOXES) as f64, numbers.between(0.05, 0.12), numbers.between(0.05, 0.2));
        let width = numbers.between(0.4, 0.9) * pitch;
        let (a, b) = (along, along + width);
        let (lo, hi) = match k / WALL_BOXES {
            0 => ([0.0, a], [depth, b]),
            1 => ([edge - depth, a], [edge, b]),
            2 => ([a, 0.0], [b, depth]),
            _ => ([a, edge - depth], [b, edge]),
        };
        walls.cuboid([lo[0], lo[1], 0.0], [hi[0], hi[1], height], 0.0);
    }
    for k in 0..FLOOR_BOXES {
        let cell = [0.75 + 0.3 * (k % 16) as f64, 0.75 + 0.36 * (k / 16) as f64];
        let half = numbers.between(0.03, 0.07);
        let (turn, height) = (numbers.between(0.0, 1.5), numbers.between(0.05, 0.25));
        floor.cuboid([cell[0] - half, cell[1] - half, 0.0], [cell[0] + half, cell[1] + half, height], turn);
    }
    for (name, mesh, reflectance) in
        [("boxes at walls", walls, "[0.5, 0.4, 0.3]"), ("boxes on the floor", floor, "[0.3, 0.45, 0.55]")]
    {
        t += &folder.mesh_surface("contacts", name, &mesh)?;
        let _ = writeln!(t, "reflectance = {reflectance}");
    }
    t += &lamp([2.2, 3.1, 2.7], 0.5, "[600, 560, 500]");
    t += "[[camera]]\nname = \"corner\"\norigin = [0.5, 0.5, 1.7]\ntarget = [4, 4, 0]\nfov = 75\n";
    Ok(t)
}

/// A room lit by the sun through a lattice of bars, 3 cm wide and 20 cm apart, in its window.
pub(super) fn lattice(_: &SceneFolder) -> Result<String, Error> {
    let mut t = String::from(
        "name = \"lattice\"\n[solve]\ntolerance = 0.05\npatch_size = 0.3\n\
         [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [4, 3, 2.7] }\nreflectance = [0.65, 0.63, 0.6]\nomit = [\"x1\"]\n\
         faces.z0 = { reflectance = [0.45, 0.35, 0.28] }\n",
    );
    let (y, z) = ([0.6, 2.4], [0.6, 2.2]);
    t += &wall_with_opening(4.0, [3.0, 2.7], [y, z], "[0.65, 0.63, 0.6]");
    for k in 0..8 {
        let at = y[0] + 0.2 * f64::from(k + 1);
        t += &cuboid(&format!("upright bar {k}"), [3.97, at - 0.015, z[0]], [4.0, at + 0.015, z[1]], "0.3");
    }
    for k in 0..7 {
        let at = z[0] + 0.2 * f64::from(k + 1);
        t += &cuboid(&format!("level bar {k}"), [3.94, y[0], at - 0.015], [3.97, y[1], at + 0.015], "0.3");
    }
    t += "[[light]]\nkind = \"sun\"\nname = \"sun\"\ndirection = [-0.75, 0.2, -0.6]\nirradiance = [900, 840, 740]\n\
          [[light]]\nkind = \"sky\"\nname = \"sky\"\nradiance = [25, 32, 45]\n\
          [[camera]]\nname = \"door\"\norigin = [0.3, 0.4, 1.6]\ntarget = [3.2, 1.6, 0.8]\nfov = 75\n";
    Ok(t)
}

/// A closed room whose walls and three blocks reflect nine tenths of all light, with a lamp.
pub(super) fn white(_: &SceneFolder) -> Result<String, Error> {
    let mut t = String::from(
        "name = \"white-room\"\n[solve]\ntolerance = 0.05\npatch_size = 0.4\n\
         [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [4, 3, 2.6] }\nreflectance = 0.9\n",
    );
    t += &cuboid("cupboard", [0.0, 0.5, 0.0], [0.5, 1.7, 1.9], "0.9");
    t += &cuboid("block", [1.8, 1.1, 0.0], [2.6, 1.9, 0.7], "0.9");
    t += &cuboid("step", [3.2, 2.2, 0.0], [4.0, 3.0, 0.25], "0.9");
    t += &lamp([1.0, 1.4, 2.5], 0.4, "[600, 560, 500]");
    t += "[[camera]]\nname = \"corner\"\norigin = [0.7, 0.3, 1.6]\ntarget = [2.8, 2, 0.6]\nfov = 75\n";
    Ok(t)
}
