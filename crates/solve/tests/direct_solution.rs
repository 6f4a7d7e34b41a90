//! Direct light alone is the right-hand side of the full solution: the same direct light, the surroundings without interreflection, errors unknown.

use crate::common;

use common::{read, solve};
use zonal_scene::{Bands, LightGroupKind, NoProgress, Scene, Solution, SolveStatus};
use zonal_solve::{SolveSettings, solve_direct_light};

/// Sun, point light and sky through an open top onto a floor and a wall, in a thin medium.
const COURT: &str = "
[solve]
patch_size = 0.5
tolerance = 0.1
[[surface]]
name = 'floor'
rectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }
reflectance = [0.7, 0.4, 0.1]
[[surface]]
name = 'wall'
rectangle = { origin = [0,0,0], edge1 = [0,1,0], edge2 = [0,0,1] }
reflectance = 0.8
emission = 2
[medium]
min = [0,0,0]
max = [1,1,1]
cells = [2,2,2]
extinction = 0.2
albedo = 0.6
[[light]]
name = 'sun'
kind = 'sun'
direction = [-0.3, 0.2, -1]
irradiance = [30, 20, 10]
[[light]]
kind = 'point'
name = 'lamp'
position = [0.4, 0.5, 0.6]
intensity = 2
[surroundings]
radiance = 1
";

fn first(scene: Scene) -> Solution {
    solve_direct_light(scene, &SolveSettings::new(4 << 30, &NoProgress)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn direct_light_equals_that_of_the_solution() {
    for engine in ["dense", "rays"] {
        let text = COURT.replace("[solve]", &format!("[solve]\nengine = \"{engine}\""));
        let (a, b) = (first(read(&text)), solve(read(&text)));
        assert_eq!(a.fields.direct, b.fields.direct, "{engine}");
        assert_eq!(a.fields.direct_error, b.fields.direct_error);
        assert_eq!(a.zones.len(), b.zones.len());
        let kinds = |s: &Solution| s.groups.iter().map(|g| (g.name.clone(), g.kind)).collect::<Vec<_>>();
        assert_eq!(kinds(&a), kinds(&b), "the sliders of the page stay");
        let is_sky = |k: LightGroupKind| k == LightGroupKind::Surroundings;
        for (x, y) in a.groups.iter().zip(&b.groups) {
            let zones = 0..a.zones.len();
            assert!(zones.clone().all(|i| {
                (x.direct.at(i) - y.direct.at(i) * y.direct_scale).abs().into_iter().all(|d| d < 1e-4)
            }));
            // Light of the surroundings without interreflection is a part of theirs; other groups have none yet.
            for i in zones {
                let (own, all) = (x.incident.at(i), y.incident.at(i) * y.incident_scale);
                let is_part = (0.0..=1.05 * all.first() + 0.02).contains(&own.first());
                assert!(
                    if is_sky(x.kind) { is_part } else { own == Bands::ZERO },
                    "{} {i}: {own:?} {all:?}",
                    x.name
                );
            }
        }
        let sky = a.groups.iter().find(|g| is_sky(g.kind)).unwrap();
        assert!(sky.incident.at(0).first() > 1.0, "the floor sees the sky: {:?}", sky.incident.at(0));
    }
}

#[test]
fn zones_without_light_have_their_emission_alone() {
    let settings = SolveSettings::new(4 << 30, &NoProgress);
    let (dark, lit) = (zonal_solve::solve_without_light(read(COURT), &settings).unwrap(), first(read(COURT)));
    assert_eq!(dark.zones.patches, lit.zones.patches);
    let names = |s: &Solution| s.groups.iter().map(|g| g.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&dark), names(&lit), "the sliders of the page stay");
    for i in 0..dark.zones.len() {
        assert_eq!(dark.fields.radiosity[i], dark.zones.emission(i));
        assert_eq!((dark.fields.incident[i], dark.fields.direct_light(i)), (Bands::ZERO, Bands::ZERO));
        assert!(
            dark.fields.total_error(i).into_iter().all(f64::is_infinite),
            "what is not known has no error"
        );
        assert!(dark.groups.iter().all(|g| (g.incident_at(i), g.direct_at(i)) == (Bands::ZERO, Bands::ZERO)));
    }
    assert!(dark.fields.radiosity.iter().any(|b| *b != Bands::ZERO));
}

#[test]
fn zones_of_an_earlier_solve_serve_the_next() {
    let first = first(read(COURT));
    let settings = SolveSettings { zones: Some(&first.zones), ..SolveSettings::new(4 << 30, &NoProgress) };
    let (again, alone) =
        (zonal_solve::solve_with_settings(read(COURT), &settings).unwrap(), solve(read(COURT)));
    assert_eq!(again.fields, alone.fields);
    assert_eq!(again.zones.patches, alone.zones.patches);
}

#[test]
fn radiosity_is_emission_and_first_reflection() {
    let s = first(read(COURT));
    for i in 0..s.zones.len() {
        let (e, (rho, _)) = (s.zones.emission(i), s.zones.response(i));
        let expected = e + rho * (s.fields.incident[i] + s.fields.direct_light(i));
        assert!((s.fields.radiosity[i] - expected).abs().into_iter().all(|d| d < 1e-12));
    }
}

#[test]
fn errors_are_unknown_until_the_exchange_is_known() {
    let s = first(read(COURT));
    assert!(s.fields.error.iter().flatten().all(|e| *e == f64::INFINITY));
    assert!(s.report.estimate.patches.into_iter().all(|e| e == f64::INFINITY));
    assert!(s.report.status.iter().all(|x| *x == SolveStatus::FixedOrder));
    assert!(s.report.warnings.iter().any(|d| d.code == "direct-light"));
}

#[test]
fn a_part_between_symmetry_planes_has_the_direct_light_of_its_solution() {
    let text = COURT
        .replace("[solve]", "[solve]\nengine = \"dense\"")
        .replace("[medium]", "[boundary]\nx0 = \"symmetry\"\n[medium]");
    let text = text.replace(
        "rectangle = { origin = [0,0,0], edge1 = [0,1,0], edge2 = [0,0,1] }",
        "rectangle = { origin = [1,0,0], edge1 = [0,0,1], edge2 = [0,1,0] }",
    );
    let (a, b) = (first(read(&text)), solve(read(&text)));
    assert_eq!(a.fields.direct, b.fields.direct);
    assert_eq!(a.fields.incident.len(), b.zones.len());
}

#[test]
fn thermal_scenes_are_refused() {
    let text = "mode = \"thermal\"\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\nemissivity = 0.5\ntemperature = 300\n";
    let refused = solve_direct_light(read(text), &SolveSettings::new(4 << 30, &NoProgress));
    assert_eq!(refused.unwrap_err().key(), "mode");
}
