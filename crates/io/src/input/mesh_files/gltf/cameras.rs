//! Perspective cameras of glTF: they look along −z of their node, with y up. The angle of view across the width is 2 arctan(a tan(φ/2)) for the vertical
//! angle φ and the width over the height a.

use super::nodes::NodeInstance;
use gltf::Document;
use gltf::camera::Projection;
use std::collections::BTreeMap;
use zonal_math::vec3;
use zonal_scene::Camera;

/// Width over height of a camera that does not give it.
const DEFAULT_ASPECT: f64 = 4.0 / 3.0;

/// The camera of a node, if it has a perspective one with valid numbers.
pub(super) fn camera_of_node(document: &Document, at: &NodeInstance) -> Option<Camera> {
    let node = document.nodes().nth(at.node)?;
    let camera = node.camera()?;
    let Projection::Perspective(lens) = camera.projection() else { return None };
    let aspect = lens.aspect_ratio().map_or(DEFAULT_ASPECT, f64::from);
    let half = aspect * (0.5 * f64::from(lens.yfov())).tan();
    let origin = at.point(vec3(0.0, 0.0, 0.0));
    let target = origin + at.vector(vec3(0.0, 0.0, -1.0)).normalized();
    let out = Camera {
        up: at.vector(vec3(0.0, 1.0, 0.0)).normalized(),
        fov: 2.0 * half.atan().to_degrees(),
        ..Camera::look_at(origin.array(), target.array())
            .name(camera.name().or(node.name()).unwrap_or("camera"))
    };
    out.check().is_ok().then_some(out)
}

/// Numbers the cameras that share a name: `view`, `view-2`, ….
pub(super) fn name_uniquely(cameras: &mut [Camera]) {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for camera in cameras {
        let count = seen.entry(camera.name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            camera.name = format!("{}-{count}", camera.name);
        }
    }
}
