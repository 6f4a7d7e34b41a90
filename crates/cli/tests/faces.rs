//! Data and results by face of a mesh, through the command.

use crate::support;

use support::{Folder, Program, refused, text};

/// Cells along an edge of the box: six walls of 10 × 10 faces.
const CELLS: usize = 10;
const FACES: usize = 6 * CELLS * CELLS;

/// The walls of a unit box as quads with inward normals. Faces of all walls alternate.
fn box_mesh() -> String {
    let (mut points, mut faces) = (String::new(), String::new());
    for k in 0..FACES {
        let (wall, cell) = (k % 6, k / 6);
        let (axis, end) = (wall / 2, wall % 2);
        let mut corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
        if end == 1 {
            corners.reverse();
        }
        for (a, b) in corners {
            let mut p = [end as f64; 3];
            p[(axis + 1) % 3] = (cell / CELLS + a) as f64 / CELLS as f64;
            p[(axis + 2) % 3] = (cell % CELLS + b) as f64 / CELLS as f64;
            points += &format!("v {} {} {}\n", p[0], p[1], p[2]);
        }
        let first = 4 * k + 1;
        faces += &format!("f {first} {} {} {}\n", first + 1, first + 2, first + 3);
    }
    points + &faces
}

fn temperature(face: usize) -> f64 {
    300.0 + ((face * 7919) % 601) as f64
}

const SCENE: &str = "mode = 'thermal'
[solve]
patch_size = 1
discretization_error = false
[[surface]]
name = 'box'
mesh = { file = 'box.obj' }
temperature = { file = 't.csv', column = 'T' }
emissivity = 0.7
";

fn folder() -> Folder {
    let f = Folder::new();
    f.put("box.obj", box_mesh());
    let rows: String = (0..FACES).map(|k| format!("{k},{}\n", temperature(k))).collect();
    f.put("t.csv", format!("face,T\n{rows}"));
    f.put("box.toml", SCENE);
    f
}

/// Rows of numbers of a CSV, by the names of the columns.
fn column(table: &str, name: &str) -> Vec<f64> {
    let at =
        table.lines().next().unwrap().split(',').position(|c| c == name).unwrap_or_else(|| panic!("{name}"));
    table.lines().skip(1).map(|l| l.split(',').nth(at).unwrap().parse().unwrap_or(f64::NAN)).collect()
}

// Guards (files): values and results by face keep the order of the mesh file.
#[test]
fn six_hundred_faces_keep_their_temperatures_and_their_order() {
    let f = folder();
    f.done(&["solve", "box.toml", "-o", "run.npz"]);
    for ending in ["csv", "npy", "vtu"] {
        f.done(&["export", "run.npz", "--faces", "-o", &format!("q.{ending}")]);
    }
    let table = text(&f.get("q.csv"));
    let kelvin = column(&table, "temperature_K");
    assert_eq!(kelvin.len(), FACES);
    assert!((0..FACES).all(|k| (kelvin[k] - temperature(k)).abs() < 1e-9));
    // Each face gives ε (σT⁴ − H); the net powers of a closed box sum to zero.
    let [q, h, area] = ["net_flux_W_m2", "incident_flux_W_m2", "area_m2"].map(|c| column(&table, c));
    for k in 0..FACES {
        let wanted = 0.7 * (5.670374419184429e-8 * temperature(k).powi(4) - h[k]);
        assert!((q[k] - wanted).abs() < 1e-6, "{k}: {} {wanted}", q[k]);
    }
    let sum: f64 = q.iter().zip(&area).map(|(q, a)| q * a).sum();
    assert!(
        sum.abs() < 1e-6 && column(&table, "net_flux_error_W_m2").iter().all(|e| *e >= 0.0 && *e < 1e-3),
        "{sum}"
    );
    let bytes = f.get("q.npy");
    assert_eq!(bytes.len(), 128 + 8 * FACES * 12);
    // The results are values of another scene.
    f.put("again.toml", SCENE.replace("t.csv', column = 'T'", "q.vtu'"));
    f.done(&["solve", "again.toml", "-o", "again.npz"]);
    f.done(&["export", "again.npz", "--faces", "-o", "again.csv"]);
    let again = column(&text(&f.get("again.csv")), "net_flux_W_m2");
    assert!((0..FACES).all(|k| (again[k] - q[k]).abs() < 1e-6));
    // The report has one surface.
    let report = f.done(&["solve", "box.toml", "-o", "run.npz"]);
    assert_eq!(report.lines().filter(|l| l.trim_start().starts_with("box ")).count(), 1, "{report}");
}

#[test]
fn scenes_without_meshes_have_no_faces_to_export() {
    let f = Folder::new();
    f.put("room.npz", support::solution());
    refused(&f, Program, &["export", "room.npz", "--faces", "-o", "q.csv"], "this solution has no faces");
    refused(&f, Program, &["export", "room.npz", "--faces", "-o", "q.glb"], ".csv or .npy or .vtu");
}
