//! Inline scenes read right: every key of the format, with its numbers.

use zonal_io::input::parse_scene;
use zonal_math::{Vec3, vec3};
use zonal_scene::{
    Bands, Engine, Lens, Light, LightGrouping, PatchRule, PlateKind, Scene, Sides, SkyDistribution,
};

fn read(text: &str) -> Scene {
    parse_scene(text, None, "test.toml").unwrap_or_else(|e| panic!("{e}"))
}

const CHAPEL: &str = r##"
name = "chapel"
[solve]
tolerance = 1e-3
patch_size = 0.5
closure = "restore"
residual = 1e-8
max_iterations = 50
scattering_orders = 6
engine = "rays"
light_groups = "each"

[[surface]]
name = "floor"
rectangle = { origin = [0,0,0], edge1 = [4,0,0], edge2 = [0,6,0] }
reflectance = [0.1, 0.2, 0.3]
emission = 2
sides = "both"
patch_size = 0.2

[[surface]]
triangle = { corners = [[0,0,1],[1,0,1],[0,1,1]] }

[[surface]]
name = "block"
box = { min = [1,1,0], max = [2,3,1], rotate_z_degrees = 90 }
faces.z1 = { emission = 5 }

[[surface]]
name = "hall"
room = { min = [0,0,0], max = [4,6,3] }
reflectance = 0.8
omit = ["y0"]
faces.x0 = { emission = 1, reflectance = 0.2 }

[[pane]]
name = "red glass"
polygon = [[1,0,1],[2,0,1],[2,0,2],[1,0,2]]
thickness = 0.01
extinction = [10, 200, 200]
albedo = 0.1
emission = 0.5

[[pane]]
name = "gable"
polygon = [[0,0,0],[1,0,0],[1.5,0,1],[0.5,0,2],[-0.5,0,1]]
thickness = 0.02
extinction = 3

[medium]
min = [0,0,0]
max = [4,6,3]
cells = [4,6,3]
extinction = 0.1
albedo = 0.9
[[medium.region]]
box = { min = [0,0,0], max = [1.5,1,1] }
extinction = 1.1
albedo = 0.5
emission = 7
source = 2

[[light]]
kind = "sun"
direction = [0, 3, -4]
irradiance = [1000, 900, 800]
[[light]]
kind = "sky"
name = "blue"
radiance = [1,2,3]
[[light]]
kind = "emitter"
surface = "hall.x0"
[surroundings]
radiance = 0.25
[[camera]]
name = "nave"
origin = [2,1,1.6]
target = [2,6,1.6]
fov = 75
aperture = 0.04
focus = 3
[[camera]]
origin = [0,0,0]
target = [1,1,1]
"##;

#[test]
fn inline_settings_and_surfaces_have_their_values() {
    let s = read(CHAPEL);
    assert_eq!(s.name(), "chapel");
    let o = s.options();
    assert_eq!((o.tolerance, o.residual, o.max_iterations), (1e-3, 1e-8, 50));
    assert_eq!((o.patch_size, o.restore_closure), (Some(0.5), Some(true)));
    assert_eq!(
        (o.scattering_orders, o.engine, o.light_grouping),
        (Some(6), Engine::Rays, LightGrouping::Each)
    );

    let names: Vec<&str> = s.surfaces().iter().map(|s| s.name.as_str()).collect();
    let walls = ["hall.x0", "hall.x1", "hall.y1", "hall.z0", "hall.z1"];
    assert_eq!(names[..4], ["floor", "surface2", "block", "block.z1"]);
    assert_eq!(names[4..], walls);
    let floor = &s.surfaces()[0];
    assert_eq!(floor.reflectance, Bands::from_rgb([0.1, 0.2, 0.3]));
    assert_eq!((floor.emission, floor.patch_size), (Bands::splat(2.0), Some(0.2)));
    assert_eq!((floor.sides, floor.solid), (Sides::Both, false));
    assert_eq!(s.facets()[0].plate.normal(), vec3(0.0, 0.0, 1.0));
    assert_eq!(s.facets()[0].plate.area(), 24.0);
    let triangle = &s.facets()[1].plate;
    assert_eq!((triangle.kind, triangle.area()), (PlateKind::Triangle, 0.5));
    assert_eq!((s.surfaces()[1].reflectance, s.surfaces()[1].sides), (Bands::splat(0.5), Sides::Front));
    assert!(s.surfaces()[2].solid && s.surfaces()[3].solid && !s.surfaces()[4].solid);
    assert_eq!(
        (s.surfaces()[3].emission, s.surfaces()[3].reflectance),
        (Bands::splat(5.0), Bands::splat(0.5))
    );
    assert_eq!((s.surfaces()[4].emission, s.surfaces()[4].reflectance), (Bands::ONE, Bands::splat(0.2)));
    assert_eq!((s.surfaces()[5].emission, s.surfaces()[5].reflectance), (Bands::ZERO, Bands::splat(0.8)));
}

#[test]
fn inline_boxes_and_rooms_have_their_geometry() {
    let s = read(CHAPEL);
    let block: Vec<_> = s.facets().iter().filter(|f| [2, 3].contains(&f.surface)).collect();
    assert_eq!(block.len(), 6);
    // A box of 1 by 2 turned by a right angle about (1.5, 2) is a box of 2 by 1.
    let lo = block.iter().fold(Vec3::splat(9.0), |m, f| m.min(f.plate.bounds().0));
    let hi = block.iter().fold(Vec3::splat(-9.0), |m, f| m.max(f.plate.bounds().1));
    assert!((lo - vec3(0.5, 1.5, 0.0)).length() < 1e-12 && (hi - vec3(2.5, 2.5, 1.0)).length() < 1e-12);
    let middle = vec3(1.5, 2.0, 0.5);
    assert!(block.iter().all(|f| (f.plate.centre() - middle).dot(f.plate.normal()) > 0.0));
    let centre = vec3(2.0, 3.0, 1.5);
    for f in s.facets().iter().filter(|f| f.surface >= 4) {
        assert!((centre - f.plate.centre()).dot(f.plate.normal()) > 0.0);
    }
}

#[test]
fn inline_panes_lights_and_cameras_have_their_values() {
    let s = read(CHAPEL);
    assert_eq!(s.panes().len(), 2);
    let red = &s.panes()[0];
    assert_eq!(
        (red.plates.len(), red.thickness, red.extinction),
        (1, 0.01, Bands::from_rgb([10.0, 200.0, 200.0]))
    );
    assert_eq!((red.albedo, red.emission), (Bands::splat(0.1), Bands::splat(0.5)));
    let gable: f64 = s.panes()[1].plates.iter().map(|p| p.area()).sum();
    assert_eq!(s.panes()[1].plates.len(), 3);
    assert!((gable - 2.5).abs() < 1e-12, "{gable}");

    match &s.lights()[0] {
        Light::Sun { name, direction, irradiance, angular_diameter } => {
            assert_eq!((name.as_str(), *irradiance), ("light1", Bands::from_rgb([1000.0, 900.0, 800.0])));
            assert!((*direction - vec3(0.0, 0.6, -0.8)).length() < 1e-15);
            assert!((angular_diameter.to_degrees() - 0.53).abs() < 1e-12);
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(
        s.lights()[1],
        Light::Sky {
            name: "blue".into(),
            radiance: Bands::from_rgb([1.0, 2.0, 3.0]),
            distribution: SkyDistribution::uniform(),
        }
    );
    assert_eq!(s.lights()[2], Light::Emitter { surface: 4, name: None });
    assert_eq!(s.surroundings().radiance, Bands::splat(0.25));
    assert_eq!((s.cameras()[0].name.as_str(), s.cameras()[0].fov), ("nave", 75.0));
    assert_eq!((s.cameras()[1].name.as_str(), s.cameras()[1].fov), ("camera2", 60.0));
    assert_eq!(s.cameras()[0].lens, Lens { aperture: 0.04, focus: Some(3.0) });
    assert_eq!(s.cameras()[1].lens, Lens::default());
    assert_eq!(s.cameras()[1].up, vec3(0.0, 0.0, 1.0));
}

#[test]
fn regions_mix_cut_cells_by_volume() {
    let s = read(CHAPEL);
    let v = s.voxel_grid().unwrap();
    assert_eq!((v.dims(), v.cell(), v.max()), ([4, 6, 3], Vec3::ONE, vec3(4.0, 6.0, 3.0)));
    let whole = v.index([0, 0, 0]);
    assert_eq!((v.extinction(whole), v.albedo(whole)), (Bands::splat(1.1), Bands::splat(0.5)));
    assert_eq!((v.emission(whole), v.source(whole)), (Bands::splat(7.0), Bands::splat(2.0)));
    let half = v.index([1, 0, 0]);
    assert!((v.extinction(half).first() - 0.6).abs() < 1e-15);
    // Scattering and emitted power are what is mixed: (0.09 + 0.55)/2 of 0.6, and 0.55/(0.55 + 0.01) of 7.
    assert!((v.albedo(half).to_rgb()[1] - 0.32 / 0.6).abs() < 1e-14);
    assert!((v.emission(half).to_rgb()[2] - 7.0 * 0.55 / 0.56).abs() < 1e-12);
    assert_eq!(v.source(half), Bands::ONE);
    assert_eq!(v.extinction(v.index([2, 0, 0])), Bands::splat(0.1));
    assert_eq!(v.uniform_extinction(), None);
}

#[test]
fn cell_size_rounds_to_whole_cells_and_later_regions_take_precedence() {
    let s = read(
        "[medium]\nmin=[0,0,0]\nmax=[1,2,3]\ncell_size=[0.3,0.5,1.1]\nextinction=0.5\n\
         [[medium.region]]\nbox={min=[-1,-1,-1],max=[9,9,9]}\nextinction=2\n\
         [[medium.region]]\nbox={min=[-1,-1,-1],max=[9,9,9]}\nalbedo=[0,0.5,1]",
    );
    let v = s.voxel_grid().unwrap();
    assert_eq!(v.dims(), [3, 4, 3]);
    assert_eq!(v.uniform_extinction(), Some(Bands::splat(2.0)));
    assert_eq!(v.albedo(0), Bands::from_rgb([0.0, 0.5, 1.0]));
}

#[test]
fn defaults_equal_the_documented_ones() {
    let s = read("[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}");
    assert_eq!(s.name(), "scene");
    assert_eq!(s.options(), &zonal_scene::SolveOptions::default());
    assert_eq!(s.surroundings().radiance, Bands::ZERO);
    assert!(s.voxel_grid().is_none() && s.notes().is_empty());
    let first = &s.surfaces()[0];
    assert_eq!(
        (first.name.as_str(), first.reflectance, first.emission),
        ("surface1", Bands::splat(0.5), Bands::ZERO)
    );
    assert_eq!(s.facets()[0].uv, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
}

// Guards (documents): the example of the scene format is a valid scene.
#[test]
fn the_example_of_the_manual_is_a_scene() {
    let manual = include_str!("../../../docs/reference/scene-format.md");
    let example = manual.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let s = read(example);
    assert_eq!((s.surfaces().len(), s.panes().len(), s.lights().len()), (5, 1, 1));
    assert_eq!(s.voxel_grid().unwrap().dims(), [16, 24, 12]);
}

#[test]
fn periodic_axes_are_read() {
    let medium = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction=1\n";
    assert_eq!(read(medium).periodic(), [false; 3]);
    let s = read(&format!(
        "[solve]\npatch_rule=\"voxels\"\nengine=\"spectral\"\n[boundary]\nx=\"periodic\"\ny=\"scene\"\n{medium}"
    ));
    assert_eq!(s.periodic(), [true, false, false]);
    assert_eq!((s.options().patch_rule, s.options().engine), (PatchRule::Voxels, Engine::Spectral));
    let wrong = |text: &str| parse_scene(text, None, "scene.toml").unwrap_err().to_string();
    let all = wrong(&format!("[boundary]\nx=\"periodic\"\ny=\"periodic\"\nz=\"periodic\"\n{medium}"));
    assert!(all.contains("no more than two axes"), "{all}");
    let word = wrong(&format!("[boundary]\nx=\"endless\"\n{medium}"));
    assert!(word.contains(":2:") && word.contains("periodic"), "{word}");
    let light = "[[light]]\nkind=\"sun\"\ndirection=[0,0,-1]\nirradiance=1\n";
    let lit = wrong(&format!("[boundary]\nx=\"periodic\"\n{medium}{light}"));
    assert!(lit.contains("no periodic images"), "{lit}");
}

#[test]
fn all_toml_number_formats_are_read() {
    let s = read("[medium]\nmin=[-1_0,0x10,0]\nmax=[1_0.5,1e2,0b1000]\ncells=[1,0o2,1]\nextinction=1\n");
    let v = s.voxel_grid().unwrap();
    assert_eq!((v.min(), v.max()), (vec3(-10.0, 16.0, 0.0), vec3(10.5, 100.0, 8.0)));
    assert_eq!(v.dims(), [1, 2, 1]);
}
