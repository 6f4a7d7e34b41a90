//! Entry points of the readers: scenes, templates of scenes, cameras, meshes without a scene.
//!
//! | module | contents |
//! |---|---|
//! | `scene_text` | a whole scene from its text |
//! | `scene_template` | scenes whose numbers are replaced, for data sets |
//! | `solve_settings` | settings in place of `[solve]` |
//! | `camera_file`, `camera_path` | cameras, and key frames of a camera, in files of their own |
//! | `facets`, `model_survey` | a mesh without a scene: as a list of polygons; what it contains |

pub(crate) mod camera_file;
pub(crate) mod camera_path;
pub(crate) mod facets;
pub(crate) mod model_survey;
pub(crate) mod scene_template;
pub(crate) mod scene_text;
pub(crate) mod solve_settings;
