//! Keys that would have no effect where they stand: each is refused with its place and the mend.
//!
//! Guards (files): scene keys without effect are refused.

use crate::support;

use support::{Folder, NpyOrder, f32s, npy, png};
use zonal_scene::Bands;

const LIGHT_MESH: &str = "[[surface]]\nname = 'm'\nmesh = { file = 'a.obj' }\n";
const THERMAL_MESH: &str = "mode = 'thermal'\n[[surface]]\nname = 'm'\nmesh = { file = 'a.obj' }\ntemperature = 900\nemissivity = 0.7\n";
const MEDIUM: &str = "[medium]\nmin = [0,0,0]\nmax = [2,1,1]\ncells = [2,1,1]\n";
const PANE: &str = "pane = { thickness = 0.1, extinction = 3 }";
const SQUARE: &str = "[[surface]]\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\n";

/// A triangle, a room of two cells with an array for each.
fn folder() -> Folder {
    let halves = npy("<f4", NpyOrder::C, "(2, 1, 1)", &f32s(&[0.5, 0.25]));
    Folder::new()
        .with("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
        .with("half.npy", halves)
        .with("p.png", png(1, 1, &[9, 9, 9]))
}

fn refused(folder: &Folder, text: &str, wanted: &[&str]) {
    let text = text
        .replace("LIGHT_MESH", LIGHT_MESH)
        .replace("THERMAL_MESH", THERMAL_MESH)
        .replace("MEDIUM", MEDIUM)
        .replace("PANE", PANE)
        .replace("SQUARE", SQUARE);
    let message = folder.refusal(&text);
    for w in wanted {
        assert!(message.contains(w), "'{w}' is not in:\n{message}\nfor\n{text}");
    }
    assert!(message.contains(';') && !message.contains('\n'), "no mend, or several lines:\n{message}");
}

/// What is said of a surface beside a pane, in both modes, whichever key and in whatever order.
#[test]
fn surface_keys_are_refused_on_glass() {
    let f = folder();
    for (key, mend) in [
        ("reflectance = 0.3", "remove it, or write materials.\"a\".pane = false"),
        ("emission = 3", "put emission into materials.\"a\".pane = { … }"),
        ("texture = 'p.png'", "remove it, or write"),
        ("sides = 'both'", "remove it, or write"),
        ("patch_size = 0.1", "remove it, or write"),
        ("emissivity = 0.9", "remove it, or write"),
    ] {
        let name = key.split(' ').next().unwrap();
        let line = format!("test.toml:4:{}: surface 'm'.materials.a.{name}", 16 + name.len() + 4);
        refused(&f, &format!("LIGHT_MESHmaterials.a = {{ {key}, PANE }}\n"), &[&line, mend]);
        refused(&f, &format!("LIGHT_MESHmaterials.a = {{ PANE, {key} }}\n"), &[name, mend]);
    }
    for key in ["reflectance = 0.3", "sides = 'front'", "patch_size = 1"] {
        refused(
            &f,
            &format!("THERMAL_MESHmaterials.a = {{ PANE, {key} }}\n"),
            &["is a pane", "of surfaces; remove it"],
        );
    }
    refused(
        &f,
        "LIGHT_MESHmaterials.a = { region = true, pane = { extinction = 3 }, reflectance = 0.5 }\nMEDIUMextinction = 1\n",
        &["materials.a.reflectance", "fills the medium", "; remove it"],
    );
    refused(
        &f,
        "LIGHT_MESHmaterials.a = { region = true, pane = false }\nMEDIUMextinction = 1\n",
        &["test.toml:4:", "materials.a.pane", "keep one of them"],
    );
    // The same keys of what is opaque, and of what is left out, are read.
    f.scene(&format!("{LIGHT_MESH}materials.a = {{ pane = false, reflectance = 0.3, sides = 'both' }}\n"));
    f.scene(&format!("{SQUARE}{LIGHT_MESH}materials.a = {{ omit = true, {PANE}, reflectance = 0.3 }}\n"));
    assert_eq!(
        f.scene(&format!("{LIGHT_MESH}reflectance = 0.3\nmaterials.a = {{ {PANE} }}\n")).panes().len(),
        1
    );
}

#[test]
fn numbers_beside_arrays_are_refused_without_a_shape() {
    let f = folder();
    for key in ["albedo = 0.5", "extinction = 1", "source = 1", "absorption = 2"] {
        let array = if key.starts_with('a') { "emission" } else { "albedo" };
        refused(
            &f,
            &format!("MEDIUMextinction = 1\n[[medium.region]]\n{array} = {{ file = 'half.npy' }}\n{key}\n"),
            &["test.toml:8:", "medium.region[0]", "write box = { min, max }"],
        );
    }
    refused(
        &f,
        "MEDIUMabsorption = 1\nalbedo = { file = 'half.npy' }\n",
        &["test.toml:5:14: medium.absorption", "give the extinction"],
    );
    refused(
        &f,
        "MEDIUM[[medium.region]]\ndensity = { file = 'half.npy', min = [0,0,0], max = [2,1,1] }\nabsorption = 1\n",
        &["test.toml:7:14: medium.region[0].absorption", "density.scale and albedo"],
    );
    let s = f.scene(&format!(
        "{MEDIUM}extinction = 1\n[[medium.region]]\nbox = {{ min = [0,0,0], max = [2,1,1] }}\nextinction = 4\nalbedo = {{ file = 'half.npy' }}\n"
    ));
    let map = s.voxel_grid().unwrap();
    assert_eq!(
        (map.extinction(1), map.albedo(0), map.albedo(1)),
        (Bands::splat(4.0), Bands::splat(0.5), Bands::splat(0.25))
    );
}

#[test]
fn settings_without_effect_are_refused() {
    let f = folder();
    refused(
        &f,
        "[solve]\npatch_rule = 'voxels'\nSQUARE",
        &["test.toml:2:14: solve.patch_rule", "no medium", "add a [medium], or remove this key"],
    );
    refused(
        &f,
        "mode = 'thermal'\n[solve]\nlight_groups = 'each'\nMEDIUMextinction = 1\ntemperature = 300\n",
        &["test.toml:3:16: solve.light_groups", "one sum"],
    );
    f.scene(&format!(
        "[solve]\npatch_rule = 'voxels'\nlight_groups = 'each'\n{SQUARE}{MEDIUM}extinction = 1\n"
    ));
}
