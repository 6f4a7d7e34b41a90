//! Scenes from arrays: values per band, direct lights, heat, and the shells of meshes.

use zonal_math::{Vec3, vec3};
use zonal_scene::shells::{Shell, ShellKind, Shells};
use zonal_scene::{
    BandValues, Bands, DiscretizationError, Fields, Light, Medium, Mesh, Plate, Report, Scene, Solution, Sun,
    ThermalCondition, VoxelValues, Zones,
};

fn square(z: f64) -> Plate {
    Plate::parallelogram(vec3(0.0, 0.0, z), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))
}

/// The emission of a lamp after the builder, with the number of its direct lights.
fn built_emission(flux: impl BandValues) -> (Bands, usize) {
    let lamp = Mesh::from_plates(vec![square(0.0)]).name("lamp").emission(flux).as_direct_light();
    let scene = Scene::builder().surface(lamp).build().unwrap();
    assert!(scene.is_direct_emitter(0));
    (scene.surfaces()[0].emission, scene.lights().len())
}

#[test]
fn numbers_triples_and_bands_give_the_same_emission() {
    assert_eq!(built_emission(2.0), (Bands::splat(2.0), 1));
    assert_eq!(built_emission([1.0, 2.0, 3.0]), (Bands::from_rgb([1.0, 2.0, 3.0]), 1));
    assert_eq!(built_emission(Bands::from_rgb([1.0, 2.0, 3.0])), built_emission([1.0, 2.0, 3.0]));
}

#[test]
fn angular_diameter_of_a_sun_is_stored_in_radians() {
    let light = Light::from(Sun::new([0.0, 0.0, -3.0]).irradiance(1000.0).angular_diameter_degrees(90.0));
    let Light::Sun { direction, irradiance, angular_diameter, .. } = light else { panic!("a sun") };
    assert_eq!((direction, irradiance), (vec3(0.0, 0.0, -1.0), Bands::splat(1000.0)));
    assert!((angular_diameter - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
}

#[test]
fn heat_flux_and_temperature_of_the_surroundings_make_a_thermal_scene() {
    let floor = Mesh::from_plates(vec![square(0.0)]).emissivity(0.8).heat_flux(50.0);
    let scene = Scene::builder().surface(floor).surroundings_temperature(300.0).build().unwrap();
    let thermal = scene.thermal().unwrap();
    assert_eq!((thermal.surfaces[0], thermal.surroundings), (ThermalCondition::Flux(50.0), Some(300.0)));
}

#[test]
fn shells_have_the_area_and_signed_volume_of_their_plates() {
    let (a, b, c, d) = (Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let solid = [(a, c, b), (a, b, d), (a, d, c), (b, c, d)].map(|(p, q, r)| Plate::triangle(p, q, r));
    let shell = |plates: &[Plate]| -> Shell { Shells::find(plates, 1e-6).shells()[0] };
    let (outward, inward) = (shell(&solid), shell(&solid.map(|p| p.flipped())));
    assert_eq!((outward.kind, inward.kind), (ShellKind::Solid, ShellKind::Enclosure));
    assert!((outward.volume - 1.0 / 6.0).abs() < 1e-15 && (outward.volume + inward.volume).abs() < 1e-15);
    assert!((outward.area - 0.5 * (3.0 + 3f64.sqrt())).abs() < 1e-14);
    assert!(outward.area_vector.length() < 1e-15 && outward.free_edges + outward.flipped_edges == 0);
}

#[test]
fn errors_that_a_report_lacks_are_infinite() {
    let scene = Scene::builder().surface(Mesh::from_plates(vec![square(0.0)]).name("sheet")).build().unwrap();
    let solution = Solution {
        scene,
        zones: Zones::default(),
        fields: Fields::default(),
        groups: Vec::new(),
        report: Report { discretization_error: Some(DiscretizationError::default()), ..Report::default() },
        further_blocks: Vec::new(),
        scene_hash: String::new(),
        version: String::new(),
    };
    let sheet = solution.surface("sheet").unwrap();
    assert_eq!((sheet.exchange_error, sheet.discretization_error), (f64::INFINITY, Some(f64::INFINITY)));
    assert_eq!(sheet.total_error(), Some(f64::INFINITY));
}

#[test]
fn uniform_and_listed_voxel_values_give_the_same_medium() {
    let grid = |extinction: VoxelValues| {
        let medium = Medium::grid([0.0; 3], [1.0, 1.0, 2.0], [1, 1, 2]).extinction(extinction).albedo(0.25);
        Scene::builder().medium(medium).build().unwrap().voxel_grid().unwrap().clone()
    };
    assert_eq!(grid(0.5.into()), grid(vec![0.5, 0.5].into()));
    let varying = grid(vec![0.5, 2.0].into());
    assert_eq!([0, 1].map(|i| varying.extinction(i)), [Bands::splat(0.5), Bands::splat(2.0)]);
    assert_eq!(varying.albedo(1), Bands::splat(0.25));
}
