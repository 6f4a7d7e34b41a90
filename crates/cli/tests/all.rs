//! The integration tests of the crate as one program, which is linked once.
#![allow(missing_docs)]

mod architecture;
mod camera_animation;
mod commands;
mod dataset;
mod documents;
mod export;
mod faces;
mod false_colours;
mod final_gather;
mod init;
mod many_bands;
mod mesh_defects;
mod refused_arguments;
mod refused_scenes;
mod relight;
mod report;
mod robustness;
mod scene_keys;
mod support;
mod symmetry_planes;
mod thermal;
mod update;
mod validate;
mod view;
mod view_factors;
