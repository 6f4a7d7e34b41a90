//! The text of a proposed scene.

use super::lighting::{AddedLight, ProposedLight};
use super::own_light::{MIN_IRRADIANCE, MIN_LIT_FRACTION};
use super::placement::ModelPlacement;
use std::fmt::Write;
use zonal_io::input::ModelSurvey;
use zonal_math::Vec3;
use zonal_scene::Camera;

/// Thickness of glass whose file gives none, m.
const GLASS_THICKNESS: f64 = 0.01;
/// Irradiance of the sun by band, W/m².
const SUN_IRRADIANCE: [f64; 3] = [900.0, 840.0, 740.0];
/// Radiance of the sky by band, W/(m² sr).
const SKY_RADIANCE: [f64; 3] = [30.0, 36.0, 48.0];
/// Emission of a lamp, W/m².
const LAMP_EMISSION: f64 = 500.0;
/// Cells of the commented medium along the longest side of the scene.
const MEDIUM_CELLS: f64 = 40.0;

/// The content of a scene file.
pub(super) struct SceneDocument<'a> {
    pub(super) name: &'a str,
    /// The model's file as the scene names it.
    pub(super) file: &'a str,
    pub(super) survey: &'a ModelSurvey,
    pub(super) placement: &'a ModelPlacement,
    pub(super) sides: FaceSides,
    /// Edge of a patch, m, and the number of zones that it gives.
    pub(super) patches: Option<(f64, f64)>,
    pub(super) light: Option<&'a ProposedLight>,
    pub(super) cameras: &'a [Camera],
    pub(super) bounds: Option<(Vec3, Vec3)>,
}

/// Which sides of faces exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSides {
    /// Closed parts have their outside or their inside, open parts what their file says.
    OfFile,
    /// Solids have their outside and rooms their inside; open parts and parts that are turned inside out have both.
    OpenBoth,
}

impl<'a> SceneDocument<'a> {
    /// The document of a model alone, without light, cameras and patch size.
    pub(super) fn bare(
        name: &'a str,
        file: &'a str,
        survey: &'a ModelSurvey,
        placement: &'a ModelPlacement,
        sides: FaceSides,
    ) -> SceneDocument<'a> {
        SceneDocument {
            name,
            file,
            survey,
            placement,
            sides,
            patches: None,
            light: None,
            cameras: &[],
            bounds: None,
        }
    }

    /// The scene file.
    pub(super) fn text(&self) -> String {
        let mut out = String::new();
        self.write(&mut out).unwrap_or_default();
        out
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        let (low, high) = self.survey.bounds;
        let size = (high - low) * self.placement.unit.metres;
        writeln!(
            out,
            "# {}: {} faces, {} materials.",
            self.file,
            self.survey.faces,
            self.survey.materials.len()
        )?;
        writeln!(
            out,
            "# Unit: {} ({}); extent along its axes {:.4} x {:.4} x {:.4} m. Up: {} ({}).",
            self.placement.unit.name(),
            self.placement.unit_reason,
            size.x,
            size.y,
            size.z,
            self.placement.up.name(),
            self.placement.up_reason
        )?;
        writeln!(
            out,
            "name = {}\n\n[solve]\ntolerance = 0.05      # relative; smaller takes longer",
            quoted(self.name)
        )?;
        writeln!(out, "patch_rule = \"area\"\nclosure = \"restore\"")?;
        if let Some((size, zones)) = self.patches {
            writeln!(out, "patch_size = {size}      # m; about {zones:.0} patches")?;
        }
        self.write_surface(out)?;
        self.write_light(out)?;
        self.write_medium(out)?;
        self.cameras.iter().try_for_each(|c| write_camera(out, c))
    }

    fn write_surface(&self, out: &mut String) -> std::fmt::Result {
        let metres = self.placement.unit.metres;
        let mut mesh = format!("file = {}", quoted(self.file));
        if metres != 1.0 {
            write!(mesh, ", scale = {metres}")?;
        }
        let rotation = self.placement.up.rotation_degrees();
        if rotation != [0; 3] {
            write!(mesh, ", rotate_degrees = {rotation:?}")?;
        }
        writeln!(out, "\n[[surface]]\nname = {}\nmesh = {{ {mesh} }}", quoted(self.name))?;
        if self.sides == FaceSides::OpenBoth {
            writeln!(
                out,
                "open_sides = \"both\"    # open parts and parts turned inside out are not black from behind"
            )?;
        }
        for m in &self.survey.materials {
            if m.lacks_thickness {
                let thickness = format!("pane = {{ thickness = {GLASS_THICKNESS} }}");
                writeln!(out, "materials.{}.{thickness}   # m; the file gives none", quoted(&m.name))?;
            }
        }
        Ok(())
    }

    fn write_light(&self, out: &mut String) -> std::fmt::Result {
        let Some(light) = self.light else { return Ok(()) };
        if light.of_model.is_some() && light.added.is_some() {
            writeln!(
                out,
                "\n# The light of the model gives {MIN_IRRADIANCE} W/m2 or more to less than {:.0} % of its area; the following is added. Remove it to see the model by its own light.",
                100.0 * MIN_LIT_FRACTION
            )?;
        }
        if let Some(added) = &light.added {
            write_added_light(out, added)?;
        }
        light
            .of_model
            .iter()
            .flatten()
            .try_for_each(|name| writeln!(out, "\n[[light]]\nkind = \"emitter\"\nsurface = {}", quoted(name)))
    }

    /// A medium in comments.
    fn write_medium(&self, out: &mut String) -> std::fmt::Result {
        let Some((low, high)) = self.bounds else { return Ok(()) };
        let size = (high - low).max_abs();
        let [low, high] = [low, high].map(|p| p.array().map(|x| format!("{x:.4}")).join(", "));
        let cell = size / MEDIUM_CELLS;
        writeln!(
            out,
            "\n# Haze: remove the marks to fill the scene with a medium that halves light over a third of its length."
        )?;
        writeln!(out, "# [medium]\n# min = [{low}]\n# max = [{high}]\n# cell_size = {cell:.4}       # m")?;
        writeln!(out, "# extinction = {:.5}     # 1/m\n# albedo = 0.9", 3.0 * std::f64::consts::LN_2 / size)
    }
}

fn write_added_light(out: &mut String, light: &AddedLight) -> std::fmt::Result {
    match light {
        AddedLight::SunAndSky(d) => {
            let [x, y, z] = d.array().map(|x| format!("{x:.4}"));
            writeln!(out, "\n[[light]]\nkind = \"sun\"\nname = \"sun\"\ndirection = [{x}, {y}, {z}]")?;
            writeln!(out, "irradiance = {SUN_IRRADIANCE:?}      # W/m2")?;
            writeln!(out, "\n[[light]]\nkind = \"sky\"\nname = \"sky\"\nradiance = {SKY_RADIANCE:?}      # W/(m2 sr)")
        }
        AddedLight::Lamps(lamps) => lamps.iter().enumerate().try_for_each(|(k, (corner, edge))| {
            let [x, y, z] = corner.array();
            let name = format!("zonal-lamp-{}", k + 1);
            writeln!(out, "\n[[surface]]\nname = \"{name}\"")?;
            // Counter-clockwise from below: the light goes down.
            writeln!(
                out,
                "rectangle = {{ origin = [{x:.6}, {y:.6}, {z:.6}], edge1 = [0, {edge:.6}, 0], edge2 = [{edge:.6}, 0, 0] }}"
            )?;
            writeln!(out, "reflectance = 0\nsides = \"front\"\nemission = {LAMP_EMISSION}      # W/m2")?;
            writeln!(out, "\n[[light]]\nkind = \"emitter\"\nsurface = \"{name}\"")
        }),
    }
}

fn write_camera(out: &mut String, c: &Camera) -> std::fmt::Result {
    let list = |v: Vec3| v.array().map(|x| format!("{x:.5}")).join(", ");
    writeln!(out, "\n[[camera]]\nname = {}", quoted(&c.name))?;
    writeln!(out, "origin = [{}]\ntarget = [{}]", list(c.origin), list(c.target))?;
    if c.up != zonal_math::vec3(0.0, 0.0, 1.0) {
        writeln!(out, "up = [{}]", list(c.up))?;
    }
    writeln!(out, "fov = {:.4}", c.fov)
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => out.push_str(&format!("\\u{:04X}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
