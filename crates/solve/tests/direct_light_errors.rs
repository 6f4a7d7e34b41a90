//! Stated errors of direct light in the results of a solve.

use crate::common::lit_rooms::{ROOM, SUN, lid};
use crate::common::solved;
use zonal_math::{Grade, vec3};

/// A symmetric room lit by its ceiling; mirror images of its walls once differed by 1 % with a stated error of 4e-13.
const MIRROR: &str = "[solve]\ntolerance = TOLERANCE\nresidual = 1e-12\npatch_size = 0.5\nengine = \"ENGINE\"\n[[surface]]\nname = \"room\"\n\
    room = { min = [0, 0, 0], max = [2, 2, 2] }\nreflectance = 0.5\nfaces.z1 = { emission = 10 }\n\
    [[light]]\nkind = \"emitter\"\nsurface = \"room.z1\"\n";

// Guards (numbers): direct light of mirror images agrees within the stated errors.
#[test]
fn mirror_images_agree_within_the_stated_errors() {
    for engine in ["dense", "rays"] {
        for tolerance in ["0.1", "0.02", "0.004"] {
            let s = solved(&MIRROR.replace("TOLERANCE", tolerance).replace("ENGINE", engine));
            let p = &s.zones.patches;
            let centre = |i: usize| p[i].plate.centre();
            let (mut pairs, mut beyond, mut most) = (0, 0, 0.0f64);
            for i in 0..p.len() {
                let c = centre(i);
                // Mirrored in x, in y, and in the plane x = y.
                for image in [vec3(2.0 - c.x, c.y, c.z), vec3(c.x, 2.0 - c.y, c.z), vec3(c.y, c.x, c.z)] {
                    let j = (0..p.len()).find(|&j| (centre(j) - image).length() < 1e-9).unwrap();
                    for (field, e) in [
                        (&s.fields.direct, (s.fields.direct_error[i] + s.fields.direct_error[j]).first()),
                        (&s.fields.incident, (s.fields.error[i] + s.fields.error[j]).first()),
                    ] {
                        let d = (field[i] - field[j]).first().abs();
                        pairs += 1;
                        beyond += usize::from(d > e + 1e-12);
                        most = most.max(d / field[i].first().max(1e-12));
                    }
                }
            }
            assert!(
                beyond * 25 <= pairs,
                "{engine} {tolerance}: {beyond} of {pairs} beyond, up to {most:.1e}"
            );
            let estimate = s.report.estimate.patches.first();
            match engine {
                "dense" => {
                    let of_exchange = s.error_parts()[0].1.sampling;
                    assert!(most < 1e-9 && of_exchange < 1e-9, "{most:e} {of_exchange:e}");
                }
                _ => assert!(estimate > 0.0 && s.report.estimate.grade == Grade::Statistical, "{estimate:e}"),
            }
        }
    }
}

// Guards (numbers): errors of direct light propagate to indirect light.
#[test]
fn errors_of_sunlight_propagate_to_reflected_light() {
    let open = ROOM.replace("OMIT", "\"z1\"") + &lid() + SUN;
    let truth = solved(&open.replace("TOLERANCE", "0.003"));
    let mut last = f64::INFINITY;
    for tolerance in ["0.2", "0.05", "0.01"] {
        let s = solved(&open.replace("TOLERANCE", tolerance));
        let (f, t) = (&s.fields, &truth.fields);
        let n = f.incident.len();
        let within = |i: &usize| {
            let d = (f.incident[*i] - t.incident[*i]).first().abs();
            d <= 2.0 * (f.error[*i] + t.error[*i]).first()
        };
        let (share, stated) =
            ((0..n).filter(within).count() as f64 / n as f64, s.report.estimate.patches.first());
        assert!(share >= 0.97 && stated <= last && stated > 1e-6, "{tolerance}: {share} {stated:e} {last:e}");
        assert_eq!(s.report.estimate.grade, Grade::Statistical);
        last = stated;
    }
}
