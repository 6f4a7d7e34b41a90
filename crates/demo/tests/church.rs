//! The generated church is sealed, lit through its panes only, and a valid scene.

use zonal_demo::church::{
    ChurchModel, ChurchPlan, ChurchResolution, GlassHue, HUES, build, glb_model, scene_text,
};
use zonal_io::{input, output};
use zonal_math::{Vec3, direction_sampling, low_discrepancy, vec3};
use zonal_scene::Scene;
use zonal_transport::Transport;

const RESOLUTION: ChurchResolution =
    ChurchResolution { patch: 0.9, cell: 0.75, tolerance: 0.12, closure: "measure" };

fn scene(plan: &ChurchPlan, name: &str) -> Scene {
    let folder = std::env::temp_dir().join(format!("zonal-church-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let model: ChurchModel = build(plan);
    output::write_glb(&folder.join("church.glb"), &glb_model(&model)).unwrap();
    std::fs::write(folder.join("church.toml"), scene_text(plan, "church.glb", &RESOLUTION)).unwrap();
    let scene = input::read_scene(folder.join("church.toml")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    scene
}

/// From points in nave, aisles and apse every ray that leaves passes a pane.
fn leaks(scene: &Scene, plan: &ChurchPlan, rays: usize) -> usize {
    let transport = Transport::new(scene);
    let l = plan.length();
    let from = [
        vec3(0.3, 0.4 * l, 7.0),
        vec3(-0.4, 0.7 * l, 12.5),
        vec3(6.2, 0.3 * l, 4.0),
        vec3(-6.1, 0.8 * l, 6.8),
        vec3(0.2, l + 1.6, 6.0),
        vec3(2.9, 0.5 * l, 9.4),
    ];
    let leaking = |i: usize| {
        let origin = from[i % from.len()];
        let dir = direction_sampling::uniform_sphere(low_discrepancy::r2(i / from.len(), [0.3, 0.7]));
        if transport.closest_hit(origin, dir, 0.0, f64::INFINITY).is_some() {
            return false;
        }
        let mut panes = 0;
        transport.pane_crossings(origin, transport.exterior_point(origin, dir), &mut |_| panes += 1);
        panes == 0
    };
    (0..rays).filter(|i| leaking(*i)).count()
}

// Guards (numbers): light enters the church through its panes only.
#[test]
fn light_enters_through_panes_only() {
    for (plan, name) in [(ChurchPlan::TWO_BAYS, "small"), (ChurchPlan::SIX_BAYS, "full")] {
        let scene = scene(&plan, name);
        assert_eq!(leaks(&scene, &plan, 120_000), 0, "{name}");
    }
}

#[test]
fn surfaces_panes_and_lights_have_their_names() {
    let scene = scene(&ChurchPlan::TWO_BAYS, "parts");
    let names: Vec<&str> = scene.surfaces().iter().map(|s| s.name.as_str()).collect();
    for part in ["church/ashlar", "church/web", "church/tiles", "church/oak", "church/flame"] {
        assert!(names.contains(&part), "{part} in {names:?}");
    }
    // Columns, ribs and bars are bodies; reveals and spandrels are not.
    assert!(names.contains(&"church/dressed stone (solid)") && names.contains(&"church/dressed stone"));
    assert_eq!(scene.panes().len(), HUES.len());
    for (pane, hue) in scene.panes().iter().zip(&HUES) {
        let transmittance = (-pane.extinction * pane.thickness).map(f64::exp);
        let error = (transmittance - hue.transmittance).abs().max_element();
        assert!(error < 0.01, "{}: {transmittance:?}", hue.name);
        assert!(pane.albedo.all(|a| a > 0.0));
    }
    let lights: Vec<&str> = scene.lights().iter().map(|l| l.name(scene.surfaces())).collect();
    assert_eq!((lights, scene.surroundings().name()), (vec!["sun", "candles"], "sky"));
    assert!(scene.notes().is_empty(), "{:?}", scene.notes());
}

#[test]
fn hues_differ_by_ten_degrees() {
    // By the direction of their colours: no two panes within ten degrees.
    let direction = |hue: &GlassHue| Vec3::from_array(hue.transmittance.to_rgb()).normalized();
    for (i, a) in HUES.iter().enumerate() {
        for b in &HUES[..i] {
            let angle = direction(a).dot(direction(b)).clamp(-1.0, 1.0).acos().to_degrees();
            assert!(angle > 10.0, "{} and {}: {angle}", a.name, b.name);
        }
    }
}
