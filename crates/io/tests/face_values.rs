//! Values by face and by material of a mesh, from CSV, npy and VTK files.

use crate::support;

use support::{Folder, NpyOrder, npy};
use zonal_scene::{Bands, Scene, ThermalCondition};

/// A closed box of four quads and four triangles, with materials, in an order that mixes them.
const OBJ: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
usemtl side\nf 1 2 6 5
usemtl floor\nf 1 3 2\nf 1 4 3
usemtl side\nf 2 3 7 6\nf 3 4 8 7
usemtl lid\nf 5 6 7\nf 5 7 8
usemtl side\nf 4 1 5 8
";

fn scene_text(keys: &str) -> String {
    format!("mode = \"thermal\"\n[[surface]]\nname = \"body\"\nmesh = {{ file = \"body.obj\" }}\n{keys}\n")
}

fn folder() -> Folder {
    Folder::new().with("body.obj", OBJ)
}

/// Temperature of each face of the mesh.
fn temperatures(scene: &Scene) -> Vec<f64> {
    let mut out = vec![0.0; scene.faces().len()];
    for k in 0..scene.facets().len() {
        let Some(ThermalCondition::Temperature(t)) = scene.facet_condition(k) else { panic!("facet {k}") };
        out[scene.faces().face_of(k).unwrap()] = t;
    }
    out
}

const WANTED: [f64; 8] = [301.0, 302.0, 303.0, 304.0, 305.0, 306.0, 307.0, 308.0];

#[test]
fn faces_have_the_rows_of_the_file_in_its_order() {
    let csv: String = WANTED.iter().enumerate().map(|(k, t)| format!("{k},{t}\n")).collect();
    let bytes: Vec<u8> = WANTED.iter().flat_map(|t| t.to_le_bytes()).collect();
    let vtu = format!(
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"0\" NumberOfPolys=\"8\"><CellData><DataArray type=\"Float64\" Name=\"temperature [K]\" format=\"ascii\">{}</DataArray></CellData></Piece></PolyData></VTKFile>",
        WANTED.map(|t| t.to_string()).join(" ")
    );
    let f = folder()
        .with("t.csv", format!("face,T\n{csv}"))
        .with("t.npy", npy("<f8", NpyOrder::C, "(8,)", &bytes))
        .with("t.vtp", vtu);
    for value in [
        "{ file = 't.csv', column = 'T' }",
        "{ file = 't.csv', column = 2 }",
        "{ file = 't.npy' }",
        "{ file = 't.vtp' }",
    ] {
        let scene = f.scene(&scene_text(&format!("temperature = {value}\nemissivity = 0.9")));
        assert_eq!(temperatures(&scene), WANTED, "{value}");
        let names: Vec<&str> = scene.surfaces().iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["body/side", "body/floor", "body/lid"]);
        assert_eq!((scene.faces().meshes[0].name.as_str(), scene.faces().len()), ("body", 8));
    }
}

#[test]
fn materials_have_values_by_name_and_their_own_values_precede() {
    let f = folder()
        .with("m.csv", "material,T\nlid,500\nside,300\nfloor,400\n")
        .with("e.csv", "emissivity\n0.1\n0.2\n0.3\n0.4\n0.5\n0.6\n0.7\n0.8\n");
    let keys = "temperature = { file = 'm.csv', by = 'material' }\nemissivity = { file = 'e.csv' }\nmaterials.lid = { emissivity = 1 }";
    let scene = f.scene(&scene_text(keys));
    assert_eq!(temperatures(&scene), [300.0, 400.0, 400.0, 300.0, 300.0, 500.0, 500.0, 300.0]);
    let mut emissivities = vec![0.0; 8];
    for k in 0..scene.facets().len() {
        emissivities[scene.faces().face_of(k).unwrap()] = 1.0 - scene.facet_reflectance(k).first();
    }
    for (found, wanted) in emissivities.iter().zip([0.1, 0.2, 0.3, 0.4, 0.5, 1.0, 1.0, 0.8]) {
        assert!((found - wanted).abs() < 1e-15, "{emissivities:?}");
    }
    let light = f.with("q.csv", "1\n2\n3\n4\n5\n6\n7\n8\n");
    let scene = light.scene("[[surface]]\nmesh = { file = 'body.obj' }\nemission = { file = 'q.csv' }");
    let of_face = |face| (0..8).find(|k| scene.faces().face_of(*k) == Some(face)).unwrap();
    assert_eq!(scene.emission_at(of_face(6), 0.3, 0.3), Bands::splat(7.0));
}

#[test]
fn triangulated_polygons_keep_one_face() {
    let pentagon =
        "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nv 0 0 0\nf 1 2 3 4 5\nf 1 1 2\nf 2 1 5 4 3\n";
    let f = Folder::new().with("body.obj", pentagon).with("t.csv", "300\n400\n500\n");
    let scene = f.scene(&scene_text("temperature = { file = 't.csv' }\nemissivity = 1"));
    // The face without area has a row and no facet.
    assert_eq!((temperatures(&scene), scene.facets().len()), (vec![300.0, 0.0, 500.0], 6));
}

#[test]
fn vtk_surfaces_are_meshes_with_data_of_their_own() {
    let file = |kind: &str, cells: &str| {
        format!(
            "<VTKFile type=\"{kind}\"><{kind}><Piece NumberOfPoints=\"5\" {cells}<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 0 0 0 1</DataArray></Points><CellData><DataArray type=\"Float64\" Name=\"T\" format=\"ascii\">300 400</DataArray></CellData></Piece></{kind}></VTKFile>"
        )
    };
    let list = |name: &str, values: &str| {
        format!("<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>")
    };
    let (corners, ends) = (list("connectivity", "0 1 2 3 0 1 4"), list("offsets", "4 7"));
    let types = |values: &str| list("types", values);
    let f = Folder::new()
        .with(
            "a.vtu",
            file(
                "UnstructuredGrid",
                &format!("NumberOfCells=\"2\"><Cells>{corners}{ends}{}</Cells>", types("9 5")),
            ),
        )
        .with("b.vtp", file("PolyData", &format!("NumberOfPolys=\"2\"><Polys>{corners}{ends}</Polys>")))
        .with(
            "c.vtu",
            file(
                "UnstructuredGrid",
                &format!("NumberOfCells=\"2\"><Cells>{corners}{ends}{}</Cells>", types("10 5")),
            ),
        )
        .with(
            "d.vtp",
            file(
                "PolyData",
                &format!("NumberOfPolys=\"2\" NumberOfLines=\"1\"><Polys>{corners}{ends}</Polys>"),
            ),
        );
    let text = |name: &str| {
        scene_text(&format!("temperature = {{ file = '{name}' }}\nemissivity = 1")).replace("body.obj", name)
    };
    for name in ["a.vtu", "b.vtp"] {
        let scene = f.scene(&text(name));
        assert_eq!((temperatures(&scene), scene.facets()[0].plate.area()), (vec![300.0, 400.0], 1.0));
    }
    assert!(f.refusal(&text("c.vtu")).contains("cell 0: it has VTK's type 10, which is no face"));
    assert!(f.refusal(&text("d.vtp")).contains("1 cells are points, lines or strips"));
}

#[test]
fn wrong_files_name_numbers_line_and_remedy() {
    let f = folder()
        .with("short.csv", "T\n300\n400\n")
        .with("nan.csv", "T\n300\nNaN\n1\n1\n1\n1\n1\n1\n")
        .with("cold.csv", "T\n1\n1\n1\n-4\n1\n1\n1\n1\n")
        .with("two.csv", "a,b\n1,2\n1,2\n")
        .with("names.csv", "lid,300\nside,300\n")
        .with("other.csv", "lid,300\nsides,300\n");
    for (value, wanted) in [
        (
            "{ file = 'short.csv' }",
            "short.csv:3: the file has 2 rows of values, and there are 8 faces in the mesh; give one row",
        ),
        ("{ file = 'nan.csv' }", "nan.csv:3: the value is not a number (NaN); give a number"),
        ("{ file = 'cold.csv' }", "cold.csv:5: -4 K is out of range; give kelvin above 0"),
        ("{ file = 'two.csv', column = 'c' }", "two.csv:1: there is no column 'c'; "),
        ("{ file = 'two.csv' }", "two.csv:1: the file has several columns (a, b); write column"),
        ("{ file = 'none.csv' }", "none.csv: there is no such file"),
        ("{ file = 't.xls' }", "t.xls: this kind of table is not read"),
        ("{ file = 'names.csv', by = 'material' }", "names.csv:2: material 'floor' has no row; add one"),
        (
            "{ file = 'other.csv', by = 'material' }",
            "other.csv:2: the mesh has no material 'sides'; did you mean 'side'?",
        ),
        ("{ file = 'short.csv', colum = 'T' }", "unknown key; did you mean 'column'?"),
    ] {
        let e = f.refusal(&scene_text(&format!("temperature = {value}\nemissivity = 0.9")));
        assert!(e.starts_with("test.toml:5:") && e.contains(wanted), "{e}");
    }
    let room = "mode = 'thermal'\n[[surface]]\nroom = { min = [0, 0, 0], max = [1, 1, 1] }\nemissivity = 1\ntemperature = { file = 'short.csv' }";
    assert!(f.refusal(room).contains("belongs to the table of a [[surface]] that has a mesh"));
    let two = "temperature = { file = 'short.csv' }\nheat_flux = 0\nemissivity = 0.9";
    assert!(f.refusal(&scene_text(two)).contains("more than one of temperature, heat_flux"));
    let zero = folder().with("e.csv", "1\n0\n1\n1\n1\n1\n1\n1\n");
    let e = zero.refusal(&scene_text("heat_flux = 5\nemissivity = { file = 'e.csv' }"));
    assert!(e.contains("a surface of emissivity 0 can give no power"), "{e}");
}
