//! Scenes of published tables and pictures, and z-scores of two sets of means.
//!
//! Shared by the example `path_tracer` and the tests of the crate `reference`.

use std::path::Path;
use zonal_io::{input, output};
use zonal_math::{Vec3, vec3};
use zonal_reference::SampleEstimate;
use zonal_reference::path_tracer::Detector;
use zonal_scene::{Bands, Camera, Facet, Plate, Scene, SceneParts, Sides, Surface, VoxelGrid};

/// Any error, in a sentence.
pub(crate) type Error = Box<dyn std::error::Error>;

/// A unit cube of `reference/montecarlo`.
pub(crate) struct TableCube {
    /// Short name.
    pub name: &'static str,
    /// File without its ending.
    pub file: &'static str,
    albedo: f64,
    rho: f64,
    hot: f64,
    gas: f64,
    /// A diffuse box stands inside.
    pub block: bool,
}

const BASE_CUBE: TableCube =
    TableCube { name: "", file: "", albedo: 0.5, rho: 0.5, hot: 1.0, gas: 0.0, block: false };

/// The cubes.
pub(crate) const CUBES: [TableCube; 7] = [
    TableCube { name: "c0", file: "c0_K1_a0.90_r0.5", albedo: 0.9, ..BASE_CUBE },
    TableCube { name: "c1", file: "c1_K0.1_a0_r0", albedo: 0.0, rho: 0.0, ..BASE_CUBE },
    TableCube { name: "c3", file: "c3_K1_a0.50_r0", rho: 0.0, ..BASE_CUBE },
    TableCube { name: "c5", file: "c5_K5_a0.50_r0.5", ..BASE_CUBE },
    TableCube { name: "c8", file: "c8_het_a0.90_r0.5", albedo: 0.9, ..BASE_CUBE },
    TableCube { name: "c9", file: "c9_occ_K1_a0.50_r0.5", block: true, ..BASE_CUBE },
    TableCube { name: "c10", file: "c10_emitting_K1_a0.50_r0.5", hot: 0.0, gas: 1.0, ..BASE_CUBE },
];

/// Cells of the tables along an edge.
pub(crate) const CELLS: usize = 10;
/// Cells of the table on a face of the block.
pub(crate) const BLOCK_CELLS: usize = 4;
const BLOCK_CORNERS: (Vec3, Vec3) = (vec3(0.4, 0.3, 0.2), vec3(0.7, 0.6, 0.6));

fn surface(name: &str, rho: f64, emission: f64) -> Surface {
    Surface {
        name: name.into(),
        reflectance: Bands::splat(rho),
        emission: Bands::splat(emission),
        reflectance_texture: None,
        emission_texture: None,
        transmission: None,
        sides: Sides::Front,
        patch_size: None,
        solid: false,
    }
}

/// Cell (i, j) of n × n on face `wall` (x0, x1, y0, …) of a box, and the unit normal that points inward, or outward.
fn face(lo: Vec3, hi: Vec3, wall: usize, cell: [usize; 2], n: usize, inward: bool) -> (Plate, Vec3) {
    let (axis, upper) = (wall / 2, wall % 2 == 1);
    let others = [0, 1, 2].map(|k| (k != axis).then_some(k));
    let [a, b] = [others.iter().flatten().next(), others.iter().flatten().nth(1)].map(|k| *k.unwrap_or(&0));
    let size = hi - lo;
    let mut origin = lo.array();
    origin[axis] = if upper { hi[axis] } else { lo[axis] };
    let edge = |k: usize| {
        let mut e = [0.0; 3];
        e[k] = size[k] / n as f64;
        Vec3::from_array(e)
    };
    let origin = Vec3::from_array(origin) + edge(a) * cell[0] as f64 + edge(b) * cell[1] as f64;
    let mut normal = [0.0; 3];
    normal[axis] = if upper == inward { -1.0 } else { 1.0 };
    let normal = Vec3::from_array(normal);
    let plate = Plate::parallelogram(origin, edge(a), edge(b));
    (if plate.normal().dot(normal) > 0.0 { plate } else { plate.flipped() }, normal)
}

fn at(i: usize, n: usize) -> [usize; 3] {
    [i / (n * n), i / n % n, i % n]
}

impl TableCube {
    /// The scene, with the extinction of each cell.
    pub(crate) fn scene(&self, extinction: &[f64]) -> Result<Scene, Error> {
        let names = ["x0", "x1", "y0", "y1", "z0", "z1"];
        let mut surfaces: Vec<Surface> =
            (0..6).map(|k| surface(names[k], self.rho, if k == 0 { self.hot } else { 0.0 })).collect();
        let whole = |lo, hi, k, inward| face(lo, hi, k, [0, 0], 1, inward).0;
        let facet = |surface, plate| Facet { surface, plate, uv: [[0.0; 2]; 3] };
        let mut facets: Vec<Facet> =
            (0..6).map(|k| facet(k, whole(Vec3::ZERO, Vec3::ONE, k, true))).collect();
        if self.block {
            surfaces.push(surface("block", 0.5, 0.0));
            facets.extend((0..6).map(|k| facet(6, whole(BLOCK_CORNERS.0, BLOCK_CORNERS.1, k, false))));
        }
        let mut map = VoxelGrid::new(Vec3::ZERO, Vec3::splat(1.0 / CELLS as f64), [CELLS; 3])?;
        for (i, k) in extinction.iter().enumerate() {
            map.set(i, Bands::splat(*k), Bands::splat(self.albedo), Bands::splat(self.gas), Bands::ZERO);
        }
        let camera = Camera {
            name: "inside".into(),
            origin: vec3(0.9, 0.9, 0.8),
            target: vec3(0.1, 0.3, 0.2),
            up: vec3(0.0, 0.0, 1.0),
            fov: 75.0,
            lens: Default::default(),
        };
        let parts = SceneParts {
            name: self.name.into(),
            surfaces,
            facets,
            voxel_grid: Some(map.seal()?),
            cameras: vec![camera],
            ..SceneParts::default()
        };
        Ok(Scene::new(parts)?)
    }

    /// The scene, with the extinction of its table.
    pub(crate) fn read(&self, folder: &Path) -> Result<Scene, Error> {
        self.scene(&self.table(folder, "sigma_t")?)
    }

    /// An array of the table.
    pub(crate) fn table(&self, folder: &Path, name: &str) -> Result<Vec<f64>, Error> {
        Ok(output::read_array(&folder.join(format!("{}.npz", self.file)), name)?.1)
    }
}

/// Entry k of the tables: H on the walls, H on the block, G.
pub(crate) fn receiver(quantity: &str, k: usize) -> Detector {
    let on = |lo, hi, n, inward| {
        let (plate, normal) = face(lo, hi, k / (n * n), [k / n % n, k % n], n, inward);
        Detector::Patch { plate, normal }
    };
    match quantity {
        "H" => on(Vec3::ZERO, Vec3::ONE, CELLS, true),
        "Hocc" => on(BLOCK_CORNERS.0, BLOCK_CORNERS.1, BLOCK_CELLS, false),
        _ => {
            let step = 1.0 / CELLS as f64;
            let lo = Vec3::from_array(at(k, CELLS).map(|i| i as f64 * step));
            Detector::Cell { lo, hi: lo + Vec3::splat(step) }
        }
    }
}

const WHITE_REFLECTANCE: &str = "[0.885809, 0.698859, 0.666422]";
const RED_REFLECTANCE: &str = "[0.570068, 0.0430135, 0.0443706]";
const GREEN_REFLECTANCE: &str = "[0.105421, 0.37798, 0.076425]";
/// Radiance of the lamp of the Cornell box.
const LAMP_RADIANCE: [f64; 3] = [18.387, 13.9873, 6.75357];

/// The Cornell boxes of `mitsuba-refs`: name and medium.
pub(crate) const CORNELL_CASES: [&str; 4] =
    ["cbox_vacuum", "cbox_homog_st0.002_a08", "cbox_homog_st0.001_argb", "cbox_smoke"];

/// The upper rows of Mitsuba's `cbox_smoke` that are not compared. A band under the ceiling is dark in it, 0.03 beside 0.11, where
/// the way to the lamp cuts an upper edge of the medium's box; the smoke has no density there, so nothing can cast that shadow, and
/// walks that ask every facet see none either.
pub(crate) const SMOKE_ROWS: usize = 40;

/// One of [`CORNELL_CASES`] from the folder `data`.
pub(crate) fn cornell(name: &str, data: &Path) -> Result<Scene, Error> {
    let meshes = data.join("cornell/mitsuba-cbox/meshes");
    let mut t = format!("name = \"{name}\"\n");
    let mut walls = vec![
        ("back", WHITE_REFLECTANCE),
        ("ceiling", WHITE_REFLECTANCE),
        ("floor", WHITE_REFLECTANCE),
        ("greenwall", GREEN_REFLECTANCE),
        ("redwall", RED_REFLECTANCE),
    ];
    if name != "cbox_smoke" {
        walls.extend([("smallbox", WHITE_REFLECTANCE), ("largebox", WHITE_REFLECTANCE)]);
    }
    for (wall, rho) in walls {
        let file = meshes.join(format!("cbox_{wall}.obj"));
        t += &format!(
            "[[surface]]\nname = \"{wall}\"\nmesh = {{ file = {:?} }}\nsolid = false\nsides = \"both\"\nreflectance = {rho}\n",
            file.display().to_string()
        );
    }
    let e = LAMP_RADIANCE.map(|l| l * std::f64::consts::PI);
    t += &format!(
        "[[surface]]\nname = \"lamp\"\nmesh = {{ file = {:?}, translate = [0, -0.5, 0] }}\nreflectance = {WHITE_REFLECTANCE}\nsides = \"front\"\nemission = {e:?}\n",
        meshes.join("cbox_luminaire.obj").display().to_string()
    );
    t += "[[camera]]\nname = \"front\"\norigin = [278, 273, -800]\ntarget = [278, 273, -799]\nup = [0, 1, 0]\nfov = 39.3077\n";
    let haze = |extinction: &str, albedo: &str| {
        format!(
            "[medium]\nmin = [-2, -1.6, -0.4]\nmax = [558, 550.4, 559.6]\ncells = [1, 1, 1]\nextinction = {extinction}\nalbedo = {albedo}\n"
        )
    };
    match name {
        "cbox_homog_st0.002_a08" => t += &haze("0.002", "0.8"),
        "cbox_homog_st0.001_argb" => t += &haze("0.001", "[0.95, 0.6, 0.3]"),
        _ => {}
    }
    let scene = input::parse_scene(&t, Some(data), name)?;
    if name != "cbox_smoke" {
        return Ok(scene);
    }
    let mut parts = scene.into_parts();
    parts.voxel_grid = Some(smoke(&data.join("smoke-vdb/smoke_28x56x29.vol"))?);
    Ok(Scene::new(parts)?)
}

/// The smoke of `cbox_smoke`: a grid of Mitsuba (VOL 3: float32, x fastest), nearest cell, scaled by 0.01 per millimetre.
fn smoke(file: &Path) -> Result<VoxelGrid, Error> {
    let bytes = std::fs::read(file)?;
    let word = |k: usize| -> Result<[u8; 4], Error> {
        Ok(bytes.get(k..k + 4).ok_or("the volume is cut short")?.try_into()?)
    };
    if !bytes.starts_with(b"VOL\x03") || i32::from_le_bytes(word(4)?) != 1 {
        return Err(format!("{}: not a volume of floats", file.display()).into());
    }
    let mut dims = [0usize; 3];
    for (k, d) in dims.iter_mut().enumerate() {
        *d = usize::try_from(i32::from_le_bytes(word(8 + 4 * k)?))?;
    }
    let (lo, hi) = (vec3(141.0, 5.0, 145.0), vec3(411.0, 535.0, 415.0));
    let count = vec3(dims[0] as f64, dims[1] as f64, dims[2] as f64);
    let edge = Vec3::from_array([0, 1, 2].map(|k| (hi[k] - lo[k]) / count[k]));
    let mut map = VoxelGrid::new(lo, edge, dims)?;
    for i in 0..map.len() {
        let [x, y, z] = map.coordinates(i);
        let k = (z * dims[1] + y) * dims[0] + x;
        let density = f64::from(f32::from_le_bytes(word(48 + 4 * k)?));
        map.set(i, Bands::splat(0.01 * density), Bands::splat(0.9), Bands::ZERO, Bands::ZERO);
    }
    Ok(map.seal()?)
}

/// The arcade of `mitsuba-refs/sponza_haze_st0.02_a09`.
pub(crate) fn sponza(data: &Path) -> Result<Scene, Error> {
    let file = data.join("sponza-dabrovic/sponza-dabrovic.glb");
    let t = format!(
        "name = \"sponza\"\n[[surface]]\nname = \"hall\"\nmesh = {{ file = {:?} }}\nsolid = false\nsides = \"both\"\nreflectance = 0.7\n\
         [[surface]]\nname = \"sky\"\nrectangle = {{ origin = [-12, 15.2, -3], edge1 = [24, 0, 0], edge2 = [0, 0, 6] }}\nreflectance = 0\nemission = {}\nsides = \"front\"\n\
         [medium]\nmin = [-17.413, -0.917, -7.809]\nmax = [17.427, 15.663, 7.811]\ncells = [1, 1, 1]\nextinction = 0.02\nalbedo = 0.9\n\
         [[camera]]\nname = \"aisle\"\norigin = [-13, 1.7, 0]\ntarget = [12, 5, 0]\nup = [0, 1, 0]\nfov = 75\n",
        file.display().to_string(),
        10.0 * std::f64::consts::PI
    );
    Ok(input::parse_scene(&t, Some(data), "sponza")?)
}

/// Differences in standard errors: their mean, root mean square and largest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ZScores {
    /// How many.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// Largest modulus.
    pub max: f64,
    /// Sum of ours over sum of theirs, less 1.
    pub bias: f64,
}

impl ZScores {
    /// Compares pairs of means; those without any error on their side are passed over.
    pub(crate) fn new(pairs: impl Iterator<Item = (SampleEstimate, SampleEstimate)>) -> ZScores {
        let (mut s, mut sums) = (ZScores::default(), [0.0; 2]);
        for (ours, theirs) in pairs.filter(|p| p.1.error > 0.0) {
            let z = (ours.value - theirs.value) / ours.error.hypot(theirs.error);
            s.n += 1;
            s.mean += z;
            s.rms += z * z;
            s.max = s.max.max(z.abs());
            sums = [sums[0] + ours.value, sums[1] + theirs.value];
        }
        let n = s.n.max(1) as f64;
        (s.mean, s.rms, s.bias) = (s.mean / n, (s.rms / n).sqrt(), sums[0] / sums[1] - 1.0);
        s
    }
}

/// Blocks of `size` × `size` pixels of a picture `width` across in one band, each with the standard error of its mean.
pub(crate) fn blocks(mean: &[f64], error: &[f64], width: usize, size: usize) -> Vec<SampleEstimate> {
    let (across, down) = (width / size, mean.len() / width / size);
    let block = |k: usize| {
        let first = (k / across * width + k % across) * size;
        let pixels = (0..size * size).map(|p| first + p / size * width + p % size);
        let n = (size * size) as f64;
        let (sum, squares) = pixels.fold((0.0, 0.0), |s, p| (s.0 + mean[p], s.1 + error[p] * error[p]));
        SampleEstimate { value: sum / n, error: squares.sqrt() / n }
    };
    (0..across * down).map(block).collect()
}
