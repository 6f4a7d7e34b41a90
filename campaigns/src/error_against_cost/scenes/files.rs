//! Scenes of files: of the folder `scenes`, of `zonal demo`, and of the shared data.

use super::SceneFolder;
use crate::harness::Error;
use std::path::Path;
use zonal_demo::{Size, chapel_text, church};
use zonal_io::output;

/// The path of the shared data in the scenes of the project.
const SHARED_IN_SCENES: &str = "../../shared";

/// The text of a scene of the project with its files in the shared folder.
fn with_shared(text: &str, shared: &Path) -> Result<String, Error> {
    Ok(text.replace(SHARED_IN_SCENES, &shared.canonicalize()?.display().to_string()))
}

/// A room of a museum in haze.
pub(super) fn gallery(folder: &SceneFolder) -> Result<String, Error> {
    with_shared(include_str!("../../../../scenes/vr-gallery.toml"), folder.shared)
}

/// The arcade of Sponza in haze.
pub(super) fn sponza(folder: &SceneFolder) -> Result<String, Error> {
    with_shared(include_str!("../../../../scenes/sponza.toml"), folder.shared)
}

/// A Victorian factory.
pub(super) fn factory(folder: &SceneFolder) -> Result<String, Error> {
    with_shared(include_str!("../../../../scenes/victorian-factory.toml"), folder.shared)
}

/// The chapel of `zonal demo chapel`.
pub(super) fn chapel(_: &SceneFolder) -> Result<String, Error> {
    Ok(chapel_text(Size::Full))
}

fn church(
    folder: &SceneFolder,
    name: &str,
    plan: &church::ChurchPlan,
    sizes: [f64; 2],
) -> Result<String, Error> {
    let mesh = format!("{name}.glb");
    output::write_glb(&folder.path.join(&mesh), &church::glb_model(&church::build(plan)))?;
    let [patch, cell] = sizes;
    let resolution = church::ChurchResolution { patch, cell, tolerance: 0.12, closure: "measure" };
    Ok(church::scene_text(plan, &mesh, &resolution))
}

/// The church of `zonal demo church --size small`.
pub(super) fn church_small(folder: &SceneFolder) -> Result<String, Error> {
    church(folder, "church-small", &church::ChurchPlan::TWO_BAYS, [0.9, 0.75])
}

/// The church of `zonal demo church`.
pub(super) fn church_full(folder: &SceneFolder) -> Result<String, Error> {
    church(folder, "church", &church::ChurchPlan::SIX_BAYS, [0.29, 0.179])
}
