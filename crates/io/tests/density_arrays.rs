//! Densities and meshes in the voxel grid.

use crate::support;

use std::path::Path;
use support::{CUBE, Folder, NpyOrder, f32s, npy};
use zonal_io::input::parse_scene;
use zonal_scene::Bands;

fn total(s: &zonal_scene::Scene) -> f64 {
    let v = s.voxel_grid().unwrap();
    (0..v.len()).map(|i| v.extinction(i).first()).sum::<f64>() * v.cell().product()
}

/// The value at (i, j, k) of a 2 × 3 × 4 array.
fn value(i: usize, j: usize, k: usize) -> f32 {
    (1 + i + 2 * j + 6 * k) as f32
}

fn elements(order: NpyOrder) -> Vec<f32> {
    let mut out = Vec::new();
    match order {
        NpyOrder::C => {
            (0..2).for_each(|i| (0..3).for_each(|j| (0..4).for_each(|k| out.push(value(i, j, k)))))
        }
        NpyOrder::Fortran => {
            (0..4).for_each(|k| (0..3).for_each(|j| (0..2).for_each(|i| out.push(value(i, j, k)))))
        }
    }
    out
}

#[test]
fn all_element_types_and_orders_read_equal() {
    for order in [NpyOrder::C, NpyOrder::Fortran] {
        let values = elements(order);
        let files: Vec<(&str, Vec<u8>)> = vec![
            ("<f4", f32s(&values)),
            (">f4", values.iter().flat_map(|v| v.to_be_bytes()).collect()),
            ("<f8", values.iter().flat_map(|v| (*v as f64).to_le_bytes()).collect()),
            ("|u1", values.iter().map(|v| *v as u8).collect()),
            ("|i1", values.iter().map(|v| *v as u8).collect()),
            ("<i2", values.iter().flat_map(|v| (*v as i16).to_le_bytes()).collect()),
            (">u4", values.iter().flat_map(|v| (*v as u32).to_be_bytes()).collect()),
            ("<i8", values.iter().flat_map(|v| (*v as i64).to_le_bytes()).collect()),
        ];
        for (descr, data) in files {
            let folder = Folder::new().with("d.npy", npy(descr, order, "(2, 3, 4)", &data));
            let s = folder.scene(
                "[medium]\nmin=[0,0,0]\nmax=[2,3,4]\ncell_size=1\n[[medium.region]]\n\
                 density={file='d.npy',min=[0,0,0],max=[2,3,4],scale=[1,2,0]}\nalbedo=0.5\nsource=3\n",
            );
            let v = s.voxel_grid().unwrap();
            for i in 0..v.len() {
                let [x, y, z] = v.coordinates(i);
                let k = value(x, y, z) as f64;
                assert_eq!(v.extinction(i), Bands::from_rgb([k, 2.0 * k, 0.0]), "{descr} {order:?}");
                assert_eq!((v.albedo(i), v.source(i)), (Bands::splat(0.5), Bands::from_rgb([3.0, 3.0, 0.0])));
            }
        }
    }
}

#[test]
fn resampling_conserves_the_integral() {
    let folder =
        Folder::new().with("d.npy", npy("<f4", NpyOrder::C, "(2, 3, 4)", &f32s(&elements(NpyOrder::C))));
    let wanted: f64 = elements(NpyOrder::C).iter().map(|v| f64::from(*v)).sum::<f64>() * 0.5 * 0.5 * 0.25;
    for cells in ["[1,1,1]", "[3,5,7]", "[16,2,9]", "[40,40,40]"] {
        let s = folder.scene(&format!(
            "[medium]\nmin=[-0.1,-0.2,-0.3]\nmax=[1.3,1.7,1.9]\ncells={cells}\n[[medium.region]]\n\
             density={{file='d.npy',min=[0,0,0],max=[1,1.5,1]}}\n"
        ));
        assert!((total(&s) / wanted - 1.0).abs() < 1e-12, "{cells}: {} {wanted}", total(&s));
    }
}

#[test]
fn shared_smoke_conserves_its_integral() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/smoke-vdb");
    if !data.exists() {
        println!("skipped: {} is missing", data.display());
        return;
    }
    let text = "[medium]\nmin=[0,0,0]\nmax=[5.6,11.2,5.7]\ncells=[14,28,13]\n[[medium.region]]\n\
                density={file='smoke_56x112x57_f16.npy',min=[0,0,0],max=[5.6,11.2,5.7]}\n";
    let s = parse_scene(text, Some(&data), "smoke.toml").unwrap_or_else(|e| panic!("{e}"));
    // The array holds means over 2³ cells of a grid with this sum; each of its cells is 0.1 m wide; half floats round.
    let wanted = 171_499.695_5 / 8.0 * 1e-3;
    assert!((total(&s) / wanted - 1.0).abs() < 1e-3, "{} {wanted}", total(&s));
}

#[test]
fn closed_meshes_fill_interior_cells() {
    let folder = Folder::new().with("cube.obj", CUBE);
    let s = folder.scene(
        "[medium]\nmin=[0,0,0]\nmax=[4,4,4]\ncells=[8,8,8]\nextinction=0.125\n[[medium.region]]\n\
         mesh={file='cube.obj',scale=2,translate=[1,1,0.5]}\nextinction=2\nemission=7\n",
    );
    let v = s.voxel_grid().unwrap();
    for i in 0..v.len() {
        let c = v.centre(v.coordinates(i));
        let inside = (1.0..3.0).contains(&c.x) && (1.0..3.0).contains(&c.y) && (0.5..2.5).contains(&c.z);
        assert_eq!(v.extinction(i), Bands::splat(if inside { 2.0 } else { 0.125 }), "{c:?}");
        assert_eq!(v.emission(i).first(), if inside { 7.0 } else { 0.0 });
    }
}

/// Extinctions of the cells along x of a medium of 2 m × 1 m × 1 m in `cells` × 1 × 1 cells with a density of these values along x.
fn along_x(values: &[f64], cells: usize, keys: &str) -> Vec<f64> {
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let shape = format!("({}, 1, 1)", values.len());
    let folder = Folder::new().with("d.npy", npy("<f8", NpyOrder::C, &shape, &data));
    let s = folder.scene(&format!(
        "[medium]\nmin=[0,0,0]\nmax=[2,1,1]\ncells=[{cells},1,1]\n[[medium.region]]\ndensity={{file='d.npy',min=[0,0,0],max=[2,1,1]{keys}}}\n"
    ));
    let v = s.voxel_grid().unwrap();
    assert!((0..v.len()).all(|i| v.is_interpolated(i) != keys.contains("constant")));
    (0..v.len()).map(|i| v.extinction(i).first()).collect()
}

#[test]
fn cells_have_the_mean_of_the_trilinear_field() {
    // 1 up to x = 0.5, 3 from x = 1.5, linear between; cells of 0.25 m.
    let found = along_x(&[1.0, 3.0], 8, "");
    for (k, wanted) in [1.0, 1.0, 1.25, 1.75, 2.25, 2.75, 3.0, 3.0].iter().enumerate() {
        assert!((found[k] - wanted).abs() < 1e-14, "{found:?}");
    }
    // Samples finer than the cells: the mean of a hat function of height 4 and width 1/2 about x = 0.875.
    let found = along_x(&[0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0], 2, "");
    assert!((found[0] - 0.875).abs() < 1e-14 && (found[1] - 0.125).abs() < 1e-14, "{found:?}");
    assert_eq!(along_x(&[1.0, 3.0], 8, ",interpolation='constant'"), [[1.0; 4], [3.0; 4]].concat());
    // Elements that are the cells keep their values.
    assert_eq!(along_x(&[1.0, 3.0, 0.5], 3, ""), [1.0, 3.0, 0.5]);
}

#[test]
fn double_precision_is_kept() {
    let values = [0.1, 1.0 / 3.0, 1.2];
    assert_eq!(along_x(&values, 3, ""), values);
    let halves = along_x(&values, 6, ",interpolation='constant'");
    assert!(halves.iter().enumerate().all(|(k, v)| (v / values[k / 2] - 1.0).abs() < 1e-15), "{halves:?}");
}

#[test]
fn a_box_over_a_density_has_its_own_borders() {
    let folder =
        Folder::new().with("d.npy", npy("<f4", NpyOrder::C, "(2, 3, 4)", &f32s(&elements(NpyOrder::C))));
    let s = folder.scene(
        "[medium]\nmin=[0,0,0]\nmax=[2,3,4]\ncell_size=0.5\n[[medium.region]]\ndensity={file='d.npy',min=[0,0,0],max=[2,3,4]}\n\
         [[medium.region]]\nbox={min=[0,0,0],max=[1,1,1]}\nextinction=5\n",
    );
    let v = s.voxel_grid().unwrap();
    for i in 0..v.len() {
        let c = v.centre(v.coordinates(i));
        assert_eq!(v.is_interpolated(i), c.x > 1.0 || c.y > 1.0 || c.z > 1.0, "{c:?}");
    }
    let refused = "[medium]\nmin=[0,0,0]\nmax=[2,3,4]\ncell_size=0.5\nextinction=1\nalbedo={file='d.npy',interpolation='linear'}\n";
    assert!(folder.refusal(refused).contains("interpolation"));
}
