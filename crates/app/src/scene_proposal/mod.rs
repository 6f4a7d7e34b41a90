//! A scene for a mesh file: placement, sides, patches, light and cameras, as a text that solves at once.
//!
//! | module | content |
//! |---|---|
//! | `placement` | unit and upward axis |
//! | `viewpoints` | points inside the model, and cameras |
//! | `own_light` | the part of the model that its own light reaches |
//! | `lighting` | the light of the model, sun and sky, or lamps |
//! | `document` | the text of the scene |
//!
//! Guesses stand in the text, and the caller can replace each by what it knows.

mod document;
mod lighting;
mod own_light;
mod placement;
mod viewpoints;

pub use document::FaceSides;
pub use placement::{LengthUnit, ModelPlacement, UpAxis};

use document::SceneDocument;
use std::path::{Component, Path, PathBuf};
use zonal_io::input::{FileRecord, ModelSurvey, PartCounts};
use zonal_report::Failure;
use zonal_scene::Scene;
use zonal_transport::Transport;
use zonal_transport::zoning::{ExpectedPatches, expected_patches_of_surfaces, patches_of_area};

/// What is known about a model beyond its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelOptions {
    /// Unit of lengths.
    pub unit: Option<LengthUnit>,
    /// Upward axis.
    pub up: Option<UpAxis>,
    /// Number of patches wanted by area; faces smaller than a patch come on top.
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
    /// Largest edge of a patch, m.
    pub patch_size: f64,
    /// Patches of the parts of the model, those of many patches first.
    pub parts: Vec<PartPatches>,
    /// Where the light comes from.
    pub light: String,
    /// True if the cameras are seen from inside.
    pub has_inside: bool,
}

/// The patches of a part: of the faces of one material that are open, solids or rooms.
#[derive(Clone, Debug, PartialEq)]
pub struct PartPatches {
    /// Name of the surface in the scene.
    pub name: String,
    /// Expected number of patches, of both sides where both exchange.
    pub patches: f64,
    /// Edge of a square with the mean area of a patch, m.
    pub edge: f64,
}

impl PartPatches {
    fn of(surface: &str, expected: ExpectedPatches) -> PartPatches {
        PartPatches {
            name: surface.into(),
            patches: expected.patches,
            edge: (expected.area / expected.patches.max(1.0)).sqrt(),
        }
    }
}

/// Proposes a scene for a mesh file. The scene names the file relative to `folder`, where it will lie.
///
/// # Errors
/// If the file cannot be read or is not a mesh, or if the scene would not be valid.
pub fn propose(model: &Path, folder: &Path, options: &ModelOptions) -> Result<SceneProposal, Failure> {
    propose_recorded(model, folder, options, &FileRecord::default())
}

/// As [`propose`], with a record of the files that are read.
///
/// # Errors
/// As [`propose`].
pub fn propose_recorded(
    model: &Path,
    folder: &Path,
    options: &ModelOptions,
    record: &FileRecord,
) -> Result<SceneProposal, Failure> {
    let survey = record.survey_model(model)?;
    let placement = ModelPlacement::of(model, &survey, options.unit, options.up);
    let sides = sides_of(&survey.parts);
    let name = model.file_stem().map_or_else(|| "model".to_string(), |s| s.to_string_lossy().into_owned());
    let file = relative_path(model, folder);
    let mut document = SceneDocument::bare(&name, &file, &survey, &placement, sides);
    let parse =
        |text: &str| record.parse_scene(text, Some(folder), &format!("the scene of {}", model.display()));
    // Explore the bare model.
    let bare = parse(&document.text())?;
    let transport = Transport::new(&bare);
    let is_lit = own_light::lit_fraction(&transport) >= own_light::MIN_LIT_FRACTION;
    let inside = viewpoints::find_inside(&transport, is_lit);
    let light = lighting::propose(&transport, inside.as_ref(), is_lit);
    let of_file = |c| placement.camera(c);
    let cameras = match survey.cameras.as_slice() {
        [] => viewpoints::cameras(&bare, &transport, inside.as_ref()),
        own => own.iter().map(of_file).collect(),
    };
    let size = patch_size(&bare, f64::from(options.patches));
    let parts = patches_of_parts(&bare, size);
    document.patches = Some((size, parts.iter().map(|p| p.patches).sum()));
    document.bounds = Some(bare.bounds());
    (document.light, document.cameras) = (Some(&light), &cameras);
    let text = document.text();
    let scene = parse(&text)?;
    let (light, has_inside) = (light.name(), inside.is_some());
    Ok(SceneProposal { text, scene, has_inside, patch_size: size, parts, light, sides, survey, placement })
}

/// Open parts and parts that are turned inside out exchange on both sides; solids and rooms on one.
fn sides_of(parts: &PartCounts) -> FaceSides {
    let turned = parts.inverted_rooms + parts.inverted_solids;
    if parts.open == 0 && turned == 0 { FaceSides::OfFile } else { FaceSides::OpenBoth }
}

/// Steps of the bisection for a patch size: its last interval is 10⁻⁵ wide, relative to the size.
const BISECTION_STEPS: usize = 20;

/// Edge of a patch (m, two digits) for `wanted` patches by area. Every part has the share of its area, however finely it is meshed; triangles that are
/// smaller than a patch come on top of that number.
fn patch_size(scene: &Scene, wanted: f64) -> f64 {
    let diagonal = scene.diagonal();
    let (mut small, mut large) = ((1e-5 * diagonal).ln(), diagonal.ln());
    for _ in 0..BISECTION_STEPS {
        let middle = 0.5 * (small + large);
        if patches_of_area(scene, middle.exp()) > wanted {
            small = middle;
        } else {
            large = middle;
        }
    }
    two_digits(large.exp())
}

/// The patches of each surface of a scene for an edge of `size` m.
fn patches_of_parts(scene: &Scene, size: f64) -> Vec<PartPatches> {
    let counts = expected_patches_of_surfaces(scene, size);
    let parts = scene.surfaces().iter().zip(counts).map(|(s, expected)| PartPatches::of(&s.name, expected));
    let mut parts: Vec<PartPatches> = parts.filter(|p| p.patches > 0.0).collect();
    parts.sort_by(|a, b| b.patches.total_cmp(&a.patches));
    parts
}

/// A number rounded to two digits.
#[must_use]
pub fn two_digits(x: f64) -> f64 {
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
