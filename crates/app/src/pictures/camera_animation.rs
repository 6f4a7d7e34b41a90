//! Frames of a camera animation: camera, exposure and light factors between key frames.
//!
//! Every number (positions, field of view, lens, stops, light factors) is a cubic Hermite polynomial in time between two keys, with the slopes of Steffen
//! (*A simple method for monotonic interpolation*, 1990): with h the times between keys and s the slopes of the chords,
//!
//! ```text
//! p = (s₀ h₁ + s₁ h₀)/(h₀ + h₁)        slope = (sign s₀ + sign s₁) · min(|s₀|, |s₁|, |p|/2)
//! ```
//!
//! and 0 at both ends. The curve is continuously differentiable and monotone between two keys: a camera stays in the box of its two keys, no factor is
//! negative, and values between equal keys are constant. The motion starts and ends at rest.

use zonal_io::input::{CameraPath, KeyFrame};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Band, Bands, Camera, Lens};

/// Camera, exposure and lights of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationFrame {
    /// Camera.
    pub camera: Camera,
    /// Exposure relative to that of all frames, stops.
    pub stops: f64,
    /// Factor of each light group.
    pub lights: Vec<Bands>,
}

/// All frames, from the first key to the last.
pub fn animation_frames(path: &CameraPath) -> Vec<AnimationFrame> {
    let times: Vec<f64> = path.keys.iter().map(|k| k.time).collect();
    let values: Vec<Vec<f64>> = path.keys.iter().map(numbers_of_key).collect();
    let slopes = steffen_slopes(&times, &values);
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Vec::new() };
    let count = ((last - first) * path.frames_per_second + 1e-6).floor() as usize;
    (0..=count)
        .map(|i| {
            let t = (first + i as f64 / path.frames_per_second).min(*last);
            let after = times.partition_point(|x| *x <= t).clamp(1, times.len().max(2) - 1);
            if times.len() == 1 {
                return frame_from_numbers(i, &values[0]);
            }
            let (a, b) = (after - 1, after);
            let h = times[b] - times[a];
            let at = |c: usize| {
                let (ends, slopes) = ([values[a][c], values[b][c]], [slopes[a][c], slopes[b][c]]);
                hermite(ends, slopes.map(|s| s * h), (t - times[a]) / h)
            };
            frame_from_numbers(i, &(0..values[a].len()).map(at).collect::<Vec<f64>>())
        })
        .collect()
}

/// All numbers of a key, in a fixed order.
fn numbers_of_key(key: &KeyFrame) -> Vec<f64> {
    let c = &key.camera;
    let positions = [c.origin, c.target, c.up.normalized()].into_iter().flat_map(Vec3::array);
    let rest = [c.fov, c.lens.aperture, c.lens.focus.unwrap_or(1.0), key.stops];
    positions.chain(rest).chain(key.lights.iter().copied().flatten()).collect()
}

/// The frame of numbers in the order of [`numbers_of_key`].
fn frame_from_numbers(frame: usize, x: &[f64]) -> AnimationFrame {
    let position = |i: usize| vec3(x[i], x[i + 1], x[i + 2]);
    let lens = Lens { aperture: x[10], focus: Some(x[11]) };
    let camera =
        Camera::look_at(position(0).array(), position(3).array()).name(format!("frame {}", frame + 1));
    let lights = x[13..].chunks(Band::all().len()).filter_map(|c| Bands::try_from(c).ok()).collect();
    AnimationFrame { camera: Camera { up: position(6), fov: x[9], lens, ..camera }, stops: x[12], lights }
}

/// Cubic Hermite polynomial from `a` to `b` with the end slopes `p` and `q`, for s from 0 to 1, clamped to the range of `a` and `b`.
fn hermite([a, b]: [f64; 2], [p, q]: [f64; 2], s: f64) -> f64 {
    if a == b {
        return a;
    }
    let rise = b - a;
    let x = a + s * (p + s * (3.0 * rise - 2.0 * p - q + s * (p + q - 2.0 * rise)));
    x.clamp(a.min(b), a.max(b))
}

/// Slopes of Steffen of every number at every key.
fn steffen_slopes(times: &[f64], values: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let chord = |i: usize, c: usize| (values[i + 1][c] - values[i][c]) / (times[i + 1] - times[i]);
    let at = |i: usize, c: usize| {
        if i == 0 || i + 1 == times.len() {
            return 0.0;
        }
        let (h0, h1) = (times[i] - times[i - 1], times[i + 1] - times[i]);
        let (s0, s1) = (chord(i - 1, c), chord(i, c));
        if s0 * s1 <= 0.0 {
            return 0.0;
        }
        let p = (s0 * h1 + s1 * h0) / (h0 + h1);
        2.0 * s0.signum() * s0.abs().min(s1.abs()).min(0.5 * p.abs())
    };
    (0..times.len()).map(|i| (0..values[i].len()).map(|c| at(i, c)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, x: f64, fov: f64, sun: f64) -> KeyFrame {
        let lens = Lens { aperture: 0.01, focus: Some(2.0 + x) };
        let ahead = Camera::look_at([x, 0.0, 1.0], [x, 5.0, 1.0]);
        let camera = Camera { up: vec3(0.0, 0.0, 2.0), fov, lens, ..ahead };
        KeyFrame { time, camera, stops: -x, lights: vec![Bands::from_rgb([sun, 1.0, 0.0])] }
    }

    fn red(factor: Bands) -> f64 {
        factor.to_rgb()[0]
    }

    fn frames(keys: Vec<KeyFrame>) -> Vec<AnimationFrame> {
        animation_frames(&CameraPath { frames_per_second: 10.0, exposure: None, keys })
    }

    // Guards (pictures): a camera path stays between its keys.
    #[test]
    fn frames_meet_keys_and_do_not_overshoot() {
        let keys = vec![
            key(1.0, 0.0, 60.0, 1.0),
            key(2.0, 1.0, 20.0, 0.0),
            key(2.5, 5.0, 20.0, 0.0),
            key(5.0, 4.0, 70.0, 3.0),
        ];
        let all = frames(keys.clone());
        assert_eq!(all.len(), 41);
        for (frame, k) in [(0, 0), (10, 1), (15, 2), (40, 3)] {
            let (s, k) = (&all[frame], &keys[k]);
            assert!((s.camera.origin - k.camera.origin).length() < 1e-9 && (s.stops - k.stops).abs() < 1e-9);
            assert!(
                (s.camera.fov - k.camera.fov).abs() < 1e-9
                    && (red(s.lights[0]) - red(k.lights[0])).abs() < 1e-9
            );
            assert!(s.camera.check().is_ok());
        }
        for (i, s) in all.iter().enumerate() {
            let t = 1.0 + i as f64 * 0.1;
            let b = keys.iter().position(|k| k.time > t - 1e-9).unwrap().max(1);
            let within = |x: f64, a: f64, b: f64| x >= a.min(b) - 1e-9 && x <= a.max(b) + 1e-9;
            assert!(within(s.camera.origin.x, keys[b - 1].camera.origin.x, keys[b].camera.origin.x), "{i}");
            assert!(within(red(s.lights[0]), red(keys[b - 1].lights[0]), red(keys[b].lights[0])), "{i}");
            assert!((s.camera.lens.focus.unwrap() - 2.0 - s.camera.origin.x).abs() < 1e-9);
            assert_eq!(s.lights[0].to_rgb()[1..], [1.0, 0.0]);
        }
        // Constant between equal keys.
        assert!(all[10..=15].iter().all(|s| s.camera.fov == 20.0));
    }

    #[test]
    fn uniform_motion_is_smooth_and_rests_at_its_ends() {
        let all = frames((0..5).map(|i| key(i as f64, 2.0 * i as f64, 60.0, 1.0)).collect());
        let step: Vec<f64> = all.windows(2).map(|w| w[1].camera.origin.x - w[0].camera.origin.x).collect();
        assert!(step[0] < 0.04 && step[step.len() - 1] < 0.04 && step.iter().all(|s| *s > 0.0));
        // 2 m/s in the middle, and no jump of the speed anywhere.
        assert!(step[10..30].iter().all(|s| (s - 0.2).abs() < 1e-9));
        assert!(step.windows(2).all(|w| (w[1] - w[0]).abs() < 0.09));
    }

    #[test]
    fn one_key_is_one_frame() {
        let all = frames(vec![key(3.0, 1.0, 40.0, 0.5)]);
        assert!(
            all.len() == 1
                && all[0].camera.fov == 40.0
                && all[0].lights == [Bands::from_rgb([0.5, 1.0, 0.0])]
        );
    }
}
