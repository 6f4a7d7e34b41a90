//! Pictures against closed forms, exact geometry and reference samples.

use crate::integrator::radiance::Integrator;
use crate::integrator::ray_sampler::RaySampler;
use crate::lights::lit_intervals::ShadowCasters;
use crate::medium::ray_path::linear_source_integral;
use crate::picture::camera::PerspectiveCamera;
use crate::picture::{render_pixel, render_pixels};
use crate::test_scenes::{camera, furnace, glass, medium, quad, size, solution, sun, surface, walls, worst};
use crate::view_ray::ViewRay;
use crate::{Image, RenderOptions, render};
use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_math::parallel;
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_scene::{
    Bands, Camera, IntensityDistribution, Light, NoProgress, Plate, SkyDistribution, Solution,
};
use zonal_scene::{Facet, Pane, Scene, SceneParts, Sides, Surface};
use zonal_transport::Transport;
use zonal_transport::lights::{EmissionSample, LightSampler};

/// The view of a solution whose fields solve no equation, without the gathers near contacts, which would find other fields.
fn of_prescribed_fields(s: &Solution, cam: &Camera, options: &RenderOptions) -> Image {
    let transport = Transport::new(&s.scene);
    let pinhole = PerspectiveCamera::new(cam, options.width, options.height);
    render_pixels(&Integrator::new(s, &transport), &pinhole, options, &NoProgress)
}

#[test]
fn furnace_has_one_radiance_everywhere() {
    let closed = solution(furnace(), |_, _| 1.0, |_| 1.0);
    let mut open = furnace();
    open.facets.truncate(2);
    let open = solution(open, |_, _| 1.0, |_| 1.0);
    let empty = |parts: SceneParts| SceneParts { voxel_grid: None, ..parts };
    let vacuum = solution(empty(furnace()), |_, _| 1.0, |_| 1.0);
    for (s, from) in [
        (&vacuum, vec3(0.3, -0.8, 0.7)),
        (&closed, vec3(0.3, -0.8, 0.7)),
        (&closed, vec3(4.0, 3.0, 2.0)),
        (&open, vec3(0.3, -0.8, 0.7)),
        (&open, vec3(4.0, 3.0, 2.0)),
    ] {
        let image = render(s, &camera(from, vec3(0.0, 0.1, 0.6), 80.0), &size(64, 48), &NoProgress);
        assert!(worst(&image, 1.0 / PI) < 1e-6, "{from:?}: {}", worst(&image, 1.0 / PI));
    }
}

#[test]
fn linear_fields_are_rendered_exactly() {
    let (lo, hi) = (vec3(0.0, 0.0, 0.0), vec3(2.0, 2.0, 2.0));
    let f = |p: Vec3| 2.0 + 0.5 * p.x - 0.3 * p.y + 0.2 * p.z;
    let parts = SceneParts {
        surfaces: vec![surface("wall", 1.0, 0.0)],
        facets: walls(lo, hi),
        ..SceneParts::default()
    };
    let s = solution(parts.clone(), |p, _| f(p), |_| 0.0);
    let from = vec3(1.0, 1.0, 1.0);
    let cam = camera(from, vec3(1.0, 3.0, 1.0), 80.0);
    let one = RenderOptions { samples: 1, ..size(32, 32) };
    let image = of_prescribed_fields(&s, &cam, &one);
    let pinhole = PerspectiveCamera::new(&cam, 32, 32);
    let transport = Transport::new(&s.scene);
    for (i, c) in image.pixels.iter().enumerate() {
        let dir = pinhole.direction(((i % 32) as f64 + 0.5) / 32.0, ((i / 32) as f64 + 0.5) / 32.0);
        let t = transport.closest_hit(from, dir, 0.0, 100.0).unwrap().t;
        let exact = f(from + dir * t) / PI;
        assert!((c[1] as f64 / exact - 1.0).abs() < 1e-5, "{} {exact}", c[1]);
    }
    let mist = SceneParts {
        voxel_grid: Some(medium(lo, hi, [8, 8, 8], 0.7, 0.5)),
        surfaces: vec![surface("wall", 0.0, 0.0)],
        ..parts
    };
    let s = solution(mist, |_, _| 0.0, f);
    let image = render(&s, &cam, &one, &NoProgress);
    for (i, c) in image.pixels.iter().enumerate() {
        let dir = pinhole.direction(((i % 32) as f64 + 0.5) / 32.0, ((i / 32) as f64 + 0.5) / 32.0);
        let t = transport.closest_hit(from, dir, 0.0, 100.0).unwrap().t;
        let slope = f(from + dir) - f(from);
        let exact = linear_source_integral(0.7, t, f(from), slope) / PI;
        assert!((c[1] as f64 / exact - 1.0).abs() < 1e-4, "{} {exact}", c[1]);
    }
}

#[test]
fn beers_law_holds_through_a_pane_at_0_and_60_degrees() {
    let (lo, hi) = (Vec3::splat(-1.0), Vec3::splat(1.0));
    let mut parts = SceneParts {
        surfaces: vec![surface("wall", 0.0, 1.0)],
        facets: walls(lo, hi),
        ..SceneParts::default()
    };
    let extinction = [30.0, 10.0, 0.0];
    parts.panes.push(Pane {
        name: "glass".into(),
        plates: vec![Plate::parallelogram(vec3(-1.0, 0.0, -1.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 0.0, 2.0))],
        thickness: 0.02,
        extinction: Bands::from_rgb(extinction),
        albedo: Bands::ZERO,
        emission: Bands::ZERO,
    });
    let s = solution(parts, |_, _| 0.0, |_| 0.25);
    for angle in [0.0f64, 60.0] {
        let from = vec3(-0.5, -0.25, 0.0);
        let (sin, cos) = angle.to_radians().sin_cos();
        let image = render(&s, &camera(from, from + vec3(sin, cos, 0.0), 1e-6), &size(2, 2), &NoProgress);
        for (pixel, kappa) in image.pixels[0].into_iter().zip(extinction) {
            let tau = (-0.02 * kappa / cos).exp();
            let exact = (tau + (1.0 - tau) * 0.25) / PI;
            assert!((pixel as f64 / exact - 1.0).abs() < 1e-6, "{angle} {kappa}");
        }
    }
}

// Guards (pictures): no picture shows light through a wall.
#[test]
fn no_light_leaks_through_a_wall() {
    let (lo, hi) = (vec3(0.0, 0.0, 0.0), vec3(2.0, 1.0, 1.0));
    let mut facets = walls(lo, hi);
    let x = 1.03;
    facets.push(quad(0, vec3(x, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)));
    let parts = SceneParts {
        surfaces: vec![surface("wall", 0.8, 0.0)],
        facets,
        voxel_grid: Some(medium(lo, hi, [8, 4, 4], 0.5, 0.5)),
        ..SceneParts::default()
    };
    let bright = |p: Vec3| if p.x > x { 1.0 } else { 0.0 };
    let lit = |p: Vec3, n: Vec3| bright(p + n * 1e-3);
    let s = solution(parts, lit, bright);
    let dark = camera(vec3(0.1, 0.5, 0.5), vec3(2.0, 0.5, 0.4), 100.0);
    let dark = of_prescribed_fields(&s, &dark, &size(80, 60));
    let most = dark.pixels.iter().flatten().fold(0.0f32, |m, x| m.max(*x));
    assert!(most < 1e-3, "{most}");
    let light = camera(vec3(1.9, 0.5, 0.5), vec3(0.0, 0.5, 0.4), 100.0);
    let light = of_prescribed_fields(&s, &light, &size(80, 60));
    let least = light.pixels.iter().flatten().fold(1.0f32, |m, x| m.min(*x));
    assert!(least as f64 > 0.8 / PI - 1e-3, "{least}");
}

// Guards (determinism): pictures do not depend on the number of threads.
#[test]
fn threads_do_not_change_a_bit() {
    let mut parts = furnace();
    parts.facets.remove(1);
    parts.lights.push(sun(vec3(0.3, 0.2, -1.0), 0.05));
    parts.lights.push(Light::Sky {
        name: "sky".into(),
        radiance: Bands::from_rgb([0.1, 0.2, 0.3]),
        distribution: SkyDistribution::uniform(),
    });
    let s = solution(parts, |p, _| 1.0 + p.x, |p| 2.0 + p.z);
    let render_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let cam = camera(vec3(0.3, -0.8, 0.7), vec3(0.0, 0.1, 0.6), 80.0);
        let adaptive = RenderOptions { samples: 0, ..size(33, 26) };
        pool.install(|| [size(32, 24), adaptive].map(|o| render(&s, &cam, &o, &NoProgress)))
    };
    assert_eq!(render_with(1), render_with(3));
}

#[test]
fn shadow_edge_agrees_with_geometry() {
    // A roof over x < 0 at height 1 under a sun at 45° that shines towards +x: the floor is dark for x < 1.
    let parts = SceneParts {
        surfaces: vec![surface("wall", 0.5, 0.0)],
        facets: vec![
            quad(0, vec3(-3.0, -3.0, 0.0), vec3(6.0, 0.0, 0.0), vec3(0.0, 6.0, 0.0)),
            quad(0, vec3(-3.0, -3.0, 1.0), vec3(3.0, 0.0, 0.0), vec3(0.0, 6.0, 0.0)),
        ],
        lights: vec![sun(vec3(1.0, 0.0, -1.0), 0.0)],
        ..SceneParts::default()
    };
    let s = solution(parts, |_, _| 0.0, |_| 0.0);
    let n = 200;
    let cam = camera(vec3(1.0, 0.0, 3.0), vec3(1.0, 0.0, 0.0), 20.0);
    let cam = Camera { up: vec3(0.0, 1.0, 0.0), ..cam };
    let one = RenderOptions { samples: 1, ..size(n, 3) };
    let image = render(&s, &cam, &one, &NoProgress);
    let lit = 0.5 / 2f64.sqrt() / PI;
    for x in 0..n {
        let c = image.pixels[n + x][0] as f64;
        let exact = if x < n / 2 { 0.0 } else { lit };
        assert!((c - exact).abs() < 1e-6, "{x}: {c} {exact}");
    }
}

#[test]
fn scattered_sunlight_in_homogeneous_medium_agrees_with_closed_form() {
    // A slab 0 < z < 1 of κ, Ω under a sun straight above, seen along x from inside at height z:
    // L = κΩ E e^{−κ(1−z)}/(4π) (1 − e^{−κℓ})/κ.
    let (lo, hi) = (vec3(0.0, 0.0, 0.0), vec3(4.0, 4.0, 1.0));
    let (kappa, albedo) = (0.8, 0.6);
    let parts = SceneParts {
        voxel_grid: Some(medium(lo, hi, [9, 7, 5], kappa, albedo)),
        lights: vec![sun(vec3(0.0, 0.0, -1.0), 0.0)],
        ..SceneParts::default()
    };
    let s = solution(parts.clone(), |_, _| 0.0, |_| 0.0);
    let z = 0.3;
    let cam = camera(vec3(0.5, 2.0, z), vec3(4.0, 2.0, z), 1e-6);
    let image = render(&s, &cam, &size(2, 2), &NoProgress);
    let exact =
        |length: f64| albedo * (-kappa * (1.0 - z)).exp() / (4.0 * PI) * (1.0 - (-kappa * length).exp());
    let found = image.pixels[0][0] as f64;
    assert!((found / exact(3.5) - 1.0).abs() < 1e-5, "{found} {}", exact(3.5));
    assert!((image.pixels[0][2] as f64 / exact(3.5) / 3.0 - 1.0).abs() < 1e-5);
    // With a roof over 1 < x < 2.5 and a pane over 3 < x < 4.
    let mut parts = parts;
    parts.surfaces = vec![surface("roof", 0.0, 0.0)];
    parts.facets = vec![quad(0, vec3(1.0, 0.0, 1.5), vec3(1.5, 0.0, 0.0), vec3(0.0, 4.0, 0.0))];
    parts.panes =
        vec![glass(Plate::parallelogram(vec3(3.0, 0.0, 1.5), vec3(1.0, 0.0, 0.0), vec3(0.0, 4.0, 0.0)))];
    let s = solution(parts, |_, _| 0.0, |_| 0.0);
    let image = render(&s, &cam, &size(2, 2), &NoProgress);
    let glass = (-0.5f64).exp();
    let lit = exact(0.5) + exact(2.5) - exact(2.0) + glass * (exact(3.5) - exact(2.5));
    assert!((image.pixels[0][0] as f64 / lit - 1.0).abs() < 1e-5, "{} {lit}", image.pixels[0][0]);
}

/// A furnace open above, with random triangles inside.
fn cluttered_furnace() -> SceneParts {
    let mut parts = furnace();
    parts.facets.remove(1);
    for i in 0..40 {
        let r = |k: u64| low_discrepancy::hash_to_unit(i * 9 + k) - 0.5;
        let o = vec3(2.0 * r(0), 2.0 * r(1), 0.8 + r(2));
        let plate = Plate::triangle(o, o + vec3(r(3), r(4), r(5)) * 0.6, o + vec3(r(6), r(7), r(8)) * 0.6);
        parts.facets.push(Facet { surface: 0, plate, uv: [[0.0; 2]; 3] });
    }
    parts
}

#[test]
fn lit_intervals_agree_with_shadow_rays() {
    let parts = cluttered_furnace();
    let lamp = parts.facets.len() - 1;
    let scene = Scene::new(parts).unwrap();
    let transport = Transport::new(&scene);
    let shadows = ShadowCasters::new(&scene);
    let plate = scene.facets()[lamp].plate;
    let isotropic = IntensityDistribution::isotropic();
    let distant = vec3(0.3, 0.1, 0.9).normalized();
    let sources = [
        EmissionSample::Distant { direction: distant, fluence: Bands::ONE },
        EmissionSample::Point {
            position: plate.at(0.3, 0.4),
            normal: plate.normal(),
            two_sided: true,
            facet: Some(lamp),
            power: Bands::ONE,
        },
        EmissionSample::Intensity {
            position: vec3(0.31, -0.27, 0.83),
            intensity: Bands::ONE,
            distribution: &isotropic,
        },
    ];
    let mut wrong = 0;
    for source in &sources {
        for i in 0..200u64 {
            let p = |k: u64| {
                vec3(
                    low_discrepancy::hash_to_unit(k) * 1.8 - 0.9,
                    low_discrepancy::hash_to_unit(k + 1) * 1.8 - 0.9,
                    low_discrepancy::hash_to_unit(k + 2) * 1.4,
                )
            };
            let (a, b) = (p(1000 + 6 * i), p(1003 + 6 * i));
            let (length, dir) = ((b - a).length(), (b - a).normalized());
            let lit = shadows.lit_intervals(ViewRay { origin: a, dir }, source, 0.0, length);
            for k in 0..50 {
                let t = length * (k as f64 + 0.5) / 50.0;
                let x = a + dir * t;
                let point = source.intensity_towards(x).map(|(at, _)| at);
                let end = point.unwrap_or_else(|| transport.exterior_point(x, distant));
                let inside = lit.intervals.iter().any(|i| i.0 < t && t < i.1);
                wrong += usize::from(inside == transport.occluded(x, end));
            }
        }
    }
    assert!(wrong <= 2, "{wrong} of 30000");
}

#[test]
fn mean_over_flat_wall_is_its_radiosity() {
    let parts = SceneParts {
        surfaces: vec![surface("wall", 1.0, 0.0)],
        facets: vec![quad(0, vec3(-1.0, 1.0, -1.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 0.0, 2.0))],
        ..SceneParts::default()
    };
    let f = |p: Vec3, _: Vec3| 1.0 + 0.5 * (3.0 * p.x).sin() * (2.0 * p.z).cos();
    let s = solution(parts, f, |_| 0.0);
    let straight = Camera { up: vec3(0.0, 0.0, 1.0), ..camera(Vec3::ZERO, vec3(0.0, 1.0, 0.0), 90.0) };
    let image = render(&s, &straight, &size(100, 100), &NoProgress);
    let mean = image.pixels.iter().map(|p| p[0] as f64).sum::<f64>() / 1e4;
    let zones: f64 =
        s.zones.patches.iter().zip(&s.fields.incident).map(|(p, h): (_, &Bands)| p.area * h.first()).sum();
    let front: f64 = s.zones.patches.iter().map(|p| p.area).sum();
    assert!((mean * PI / (zones / front) - 1.0).abs() < 1e-3, "{} {}", mean * PI, zones / front);
}

/// The radiance of the second band along x at the distance δ from a light at the origin, as drawn and by quadrature; `fluence` is that of the light without a
/// medium.
fn inscattered(
    parts: SceneParts,
    delta: f64,
    (kappa, albedo): (f64, f64),
    fluence: impl Fn(Vec3) -> f64,
) -> [f64; 2] {
    let s = solution(parts, |_, _| 0.0, |_| 0.0);
    let from = vec3(-2.0, delta, 0.0);
    let image = render(&s, &camera(from, from + vec3(1.0, 0.0, 0.0), 1e-6), &size(2, 2), &NoProgress);
    let n = 200_000;
    let ds = 5.0 / n as f64;
    let at = |i: usize| {
        let t = (i as f64 + 0.5) * ds;
        let x = vec3(t - 2.0, delta, 0.0);
        kappa * albedo * (-kappa * (t + x.length())).exp() * fluence(x) / (4.0 * PI) * ds
    };
    [image.pixels[0][1] as f64, (0..n).map(at).sum()]
}

#[test]
fn point_lights_in_homogeneous_medium_agree_with_quadrature() {
    // Seen along x at distance δ: ∫ κΩ e^{−κ(s + r)} I(ω)/r² /(4π) ds.
    let (kappa, albedo) = (0.4, 0.7);
    let lo = Vec3::splat(-3.0);
    let up = vec3(0.2, 1.0, 0.1);
    let cases = [
        (IntensityDistribution::isotropic(), 0.02),
        (IntensityDistribution::spot(up, [0.1, 0.5]), 0.02),
        (IntensityDistribution::spot(up, [0.4, 0.4]), 0.02),
        (IntensityDistribution::spot(-up, [0.1, 0.5]), 0.0),
    ];
    for (distribution, tolerance) in cases {
        for delta in [1.0, 0.1, 0.02] {
            let lamp = Light::Point {
                name: "lamp".into(),
                position: Vec3::ZERO,
                intensity: Bands::from_rgb([5.0, 3.0, 1.0]),
                distribution: distribution.clone(),
            };
            let parts = SceneParts {
                voxel_grid: Some(medium(lo, -lo, [11, 9, 10], kappa, albedo)),
                lights: vec![lamp],
                ..SceneParts::default()
            };
            let fluence = |x: Vec3| 3.0 * distribution.relative(x.normalized()) / x.length2();
            let [found, sum] = inscattered(parts, delta, (kappa, albedo), fluence);
            assert!((found - sum).abs() <= tolerance * sum, "{distribution:?} {delta}: {found} {sum}");
        }
    }
}

#[test]
fn small_emitter_in_homogeneous_medium_agrees_with_quadrature() {
    // A square of side h at the origin facing +y, seen along x at distance δ: ∫ κΩ e^{−κ(s + r)} (E h²/π)(δ/r)/r² /(4π) ds.
    let (kappa, albedo, h) = (0.4, 0.7, 1e-3);
    let lo = Vec3::splat(-3.0);
    for delta in [1.0, 0.1, 0.02] {
        let parts = SceneParts {
            surfaces: vec![Surface { sides: Sides::Front, ..surface("lamp", 0.0, 5.0) }],
            facets: vec![quad(0, vec3(-h / 2.0, 0.0, -h / 2.0), vec3(0.0, 0.0, h), vec3(h, 0.0, 0.0))],
            voxel_grid: Some(medium(lo, -lo, [11, 9, 10], kappa, albedo)),
            lights: vec![Light::Emitter { surface: 0, name: None }],
            ..SceneParts::default()
        };
        let fluence = |x: Vec3| 5.0 * h * h / PI * delta / x.length().powi(3);
        let [found, sum] = inscattered(parts, delta, (kappa, albedo), fluence);
        assert!((found / sum - 1.0).abs() < 0.02, "{delta}: {found} {sum}");
    }
}

/// A room full of fog with a square lamp of side 0.4 m below the ceiling, an optional shelf below it, and black walls.
fn fog_room(sides: Sides, kappa: f64, shelf: bool) -> Solution {
    let (lo, hi) = (vec3(-2.0, -2.0, 0.0), vec3(2.0, 2.0, 2.5));
    let mut facets = walls(lo, hi);
    facets.push(quad(1, vec3(-0.2, -0.2, 1.8), vec3(0.0, 0.4, 0.0), vec3(0.4, 0.0, 0.0)));
    if shelf {
        facets.push(quad(0, vec3(0.1, -0.3, 1.2), vec3(0.6, 0.0, 0.0), vec3(0.0, 0.6, 0.0)));
    }
    let lamp = Surface { sides, ..surface("lamp", 0.0, 10.0) };
    let parts = SceneParts {
        surfaces: vec![surface("wall", 0.0, 0.0), lamp],
        facets,
        voxel_grid: Some(medium(lo, hi, [16, 16, 10], kappa, 0.7)),
        lights: vec![Light::Emitter { surface: 1, name: None }],
        ..SceneParts::default()
    };
    solution(parts, |_, _| 0.0, |_| 0.0)
}

fn fog_camera() -> Camera {
    camera(vec3(-1.7, -1.4, 1.4), vec3(0.0, 0.0, 1.55), 60.0)
}

/// The first band of all pixels.
fn render_first_band(integrator: &Integrator, cam: &Camera, o: &RenderOptions) -> Vec<f64> {
    let pinhole = PerspectiveCamera::new(cam, o.width, o.height);
    let one = |i: usize| render_pixel(integrator, &pinhole, o, [i % o.width, i / o.width])[0] as f64;
    parallel::collect(o.width * o.height, one)
}

#[test]
fn fog_beside_area_light_is_free_of_noise() {
    for (sides, kappa) in [(Sides::Front, 0.15), (Sides::Both, 1.0)] {
        let s = fog_room(sides, kappa, true);
        let transport = Transport::new(&s.scene);
        let o = size(28, 21);
        let many = RenderOptions { light_samples: 400, ..o.clone() };
        let sampled = Integrator::new(&s, &transport).with_sampled_lights_only();
        let analytic = Integrator::new(&s, &transport);
        let exact = render_first_band(&sampled, &fog_camera(), &many);
        let compare = |image: &[f64]| {
            let square = |(x, e): (&f64, &f64)| (x / e - 1.0).powi(2);
            let rms = (image.iter().zip(&exact).map(square).sum::<f64>() / exact.len() as f64).sqrt();
            (rms, image.iter().sum::<f64>() / exact.iter().sum::<f64>() - 1.0)
        };
        let old = compare(&render_first_band(&sampled, &fog_camera(), &o));
        let new = compare(&render_first_band(&analytic, &fog_camera(), &o));
        assert!(new.0 < 0.2 * old.0, "{sides:?} {kappa}: {old:?} {new:?}");
        assert!(new.1.abs() < 5e-3, "{sides:?} {kappa}: {old:?} {new:?}");
    }
}

#[test]
fn fog_beside_unoccluded_area_light_agrees_with_quadrature() {
    let kappa = 1.0;
    let s = fog_room(Sides::Front, kappa, false);
    let transport = Transport::new(&s.scene);
    let integrator = Integrator::new(&s, &transport);
    let plate = s.scene.facets()[6].plate;
    // Rays 2 cm, 20 cm and 1 m below the lamp, across its plane, beside it, straight down from it, and into it.
    for (origin, target) in [
        (vec3(-1.9, 0.05, 1.78), vec3(1.9, 0.05, 1.78)),
        (vec3(-1.9, -0.3, 1.6), vec3(1.9, 0.1, 1.6)),
        (vec3(-1.9, -1.0, 0.8), vec3(1.9, -0.5, 0.8)),
        (vec3(-1.9, -1.3, 1.3), vec3(0.3, 0.9, 2.2)),
        (vec3(-1.9, -0.25, 1.9), vec3(1.9, -0.25, 1.5)),
        (vec3(-0.1, 0.0, 1.799), vec3(-0.15, 0.0, 0.0)),
        (vec3(-1.5, -1.0, 0.3), vec3(0.05, 0.02, 1.8)),
    ] {
        let (length, dir) = ((target - origin).length(), (target - origin).normalized());
        let n = 3000;
        let m = 60;
        let at = |t: f64| {
            let x = origin + dir * t;
            let g: f64 = (0..m * m)
                .map(|i| {
                    let to_point =
                        plate.at(((i % m) as f64 + 0.5) / m as f64, ((i / m) as f64 + 0.5) / m as f64) - x;
                    let r = to_point.length();
                    (-kappa * r).exp() * (-to_point.dot(plate.normal())).max(0.0) / r.powi(3)
                })
                .sum();
            let power = 10.0 * plate.area() / (m * m) as f64 / PI;
            0.7 * kappa * (-kappa * t).exp() * power * g / (4.0 * PI)
        };
        let step = length / n as f64;
        let exact: f64 = (0..n).into_par_iter().map(|i| at((i as f64 + 0.5) * step) * step).sum();
        let found = integrator.scattered(ViewRay { origin, dir }, length, 64).first();
        assert!((found / exact - 1.0).abs() < 0.012, "{target:?}: {found} {exact}");
    }
}

/// Fog under a lid with a hole and a pane beside it.
fn fog_under_lid(light: Light) -> SceneParts {
    let (lo, hi) = (vec3(0.0, 0.0, 0.0), vec3(4.0, 4.0, 2.0));
    let lid = |x: f64, y: f64, w: f64, d: f64| quad(0, vec3(x, y, 2.5), vec3(w, 0.0, 0.0), vec3(0.0, d, 0.0));
    SceneParts {
        surfaces: vec![surface("lid", 0.0, 0.0)],
        facets: vec![
            lid(-2.0, -2.0, 8.0, 3.0),
            lid(-2.0, 2.0, 8.0, 4.0),
            lid(2.6, 1.0, 3.4, 1.0),
            lid(-2.0, 1.0, 2.5, 1.0),
        ],
        panes: vec![glass(Plate::parallelogram(
            vec3(1.5, 1.0, 2.5),
            vec3(1.1, 0.0, 0.0),
            vec3(0.0, 1.0, 0.0),
        ))],
        voxel_grid: Some(medium(lo, hi, [9, 7, 5], 0.2, 0.9)),
        lights: vec![light],
        ..SceneParts::default()
    }
}

#[test]
fn deep_shadow_map_agrees_with_exact_lit_intervals() {
    // A sun of 2 degrees.
    let light = sun(vec3(0.3, 0.1, -1.0).normalized(), 2.0f64.to_radians());
    let parts = fog_under_lid(light.clone());
    let s = solution(parts, |_, _| 0.0, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let integrator = Integrator::new(&s, &transport);
    let lamp = LightSampler::new(&s.scene, &light);
    for (from, to) in [
        (vec3(0.1, 0.5, 0.2), vec3(3.9, 2.2, 1.4)),
        (vec3(2.0, 0.1, 1.0), vec3(1.4, 3.9, 0.3)),
        (vec3(3.8, 1.5, 1.9), vec3(0.2, 1.6, 1.8)),
        (vec3(1.2, 1.4, 0.1), vec3(1.3, 1.5, 1.9)),
    ] {
        let count = 400;
        let (mut ours, mut exact) = (Bands::ZERO, Bands::ZERO);
        let length = (to - from).length();
        let ray = ViewRay { origin: from, dir: (to - from).normalized() };
        for i in 0..count {
            let shift = [0.3, 0.6, 0.9];
            ours += integrator.scattered_by_suns(ray, length, RaySampler::of_ray(i, 1, shift)) / count as f64;
            let source = lamp.sample_emission(low_discrepancy::r3(i, shift)).unwrap();
            exact += integrator.scattered_exactly(ray, length, &source) / count as f64;
        }
        assert!(exact.all(|x| x > 1e-4), "{from:?} {exact:?}");
        assert!((ours / exact - 1.0).all(|x| x.abs() < 0.01), "{from:?} {ours:?} {exact:?}");
    }
}
