//! Depth of field against the thin-lens formula.

use crate::test_scenes::{quad, solution, surface, walls};
use crate::{RenderOptions, focus_distances, render, render_each};
use zonal_math::vec3;
use zonal_scene::{Camera, Lens, NoProgress, SceneParts, Solution};

/// A bright half plane x > 0 before black, at `distance` (m) from the camera.
fn edge(distance: f64) -> Solution {
    let parts = SceneParts {
        surfaces: vec![surface("bright", 0.0, 1.0)],
        facets: vec![quad(0, vec3(0.0, distance, -9.0), vec3(30.0, 0.0, 0.0), vec3(0.0, 0.0, 18.0))],
        ..SceneParts::default()
    };
    solution(parts, |_, _| 0.0, |_| 0.0)
}

fn lens_camera(aperture: f64, focus: Option<f64>) -> Camera {
    let ahead = Camera::look_at([0.0; 3], [0.0, 1.0, 0.0]);
    Camera { fov: 40.0, lens: Lens { aperture, focus }, ..ahead }
}

/// Standard deviation of the edge's blur at its distance, m.
fn spread(distance: f64, camera: &Camera) -> f64 {
    let (width, height) = (240, 24);
    let options = RenderOptions { width, height, samples: 64, light_samples: 1, gather: 0 };
    let image = render(&edge(distance), camera, &options, &NoProgress);
    let column = |x: usize| (0..height).map(|y| image.pixels[y * width + x][0] as f64).sum::<f64>();
    let step = 2.0 * distance * (0.5 * camera.fov.to_radians()).tan() / width as f64;
    let (mut all, mut square) = (0.0, 0.0);
    for x in 1..width {
        let rise = column(x) - column(x - 1);
        all += rise;
        square += rise * ((x as f64 - 0.5 * width as f64) * step).powi(2);
    }
    // Subtract the variance of a pixel.
    (square / all - step * step / 12.0).max(0.0).sqrt()
}

// Guards (pictures): blur agrees with the thin-lens formula.
#[test]
fn blur_of_an_edge_agrees_with_the_thin_lens_formula() {
    for (aperture, focus, distance) in [(0.2, 2.0, 3.0), (0.2, 3.0, 2.0), (0.1, 4.0, 1.6)] {
        // A disc of diameter c = A |D − F|/F has the standard deviation c/4 across the edge.
        let expected = aperture * f64::abs(distance - focus) / focus / 4.0;
        let found = spread(distance, &lens_camera(aperture, Some(focus)));
        assert!((found / expected - 1.0).abs() < 0.03, "{focus} {distance}: {found} for {expected}");
        let pixel = 2.0 * focus * 20f64.to_radians().tan() / 240.0;
        assert!(spread(focus, &lens_camera(aperture, Some(focus))) < 0.5 * pixel);
    }
}

fn room() -> Solution {
    let parts = SceneParts {
        surfaces: vec![surface("wall", 0.5, 0.2)],
        facets: walls(vec3(-1.0, -1.0, -1.0), vec3(1.0, 2.5, 1.0)),
        ..SceneParts::default()
    };
    solution(parts, |p, _| 1.0 + p.x * p.z, |_| 0.0)
}

#[test]
fn default_focus_is_the_distance_in_the_middle_of_the_picture() {
    let s = room();
    let o = RenderOptions { width: 24, height: 18, ..RenderOptions::default() };
    // A wide angle, so that the side walls are visible.
    let wide = |aperture, focus| Camera { fov: 90.0, ..lens_camera(aperture, focus) };
    let draw = |aperture, focus| render(&s, &wide(aperture, focus), &o, &NoProgress);
    let sharp = draw(0.0, None);
    assert!(sharp == draw(0.0, Some(0.3)));
    assert_eq!(focus_distances(&s, &[wide(0.0, None)]), [Some(2.5)]);
    let blurred = draw(0.3, None);
    assert!(blurred != sharp);
    assert!(blurred == draw(0.3, Some(2.5)));
    let past = Camera { target: vec3(-1.0, 1.0, 0.0), ..lens_camera(0.1, None) };
    assert_eq!(focus_distances(&edge(1.0), &[past]), [None]);
}

#[test]
fn pictures_are_identical_one_by_one_or_together_on_any_number_of_threads() {
    let s = room();
    let o = RenderOptions { width: 24, height: 18, ..RenderOptions::default() };
    let cameras = [lens_camera(0.3, None), lens_camera(0.0, None), lens_camera(0.1, Some(1.0))];
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut all = Vec::new();
        let done = pool.install(|| {
            render_each(&s, &cameras, &o, &NoProgress, |i, image| {
                all.push((i, image));
                if i == 2 { Err("stopped") } else { Ok(()) }
            })
        });
        assert_eq!(done, Err("stopped"));
        for (i, image) in all {
            assert!(image == render(&s, &cameras[i], &o, &NoProgress), "{threads} {i}");
        }
    }
}
