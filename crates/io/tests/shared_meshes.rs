//! Meshes that nobody on this project made, from the shared data beside the checkout; skipped where they are missing.

use std::path::{Path, PathBuf};
use zonal_io::input::parse_scene;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Diagnostic, PlateKind, Scene, Sides, Surface};

fn shared(path: &str) -> Option<PathBuf> {
    let p = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path);
    if !p.exists() {
        println!("skipped: {} is missing", p.display());
        return None;
    }
    Some(p)
}

fn scene(text: &str) -> Scene {
    parse_scene(text, Some(Path::new("/")), "shared.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn mesh(path: &Path, more: &str) -> String {
    format!("[[surface]]\nname='m'\nmesh={{file='{}'}}\n{more}\n", path.display())
}

/// A parallelogram counts as the two triangles it stands for.
fn triangles(s: &Scene) -> usize {
    s.facets().iter().map(|f| weight(f.plate.kind)).sum::<usize>()
        + s.panes().iter().flat_map(|p| &p.plates).map(|p| weight(p.kind)).sum::<usize>()
}

fn weight(kind: PlateKind) -> usize {
    match kind {
        PlateKind::Triangle => 1,
        PlateKind::Parallelogram => 2,
    }
}

fn surface<'a>(s: &'a Scene, name: &str) -> &'a Surface {
    let find = s.surfaces().iter().find(|x| x.name == name);
    find.unwrap_or_else(|| {
        panic!("no {name} among {:?}", s.surfaces().iter().map(|s| &s.name).collect::<Vec<_>>())
    })
}

#[test]
fn mitsuba_cornell_box_is_read() {
    let Some(dir) = shared("cornell/mitsuba-cbox/meshes") else {
        return;
    };
    let text: String =
        ["luminaire", "floor", "ceiling", "back", "greenwall", "redwall", "smallbox", "largebox"]
            .iter()
            .map(|n| {
                let file = dir.join(format!("cbox_{n}.obj"));
                format!(
                    "[[surface]]\nname='{n}'\nmesh={{file='{}', scale=0.001}}\nreflectance=0.4\n",
                    file.display()
                )
            })
            .collect();
    let s = scene(&text);
    // 32 faces; six of them are quadrilaterals.
    assert_eq!(triangles(&s), 38);
    let (lo, hi) = s.bounds();
    assert!(lo.max_abs() < 0.01 && (hi - vec3(0.556, 0.5488, 0.5592)).max_abs() < 0.01, "{lo:?} {hi:?}");
    // The boxes stand on the floor and have a bottom each; they are bodies.
    for name in ["smallbox", "largebox"] {
        let x = surface(&s, name);
        assert!(x.solid && x.sides == Sides::Front, "{x:?}");
    }
    assert_eq!(surface(&s, "floor").sides, Sides::Both);
    assert!(s.surfaces().iter().all(|s| s.reflectance == Bands::splat(0.4)));
}

#[test]
fn tinyobj_cornell_box_is_read() {
    for name in ["cornell_box.obj", "cornell_box_multimaterial.obj"] {
        let Some(file) = shared(&format!("cornell/tinyobj/{name}")) else {
            return;
        };
        let s = scene(&mesh(&file, ""));
        assert_eq!(triangles(&s), 36, "{name}");
        assert_eq!(surface(&s, "m/white").reflectance, Bands::splat(0.95));
        assert_eq!(surface(&s, "m/red").reflectance, Bands::from_rgb([0.95, 0.0, 0.0]));
        assert_eq!(surface(&s, "m/green").reflectance, Bands::from_rgb([0.0, 0.95, 0.0]));
    }
}

#[test]
fn mcguire_cornell_box_is_read() {
    let Some(file) = shared("cornell/mcguire/CornellBox-Sphere.obj") else {
        return;
    };
    let s = scene(&mesh(&file, ""));
    assert_eq!(triangles(&s), 2188, "{:?}", s.notes());
    assert_eq!(surface(&s, "m/rightWall").reflectance, Bands::from_rgb([0.161, 0.133, 0.427]));
    let left = surface(&s, "m/leftSphere");
    assert!(left.solid && left.sides == Sides::Front, "{left:?}");
}

#[test]
fn unlit_gallery_reflects_and_does_not_emit() {
    let Some(file) = shared("vr-gallery/vr-gallery.glb") else {
        return;
    };
    let s = scene(&mesh(&file, ""));
    assert_eq!(triangles(&s), 1930, "{:?}", s.notes());
    let (lo, hi) = s.bounds();
    assert!(s.notes().iter().any(|n| n.contains("unlit")), "{:?}", s.notes());
    assert!((hi.y - 5.05).abs() < 0.02 && lo.y.abs() < 0.02 && (hi.x - 5.06).abs() < 0.02, "{lo:?} {hi:?}");
    for x in s.surfaces() {
        assert_eq!(x.emission, Bands::ZERO);
        assert!(x.reflectance.iter().all(|r| *r <= 0.95), "{x:?}");
        assert_eq!(x.solid, x.name.ends_with("(solid)"));
        assert!(x.reflectance_texture.is_some() && x.emission_texture.is_none());
    }
    // The shell of the room itself is no solid: no solid is as large as the room.
    for (i, x) in s.surfaces().iter().enumerate() {
        let of = s.facets().iter().filter(|f| f.surface == i);
        let size = of.map(|f| f.plate.bounds()).fold((hi, lo), |(a, b), (c, d)| (a.min(c), b.max(d)));
        assert!(!x.solid || (size.1 - size.0).max_abs() < 9.0, "{}", x.name);
    }
    assert_eq!(s.textures().len(), 1);
    let r = s.reflectance_at(100, 0.3, 0.3);
    assert!(r.iter().all(|x| *x > 0.0 && *x <= 0.95), "{r:?}");
}

/// Faces that the notes of a scene count as dropped: without area, repeated, or the other side of a sheet.
fn dropped_faces(s: &Scene) -> usize {
    let count = |n: &Diagnostic| {
        let words = match n.code.as_str() {
            "faces-dropped" => n.text.split(": ").nth(1)?,
            "repeated-faces" | "opposite-faces" => n.text.as_str(),
            _ => return None,
        };
        words.split(' ').next()?.parse::<usize>().ok()
    };
    s.notes().iter().filter_map(count).sum()
}

#[test]
fn sponza_is_read_completely() {
    let Some(file) = shared("sponza-dabrovic/sponza-dabrovic.glb") else {
        return;
    };
    let s = scene(&mesh(&file, ""));
    assert_eq!(triangles(&s) + dropped_faces(&s), 66_447, "{:?}", s.notes());
    let (lo, hi) = s.bounds();
    assert!((lo - vec3(-17.4, -0.9, -7.8)).max_abs() < 0.1 && (hi - vec3(17.4, 15.7, 7.8)).max_abs() < 0.1);
    for x in s.surfaces() {
        assert!(x.reflectance.iter().all(|r| (*r - 0.7).abs() < 1e-6));
    }
}

#[test]
fn factory_panes_require_a_thickness() {
    let Some(file) = shared("victorian-factory/victorian-factory.glb") else {
        return;
    };
    let refused = |more: &str| {
        let text = mesh(&file, more);
        parse_scene(&text, Some(Path::new("/")), "factory.toml").unwrap_err().to_string()
    };
    let first = refused("");
    assert!(first.starts_with("factory.toml:"), "{first}");
    assert!(
        first.contains("the thickness of the glass of 'phong3', 'vetro'; write pane.thickness (m)"),
        "{first}"
    );
    let second = refused("materials.phong3.pane.thickness = 0.02");
    assert!(second.contains("'vetro'"), "{second}");
    let s = scene(&mesh(
        &file,
        "materials.phong3.pane.thickness = 0.02\nmaterials.vetro.pane = {thickness=0.01, extinction=[10,100,200]}",
    ));
    assert_eq!(triangles(&s) + dropped_faces(&s), 45_347, "{:?}", s.notes());
    let vetro = s.panes().iter().find(|p| p.name == "m/vetro").unwrap();
    assert_eq!(vetro.plates.iter().map(|p| weight(p.kind)).sum::<usize>(), 244);
    assert_eq!((vetro.thickness, vetro.extinction), (0.01, Bands::from_rgb([10.0, 100.0, 200.0])));
    let phong3 = s.panes().iter().find(|p| p.name == "m/phong3").unwrap();
    let alpha = f64::from(0.223_894_82_f32);
    assert!(
        (phong3.extinction.first() + (1.0 - alpha).ln() / 0.02).abs() < 1e-4,
        "{phong3:?}",
        phong3 = phong3.extinction
    );
    let (lo, hi) = s.bounds();
    assert!(
        (lo - vec3(-132.0, -19.0, 347.0)).max_abs() < 1.0 && (hi - vec3(248.0, 369.0, 564.0)).max_abs() < 1.0
    );
    assert!(s.surfaces().iter().any(|x| x.reflectance_texture.is_some()));
}

#[test]
fn glass_blocks_become_panes_or_fill_the_medium() {
    let Some(file) = shared("gltf-volume/AttenuationTest.glb") else {
        return;
    };
    let thin: String = ["1.0", "1.5", "2.0", "0.50", "0.25"]
        .iter()
        .map(|n| format!("materials.'R1_Sample_{n}'.pane.thickness = 1\n"))
        .collect();
    let s = scene(&mesh(&file, &thin));
    let pane = |name: &str| s.panes().iter().find(|p| p.name == name).unwrap();
    let one = pane("m/R5_Attenuation_1.0");
    assert_eq!((one.thickness, one.albedo), (1.0, Bands::ZERO));
    let colour = Bands::from_rgb([0.1f32, 0.5, 0.9].map(f64::from));
    assert!((one.extinction + colour.map(f64::ln)).all(|d| d.abs() < 1e-12));
    let half = pane("m/R5_Attenuation_0.50").extinction;
    assert!((half - one.extinction / 2.0).all(|d| d.abs() < 1e-12));
    // A thin glass that passes 0.1 in a unit of thickness is one that takes ln 10 a unit.
    let sample = pane("m/R1_Sample_1.5").extinction.first();
    assert!((sample - 1.5 * 10f64.ln()).abs() < 1e-6, "{sample}");
    // Metres from centimetres: the glass gets a hundred times thinner and a hundred times denser.
    let text = mesh(&file, &thin).replace("'}", "', scale=0.01}");
    let small = scene(&text);
    let p = small.panes().iter().find(|p| p.name == "m/R5_Attenuation_1.0").unwrap();
    assert!(
        (p.thickness - 0.01).abs() < 1e-15 && (p.extinction - 100.0 * one.extinction).first().abs() < 1e-9
    );

    let (lo, hi) = one
        .plates
        .iter()
        .map(|p| p.bounds())
        .fold((Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY)), |(a, b), (c, d)| {
            (a.min(c), b.max(d))
        });
    let (min, max) = (lo - Vec3::splat(0.5), hi + Vec3::splat(0.5));
    let text = mesh(&file, &format!("{thin}materials.'R5_Attenuation_1.0'.region = true"))
        + &format!("[medium]\nmin={:?}\nmax={:?}\ncell_size=0.1\n", min.array(), max.array());
    let filled = scene(&text);
    let v = filled.voxel_grid().unwrap();
    let inside = (0..v.len()).filter(|i| v.extinction(*i).first() > 0.0).count() as f64 * v.cell().product();
    assert!((inside / (hi - lo).product() - 1.0).abs() < 0.05, "{inside} {lo:?} {hi:?}");
    let mid = v.cell_at((lo + hi) * 0.5).unwrap();
    assert!((v.extinction(v.index(mid)) - one.extinction).to_rgb()[2].abs() < 1e-12);
}
