//! Forward Monte Carlo against textbook solutions.
//!
//! Guards (numbers): the random walks of the reference have the solutions of textbooks.

use std::path::Path;
use zonal_reference::SampleEstimate;
use zonal_reference::forward_monte_carlo::{
    ClosedSurfaces, ForwardProblem, ForwardSolution, HeatBalance, trace_forward,
};
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{Band, Bands, Patch, Scene, VoxelZones, Zones};

/// Walks of a solution.
const WALK_COUNT: usize = 100_000;
/// E₃(1).
const E3_OF_1: f64 = 0.109_691_967_0;
/// Flux between black walls about a grey layer of optical depth 1 in radiative equilibrium, over the difference of their emissive powers
/// (Heaslet and Warming 1965).
const LAYER_FLUX_RATIO: f64 = 0.5534;

/// A layer between black walls of 1000 and 500 K, infinite along x and y.
fn layer(cells: usize, lines: &str, shares: &str) -> Scene {
    let text = format!(
        "mode = \"thermal\"\n{shares}\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[solve]\npatch_rule = \"voxels\"\n\
         [[surface]]\nname = \"w\"\nroom = {{ min = [0, 0, 0], max = [1, 1, 1] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\nemissivity = 1\n\
         faces.z0 = {{ temperature = 1000 }}\nfaces.z1 = {{ temperature = 500 }}\n\
         [medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [1, 1, {cells}]\n{lines}\n"
    );
    scene(&text)
}

fn scene(text: &str) -> Scene {
    zonal_io::input::parse_scene(text, None::<&Path>, "law.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn assert_near(what: &str, e: SampleEstimate, exact: f64) {
    let far = (e.value - exact).abs() / (4.0 * e.error + 1e-6 * exact.abs());
    assert!(far <= 1.0, "{what}: {} ± {}, not {exact}", e.value, e.error);
}

/// σT⁴ of an element that has a temperature, W/m².
fn emissive_power(element: &HeatBalance) -> SampleEstimate {
    element.emissive.expect("the element has a temperature")
}

fn solution(scene: &Scene, zones: Option<&Zones>) -> ForwardSolution {
    let problem = zones.map_or(ForwardProblem::Continuous, ForwardProblem::Zones);
    trace_forward(scene, &ClosedSurfaces::default(), problem, WALK_COUNT, 7)
}

#[test]
fn thin_medium_between_infinite_walls_absorbs_nothing() {
    for kappa in ["1e-12", "1e-9"] {
        let found = solution(&layer(3, &format!("extinction = {kappa}\nheat_source = 0"), ""), None);
        assert_near(
            "z0",
            found.heat[0].power,
            blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0),
        );
        assert_near(
            "z1",
            found.heat[1].power,
            blackbody_emissive_power(500.0) - blackbody_emissive_power(1000.0),
        );
    }
}

#[test]
fn grey_layer_in_radiative_equilibrium_matches_heaslet_and_warming() {
    let gap = blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0);
    for shares in ["", "[thermal]\nband_fractions = [0.3, 0.7, 0]"] {
        let found = solution(&layer(2, "extinction = 1\nheat_source = 0", shares), None);
        let flux = found.heat[0].power;
        assert!((flux.value / gap - LAYER_FLUX_RATIO).abs() < 4.0 * flux.error / gap + 5e-5, "{flux:?}");
        let mean = emissive_power(&found.heat[2]);
        assert_near(
            "mean emissive power",
            mean,
            0.5 * (blackbody_emissive_power(1000.0) + blackbody_emissive_power(500.0)),
        );
    }
}

#[test]
fn equations_of_one_volume_zone_are_solved_exactly() {
    // One zone emits half of its absorbed power to either side.
    let s = layer(1, "extinction = 1\nheat_source = 0", "");
    let found = solution(&s, Some(&three_zones(&s)));
    assert_near(
        "z0",
        found.heat[0].power,
        (0.5 + E3_OF_1) * (blackbody_emissive_power(1000.0) - blackbody_emissive_power(500.0)),
    );
}

/// The front of a facet as a patch.
fn patch_of(s: &Scene, k: usize) -> Patch {
    let plate = s.facets()[k].plate;
    let (surface, normal, area) = (s.facets()[k].surface, plate.normal(), plate.area());
    Patch { facet: k, surface, plate, normal, area, reflectance: Bands::ZERO, emission: Bands::ZERO }
}

/// One patch for each facet of a scene in light mode.
fn one_zone_a_facet(s: &Scene) -> Zones {
    let patch = |k: usize| {
        let surface = &s.surfaces()[s.facets()[k].surface];
        Patch { reflectance: surface.reflectance, emission: surface.emission, ..patch_of(s, k) }
    };
    Zones { patches: (0..s.facets().len()).map(patch).collect(), ..Zones::default() }
}

/// The zones of a layer of one cell: two walls and the cell.
fn three_zones(s: &Scene) -> Zones {
    let mut voxels = VoxelZones::whole(s.voxel_grid().unwrap());
    assert_eq!((voxels.len(), voxels.at(0).volume), (1, 1.0));
    voxels.update_extinction(|_, _| Bands::ONE);
    Zones { patches: vec![patch_of(s, 0), patch_of(s, 1)], voxels, ..Zones::default() }
}

#[test]
fn isothermal_scene_has_no_net_powers() {
    let s = scene(
        "mode = \"thermal\"\nsurroundings.temperature = 800\n\
         [[surface]]\nname = \"floor\"\nrectangle = { origin = [0, 0, 0], edge1 = [2, 0, 0], edge2 = [0, 2, 0] }\nemissivity = 0.6\ntemperature = 800\nsides = \"both\"\n\
         [[surface]]\nname = \"block\"\nbox = { min = [0.5, 0.5, 0.2], max = [1, 1.2, 0.8], rotate_z_degrees = 20 }\nemissivity = 0.3\nheat_flux = 0\n\
         [[pane]]\nname = \"glass\"\npolygon = [[1.5, 0, 0.1], [1.5, 2, 0.1], [1.6, 2, 1], [1.6, 0, 1]]\nthickness = 0.01\nextinction = 70\nalbedo = 0.4\n\
         [medium]\nmin = [0, 0, 0]\nmax = [2, 2, 1]\ncells = [3, 2, 2]\nextinction = 0.7\nalbedo = 0.2\ntemperature = 800\n",
    );
    let found = solution(&s, None);
    assert_near("floor", found.heat[0].power, 0.0);
    assert_near("block", emissive_power(&found.heat[1]), blackbody_emissive_power(800.0));
    assert_near("glass", emissive_power(&found.heat[3]), blackbody_emissive_power(800.0));
    let gas = found.heat[2].power;
    assert!(gas.value.abs() < 4.0 * gas.error + 0.01 * blackbody_emissive_power(800.0), "{gas:?}");
}

#[test]
fn error_covers_unsampled_grazing_directions_of_a_thin_layer() {
    const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;
    for (kappa, sampled) in [(1e-3, true), (1e-7, false), (1e-11, false)] {
        let s = layer(1, &format!("extinction = {kappa:e}\nheat_source = 1e5"), "");
        let mut zones = three_zones(&s);
        zones.voxels.update_extinction(|_, _| Bands::splat(kappa));
        let g = solution(&s, Some(&zones)).zones[2][Band::first()];
        // Mean of 1e5/2 ∫ E1(κ|z − z'|) dz' over the thin layer, and the fluence of the walls.
        let exact = 0.5e5 * (1.5 - EULER_GAMMA - kappa.ln())
            + 2.0 * (blackbody_emissive_power(1000.0) + blackbody_emissive_power(500.0));
        assert!(
            (g.value - exact).abs() <= 4.0 * g.error + 2.0 * kappa * exact,
            "{kappa:e}: {g:?}, not {exact}"
        );
        assert_eq!(g.error < 0.03 * exact, sampled, "{kappa:e}: {g:?}, not {exact}");
    }
}

#[test]
fn a_level_plate_absorbs_the_irradiance_of_a_sky() {
    let sky =
        "kind = \"cie-sky\"\ntype = 13\nhorizontal_irradiance = [100, 50, 20]\ndirection = [0.4, 0, -1]\n";
    let text = format!(
        "[[surface]]\nname = \"plate\"\nreflectance = 0\nrectangle = {{ origin = [0, 0, 0], edge1 = [2, 0, 0], edge2 = [0, 1, 0] }}\n[[light]]\n{sky}"
    );
    let found = solution(&scene(&text), None);
    for (b, exact) in Band::all().zip([200.0, 100.0, 40.0]) {
        assert_near("plate", found.surfaces[0][b], exact);
    }
}

/// Two reflecting plates with a small lamp between them. All light between the plates goes less far than 1.5 √A, so that rays go on from it everywhere:
/// zones of one patch a plate have the light of the continuous problem, which the equations of these zones miss.
#[test]
fn walks_that_go_on_from_close_patches_resolve_them() {
    let plates = scene(
        "[solve]\npatch_size = 2\n\
         [[surface]]\nname = \"low\"\nrectangle = { origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }\nreflectance = 0.9\n\
         [[surface]]\nname = \"high\"\nrectangle = { origin = [0, 0, 0.1], edge1 = [0, 1, 0], edge2 = [1, 0, 0] }\nreflectance = 0.9\n\
         [[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.9, 0.4, 0.05], edge1 = [0.1, 0, 0], edge2 = [0, 0.1, 0] }\nreflectance = 0\nemission = 100\n",
    );
    let zones = one_zone_a_facet(&plates);
    let high = |problem: ForwardProblem| {
        trace_forward(&plates, &ClosedSurfaces::default(), problem, WALK_COUNT, 7).surfaces[1][Band::first()]
    };
    let continuous = high(ForwardProblem::Continuous);
    let continued = high(ForwardProblem::ContinuedRays(&zones));
    let zonal = high(ForwardProblem::Zones(&zones));
    let apart = |a: SampleEstimate, b: SampleEstimate| (a.value - b.value).abs() / a.error.hypot(b.error);
    assert!(apart(continued, continuous) < 4.0, "{continued:?} {continuous:?}");
    assert!(apart(zonal, continuous) > 20.0, "{zonal:?} {continuous:?}");
}
