//! `zonal view-factors`: meshes and input files of View3D, formats, caches, refusals.

use crate::support::{By, Folder, refused, text};

/// A unit cube as View3D describes it, fronts inwards.
const CUBE: &str = "T A simple cube
C encl=1 out=0
F 3
!  #   x    y    z
V  1   0.   0.   0.
V  2   1.   0.   0.
V  3   1.   1.   0.
V  4   0.   1.   0.
V  5   0.   0.   1.
V  6   1.   0.   1.
V  7   1.   1.   1.
V  8   0.   1.   1.
!  #   v1  v2  v3  v4 base cmb  emit  name
S  1    1   2   3   4   0   0   0.50  zeq0
S  2    1   4   8   5   0   0   0.50  xeq0
S  3    1   5   6   2   0   0   0.50  yeq0
S  4    7   6   5   8   0   0   0.50  zeq1
S  5    7   3   2   6   0   0   0.50  xeq1
S  6    7   8   4   3   0   0   0.50  yeq1
End of data
";

/// A street between two blocks on a plate, as an OBJ of quadrilaterals and triangles.
const STREET: &str = "v 0 0 0\nv 10 0 0\nv 10 20 0\nv 0 20 0\nv 0 0 8\nv 0 20 8\nv 10 0 8\nv 10 20 8
o street\nf 1 2 3 4\no west\nf 1 4 6 5\no east\nf 2 7 8\nf 2 8 3\n";

fn numbers(text: &str) -> Vec<Vec<f64>> {
    let row = |l: &str| l.split_whitespace().map(|x| x.parse().expect("a number")).collect();
    text.lines().map(row).collect()
}

#[test]
fn a_cube_of_view3d_has_the_factors_of_the_catalogue() {
    let f = Folder::new();
    f.put("cube.vs3", CUBE);
    f.done(&["view-factors", "cube.vs3", "-o", "cube.txt", "--tolerance", "1e-7"]);
    let table = text(&f.get("cube.txt"));
    let (head, body) = table.split_once('\n').expect("a header");
    assert!(
        head.starts_with("View3D ") && head.split_whitespace().skip(2).eq(["0", "1", "0", "6"]),
        "{head}"
    );
    let rows = numbers(body);
    assert_eq!((rows.len(), rows[0].as_slice()), (8, [1.0; 6].as_slice()));
    // Opposite and perpendicular squares: Howell's catalogue, C-11 and C-14.
    for (i, row) in rows[1..7].iter().enumerate() {
        for (j, x) in row.iter().enumerate() {
            let exact = match (i + 3) % 6 {
                _ if i == j => 0.0,
                opposite if opposite == j => 0.199_825,
                _ => 0.200_044,
            };
            assert!((x - exact).abs() < 2e-6, "{i} {j}: {x}");
        }
    }
}

#[test]
fn emittances_give_total_exchange_factors() {
    let f = Folder::new();
    f.put("cube.vs3", CUBE.replace("encl=1", "encl=1 emit=1"));
    f.done(&["view-factors", "cube.vs3", "-o", "cube.csv", "--tolerance", "1e-6"]);
    let table = text(&f.get("cube.csv"));
    let from_first = table.lines().filter(|l| l.starts_with("0,"));
    let sum: f64 =
        from_first.map(|l| l.split(',').nth(4).expect("a factor").parse::<f64>().expect("a number")).sum();
    assert!((sum - 0.5).abs() < 1e-6, "{sum}");
}

#[test]
fn combined_surfaces_and_null_surfaces_change_the_rows() {
    let f = Folder::new();
    // The lid in two halves that are combined, and a hole in the floor.
    let vertices =
        "V 9 .5 0 1\nV 10 .5 1 1\nV 11 .25 .25 0\nV 12 .75 .25 0\nV 13 .75 .75 0\nV 14 .25 .75 0\n!  #   v1";
    let parted = CUBE
        .replace("!  #   v1", vertices)
        .replace("S  4    7   6   5   8   0   0   0.50  zeq1", "S  4    7   6   9  10   0   0   0.50  zeq1")
        .replace("End of data", "S 7 10 9 5 8 0 4 .5 half\nN 8 14 13 12 11 1 0 .5 hole\nEnd of data");
    f.put("parted.vs3", parted);
    let report = f.done(&["view-factors", "parted.vs3", "-o", "parted.csv", "--tolerance", "1e-6", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(json["facets"], 6);
    let table = text(&f.get("parted.csv"));
    let floor_to_lid = table.lines().find(|l| l.starts_with("0,3,")).expect("a factor");
    let factor: f64 = floor_to_lid.split(',').nth(4).expect("a factor").parse().expect("a number");
    // The middle of the floor, which sees most of the lid, is gone.
    assert!(factor < 0.1990, "{factor}");
}

#[test]
fn meshes_have_rows_in_their_order_with_sky_and_ground() {
    let f = Folder::new();
    f.put("street.obj", STREET);
    let report = f.done(&["view-factors", "street.obj", "-o", "street.csv", "--sky", "sky.txt", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!((json["facets"].as_u64(), json["open_rows"].as_array().map(Vec::len)), (Some(4), Some(0)));
    assert!(json["largest_defect"].as_f64().expect("a number") < 1e-9);
    assert!(json["largest_defect_before_closing"].as_f64().expect("a number") < 1e-3);
    let table = text(&f.get("street.csv"));
    for row in 0..4 {
        let own = table.lines().filter(|l| l.starts_with(&format!("{row},")));
        let sum: f64 =
            own.map(|l| l.split(',').nth(4).expect("a factor").parse::<f64>().expect("a number")).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{row}: {sum}");
    }
    let sky = text(&f.get("sky.txt"));
    assert_eq!(sky.lines().count(), 5);
    assert!(sky.starts_with("# sky view factors\n0."));
}

#[test]
fn both_sides_close_the_rows_of_thin_plates() {
    let f = Folder::new();
    // A plate whose back a floor sees.
    f.put("plates.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl floor\nf 1 2 3 4\nusemtl roof\nf 5 6 7 8\n");
    let open = f.done(&["view-factors", "plates.obj", "-o", "one.csv", "--json"]);
    let open: serde_json::Value = serde_json::from_str(&open).expect("JSON");
    assert_eq!(open["open_rows"].as_array().map(Vec::len), Some(1));
    assert!(open["warnings"].to_string().contains("--sides both"), "{open}");
    let closed = f.done(&["view-factors", "plates.obj", "-o", "two.csv", "--sides", "both", "--json"]);
    let closed: serde_json::Value = serde_json::from_str(&closed).expect("JSON");
    assert_eq!((closed["facets"].as_u64(), closed["open_rows"].as_array().map(Vec::len)), (Some(4), Some(0)));
    let table = text(&f.get("two.csv"));
    let row = table.lines().find(|l| l.starts_with("0,3,")).expect("the floor sees the back of the roof");
    let factor: f64 = row.split(',').nth(4).expect("a factor").parse().expect("a number");
    assert!((factor - 0.199_825).abs() < 1e-3 && row.contains("roof (back)"), "{row}");
}

#[test]
fn caches_resume_and_formats_and_threads_agree() {
    let f = Folder::new();
    f.put("street.obj", STREET);
    f.put("screen.obj", "v 2 5 3\nv 8 5 3\nv 8 15 3\nf 1 2 3\n");
    let run = |output: &str, more: &[&str]| {
        f.done(
            &[&["view-factors", "street.obj", "--obstructions", "screen.obj", "-o", output], more].concat(),
        );
        f.get(output)
    };
    let first = run("a.npz", &["--threads", "1"]);
    assert_eq!(first, run("b.npz", &["--threads", "2", "--cache", "cache"]));
    assert_eq!(first, run("c.npz", &["--cache", "cache"]));
    // Other settings begin anew in the same folder.
    assert_ne!(first, run("d.npz", &["--cache", "cache", "--tolerance", "1e-5"]));
    let sparse = numbers(&String::from_utf8(run("e.txt", &["--format", "sparse"])).expect("text"));
    let dense = String::from_utf8(run("f.txt", &[])).expect("text");
    let dense = numbers(dense.split_once('\n').expect("a header").1);
    for entry in &sparse {
        let value = dense[entry[0] as usize][entry[1] as usize - 1];
        assert!((value - entry[2]).abs() <= 5.1e-7, "{entry:?} {value}");
    }
    assert_eq!(sparse.len(), dense[1..5].iter().flatten().filter(|x| **x > 0.0).count());
    assert_eq!(run("g.bin", &[]).len(), 32 + 4 * (4 + 16 + 4));
    assert!(run("h.mtx", &[]).starts_with(b"%%MatrixMarket"));
}

#[test]
fn wrong_input_is_refused_in_one_line() {
    let f = Folder::new();
    f.put("street.obj", STREET);
    f.put("mask.vs3", CUBE.replace("End of data", "M 7 4 3 2 1 1 0 .5 cover\nEnd of data"));
    f.put("none.vs3", "F 3\nV 1 0 0 0\nEnd of data\n");
    for (arguments, word) in [
        (&["street.obj", "-o", "a.png"] as &[&str], ".npz"),
        (&["street.obj", "-o", "a.npz", "--tolerance", "2"], "--tolerance"),
        (&["street.obj", "-o", "a.npz", "--period-x=-1"], "period"),
        (&["street.obj", "-o", "a.npz", "--period-x", "10", "--up", "y"], "--up"),
        (&["street.obj", "-o", "a.npz", "--format", "sparse"], "--format"),
        (&["street.obj", "-o", "a.npz", "--max-memory", "1e-9"], "memory"),
        (&["missing.stl", "-o", "a.npz"], "missing.stl"),
        (&["mask.vs3", "-o", "a.npz"], "null surface"),
        (&["none.vs3", "-o", "a.npz"], "none.vs3"),
    ] {
        refused(&f, By::Program, &[&["view-factors"], arguments].concat(), word);
    }
}
