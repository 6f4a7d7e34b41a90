//! A scene for a mesh file: placement, sides, patches, light and cameras, as a text that solves at once.
//!
//! | module | content |
//! |---|---|
//! | `placement` | unit and upward axis |
//! | `viewpoints` | points inside the model, and cameras |
//! | `lighting` | sun and sky, or lamps |
//! | `document` | the text of the scene |
//!
//! Guesses stand in the text, and the caller can replace each by what it knows.

mod document;
mod lighting;
mod placement;
mod viewpoints;

pub use document::FaceSides;
pub use placement::{LengthUnit, ModelPlacement, UpAxis};

use document::SceneDocument;
use lighting::ProposedLight;
use std::path::{Component, Path, PathBuf};
use zonal_io::input::{ModelSurvey, PartCounts, parse_scene, survey_model};
use zonal_report::Failure;
use zonal_scene::Scene;
use zonal_transport::Transport;
use zonal_transport::zoning::expected_patches;

/// What is known about a model beyond its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelOptions {
    /// Unit of lengths.
    pub unit: Option<LengthUnit>,
    /// Upward axis.
    pub up: Option<UpAxis>,
    /// Number of patches wanted.
    pub patches: u32,
}

/// A proposed scene.
pub struct SceneProposal {
    /// The scene file.
    pub text: String,
    /// The scene of that text.
    pub scene: Scene,
    /// Extent, materials and parts of the model.
    pub survey: ModelSurvey,
    /// How it lies in the scene.
    pub placement: ModelPlacement,
    /// Sides that exchange.
    pub sides: FaceSides,
    /// Where the light comes from.
    pub light: &'static str,
    /// True if the cameras are seen from inside.
    pub has_inside: bool,
}

/// Proposes a scene for a mesh file. The scene names the file relative to `folder`, where it will lie.
///
/// # Errors
/// If the file cannot be read or is not a mesh, or if the scene would not be valid.
pub fn propose(model: &Path, folder: &Path, options: &ModelOptions) -> Result<SceneProposal, Failure> {
    let survey = survey_model(model)?;
    let placement = ModelPlacement::of(model, &survey, (options.unit, options.up));
    let sides = sides_of(&survey.parts);
    let name = model.file_stem().map_or_else(|| "model".to_string(), |s| s.to_string_lossy().into_owned());
    let file = relative_path(model, folder);
    let mut document = SceneDocument {
        name: &name,
        file: &file,
        survey: &survey,
        placement: &placement,
        sides,
        patches: None,
        light: None,
        cameras: &[],
        bounds: None,
    };
    let parse = |text: &str| parse_scene(text, Some(folder), &format!("the scene of {}", model.display()));
    // Explore the bare model.
    let bare = parse(&document.text())?;
    let transport = Transport::new(&bare);
    let inside = viewpoints::find_inside(&bare, &transport);
    let light = lighting::propose(&transport, inside.as_ref());
    let cameras = match survey.cameras.is_empty() {
        false => survey.cameras.iter().map(|c| placement.camera(c)).collect(),
        true => viewpoints::cameras(&bare, &transport, inside.as_ref()),
    };
    document.patches = Some(patch_size(&bare, f64::from(options.patches)));
    document.bounds = Some(bare.bounds());
    (document.light, document.cameras) = (Some(&light), &cameras);
    let text = document.text();
    let scene = parse(&text)?;
    let light = match light {
        ProposedLight::OfModel(_) => "that of the model",
        ProposedLight::SunAndSky(_) => "sun and sky",
        ProposedLight::Lamps(_) => "lamps below the ceiling",
    };
    Ok(SceneProposal { text, scene, has_inside: inside.is_some(), light, sides, survey, placement })
}

/// Both sides exchange unless all parts are bodies and rooms of the right orientation.
fn sides_of(parts: &PartCounts) -> FaceSides {
    let turned = parts.inverted_rooms + parts.inverted_solids;
    match parts.open == 0 && turned == 0 {
        true => FaceSides::OfFile,
        false => FaceSides::Both,
    }
}

/// Steps of the bisection for a patch size: its last interval is 10⁻⁵ wide, relative to the size.
const BISECTION_STEPS: usize = 20;
/// Edges, each four fifths of the one before, among which that of the least number of patches is sought.
const TRIED_EDGES: i32 = 40;

/// Edge of a patch (m, two digits) for about `wanted` patches, and the number expected of it. Small triangles are patches whatever the edge.
fn patch_size(scene: &Scene, wanted: f64) -> (f64, f64) {
    let diagonal = scene.diagonal();
    let (mut small, mut large) = ((1e-5 * diagonal).ln(), diagonal.ln());
    for _ in 0..BISECTION_STEPS {
        let middle = 0.5 * (small + large);
        match expected_patches(scene, middle.exp()) > wanted {
            true => small = middle,
            false => large = middle,
        }
    }
    // The number falls no further with an edge beyond that of the smallest number.
    let floor = expected_patches(scene, diagonal);
    let size = if floor > 0.8 * wanted { edge_of_least_patches(scene, floor) } else { large.exp() };
    let size = two_digits(size);
    (size, expected_patches(scene, size))
}

/// The smallest edge with which the number of patches exceeds the least by a tenth only.
fn edge_of_least_patches(scene: &Scene, least: f64) -> f64 {
    let diagonal = scene.diagonal();
    let edges = (0..TRIED_EDGES).map(|k| diagonal * 0.8f64.powi(k));
    edges.take_while(|e| expected_patches(scene, *e) <= 1.1 * least).last().unwrap_or(diagonal)
}

fn two_digits(x: f64) -> f64 {
    let rounded = format!("{x:.1e}").parse();
    rounded.unwrap_or(x)
}

/// The path of a file relative to a folder, with slashes; absolute if they share no root.
fn relative_path(file: &Path, folder: &Path) -> String {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let absolute = |p: &Path| p.canonicalize().unwrap_or_else(|_| p.to_path_buf());
    let (file, folder) = (absolute(file), absolute(folder));
    let of_file: Vec<Component> = file.components().collect();
    let of_folder: Vec<Component> = folder.components().collect();
    let common = of_file.iter().zip(&of_folder).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return file.display().to_string();
    }
    let up = std::iter::repeat_n(Component::ParentDir, of_folder.len() - common);
    let path: PathBuf = up.chain(of_file[common..].iter().copied()).collect();
    let parts: Vec<String> =
        path.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
    parts.join("/")
}
