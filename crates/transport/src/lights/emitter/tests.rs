use super::*;
use zonal_math::low_discrepancy;
use zonal_math::vec3;
use zonal_scene::{Facet, Plate, PlateKind, SceneParts, Surface, Texture};

/// Samples of a mean.
const SAMPLE_COUNT: u32 = 1 << 12;

/// A scene of one surface with emission π, radiance 1.
fn emitting_scene(plates: &[Plate], sides: Sides, texture: Option<Texture>) -> Scene {
    let surface = Surface {
        name: "lamp".into(),
        emission: Bands::splat(PI),
        emission_texture: texture.as_ref().map(|_| 0),
        sides,
        ..Surface::default()
    };
    let uv = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let facets = plates.iter().map(|&plate| Facet { surface: 0, plate, uv }).collect();
    let textures = texture.into_iter().collect();
    Scene::new(SceneParts { surfaces: vec![surface], facets, textures, ..SceneParts::default() }).unwrap()
}

fn roof() -> Plate {
    Plate::parallelogram(vec3(-12.0, -3.0, 0.0), vec3(24.0, 0.0, 0.0), vec3(1.0, 6.0, 0.0))
}

fn plates() -> [Plate; 3] {
    let tilted = Plate::triangle(vec3(0.1, 0.2, 0.3), vec3(2.0, 0.5, -0.4), vec3(0.6, 1.5, 0.9));
    let narrow = Plate::parallelogram(vec3(0.0, 0.0, 0.0), vec3(5.0, 0.0, 1.0), vec3(0.0, 0.01, 0.0));
    [roof(), tilted, narrow]
}

/// Points in front of a plate: far, near, very near, above its edge, beside it, and close to its plane beside it.
fn points(plate: &Plate) -> Vec<Vec3> {
    let n = plate.normal();
    let size = plate.diameter();
    let heights = [300.0, 1.0, 1e-2, 1e-4, 1e-6];
    let feet = [[0.3, 0.25], [0.0, 0.4], [-0.2, 0.3], [-0.001, 0.4], [1e-7, 0.3], [-0.3, 1.5]];
    let at = |[u, v]: [f64; 2]| heights.map(|h| plate.at(u, v) + n * (h * size));
    feet.into_iter().flat_map(at).collect()
}

fn spots(e: &Emitter, p: Vec3, receiver: Receiver, n: u32) -> impl Iterator<Item = Option<EmitterPoint>> {
    (0..n).map(move |k| {
        let [x, y] = low_discrepancy::sobol_2d(k, [0x1234_5678, 0x9abc_def0]);
        e.sample_solid_angle(p, receiver, [x, y, (k as f64 + 0.5) / n as f64])
    })
}

/// H or G as the mean over samples.
fn sampled(e: &Emitter, p: Vec3, receiver: Receiver, n: u32) -> f64 {
    let cosine = |s: &EmitterPoint| match receiver {
        Receiver::Free => 1.0,
        Receiver::Surface(front) => front.dot((s.at - p).normalized()).max(0.0),
    };
    spots(e, p, receiver, n).flatten().map(|s| s.fluence.first() * cosine(&s)).sum::<f64>() / n as f64
}

#[test]
fn sample_fluence_is_the_solid_angle() {
    for plate in plates() {
        let scene = emitting_scene(&[plate], Sides::Front, None);
        let e = Emitter::new(&scene, 0);
        for p in points(&plate) {
            let exact = solid_angle(&plate, p);
            assert!((e.unoccluded(p, Receiver::Free).first() - exact).abs() < 1e-12);
            for s in spots(&e, p, Receiver::Free, 64) {
                let got = s.unwrap().fluence.first();
                assert!((got - exact).abs() < 1e-7 * exact + 1e-12, "{p:?}: {got} {exact}");
            }
        }
    }
}

#[test]
fn sampled_directions_are_uniform_over_any_part() {
    for plate in plates() {
        let scene = emitting_scene(&[plate], Sides::Front, None);
        let e = Emitter::new(&scene, 0);
        for p in points(&plate) {
            let all = solid_angle(&plate, p);
            let [x, y]: [f64; 2] = [0.31, 0.22];
            let part = Plate { e1: plate.e1 * x, e2: plate.e2 * y, ..plate };
            let within = |s: EmitterPoint| {
                let [u, v] = part.parameters(s.at);
                u < 1.0 && v < 1.0 && (plate.kind == PlateKind::Parallelogram || u + v < 1.0)
            };
            let got = spots(&e, p, Receiver::Free, SAMPLE_COUNT).filter(|s| within(s.unwrap())).count()
                as f64
                / SAMPLE_COUNT as f64;
            let want = solid_angle(&part, p) / all;
            // Where the solid angle is at the level of rounding the fraction is not tested.
            let limit = if all > 1e-7 { 6e-3 } else { 1.0 };
            assert!((got - want).abs() < limit, "{plate:?} {p:?}: {got} {want}, {all}");
        }
    }
}

#[test]
fn mean_irradiance_matches_closed_form() {
    for plate in plates() {
        let scene = emitting_scene(&[plate], Sides::Front, None);
        let e = Emitter::new(&scene, 0);
        let n = plate.normal();
        let (t, b) = n.frame();
        for p in points(&plate) {
            for front in [-n, t, -t, (b - n * 0.1).normalized(), (t * 0.7 + n * 0.3).normalized(), n] {
                let receiver = Receiver::Surface(front);
                let exact = e.unoccluded(p, receiver).first();
                let all = solid_angle(&plate, p);
                let mean = sampled(&e, p, receiver, SAMPLE_COUNT);
                assert!(
                    (mean - exact).abs() < 3e-3 * exact + 1e-6 * all + 1e-12,
                    "{p:?} {front:?}: {mean} {exact}"
                );
            }
        }
    }
}

#[test]
fn back_and_plane_receive_no_light_from_one_sided_emitters() {
    for plate in plates() {
        let (front, both) =
            (emitting_scene(&[plate], Sides::Front, None), emitting_scene(&[plate], Sides::Both, None));
        let (one, two) = (Emitter::new(&front, 0), Emitter::new(&both, 0));
        let up = plate.normal();
        for p in points(&plate) {
            let mirrored = p - up * (2.0 * (p - plate.origin).dot(up));
            assert!(spots(&one, mirrored, Receiver::Free, 8).all(|s| s.is_none()));
            assert_eq!(one.unoccluded(mirrored, Receiver::Free), Bands::ZERO);
            let exact = solid_angle(&plate, p);
            for receiver in [Receiver::Free, Receiver::Surface(up)] {
                let (mean, closed) = (
                    sampled(&two, mirrored, receiver, SAMPLE_COUNT),
                    two.unoccluded(mirrored, receiver).first(),
                );
                assert!(
                    (mean - closed).abs() < 3e-3 * closed + 1e-6 * exact + 1e-12,
                    "{p:?}: {mean} {closed}"
                );
            }
        }
        for uv in [[0.2, 0.3], [-1.0, 0.5]] {
            let p = plate.at(uv[0], uv[1]);
            assert!(spots(&two, p, Receiver::Free, 8).all(|s| s.is_none()));
            assert_eq!(two.unoccluded(p, Receiver::Surface(up)), Bands::ZERO);
        }
    }
}

#[test]
fn samples_stay_on_the_plate_and_bounded_for_any_receiver() {
    for (k, plate) in plates().into_iter().enumerate() {
        let scene = emitting_scene(&[plate], Sides::Both, None);
        let e = Emitter::new(&scene, 0);
        for i in 0..4000u64 {
            let r: [f64; 6] =
                std::array::from_fn(|m| low_discrepancy::hash_to_unit((i * 3 + k as u64) * 6 + m as u64));
            let height = 10f64.powf(12.0 * r[0] - 10.0) * if i % 2 == 0 { 1.0 } else { -1.0 };
            let spread = 10f64.powf(4.0 * r[1] - 2.0);
            let at = plate.at(0.5 + spread * (r[2] - 0.5), 0.5 + spread * (r[3] - 0.5));
            let p = at + plate.normal() * height;
            let front = on_sphere([r[4], r[5]]);
            for receiver in [Receiver::Free, Receiver::Surface(front)] {
                for s in spots(&e, p, receiver, 4).flatten() {
                    assert!(
                        s.fluence.first() > 0.0 && s.fluence.first() < 2.0 * PI * (1.0 + 1e-9),
                        "{p:?} {s:?}"
                    );
                    let [u, v] = plate.parameters(s.at);
                    let rim = -1e-9..1.0 + 1e-9;
                    assert!(rim.contains(&u) && rim.contains(&v), "{p:?} {u} {v}");
                    assert!(plate.kind != PlateKind::Triangle || u + v < 1.0 + 1e-9, "{p:?} {u} {v}");
                }
            }
        }
    }
}

fn on_sphere(s: [f64; 2]) -> Vec3 {
    let z = 2.0 * s[0] - 1.0;
    let (sin, cos) = (2.0 * PI * s[1]).sin_cos();
    vec3(cos, sin, 0.0) * (1.0 - z * z).sqrt() + vec3(0.0, 0.0, z)
}

/// The roof in n × n plates.
fn tiles(n: usize) -> Vec<Plate> {
    let whole = roof();
    let (e1, e2) = (whole.e1 / n as f64, whole.e2 / n as f64);
    let tile =
        |k: usize| Plate::parallelogram(whole.origin + e1 * (k / n) as f64 + e2 * (k % n) as f64, e1, e2);
    (0..n * n).map(tile).collect()
}

#[test]
fn subdivided_emitter_gives_the_same_light() {
    let whole = emitting_scene(&[roof()], Sides::Front, None);
    let whole = Emitter::new(&whole, 0);
    for (n, limit) in [(2, 3e-3), (4, 3e-3), (6, 0.02)] {
        let scene = emitting_scene(&tiles(n), Sides::Front, None);
        let e = Emitter::new(&scene, 0);
        assert_eq!(e.is_uniform(), n * n <= MAX_FACETS_WITHOUT_TREE);
        for p in [vec3(1.0, 0.5, 4.0), vec3(-30.0, 2.0, 3.0)] {
            for receiver in [Receiver::Free, Receiver::Surface(vec3(0.6, 0.0, -0.8))] {
                let (mean, exact) =
                    (sampled(&e, p, receiver, SAMPLE_COUNT), whole.unoccluded(p, receiver).first());
                assert!((mean / exact - 1.0).abs() < limit, "{n} {p:?}: {mean} {exact}");
            }
        }
    }
}

#[test]
fn closed_body_is_sampled_on_facing_facets_only() {
    let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0), vec3(0.0, 0.0, 3.0));
    let (o, far) = (Vec3::ZERO, vec3(1.0, 2.0, 3.0));
    let faces = [(o, y, x), (o, z, y), (o, x, z), (far, -x, -y), (far, -y, -z), (far, -z, -x)];
    let scene = emitting_scene(&faces.map(|(o, a, b)| Plate::parallelogram(o, a, b)), Sides::Front, None);
    let e = Emitter::new(&scene, 0);
    for p in [vec3(4.0, 5.0, 6.0), vec3(0.5, 1.0, 3.001), vec3(-2.0, 1.0, 1.0)] {
        for receiver in [Receiver::Free, Receiver::Surface(vec3(0.0, 0.0, -1.0))] {
            let (mean, exact) = (sampled(&e, p, receiver, SAMPLE_COUNT), e.unoccluded(p, receiver).first());
            assert!((mean - exact).abs() < 3e-3 * exact + 1e-12, "{p:?}: {mean} {exact}");
        }
        assert!(spots(&e, p, Receiver::Free, 64).all(|s| s.is_some()));
    }
}

#[test]
fn textured_emission_is_evaluated_at_the_sampled_point() {
    let texture = Texture { width: 2, height: 1, pixels: vec![[0.1, 1.0, 0.0], [0.9, 0.0, 1.0]] };
    let scene = emitting_scene(&[roof()], Sides::Front, Some(texture));
    let e = Emitter::new(&scene, 0);
    assert!(!e.is_uniform());
    let p = vec3(3.0, 0.5, 2.5);
    let mut sums = [Bands::ZERO; 2];
    for (k, s) in spots(&e, p, Receiver::Free, 4 * SAMPLE_COUNT).enumerate() {
        let spot = s.unwrap();
        let by_area =
            e.sample_area([low_discrepancy::r1(k, 0.3), (k as f64 + 0.5) / (4 * SAMPLE_COUNT) as f64, 0.5]);
        let Some(EmissionSample::Point { position: at, normal, power, .. }) = by_area else {
            panic!("an emitter yields point samples");
        };
        let d = p - at;
        let weight = normal.dot(d) / d.length().powi(3);
        sums = [sums[0] + spot.fluence, sums[1] + power * weight];
    }
    assert!((sums[0] / sums[1] - 1.0).abs().all(|e| e < 5e-3), "{sums:?}");
}

#[test]
fn samples_of_a_view_are_those_of_single_points() {
    let one = vec![roof()];
    for (name, list) in [("one facet", one), ("few", plates().to_vec()), ("clusters", tiles(12))] {
        let scene = emitting_scene(&list, Sides::Both, None);
        let e = Emitter::new(&scene, 0);
        assert_eq!(e.is_clustered(), name == "clusters");
        for p in [vec3(0.3, 0.2, 1.5), vec3(0.1, 0.1, 1e-3), vec3(2.0, -4.0, -0.5)] {
            for receiver in [Receiver::Free, Receiver::Surface(vec3(0.6, 0.0, -0.8))] {
                let mut view = e.view(p, receiver);
                for (k, single) in spots(&e, p, receiver, 64).enumerate() {
                    let [x, y] = low_discrepancy::sobol_2d(k as u32, [0x1234_5678, 0x9abc_def0]);
                    let kept = view.sample([x, y, (k as f64 + 0.5) / 64.0]);
                    let [kept, single] = [kept, single].map(|s| s.map(|s| (s.at, s.fluence)));
                    assert_eq!(kept, single, "{name}, {p:?}, sample {k}");
                }
            }
        }
    }
}
