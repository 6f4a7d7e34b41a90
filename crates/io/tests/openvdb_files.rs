//! OpenVDB grids and Mitsuba volumes in the voxel grid.

use crate::support;

use std::path::{Path, PathBuf};
use support::Folder;
use support::vdb::Vdb;
use zonal_io::input::parse_scene;
use zonal_scene::{Bands, Scene};

fn total(s: &Scene) -> f64 {
    let v = s.voxel_grid().unwrap();
    (0..v.len()).map(|i| v.extinction(i).first()).sum::<f64>() * v.cell().product()
}

fn medium(cells: &str, density: &str) -> String {
    format!(
        "[medium]\nmin=[-1,-1,-1]\nmax=[9,9,9]\ncells={cells}\n[[medium.region]]\ndensity={{file='d.vdb'{density}}}\n"
    )
}

fn folder(v: &Vdb) -> Folder {
    Folder::new().with("d.vdb", v.bytes())
}

fn close(a: f64, b: f64) {
    assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
}

#[test]
fn all_encodings_read_equal() {
    for kind in
        ["Tree_float_5_4_3", "Tree_double_5_4_3", "Tree_float_5_4_3_HalfFloat", "Tree_double_5_4_3_HalfFloat"]
    {
        for flags in [0, 1, 2, 3, 4, 6] {
            for code in 0..=6 {
                let v = Vdb { kind, flags, code, ..Vdb::default() };
                let s = folder(&v).scene(&medium("[40,40,40]", ""));
                close(total(&s), v.sum() * 0.125);
                // Voxel (4, 2, 5) fills x from 1.75 to 2.25 and so on; it is active, 4·64 + 2·8 + 5 = 277.
                let m = s.voxel_grid().unwrap();
                let cell = [(1.75 + 1.0) * 4.0, (0.75 + 1.0) * 4.0, (2.25 + 1.0) * 4.0].map(|x| x as usize);
                assert_eq!(m.extinction(m.index(cell)).first(), (277 % 7) as f64, "{kind} {flags} {code}");
            }
        }
    }
}

#[test]
fn transforms_place_voxels() {
    let s = [0.5, 0.25, 1.0];
    let rest = [1.0; 12].to_vec();
    let scale: Vec<f64> = s.iter().copied().chain(rest).collect();
    let moved: Vec<f64> = [1.0, 2.0, 0.5].into_iter().chain(scale.clone()).collect();
    let affine = |m: [[f64; 3]; 4]| -> Vec<f64> {
        m.iter().enumerate().flat_map(|(i, r)| [r[0], r[1], r[2], f64::from(u8::from(i == 3))]).collect()
    };
    // (name, numbers, voxel (0, 0, 0)'s lower corner and edges in the scene)
    let maps = [
        ("ScaleMap", scale, [-0.25, -0.125, -0.5], s),
        ("ScaleTranslateMap", moved, [0.75, 1.875, 0.0], s),
        ("TranslationMap", vec![0.5, 0.5, 0.5], [0.0; 3], [1.0; 3]),
        // y to −z, z to y.
        (
            "AffineMap",
            affine([[0.5, 0.0, 0.0], [0.0, 0.0, -0.5], [0.0, 0.25, 0.0], [0.25, 1.125, 7.75]]),
            [0.0, 1.0, 7.5],
            [0.5, 0.25, 0.5],
        ),
    ];
    for (name, numbers, corner, edges) in maps {
        let mut leaf = vec![-1000.0; 512];
        leaf[0] = 3.0;
        let v = Vdb { map: (name, numbers), leaf, tile: 0.0, ..Vdb::default() };
        let s = folder(&v).scene(
            "[medium]\nmin=[-1,-1,-1]\nmax=[9,9,9]\ncell_size=0.125\nextinction=0\n[[medium.region]]\ndensity={file='d.vdb'}\n",
        );
        let m = s.voxel_grid().unwrap();
        for i in 0..m.len() {
            let c = m.centre(m.coordinates(i)).array();
            let inside = (0..3).all(|k| (corner[k]..corner[k] + edges[k]).contains(&c[k]));
            assert_eq!(m.extinction(i).first(), if inside { 3.0 } else { 0.0 }, "{name} {c:?}");
        }
    }
}

#[test]
fn resampling_conserves_the_integral_under_any_placement() {
    let v = Vdb::default();
    let f = folder(&v);
    let sum = v.sum();
    for cells in ["[40,40,40]", "[7,9,11]", "[1,1,1]", "[80,3,50]"] {
        for (density, volume) in [
            ("", 0.125),
            (",unit=0.7,translate=[0.3,0.1,0.2]", 0.125 * 0.343),
            // The active voxels fill 16 × 8 × 8.
            (",min=[0,1,2],max=[3,3.5,8]", 3.0 * 2.5 * 6.0 / 1024.0),
            (",rotate_degrees=[90,0,0],translate=[0,5,0]", 0.125),
            (",rotate_degrees=[0,0,90],min=[1,1,1],max=[2,4,5]", 12.0 / 1024.0),
            (",rotate_degrees=[10,20,30],translate=[2,1,2],unit=0.5", 0.125 * 0.125),
        ] {
            close(total(&f.scene(&medium(cells, density))), sum * volume);
        }
    }
    let scaled = f.scene(&medium("[9,9,9]", ",scale=[2,4,6]"));
    let m = scaled.voxel_grid().unwrap();
    assert!((0..m.len()).all(|i| {
        let [r, g, b] = m.extinction(i).to_rgb();
        (g - 2.0 * r).abs() <= 1e-12 * g && (b - 3.0 * r).abs() <= 1e-12 * b
    }));
}

#[test]
fn inactive_voxels_keep_the_background() {
    let mut leaf = vec![-1000.0; 512];
    leaf[511] = 4.0;
    let v = Vdb { leaf, map: ("TranslationMap", vec![0.5; 3]), ..Vdb::default() };
    let s = folder(&v).scene(
        "[medium]\nmin=[0,0,0]\nmax=[16,8,8]\ncell_size=2\nextinction=0.5\n[[medium.region]]\ndensity={file='d.vdb'}\n",
    );
    let m = s.voxel_grid().unwrap();
    assert_eq!(m.extinction(m.index([0, 0, 0])).first(), 0.5);
    // One voxel of the eight in this cell.
    assert_eq!(m.extinction(m.index([3, 3, 3])).first(), 0.5 * 7.0 / 8.0 + 4.0 / 8.0);
    assert_eq!(m.extinction(m.index([4, 0, 0])).first(), 2.0);
}

#[test]
fn temperature_grids_fill_active_voxels() {
    let mut leaf = vec![-1000.0; 512];
    leaf[511] = 4.0;
    let v = Vdb { leaf, map: ("TranslationMap", vec![0.5; 3]), ..Vdb::default() };
    let s = folder(&v).scene(
        "mode='thermal'\n[medium]\nmin=[0,0,0]\nmax=[16,8,8]\ncell_size=2\nextinction=0.5\ntemperature=900\n[[medium.region]]\ntemperature={file='d.vdb',scale=150}\n",
    );
    let m = s.voxel_grid().unwrap();
    let kelvin = |c: [usize; 3]| match m.heat(m.index(c)) {
        Some(zonal_scene::ThermalCondition::Temperature(t)) => t,
        other => panic!("{other:?}"),
    };
    assert_eq!(kelvin([0, 0, 0]), 900.0);
    // The tile, and one voxel of the eight in a cell: the mean of T⁴.
    close(kelvin([4, 0, 0]), 300.0);
    close(kelvin([3, 3, 3]), (7.0 / 8.0 * 900f64.powi(4) + 600f64.powi(4) / 8.0).powf(0.25));
}

#[test]
fn level_sets_are_refused_or_filled() {
    // A plane at x = 3.25: distances grow with x; the tile beyond is outside.
    let leaf = (0..512).map(|i| ((i / 64) as f32 - 3.25) * 0.5).collect();
    let v = Vdb { class: "level set", leaf, tile: 2.0, background: 2.0, code: 6, ..Vdb::default() };
    let f = folder(&v);
    let message = f.refusal(&medium("[10,10,10]", ""));
    assert!(message.contains("level set") && message.contains("level_set = true"), "{message}");
    let s = f.scene(&medium("[10,10,10]", ",level_set=true,scale=3"));
    // Three voxels and a share of ½ + ¼ of the fourth.
    close(total(&s), 3.0 * 3.75 * 64.0 * 0.125);
    let message = folder(&Vdb::default()).refusal(&medium("[10,10,10]", ",level_set=true"));
    assert!(message.contains("no level set"), "{message}");
}

#[test]
fn unread_grids_are_refused() {
    let refusals = [
        (Vdb { version: 221, ..Vdb::default() }, "", "version 221"),
        (Vdb { version: 300, ..Vdb::default() }, "", "version 300"),
        (Vdb { kind: "Tree_vec3s_5_4_3", ..Vdb::default() }, "", "Tree_vec3s_5_4_3"),
        (Vdb { kind: "Tree_ptdataidx32_5_4_3", ..Vdb::default() }, "", "convert this one to floats"),
        (Vdb { flags: 8, ..Vdb::default() }, "", "compression 8"),
        (Vdb { code: 7, ..Vdb::default() }, "", "7 is no code"),
        (Vdb { map: ("NonlinearFrustumMap", vec![1.0; 24]), ..Vdb::default() }, "", "NonlinearFrustumMap"),
        (Vdb { map: ("UniformScaleMap", vec![0.0; 15]), ..Vdb::default() }, "", "no volume"),
        (Vdb { tile: -2.0, ..Vdb::default() }, "", ":[8, 0, 0]: -2 is no density"),
        (Vdb { tile: f32::NAN, ..Vdb::default() }, "", "NaN is no density"),
        (Vdb::default(), ",grid='temperature'", "its grids are 'density'"),
        (Vdb::default(), ",min=[0,0,0],max=[1,1,1],unit=2", "already place"),
        (Vdb::default(), ",min=[0,0,0],max=[1,1,1],rotate_degrees=[0,0,20]", "along the scene's"),
        (Vdb::default(), ",unit=1e-6,translate=[50,0,0]", "fills no cell"),
    ];
    for (v, keys, wanted) in refusals {
        let message = folder(&v).refusal(&medium("[4,4,4]", keys));
        assert!(message.starts_with("test.toml:") && message.contains(wanted), "{wanted}: {message}");
    }
    let shear: Vec<f64> =
        [1.0, 0.3, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0].to_vec();
    let message =
        folder(&Vdb { map: ("AffineMap", shear), ..Vdb::default() }).refusal(&medium("[4,4,4]", ""));
    assert!(message.contains("shears"), "{message}");
}

#[test]
fn parts_outside_the_medium_give_a_note() {
    let s = folder(&Vdb::default()).scene(&medium("[4,4,4]", ",translate=[6,0,0]"));
    let notes: String = s.notes().iter().map(ToString::to_string).collect();
    assert!(notes.contains("outside the medium"), "{notes}");
    let inside = folder(&Vdb::default()).scene(&medium("[4,4,4]", ""));
    assert!(inside.notes().is_empty());
}

/// A file of OpenVDB itself: see data/mixed.py.
#[test]
fn a_file_written_by_openvdb_is_read() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let scene = |keys: &str| {
        let text = format!(
            "[medium]\nmin=[-5,-5,-5]\nmax=[150,75,45]\ncells=[50,20,25]\n[[medium.region]]\ndensity={{file='mixed.vdb'{keys}}}\n"
        );
        parse_scene(&text, Some(&data), "test.toml")
    };
    // Its own library says this of both; a voxel has 1/16 of a volume.
    for keys in ["", ",grid='half'"] {
        let s = scene(keys).unwrap();
        close(total(&s), 524_878.75 / 16.0);
        assert!(s.notes().is_empty());
    }
    let message = scene(",grid='vel'").unwrap_err().to_string();
    assert!(message.contains("Tree_vec3s_5_4_3"), "{message}");
    let message = scene(",grid='smoke'").unwrap_err().to_string();
    assert!(message.contains("'vel', 'half', 'density'"), "{message}");
}

fn shared() -> Option<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/smoke-vdb");
    if !data.exists() {
        println!("skipped: {} is missing", data.display());
        return None;
    }
    Some(data)
}

#[test]
fn shared_smoke_conserves_its_integral() {
    let Some(data) = shared() else { return };
    let check = |text: &str, volume: f64| {
        let s = parse_scene(text, Some(&data), "smoke.toml").unwrap_or_else(|e| panic!("{e}"));
        let wanted = 171_499.695_5 * volume;
        assert!((total(&s) / wanted - 1.0).abs() < 1e-9, "{} {wanted}", total(&s));
        assert!(s.notes().is_empty());
    };
    // Fitted: 111 × 222 × 112 voxels of 0.1 m.
    check(
        "[medium]\nmin=[0,0,0]\nmax=[12,23,12]\ncells=[14,28,13]\n[[medium.region]]\n\
         density={file='smoke.vdb',min=[0.2,0.2,0.3],max=[11.3,22.4,11.5]}\n",
        1e-3,
    );
    // By its own transform, upright, a hundredth as large.
    check(
        "[medium]\nmin=[-1,-1,-1]\nmax=[1,1,1.5]\ncells=[61,30,40]\n[[medium.region]]\n\
         density={file='smoke.vdb',unit=0.01,rotate_degrees=[90,0,0]}\n",
        (20.0f64 / 42.0 * 0.01).powi(3),
    );
}

/// The means over 2³ voxels that somebody else made of the same file.
#[test]
fn cell_means_agree_with_dense_arrays() {
    let Some(data) = shared() else { return };
    // Index 0 has no active voxel; the arrays begin with it. One cell, 2 voxels, is 1 m here.
    let scene = |density: &str| {
        let text = format!(
            "[medium]\nmin=[0,0,0]\nmax=[56,112,57]\ncell_size=1\n[[medium.region]]\ndensity={{file={density}}}\n"
        );
        parse_scene(&text, Some(&data), "smoke.toml").unwrap_or_else(|e| panic!("{e}"))
    };
    let grid = scene("'smoke.vdb',min=[0.5,1,0.5],max=[56,112,56.5]");
    let vol = scene("'smoke_56x112x57.vol',min=[0,0,0],max=[56,112,57]");
    let npy = scene("'smoke_56x112x57_f16.npy',min=[0,0,0],max=[56,112,57]");
    let maps = [&grid, &vol, &npy].map(|s| s.voxel_grid().unwrap());
    for i in 0..maps[0].len() {
        let [g, v, n] = maps.map(|m| m.extinction(i).first());
        assert!((g - v).abs() <= 1e-6 * v.max(1.0), "{:?}: {g} {v}", maps[0].coordinates(i));
        assert!((g - n).abs() <= 1e-3 * n.max(1e-3), "{:?}: {g} {n}", maps[0].coordinates(i));
    }
}

#[test]
fn a_sphere_is_a_level_set() {
    let Some(data) = shared() else { return };
    let scene = |keys: &str| {
        let text = format!(
            "[medium]\nmin=[-4,-4,-4]\nmax=[4,4,4]\ncells=[16,16,16]\n[[medium.region]]\ndensity={{file='sphere.vdb'{keys}}}\n"
        );
        parse_scene(&text, Some(&data), "sphere.toml")
    };
    let message = scene("").unwrap_err().to_string();
    assert!(message.contains("'ls_sphere'") && message.contains("level_set = true"), "{message}");
    let s = scene(",level_set=true").unwrap();
    // Its radius is 3.
    let volume = 36.0 * std::f64::consts::PI;
    assert!((total(&s) / volume - 1.0).abs() < 2e-4, "{} {volume}", total(&s));
}

fn vol(shape: [u32; 3], values: &[f32]) -> Vec<u8> {
    vol_of_channels(1, shape, values)
}

fn vol_of_channels(channels: u32, shape: [u32; 3], values: &[f32]) -> Vec<u8> {
    let mut out = b"VOL\x03".to_vec();
    for n in [1, shape[0], shape[1], shape[2], channels] {
        out.extend(n.to_le_bytes());
    }
    out.extend(support::f32s(&[0.0, 0.0, 0.0, 2.0, 1.0, 1.0]));
    out.extend(support::f32s(values));
    out
}

#[test]
fn mitsuba_volumes_fill_their_own_box() {
    let f = Folder::new().with("d.vdb", vol([2, 1, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    let s = f.scene(&medium("[10,10,30]", ""));
    let m = s.voxel_grid().unwrap();
    close(m.extinction(m.index([1, 1, 3])).first(), 1.0);
    close(m.extinction(m.index([2, 1, 3])).first(), 2.0);
    close(m.extinction(m.index([2, 1, 5])).first(), 6.0);
    close(total(&s), 21.0 / 3.0);
    let message = f.refusal(&medium("[10,10,30]", ",grid='density'"));
    assert!(message.contains("only OpenVDB files"), "{message}");
    let cut = Folder::new().with("d.vdb", vol([2, 2, 3], &[1.0; 6]));
    assert!(cut.refusal(&medium("[4,4,4]", "")).contains("does not agree"));
    let negative = Folder::new().with("d.vdb", vol([1, 1, 1], &[-1.0]));
    assert!(negative.refusal(&medium("[4,4,4]", "")).contains("no density"));
}

#[test]
fn three_channels_of_a_volume_are_colours() {
    let colours = vol_of_channels(3, [2, 1, 1], &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
    let f = Folder::new().with("d.vol", colours).with("two.vol", vol_of_channels(2, [1, 1, 1], &[1.0; 2]));
    let text = |head: &str, keys: &str| {
        format!(
            "{head}\n[medium]\nmin=[0,0,0]\nmax=[2,1,1]\ncells=[2,1,1]\n{keys}\n[[medium.region]]\ndensity={{file='d.vol',scale=2}}\n"
        )
    };
    let near = |a: Bands, b: [f64; 3]| assert!((a - Bands::from_rgb(b)).abs().sum() < 1e-6, "{a:?} {b:?}");
    let s = f.scene(&text("", "extinction=1\nalbedo={file='d.vol'}"));
    let m = s.voxel_grid().unwrap();
    near(m.extinction(0), [0.2, 0.4, 0.6]);
    near(m.extinction(1), [0.8, 1.0, 1.2]);
    near(m.albedo(1), [0.4, 0.5, 0.6]);
    // Bands of wavelengths have the means of the colours.
    let s = f.scene(&text("bands=[[400,490],[600,700]]", ""));
    near(s.voxel_grid().unwrap().extinction(0), [0.6, 0.2, 0.2]);
    near(f.scene(&text("bands=3", "")).voxel_grid().unwrap().extinction(0), [0.2, 0.4, 0.6]);
    for (scene, wanted) in [
        (
            text("bands=2", ""),
            "d.vol: its channels are red, green and blue, which have no meaning in bands without",
        ),
        (
            text("mode='thermal'", "temperature={file='d.vol'}"),
            "d.vol: three channels are no temperature; save",
        ),
        (
            text("", "").replace("d.vol", "two.vol"),
            "values of type 1 with 2 channels are not read; save one or three",
        ),
        (
            text("", "").replace("d.vol", "d.nvdb"),
            "NanoVDB files are not read; convert this one: nanovdb_convert in.nvdb out.vdb",
        ),
    ] {
        let message = f.refusal(&scene);
        assert!(message.contains(wanted), "{message}");
    }
}
