//! Stated errors of direct light against the true ones, known by a hundred times as many samples.

use super::*;
use crate::direct;
use zonal_scene::Quiet;
use zonal_transport::build_zones;

const ROOM: &str = "name = \"room\"\n[solve]\ntolerance = TOL\npatch_size = 0.25\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\nomit = [OMIT]\nreflectance = 0.5\n\
    [[surface]]\nname = \"block\"\nbox = { min = [0.7, 0.6, 0.5], max = [1.3, 1.4, 0.9], rotate_z_degrees = 20 }\n";
const LAMP: &str = "[[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.6, 0.7, 1.95], edge1 = [0, 0.6, 0], edge2 = [0.8, 0, 0] }\n\
    emission = 10\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n";
const SUN: &str =
    "[[light]]\nkind = \"sun\"\ndirection = [0.3, 0.2, -1]\nirradiance = 100\nangular_diameter = 2\n";
const SKY: &str = "[[light]]\nkind = \"sky\"\nradiance = 1\n";
const HAZE: &str = "[medium]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\ncells = [8, 8, 8]\nextinction = 0.4\nalbedo = 0.5\n";
const PANE: &str = "[[pane]]\nname = \"glass\"\nrectangle = { origin = [0.2, 0.1, 1.6], edge1 = [1.4, 0, 0], edge2 = [0, 1.5, 0] }\n\
    thickness = 0.01\nextinction = [20, 40, 80]\nalbedo = 0\npatch_size = 0.25\n";

/// A lid with a square hole of 12 cm.
fn lid() -> String {
    let part = |name: &str, x: f64, y: f64, dx: f64, dy: f64| {
        format!(
            "[[surface]]\nname = \"{name}\"\nrectangle = {{ origin = [{x}, {y}, 2], edge1 = [{dx}, 0, 0], edge2 = [0, {dy}, 0] }}\nsides = \"both\"\n"
        )
    };
    [part("a", 0.0, 0.0, 0.9, 2.0), part("b", 1.02, 0.0, 0.98, 2.0)].concat()
        + &[part("c", 0.9, 0.0, 0.12, 0.9), part("d", 0.9, 1.02, 0.12, 0.98)].concat()
}

/// What a check found: relative errors over the zones, true and stated, and shares of the zones within once and twice the stated error.
struct Found {
    off: f64,
    told: f64,
    once: f64,
    twice: f64,
    /// Of each surface, all voxels and all panes: difference of the power met over the stated error of the sum.
    sums: Vec<(String, f64)>,
}

fn check(text: &str, tolerance: f64, step: usize) -> Found {
    let text = text.replace("TOL", &tolerance.to_string());
    let scene = zonal_io::input::parse_scene(&text, None, "room").unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let g = Gatherer::new(&scene, &zones, &transport, &scene.lights()[0]);
    let lit = direct::light(&scene, &zones, &transport, 0, false, &Quiet);
    let samples = (100.0 * (lit.rays as f64 / zones.len() as f64)) as usize;
    let samples = samples.clamp(1 << 12, 1 << 15);
    let list: Vec<usize> = (0..zones.len()).step_by(step).collect();
    let truth: Vec<Bands> = list
        .par_iter()
        .map(|&i| match i < zones.pane_offset() {
            true => g.look(i, 1 << 16..(1 << 16) + samples).value(),
            false => g.pane(i - zones.pane_offset(), PANE_POINTS * 64)[0],
        })
        .collect();
    let (mut off, mut told, mut all, mut once, mut twice) = (0.0, 0.0, 0.0, 0, 0);
    let mut sums: Vec<(String, [f64; 3])> = Vec::new();
    for (&i, t) in list.iter().zip(&truth) {
        let (d, e) = (lit.fields[i][0] - t[0], lit.error_of(i)[0]);
        (off, told, all) = (off + d * d, told + e * e, all + t[0] * t[0]);
        once += usize::from(d.abs() <= e + 1e-9 * t[0]);
        twice += usize::from(d.abs() <= 2.0 * e + 1e-9 * t[0]);
        let name = match zones.patches.get(i) {
            Some(p) => scene.surfaces()[p.surface].name.clone(),
            None if i < zones.pane_offset() => "medium".into(),
            None => "panes".into(),
        };
        if sums.last().is_none_or(|s| s.0 != name) {
            sums.push((name, [0.0; 3]));
        }
        let w = direct::section(&zones, i)[0];
        let own = &mut sums.last_mut().unwrap().1;
        *own = [own[0] + w * d, own[1] + (w * lit.error[i][0]).powi(2), own[2] + w * lit.shared[0] * lit.fields[i][0]];
    }
    let n = list.len() as f64;
    let sums = sums.into_iter().map(|(name, [d, e, s])| (name, d.abs() / (e.sqrt() + s).max(1e-300))).collect();
    Found { off: (off / all).sqrt(), told: (told / all).sqrt(), once: once as f64 / n, twice: twice as f64 / n, sums }
}

#[test]
fn explore() {
    let open = ROOM.replace("OMIT", "\"z1\"");
    let closed = ROOM.replace("OMIT", "");
    let scenes = [
        ("sun through a hole", open.clone() + &lid() + SUN, 1),
        ("sun", open.clone() + SUN, 1),
        ("lamp behind a block", closed.clone() + LAMP, 1),
        ("sky in haze", open.clone() + HAZE + SKY, 3),
        ("lamp in haze", closed.clone() + HAZE + LAMP, 3),
        ("sun and a pane", open.clone() + PANE + SUN, 1),
        ("sky and a pane", open.clone() + PANE + SKY, 1),
    ];
    for (name, text, step) in scenes {
        for tolerance in [0.1, 0.02, 0.005] {
            let f = check(&text, tolerance, step);
            let worst = f.sums.iter().fold(0.0f64, |m, s| m.max(s.1));
            let beyond = f.sums.iter().filter(|s| s.1 > 1.0).count();
            println!("{name} {tolerance}: off {:.2e} told {:.2e} once {:.3} twice {:.3} sums worst {worst:.2}, {beyond} of {} beyond", f.off, f.told, f.once, f.twice, f.sums.len());
        }
    }
}
