//! Materials whose alpha varies: their faces are cut into plates and panes.

use crate::support;

use std::f64::consts::PI;
use support::{Folder, Quad, grey_alpha_png, png};
use zonal_scene::{Bands, Pane, Plate, Scene, Sides};

fn mesh(file: &str, more: &str) -> String {
    format!("[[surface]]\nname = 'm'\nmesh = {{ file = '{file}' }}\n{more}\n")
}

/// White with the alpha of a disc of radius 0.3 about the centre.
fn disc() -> Vec<u8> {
    let n = 128;
    let alpha = |i: usize| {
        let place = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
        let r = place(i % n).hypot(place(i / n));
        (255.0 * (0.5 + (0.3 - r) * n as f64).clamp(0.0, 1.0)).round() as u8
    };
    grey_alpha_png(n as u32, &(0..n * n).flat_map(|i| [255, alpha(i)]).collect::<Vec<_>>())
}

/// A unit square of a material with a picture and an alpha mode.
fn square(picture: &[u8], mode: &str, alpha: f64, more: &str) -> Scene {
    let mut q = Quad::default();
    let start = q.binary.len();
    q.binary.extend(picture);
    q.views += &format!(r#",{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, picture.len());
    q.more = r#","images":[{"bufferView":3,"mimeType":"image/png"}],"textures":[{"source":0}]"#.into();
    q.material = format!(
        r#"{{"name":"leaf","doubleSided":true,{mode},"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorFactor":[0.5,0.5,0.5,{alpha}],"baseColorTexture":{{"index":0}}}}}}"#
    );
    Folder::new().with("q.glb", q.glb()).scene(&mesh("q.glb", more))
}

fn area(s: &Scene) -> f64 {
    s.facets().iter().map(|f| f.plate.area()).sum()
}

/// The opaque area and the area of the panes times 1 − their transmittance.
fn covered_area(s: &Scene) -> f64 {
    let of_pane = |p: &Pane| {
        let transmittance = (-p.extinction.first() * p.thickness).exp();
        (1.0 - transmittance) * p.plates.iter().map(Plate::area).sum::<f64>()
    };
    area(s) + s.panes().iter().map(of_pane).sum::<f64>()
}

fn notes(s: &Scene) -> String {
    s.notes().iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

const MASK: &str = r#""alphaMode":"MASK""#;
const BLEND: &str = r#""alphaMode":"BLEND""#;

#[test]
fn masks_leave_the_area_above_the_cutoff() {
    let s = square(&disc(), MASK, 1.0, "");
    assert!((area(&s) / (PI * 0.09) - 1.0).abs() < 2e-3, "{}", area(&s));
    assert_eq!((s.surfaces().len(), s.surfaces()[0].sides, s.panes().len()), (1, Sides::Both, 0));
    assert!(notes(&s).contains("'leaf'") && notes(&s).contains("cut along their alpha"), "{}", notes(&s));
    // All pieces belong to the two triangles of the file.
    assert!((0..s.facets().len()).all(|k| s.faces().face_of(k).is_some_and(|f| f < 2)));
    // A patch size sets the size of the pieces.
    let coarse = square(&disc(), MASK, 1.0, "patch_size = 8");
    assert!(coarse.facets().len() * 4 < s.facets().len(), "{} {}", coarse.facets().len(), s.facets().len());
    assert!((area(&coarse) / (PI * 0.09) - 1.0).abs() < 0.05, "{}", area(&coarse));
    // A factor below the cutoff leaves nothing, and the picture of an opaque material has no effect.
    let other = "[[surface]]\nrectangle = { origin = [0,0,1], edge1 = [1,0,0], edge2 = [0,1,0] }\n";
    let gone = square(&disc(), MASK, 0.4, other);
    assert!(
        (area(&gone) - 1.0).abs() < 1e-12 && notes(&gone).contains("entirely cut out"),
        "{}",
        notes(&gone)
    );
    let opaque = square(&disc(), r#""alphaMode":"OPAQUE""#, 1.0, "");
    assert!(area(&opaque) == 1.0 && opaque.notes().is_empty());
}

#[test]
fn blended_pictures_become_panes_by_level() {
    let s = square(&disc(), BLEND, 1.0, "");
    assert!((covered_area(&s) / (PI * 0.09) - 1.0).abs() < 0.01, "{}", covered_area(&s));
    assert!(area(&s) > 0.95 * PI * 0.09, "{}", area(&s));
    // Alpha 0.5 of the whole disc.
    let half = square(&disc(), BLEND, 0.5, "");
    assert_eq!(half.facets().len(), 0);
    assert!((covered_area(&half) / (0.5 * PI * 0.09) - 1.0).abs() < 0.01, "{}", covered_area(&half));
    assert!(
        half.panes().iter().all(|p| (p.albedo.first() - 0.5).abs() < 1e-6),
        "{:?}",
        half.panes()[0].albedo
    );
    assert!(half.panes().iter().any(|p| p.name.contains("alpha 0.50")), "{}", half.panes()[0].name);
    // Properties of the scene take the place of the file's alpha.
    for more in ["materials.leaf.pane = {thickness=0.01, extinction=5}", "materials.leaf.pane = false"] {
        let given = square(&disc(), BLEND, 1.0, more);
        let panes: f64 = given.panes().iter().flat_map(|p| &p.plates).map(|q| q.area()).sum();
        assert_eq!(area(&given) + panes, 1.0, "{more}");
        assert_eq!(notes(&given), "");
    }
}

#[test]
fn diffuse_transmission_and_frosted_glass_become_sheets() {
    let read = |material: &str, more: &str| {
        let q = Quad { material: material.into(), ..Quad::default() };
        Folder::new().with("q.glb", q.glb()).scene(&mesh("q.glb", more))
    };
    let leaf = r#"{"name":"leaf","pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[0.4,0.8,0.2,1]},
        "extensions":{"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.25,"diffuseTransmissionColorFactor":[0.5,1,0.25]}}}"#;
    let s = read(leaf, "");
    let (surface, tau) = (&s.surfaces()[0], s.transmittance_at(0, 0.3, 0.3));
    assert!((surface.reflectance - Bands::from_rgb([0.3, 0.6, 0.15])).abs().max_element() < 1e-6);
    assert!((tau - Bands::from_rgb([0.125, 0.25, 0.0625])).abs().max_element() < 1e-6, "{tau:?}");
    assert_eq!((surface.sides, s.panes().len()), (Sides::Both, 0));
    // Keys of the scene precede the file.
    let given = read(leaf, "transmittance = 0.1\nreflectance = 0.2");
    assert_eq!(given.transmittance_at(0, 0.3, 0.3), Bands::splat(0.1));
    assert!(read(leaf, "transmittance = 0").surfaces()[0].transmission.is_none());
    // The roughness of glTF is 1 unless the file says otherwise.
    let glass = |roughness: f64| {
        format!(
            r#"{{"name":"glass","pbrMetallicRoughness":{{"metallicFactor":0,"roughnessFactor":{roughness},"baseColorFactor":[0.5,0.9,1,1]}},"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":0.75}}}}}}"#
        )
    };
    let frosted = read(&glass(0.6), "");
    let (rho, tau) = (frosted.surfaces()[0].reflectance, frosted.transmittance_at(0, 0.5, 0.5));
    // Blue, of which the file absorbs nothing, is limited to 0.95 in all.
    assert!((rho - Bands::from_rgb([0.125, 0.225, 0.2375])).abs().max_element() < 1e-6, "{rho:?}");
    assert!((tau - Bands::from_rgb([0.375, 0.675, 0.7125])).abs().max_element() < 1e-6, "{tau:?}");
    assert_eq!(read(&glass(0.0), "materials.glass.pane.thickness = 0.01").panes().len(), 1);
    assert_eq!(read(&glass(0.6), "materials.glass.pane.thickness = 0.01").panes().len(), 1);
}

#[test]
fn textures_of_transmission_weigh_reflectance_and_transmittance() {
    // Left half: the whole light is transmitted; right half: reflected.
    let picture = png(2, 1, &[255, 0, 0, 0, 0, 0]);
    let mut q = Quad::default();
    let start = q.binary.len();
    q.binary.extend(&picture);
    q.views += &format!(r#",{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, picture.len());
    q.more = r#","images":[{"bufferView":3,"mimeType":"image/png"}],"textures":[{"source":0}]"#.into();
    q.material = r#"{"name":"glass","pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[0.5,0.5,0.5,1]},
        "extensions":{"KHR_materials_transmission":{"transmissionFactor":1,"transmissionTexture":{"index":0}}}}"#
        .into();
    let s = Folder::new().with("q.glb", q.glb()).scene(&mesh("q.glb", ""));
    for (u, transmitted) in [(0.25, 0.5), (0.75, 0.0)] {
        let facet = &s.facets()[0];
        let at = facet.plate.parameters(zonal_math::vec3(u, 0.2, 0.0));
        let [rho, tau] = [s.reflectance_at(0, at[0], at[1]), s.transmittance_at(0, at[0], at[1])];
        assert!((tau.first() - transmitted).abs() < 1e-6, "{u}: {tau:?}");
        assert!((rho.first() - (0.5 - transmitted)).abs() < 1e-6, "{u}: {rho:?}");
    }
}

#[test]
fn alpha_pictures_of_obj_files_are_read() {
    let obj = "mtllib a.mtl\nusemtl leaf\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let mtl = "newmtl leaf\nKd 0.25 0.5 0.25\nd 1\nmap_d disc.png\n";
    let folder = Folder::new().with("a.obj", obj).with("a.mtl", mtl).with("disc.png", disc());
    let s = folder.scene(&mesh("a.obj", ""));
    assert!((covered_area(&s) / (PI * 0.09) - 1.0).abs() < 0.01, "{}", covered_area(&s));
    let missing = Folder::new().with("a.obj", obj).with("a.mtl", mtl).scene(&mesh("a.obj", ""));
    assert!(
        area(&missing) == 1.0 && notes(&missing).contains("no picture 'disc.png'"),
        "{}",
        notes(&missing)
    );
}

#[test]
fn transparent_materials_of_obj_files_are_panes() {
    let obj = "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let scene = |mtl: &str| {
        let mtl = format!("newmtl m\nKd 0.2 0.4 0.6\n{mtl}\n");
        Folder::new().with("a.obj", obj).with("a.mtl", mtl).scene(&mesh("a.obj", ""))
    };
    for (mtl, transmittance, albedo) in [
        ("d 0.25", [0.75; 3], [0.2, 0.4, 0.6]),
        ("Tr 0.75", [0.75; 3], [0.2, 0.4, 0.6]),
        ("Tr 0\nd 0.25", [0.75; 3], [0.2, 0.4, 0.6]),
        ("illum 7\nTf 0.1 0.2 0.3", [0.1, 0.2, 0.3], [0.0; 3]),
    ] {
        let s = scene(mtl);
        let [pane] = s.panes() else { panic!("{mtl}: {} panes", s.panes().len()) };
        let found = pane.extinction.map(|k| (-k * pane.thickness).exp());
        assert!((found - Bands::from_rgb(transmittance)).abs().max_element() < 1e-12, "{mtl}: {found:?}");
        assert!(
            (pane.albedo - Bands::from_rgb(albedo)).abs().max_element() < 1e-12,
            "{mtl}: {:?}",
            pane.albedo
        );
    }
    for opaque in ["d 1", "Tr 0", "Tr 1", "illum 2\nTf 1 1 1", "d 1\nTr 0.5"] {
        let s = scene(opaque);
        assert!(s.panes().is_empty() && area(&s) == 1.0, "{opaque}");
    }
    let mirror = scene("illum 5\nKs 0.9 0.9 0.9");
    assert!(notes(&mirror).contains("specular reflectance (Ks, illum 5)"), "{}", notes(&mirror));
    assert!(!notes(&scene("illum 2\nKs 0.9 0.9 0.9")).contains("specular"));
}
