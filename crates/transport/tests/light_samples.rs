//! Samples of lights as seen from a point.

use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Light, Plate};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSample, LightSampler, Receiver};

use crate::common;

/// A floor of 2 m under a sun from the zenith.
fn sun_over_floor() -> (zonal_scene::Scene, Light) {
    let floor = Plate::parallelogram(vec3(-1.0, -1.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
    let sun = Light::Sun {
        name: "sun".into(),
        direction: vec3(0.0, 0.0, -1.0),
        irradiance: Bands::from_rgb([3.0, 2.0, 1.0]),
        angular_diameter: 0.0,
    };
    (common::plain(&[floor], None), sun)
}

#[test]
fn sun_sample_carries_its_irradiance_and_is_blocked_below_a_floor() {
    let (scene, sun) = sun_over_floor();
    let (transport, sampler) = (Transport::new(&scene), LightSampler::new(&scene, &sun));
    let up = Receiver::Surface(vec3(0.0, 0.6, 0.8));
    let sample = |z: f64| -> LightSample {
        sampler.sample_at(&transport, vec3(0.1, 0.2, z), up, [0.5; 3]).expect("the receiver faces the sun")
    };
    let (above, below) = (sample(1.0), sample(-1.0));
    assert_eq!((above.direction, above.direction), (below.direction, vec3(0.0, 0.0, 1.0)));
    assert_eq!(above.flux, Bands::from_rgb([3.0, 2.0, 1.0]) * 0.8);
    assert!(above.end.z > 1.0);
    assert_eq!(sampler.attenuated(&transport, vec3(0.1, 0.2, 1.0), &above), Some(above.flux));
    assert_eq!(sampler.attenuated(&transport, vec3(0.1, 0.2, -1.0), &below), None);
    let away = Receiver::Surface(vec3(0.0, 0.0, -1.0));
    assert_eq!(sampler.sample_at(&transport, Vec3::ZERO, away, [0.5; 3]), None);
}
