//! `zonal init`: a scene for a mesh file.

use crate::commands::context::Context;
use std::path::{Path, PathBuf};
use zonal_app::scene_proposal::{
    FaceSides, LengthUnit, ModelOptions, PartPatches, SceneProposal, UpAxis, propose, two_digits,
};
use zonal_io::input::SurveyedMaterial;
use zonal_io::output::write_bytes;
use zonal_report::{Failure, check_output, say};
use zonal_scene::Bands;
use zonal_scene::topology::Defect;

const EXAMPLES: &str = "Examples:
  zonal init hall.glb                              writes hall.toml
  zonal init part.stl --unit mm --up z -o part.toml
  zonal init city.obj --patches 100000

next:
  zonal solve hall.toml -o hall.npz
  zonal render hall.npz -o hall.png";

/// Write a scene file for a mesh file: materials, patches, light and cameras, ready to solve.
///
/// Reports the extent of the model, its materials, and which parts are open, closed or turned inside out. Unit and upward axis are those of the format, or
/// guessed; the scene says which. Cameras are those of the file, else three are placed inside or outside of the model. A model without light gets sun and
/// sky, or lamps if it is closed.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Mesh file.
    pub model: PathBuf,
    /// Scene file to write [default: MODEL.toml in this folder].
    #[arg(long, short, value_name = "SCENE.toml")]
    pub output: Option<PathBuf>,
    /// Unit, upward axis and number of patches.
    #[command(flatten)]
    pub options: ModelArgs,
    /// Replace an existing scene file.
    #[arg(long)]
    pub force: bool,
}

/// Arguments of commands that take a mesh file.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct ModelArgs {
    /// Unit of the mesh file: m, cm, mm, km, inch, foot, or a number of metres [default: that of the format, or guessed].
    #[arg(long, value_name = "UNIT", value_parser = LengthUnit::parse)]
    pub unit: Option<LengthUnit>,
    /// Upward axis of the mesh file [default: that of the format, or guessed].
    #[arg(long, value_enum)]
    pub up: Option<UpAxis>,
    /// Number of patches to aim at, shared among the parts by area; triangles that are smaller than a patch come on top.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_PATCHES, value_parser = clap::value_parser!(u32).range(100..=8_000_000))]
    pub patches: u32,
}

/// Number of patches of a model.
const DEFAULT_PATCHES: u32 = 20_000;

impl ModelArgs {
    /// The options of a proposal.
    #[must_use]
    pub fn options(&self) -> ModelOptions {
        ModelOptions { unit: self.unit, up: self.up, patches: self.patches }
    }
}

/// Runs the command.
///
/// # Errors
/// If the model cannot be read, or the scene exists or cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let output = match &args.output {
        Some(path) => path.clone(),
        None => PathBuf::from(args.model.file_stem().unwrap_or_default()).with_extension("toml"),
    };
    check_output(&output, &["toml"])?;
    if output.exists() && !args.force {
        let message = "this file exists; give another name by -o, or replace it by --force";
        return Err(Failure::in_file(&output, message));
    }
    let folder = output.parent().unwrap_or(Path::new(""));
    let proposal = propose(&args.model, folder, &args.options.options())?;
    write_bytes(&output, proposal.text.as_bytes())?;
    if context.json {
        return context.say_json(json(&proposal, &output));
    }
    print_text(args, &proposal, &output)?;
    context.check_warnings(proposal.scene.notes())
}

fn json(p: &SceneProposal, output: &Path) -> serde_json::Value {
    let (low, high) = p.scene.bounds();
    let material = |m: &SurveyedMaterial| {
        serde_json::json!({
            "name": m.name, "faces": m.faces, "area_m2": m.area * p.placement.unit.metres.powi(2),
            "reflectance": m.reflectance.map(Bands::to_rgb), "textured": m.is_textured, "emission": m.emission.to_rgb(),
            "glass": m.is_glass, "double_sided": m.double_sided, "unread_transparency": m.unread_transparency,
        })
    };
    let part = |part: &PartPatches| serde_json::json!({ "name": part.name, "patches": part.patches.round(), "edge_m": part.edge });
    let parts = &p.survey.parts;
    serde_json::json!({
        "written": output.display().to_string(), "faces": p.survey.faces,
        "bounds_m": [low.array(), high.array()],
        "unit_m": p.placement.unit.metres, "unit_reason": p.placement.unit_reason,
        "up": p.placement.up.name(), "up_reason": p.placement.up_reason,
        "parts": { "open": parts.open, "solids": parts.solids, "rooms": parts.rooms, "inverted_rooms": parts.inverted_rooms,
            "inverted_solids": parts.inverted_solids, "flipped_edges": parts.flipped_edges, "open_area_fraction": parts.open_area_fraction },
        "doubled_faces": p.survey.doubled_faces, "open_sides": if p.sides == FaceSides::OpenBoth { "both" } else { "file" },
        "topology": p.survey.topology.list().map(|(what, d)| defect_json(what, &d)).collect::<Vec<_>>(),
        "patch_size_m": p.patch_size,
        "patches_of_parts": p.parts.iter().map(part).collect::<Vec<_>>(),
        "light": p.light, "inside": p.has_inside,
        "materials": p.survey.materials.iter().map(material).collect::<Vec<_>>(),
        "cameras": p.scene.cameras().iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
        "warnings": zonal_io::output::notes_json(p.scene.notes()),
    })
}

fn defect_json(what: &str, defect: &Defect) -> serde_json::Value {
    serde_json::json!({ "defect": what, "count": defect.count, "first": defect.first_place() })
}

/// Parts whose patches the text lists.
const MAX_LISTED_PARTS: usize = 12;

/// Sizes of patches: the largest of the scene, and those of each part, which are smaller where its faces are.
fn print_patches(p: &SceneProposal) -> Result<(), Failure> {
    let all: f64 = p.parts.iter().map(|part| part.patches).sum();
    say(&format!("  patches: about {all:.0} of at most {} m", p.patch_size))?;
    for part in p.parts.iter().take(MAX_LISTED_PARTS) {
        say(&format!("    {}: {:.0} of {} m", part.name, part.patches, two_digits(part.edge)))?;
    }
    match p.parts.len().saturating_sub(MAX_LISTED_PARTS) {
        0 => Ok(()),
        n => say(&format!("    and {n} further parts (--json lists all)")),
    }
}

/// Materials that the text lists.
const MAX_LISTED_MATERIALS: usize = 24;

fn print_text(args: &Args, p: &SceneProposal, output: &Path) -> Result<(), Failure> {
    let (low, high) = p.scene.bounds();
    let size = high - low;
    let survey = &p.survey;
    say(&format!(
        "{}: {} faces, {} material(s), {:.4} × {:.4} × {:.4} m",
        args.model.display(),
        survey.faces,
        survey.materials.len(),
        size.x,
        size.y,
        size.z
    ))?;
    say(&format!(
        "  unit {} ({}), up {} ({}); --unit and --up replace them",
        p.placement.unit.name(),
        p.placement.unit_reason,
        p.placement.up.name(),
        p.placement.up_reason
    ))?;
    print_parts(p)?;
    print_materials(p)?;
    print_patches(p)?;
    let cameras: Vec<&str> = p.scene.cameras().iter().map(|c| c.name.as_str()).collect();
    let of = if !survey.cameras.is_empty() {
        "of the file"
    } else if p.has_inside {
        "inside"
    } else {
        "outside"
    };
    say(&format!("  cameras {of}: {}", cameras.join(", ")))?;
    say(&format!("  light: {}", p.light))?;
    p.scene.notes().iter().try_for_each(|d| say(&format!("  {}", d.line())))?;
    let solution = output.with_extension("npz");
    say(&format!("written: {}", output.display()))?;
    say(&format!("next: zonal solve {} -o {}", output.display(), solution.display()))
}

fn print_parts(p: &SceneProposal) -> Result<(), Failure> {
    let parts = &p.survey.parts;
    let counted = [
        (parts.open, "open"),
        (parts.solids, "closed with normals outward (solids)"),
        (parts.rooms, "closed with normals inward (rooms)"),
        (parts.inverted_rooms, "closed around the model with normals outward (rooms turned inside out)"),
        (parts.inverted_solids, "closed and small with normals inward (solids turned inside out)"),
    ];
    let list: Vec<String> =
        counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    say(&format!("  parts: {}", if list.is_empty() { "none".into() } else { list.join(", ") }))?;
    for (what, defect) in p.survey.topology.list() {
        let first = defect.first_place().map_or(String::new(), |place| format!(" (first: {place})"));
        say(&format!("  {} {what}{first}", defect.count))?;
    }
    let policy = match p.sides {
        FaceSides::OpenBoth => {
            "solids exchange outside, rooms inside, the others on both sides (open_sides = \"both\")"
        }
        FaceSides::OfFile => "solids exchange outside, rooms inside",
    };
    say(&format!("  {policy}"))
}

fn print_materials(p: &SceneProposal) -> Result<(), Failure> {
    let materials = &p.survey.materials;
    let metres2 = p.placement.unit.metres.powi(2);
    for m in materials.iter().take(MAX_LISTED_MATERIALS) {
        let [r, g, b] = m.reflectance.unwrap_or(zonal_scene::DEFAULT_REFLECTANCE).to_rgb();
        let kind = if m.is_glass {
            "glass".to_string()
        } else if m.emission != Bands::ZERO {
            format!("emits {:.0} W/m2", m.emission.max_element())
        } else if m.reflectance.is_none() {
            "reflectance 0.5, not in the file".to_string()
        } else if m.is_textured {
            "texture".to_string()
        } else {
            format!("reflectance {r:.2}, {g:.2}, {b:.2}")
        };
        let name = if m.name.is_empty() { "(without a name)" } else { &m.name };
        say(&format!("  material {name}: {:.4} m2, {kind}", m.area * metres2))?;
    }
    match materials.len().saturating_sub(MAX_LISTED_MATERIALS) {
        0 => Ok(()),
        n => say(&format!("  and {n} further materials (--json lists all)")),
    }
}
