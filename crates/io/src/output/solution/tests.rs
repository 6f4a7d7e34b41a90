//! Solution files: round trips, damaged and hostile files.

use super::header::encode_header;
use super::{read_solution, write_solution};
use crate::output::npz::npy::{ElementType, header};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use zonal_math::{Grade, Vec3, vec3};
use zonal_scene::{
    BandFractions, Bands, Camera, ClosureDefect, Diagnostic, DiscretizationError, EnergyBalance,
    ErrorEstimate, ErrorParts, FaceMesh, FaceTable, Facet, FacetValues, Fields, HeatReport, HeatRow,
    HeatRowKind, Lens, Light, LightGroup, LightGroupKind, Pane, PaneZone, Patch, PerBand, Plate, Report,
    Scene, SceneParts, Sides, Solution, SolveOptions, SolveStatus, Surface, Surroundings, Texture, Thermal,
    ThermalCondition, ThermalFields, VolumeSample, VoxelGrid, VoxelPlace, VoxelSamples, VoxelZones,
    ZoneValues, Zones,
};
use zonal_scene::{Convection, LinkLaw, NodeCondition, NodeLink, NodeResult, ThermalNetwork, ThermalNode};
use zonal_scene::{IntensityDistribution, IntensityTable, PlaneSymmetry, SkyDistribution, SkyPlacement};

pub(super) fn folder(name: &str) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("zonal-{name}-{}", std::process::id()));
    fs::create_dir_all(&dir).unwrap();
    dir
}

fn voxel_grid() -> VoxelGrid {
    let mut voxel_grid = VoxelGrid::new(Vec3::ZERO, Vec3::splat(0.5), [2, 3, 4]).unwrap();
    for i in 0..24 {
        let (extinction, albedo) =
            (Bands::from_rgb([0.1 * i as f64, 0.2, 0.0]), Bands::from_rgb([0.5, 0.25, 1.0]));
        voxel_grid.set(i, extinction, albedo, Bands::ONE, Bands::ZERO);
    }
    voxel_grid.seal().unwrap()
}

/// A model of a sky and a picture.
fn varying_skies() -> [Light; 2] {
    [
        Light::Sky {
            name: "clear".into(),
            radiance: Bands::ONE,
            distribution: SkyDistribution::cie(
                12,
                SkyPlacement { sun: vec3(1.0, 0.2, 0.7), up: vec3(0.0, 0.0, 1.0), ground_reflectance: 0.2 },
            )
            .unwrap(),
        },
        Light::Sky {
            name: "picture".into(),
            radiance: Bands::splat(2.0),
            distribution: SkyDistribution::picture(
                Texture { width: 2, height: 1, pixels: vec![[0.25, 0.5, 1.0], [0.1, 0.2, 0.3]] },
                vec3(0.1, 1.0, 0.2),
                0.3,
            )
            .unwrap(),
        },
    ]
}

fn lights() -> Vec<Light> {
    vec![
        Light::Sun {
            name: "sun".into(),
            direction: vec3(0.0, 0.6, -0.8),
            irradiance: Bands::from_rgb([1.0, 2.0, 3.0]),
            angular_diameter: 0.0093,
        },
        Light::Sky {
            name: "sky".into(),
            radiance: Bands::from_rgb([0.1, 0.2, 0.4]),
            distribution: SkyDistribution::uniform(),
        },
        Light::Point {
            name: "spot".into(),
            position: vec3(0.1, 0.2, 1.0 / 3.0),
            intensity: Bands::from_rgb([1.0, 2.0, 1.0 / 3.0]),
            distribution: IntensityDistribution::spot(vec3(0.1, 0.3, -0.7), [0.1, 1.0 / 3.0]),
        },
        Light::Point {
            name: "luminaire".into(),
            position: vec3(0.1, 0.2, 0.3),
            intensity: Bands::ONE,
            distribution: IntensityDistribution::table(
                IntensityTable::new(
                    &[0.0, 70.0, 90.0],
                    &[0.0, 33.3, 90.0],
                    &[1.0, 0.7, 0.1, 1.0, 0.6, 0.2, 1.0, 1.0 / 3.0, 0.0],
                    PlaneSymmetry::Quadrants,
                )
                .unwrap(),
                vec3(0.1, 0.3, -0.7),
                0.3,
            ),
        },
        Light::Emitter { surface: 1, name: Some("lamp".into()) },
    ]
}

fn scene() -> Scene {
    let surface = |name: &str, texture| Surface {
        name: name.into(),
        reflectance: Bands::from_rgb([0.5, 0.6, 0.7]),
        emission: Bands::from_rgb([0.0, 0.0, 1.0 / 3.0]),
        reflectance_texture: texture,
        emission_texture: None,
        transmission: None,
        sides: Sides::Both,
        patch_size: Some(0.1),
        solid: false,
    };
    let facet = |surface, plate| Facet { surface, plate, uv: [[0.0, 0.1], [1.0, 0.2], [0.3, 1.0]] };
    let square = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let triangle = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0));
    Scene::new(SceneParts {
        name: "Stube \"ä\"".into(),
        surfaces: vec![surface("floor", Some(0)), surface("lamp, old", None)],
        facets: vec![facet(0, square), facet(1, triangle)],
        faces: faces(),
        textures: vec![Texture { width: 2, height: 1, pixels: vec![[0.25, 0.5, 1.0], [0.1, 0.2, 0.3]] }],
        panes: vec![Pane {
            name: "glass".into(),
            plates: vec![square, triangle],
            thickness: 0.01,
            extinction: Bands::from_rgb([10.0, 20.0, 0.0]),
            albedo: Bands::splat(0.1),
            emission: Bands::ZERO,
        }],
        voxel_grid: Some(voxel_grid()),
        lights: lights(),
        periodic: [false; 3],
        symmetry_planes: [[true, false], [false; 2], [false; 2]],
        boundary_box: None,
        thermal: None,
        surroundings: Surroundings { radiance: Bands::splat(0.01), name: Some("sky".into()) },
        cameras: vec![Camera {
            name: "c".into(),
            origin: Vec3::ONE,
            target: Vec3::ZERO,
            up: vec3(0.0, 0.0, 1.0),
            fov: 60.0,
            lens: Lens { aperture: 0.02, focus: Some(3.5) },
        }],
        options: SolveOptions { patch_size: Some(0.25), ..SolveOptions::default() },
        notes: vec!["dropped 2 triangles".into()],
        ..SceneParts::default()
    })
    .unwrap()
}

/// A mesh of three faces, of which the second facet is the last, with a reflectance of its own.
fn faces() -> FaceTable {
    let meshes = vec![FaceMesh { name: "lamp, old".into(), faces: 3 }];
    let mut table = FaceTable { meshes, ..FaceTable::default() };
    table.push(
        1,
        2,
        FacetValues { reflectance: Some(Bands::from_rgb([0.1, 0.2, 0.3])), ..FacetValues::default() },
    );
    table
}

fn report() -> Report {
    Report {
        status: PerBand::from_rgb([SolveStatus::Converged, SolveStatus::Stalled, SolveStatus::MaxIterations]),
        residuals: PerBand::from_rgb([vec![0.1, 1e-11], vec![], vec![1.0 / 3.0]]),
        closure: ClosureDefect {
            worst: Bands::from_rgb([1e-3, 2e-3, 3e-3]),
            restored: true,
            ..ClosureDefect::default()
        },
        energy: EnergyBalance {
            emitted: Bands::from_rgb([1.0, 2.0, 3.0]),
            absorbed_surfaces: vec![("floor".into(), Bands::splat(0.1))],
            ..EnergyBalance::default()
        },
        energy_error: EnergyBalance {
            absorbed_surfaces: vec![("floor".into(), Bands::from_rgb([0.01, f64::INFINITY, 0.03]))],
            escaped: Bands::splat(f64::INFINITY),
            ..EnergyBalance::default()
        },
        heat: None,
        discretization_error: None,
        counts: vec![("pairs".into(), 1 << 60), ("rays".into(), 7)],
        warnings: vec!["open".into(), Diagnostic::warning("heat-balance", "off").at("surface 'a'")],
        grade: Grade::Estimated,
        engine: "rays".into(),
        reason: "many zones".into(),
        estimate: ErrorEstimate {
            patches: Bands::from_rgb([0.01, 0.02, 0.03]),
            volumes: Bands::splat(0.1),
            grade: Grade::Statistical,
            parts: Some([
                ErrorParts {
                    sampling: 0.1,
                    radiosities: 0.02,
                    direct: 0.03,
                    zoning: 0.04,
                    zoning_removed: 0.0,
                },
                ErrorParts { zoning_removed: 0.5, ..ErrorParts::default() },
            ]),
        },
    }
}

fn zones(scene: &Scene) -> Zones {
    let facet = |i: usize| scene.facets()[i].plate;
    let patch = |i: usize| Patch {
        facet: i,
        surface: i,
        plate: facet(i),
        normal: facet(i).normal(),
        area: facet(i).area(),
        reflectance: Bands::splat(0.5),
        emission: Bands::splat(0.25),
    };
    let map = scene.voxel_grid().unwrap();
    let voxel = |cell: usize, samples: Vec<VolumeSample>| VoxelPlace {
        cell,
        centre: Vec3::splat(0.25),
        volume: 0.125,
        samples: VoxelSamples::new(map.corner(map.coordinates(cell)), map.cell(), 0.125, &samples),
    };
    let sample = |subcell| VolumeSample { point: Vec3::splat(0.1), volume: 0.01, subcell };
    let places = [voxel(0, vec![]), voxel(2, vec![sample(1), sample(63)]), voxel(2, vec![sample(5)])];
    let mut voxels = VoxelZones::new(map, places);
    voxels.update_extinction(|_, _| Bands::splat(0.1));
    voxels.update_albedo(|_, _| Bands::splat(0.5));
    voxels.update_emission(|i, _| Bands::splat(i as f64));
    voxels.update_source(|_, _| Bands::ZERO);
    Zones {
        patches: vec![patch(0), patch(1)],
        voxels,
        panes: vec![PaneZone {
            pane: 0,
            plate: facet(0),
            normal: facet(0).normal(),
            area: 1.0,
            thickness: 0.01,
            extinction: Bands::from_rgb([10.0, 20.0, 0.0]),
            albedo: Bands::splat(0.1),
            emission: Bands::ZERO,
        }],
        ..Zones::default()
    }
}

fn solution() -> Solution {
    let scene = scene();
    let zones = zones(&scene);
    let value = |s: f64, i: usize| Bands::from_rgb([s / 3.0, i as f64 * s, 1e-300]);
    let field = |s: f64| (0..zones.len()).map(|i| value(s, i)).collect::<Vec<_>>();
    Solution {
        further_blocks: Vec::new(),
        fields: Fields {
            radiosity: field(1.0),
            incident: field(2.0),
            direct: field(3.0),
            error: field(0.01),
            direct_error: field(0.004),
            surroundings_error: field(0.002),
            heat: None,
        },
        groups: vec![
            LightGroup {
                name: "sun".into(),
                kind: LightGroupKind::Light(0),
                incident: ZoneValues::Double(field(0.5)),
                direct: ZoneValues::to_single_precision(&field(3.0)).0,
                direct_scale: Bands::from_rgb([1.0 / 3.0, 2.0, 1e-300]),
                energy: EnergyBalance {
                    incoming: Bands::from_rgb([1.0, 2.0, 3.0]),
                    ..EnergyBalance::default()
                },
                residual: Bands::from_rgb([0.1, 0.2, 1e-11]),
                error: ZoneValues::Double(field(0.003)),
                direct_error: ZoneValues::Double(field(0.004)),
                ..LightGroup::default()
            },
            LightGroup {
                name: "floor = 2".into(),
                incident: ZoneValues::Double(field(1.5)),
                ..LightGroup::default()
            },
        ],
        scene_hash: crate::output::scene_hash(&scene),
        version: "0.1.0".into(),
        report: report(),
        zones,
        scene,
    }
}

/// The header of a solution.
pub(super) fn document(s: &Solution) -> serde_json::Value {
    encode_header(s)
}

fn assert_same(a: &Solution, b: &Solution) {
    assert_eq!(a.zones, b.zones);
    assert_eq!(a.fields, b.fields);
    assert_eq!(a.groups, b.groups);
    assert_eq!(a.report, b.report);
    assert_eq!((&a.scene_hash, &a.version), (&b.scene_hash, &b.version));
    let (p, q) = (a.scene.clone().into_parts(), b.scene.clone().into_parts());
    assert_eq!(format!("{p:?}"), format!("{q:?}"));
    assert_eq!(crate::output::scene_hash(&a.scene), crate::output::scene_hash(&b.scene));
}

// Guards (files): a solution survives its file to the bit.
#[test]
fn a_solution_round_trips_to_the_bit() {
    let dir = folder("solution");
    let path = dir.join("a.npz");
    let s = solution();
    write_solution(&path, &s).unwrap();
    let once = fs::read(&path).unwrap();
    let back = read_solution(&path).unwrap();
    assert_same(&s, &back);
    write_solution(&path, &back).unwrap();
    assert_eq!(once, fs::read(&path).unwrap(), "the bytes are deterministic");
    crate::output::write_zones_csv(dir.join("a.csv"), &s).unwrap();
    let table = fs::read_to_string(dir.join("a.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + s.zones.len());
    assert!(table.contains("\"lamp, old\""));
    fs::remove_dir_all(&dir).unwrap();
}

/// In a scene with symmetry planes a sky is uniform, so that those that vary have a scene without.
#[test]
fn skies_that_vary_round_trip() {
    let dir = folder("skies");
    let mut s = solution();
    let mut parts = s.scene.into_parts();
    (parts.symmetry_planes, parts.lights) = ([[false; 2]; 3], [lights(), varying_skies().to_vec()].concat());
    s.scene = Scene::new(parts).unwrap();
    s.scene_hash = crate::output::scene_hash(&s.scene);
    write_solution(dir.join("a.npz"), &s).unwrap();
    assert_same(&s, &read_solution(dir.join("a.npz")).unwrap());
    fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn the_scene_hash_depends_on_numbers_and_not_on_names_or_cameras() {
    let parts = scene().into_parts();
    let hash = |p: &SceneParts| crate::output::scene_hash(&Scene::new(p.clone()).unwrap());
    let (mut named, mut moved) = (parts.clone(), parts.clone());
    named.cameras.clear();
    named.name.clear();
    moved.facets[0].plate.origin.x += 1e-12;
    assert_eq!(hash(&parts), hash(&named));
    assert_ne!(hash(&parts), hash(&moved));
    assert_eq!(hash(&parts).len(), 64);
}

// Guards (files): no file makes the program panic.
#[test]
fn truncated_and_flipped_files_are_refused_without_a_panic() {
    let dir = folder("hostile");
    let path = dir.join("a.npz");
    write_solution(&path, &solution()).unwrap();
    let bytes = fs::read(&path).unwrap();
    for cut in (0..bytes.len()).step_by(389) {
        fs::write(&path, &bytes[..cut]).unwrap();
        let e = read_solution(&path).unwrap_err().to_string();
        assert!(e.contains("a.npz") && !e.contains('\n'), "{e}");
    }
    for i in (0..bytes.len()).step_by(19) {
        let mut hurt = bytes.clone();
        hurt[i] ^= 1 << (i % 8);
        fs::write(&path, &hurt).unwrap();
        let _ = read_solution(&path);
    }
    fs::remove_dir_all(&dir).unwrap();
}

/// Rewrites the archive with one entry replaced.
pub(super) fn replace_entry(path: &Path, name: &str, data: &[u8], method: zip::CompressionMethod) {
    let mut old = zip::ZipArchive::new(fs::File::open(path).unwrap()).unwrap();
    let mut new = zip::ZipWriter::new(io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for i in 0..old.len() {
        let mut entry = old.by_index(i).unwrap();
        let mut bytes = Vec::new();
        io::copy(&mut entry, &mut bytes).unwrap();
        let entry_name = entry.name().unwrap().into_owned();
        let bytes = if entry_name == name { data.to_vec() } else { bytes };
        new.start_file(entry_name, options).unwrap();
        new.write_all(&bytes).unwrap();
    }
    fs::write(path, new.finish().unwrap().into_inner()).unwrap();
}

#[test]
fn errors_name_the_invalid_entry() {
    let dir = folder("wrong");
    let path = dir.join("a.npz");
    let check = |name: &str, data: Vec<u8>, says: &str| {
        for method in [zip::CompressionMethod::Stored, zip::CompressionMethod::Deflated] {
            write_solution(&path, &solution()).unwrap();
            replace_entry(&path, &format!("{name}.npy"), &data, method);
            let e = read_solution(&path).unwrap_err().to_string();
            assert!(e.contains(name) && e.contains(says), "{e}");
        }
    };
    let with = |mut head: Vec<u8>, data: &[u8]| {
        head.extend(data);
        head
    };
    let nan: Vec<u8> = (0..18).flat_map(|_| f64::NAN.to_le_bytes()).collect();
    check("radiosity", with(header(ElementType::F64, &[6, 3]), &nan), "finite");
    check("radiosity", with(header(ElementType::F64, &[1 << 60, 3]), &nan), "shape");
    check("radiosity", with(header(ElementType::F64, &[3, 6]), &nan[..0]), "cut short");
    check("group_1_incident", with(header(ElementType::F64, &[6, 3]), &nan), "finite");
    check("group_0_direct", with(header(ElementType::F32, &[5, 3]), &[0; 60]), "shape");
    check("voxel_source", with(header(ElementType::F64, &[2, 3]), &[0; 48]), "shape");
    let index: Vec<u8> = [0i64, -1].iter().flat_map(|n| n.to_le_bytes()).collect();
    check("patch_facet", with(header(ElementType::I64, &[2]), &index), "out of range");
    check("facet_kind", with(header(ElementType::U8, &[2]), &[1, 9]), "facet");
    check("voxel_part_first", with(header(ElementType::I64, &[4]), &[0; 32]), "cover");
    check("header.json", with(header(ElementType::U8, &[2]), b"{}"), "not a zonal solution");
    check("header.json", with(header(ElementType::U8, &[9]), b"[[[[[[[[["), "JSON");
    let other = br#"{"format":"zonal solution","format_version":99}"#;
    check("header.json", with(header(ElementType::U8, &[other.len()]), other), "99");
    let below: Vec<u8> = (0..18).flat_map(|_| (-1.0f64).to_le_bytes()).collect();
    check("error", with(header(ElementType::F64, &[6, 3]), &below), "below 0");
    let mut negative = document(&solution());
    negative["report"]["light_groups"][0]["incident_scale"] = serde_json::json!([1.0, -1.0, 1.0]);
    let negative = negative.to_string();
    let text = with(header(ElementType::U8, &[negative.len()]), negative.as_bytes());
    check("header.json", text, "incident_scale: a factor is below 0");
    fs::remove_dir_all(&dir).unwrap();
}

// Guards (files): no file makes the program allocate memory out of proportion to its size.
/// 148 KB of packed JSON once took 1.4 GB.
#[test]
fn json_larger_than_the_file_allows_is_refused_before_it_is_parsed() {
    let dir = folder("bomb");
    let path = dir.join("a.npz");
    let with = |text: String| [header(ElementType::U8, &[text.len()]), text.into_bytes()].concat();
    for (text, says) in [
        (format!("[{}0]", "0,".repeat(3_000_000)), "values, more than"),
        (format!("\"{}\"", "a".repeat(40 << 20)), "bytes, more than"),
    ] {
        write_solution(&path, &solution()).unwrap();
        replace_entry(&path, "header.json.npy", &with(text), zip::CompressionMethod::Deflated);
        assert!(fs::metadata(&path).unwrap().len() < 1 << 17);
        let e = read_solution(&path).unwrap_err().to_string();
        assert!(e.contains("header.json") && e.contains(says), "{e}");
    }
    fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn unknown_errors_round_trip() {
    let dir = folder("unknown");
    let path = dir.join("a.npz");
    let mut s = solution();
    *s.fields.error[1].iter_mut().last().unwrap() = f64::INFINITY;
    write_solution(&path, &s).unwrap();
    assert_eq!(read_solution(&path).unwrap().fields, s.fields);
    fs::remove_dir_all(&dir).unwrap();
}

fn thermal_voxel_grid(map: &VoxelGrid) -> VoxelGrid {
    let mut warm = VoxelGrid::new(map.min(), map.cell(), map.dims()).unwrap();
    for i in 0..map.len() {
        let known = if i % 2 == 0 {
            ThermalCondition::Temperature(300.0 + i as f64)
        } else {
            ThermalCondition::Flux(7.5)
        };
        warm.set(i, Bands::ONE, Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
        warm.set_heat(i, known, ThermalCondition::Flux(0.0));
    }
    warm.seal().unwrap()
}

fn thermal_fields(zones: usize) -> ThermalFields {
    let list = |x: f64| (0..zones).map(|i| x + i as f64).collect::<Vec<_>>();
    let mut heat = ThermalFields {
        temperature: list(300.0),
        temperature_error: list(0.1),
        net: list(-2.0),
        net_error: list(0.0),
    };
    (heat.temperature[1], heat.temperature_error[1]) = (f64::NAN, f64::NAN);
    heat
}

fn heat_report() -> HeatReport {
    let row = |name: &str, temperature| HeatRow {
        name: name.into(),
        kind: HeatRowKind::Medium,
        size: 2.0,
        temperature,
        temperature_error: temperature.map(|_| 0.25),
        power: -1.0 / 3.0,
        power_error: 1e-9,
        absorbed_sunlight: temperature.map(|t| t / 7.0),
    };
    HeatReport {
        rows: vec![row("a", None), row("b", Some(431.0))],
        nodes: vec![NodeResult {
            name: "body".into(),
            temperature: 1e3 / 3.0,
            temperature_error: f64::INFINITY,
            radiated: -0.1,
            convected: 0.2,
            conducted: 0.0,
        }],
        surroundings: 1.5,
        absorbed_backfaces: 0.25,
        emitters: 40.0 / 3.0,
    }
}

/// Nodes with links of every law; the first surface, of unknown temperature, belongs to one and has convection.
fn network(surfaces: usize) -> ThermalNetwork {
    let node = |name: &str, condition| ThermalNode { name: name.into(), condition };
    let laws = [
        LinkLaw::Conductance(0.1),
        LinkLaw::ConductancePerArea(1.0 / 3.0),
        LinkLaw::EffectiveEmissivity(0.02),
    ];
    let mut network = ThermalNetwork {
        nodes: vec![
            node("body", NodeCondition::Power(1.0 / 7.0)),
            node("hull", NodeCondition::Temperature(300.0)),
        ],
        links: laws.map(|law| NodeLink { nodes: [0, 1], law }).to_vec(),
        surface_nodes: vec![None; surfaces],
        convection: vec![None; surfaces],
    };
    network.surface_nodes[0] = Some(0);
    network.convection[0] = Some(Convection { coefficient: 0.1, ambient: 1e3 / 3.0 });
    network
}

/// A solution in thermal mode with a discretization error.
pub(super) fn thermal_solution() -> Solution {
    let mut s = solution();
    let mut parts = s.scene.into_parts();
    parts.lights.clear();
    parts.surfaces.iter_mut().for_each(|x| {
        (x.emission, x.emission_texture, x.reflectance_texture) = (Bands::ZERO, None, None);
    });
    parts.panes.iter_mut().for_each(|p| p.emission = Bands::ZERO);
    parts.voxel_grid = parts.voxel_grid.as_ref().map(thermal_voxel_grid);
    let surfaces = [
        ThermalCondition::Power(-3.5),
        ThermalCondition::Temperature(1e3 / 3.0),
        ThermalCondition::Flux(0.0),
    ];
    parts.thermal = Some(Thermal {
        band_fractions: BandFractions::GreyGases {
            coefficients: PerBand::from_rgb([vec![0.5, -1e-4], vec![0.25, 1e-4], vec![0.25]]),
            range: [400.0, 2e3],
            allow_partial: false,
            all_bands: None,
        },
        cell_fractions: None,
        surfaces: surfaces.into_iter().cycle().take(parts.surfaces.len()).collect(),
        panes: vec![ThermalCondition::Temperature(290.0); parts.panes.len()],
        surroundings: Some(280.0),
        network: Some(network(parts.surfaces.len())),
        emissivities: Vec::new(),
    });
    s.scene = Scene::new(parts).unwrap();
    s.fields.heat = Some(thermal_fields(s.zones.len()));
    s.groups.clear();
    s.report.heat = Some(heat_report());
    s.report.discretization_error = Some(DiscretizationError {
        zones: 7,
        ratio: 1.0 / 3.0 + 1.0,
        heat: vec![[0.0, 1e-3], [0.1, 2.0]],
        energy: s.report.energy.clone(),
        notes: vec!["a pane".into()],
    });
    s
}

#[test]
fn thermal_solutions_round_trip() {
    let mut s = thermal_solution();
    for unknown in [false, true] {
        if unknown {
            let zoning = s.report.discretization_error.as_mut().unwrap();
            (zoning.zones, zoning.ratio) = (0, f64::INFINITY);
            zoning.heat = vec![[f64::NAN, f64::INFINITY], [f64::INFINITY; 2]];
            zoning.energy = zoning.energy.zip_map(&zoning.energy, |_, _| f64::INFINITY);
        }
        let path = std::env::temp_dir().join(format!("zonal-warm-{}.npz", std::process::id()));
        write_solution(&path, &s).unwrap();
        let back = read_solution(&path).unwrap();
        fs::remove_file(&path).unwrap();
        // Compare texts, since NaN is not equal to itself.
        assert_eq!(format!("{:?}", s.fields.heat), format!("{:?}", back.fields.heat));
        assert_eq!(format!("{:?}", s.report), format!("{:?}", back.report));
        assert_eq!(format!("{:?}", s.scene), format!("{:?}", back.scene));
        assert_eq!(crate::output::scene_hash(&s.scene), crate::output::scene_hash(&back.scene));
    }
}
