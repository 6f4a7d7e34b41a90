//! Visibility of two zones: occluders, media along rays, and the uncertainty of a visibility that is sampled.

pub(crate) mod occlusion;
pub(crate) mod path_media;
pub(crate) mod ray_samples;
pub(crate) mod visibility_uncertainty;
