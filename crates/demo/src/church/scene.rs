//! The church as a scene file beside its mesh.

use super::glass::HUES;
use super::model::ChurchMaterial;
use super::plan::{ChurchPlan, NAVE_VAULT, NAVE_WALL_OFFSETS, OUTER_WALL_OFFSET};
use super::textures;
use zonal_scene::{Bands, Texture};

/// Thickness of the glass, m.
pub(super) const GLASS_THICKNESS: f64 = 0.006;
/// Scattering albedo of the glass.
const GLASS_ALBEDO: f64 = 0.06;

/// Appearance of a material.
pub(crate) struct MaterialAppearance {
    /// Name in the mesh.
    pub name: String,
    /// Reflectance, which multiplies the texture.
    pub reflectance: Bands,
    /// Picture and the length of its side, m.
    pub texture: Option<(Texture, f64)>,
    /// Emitted flux, W/m².
    pub emission: Bands,
    /// True where both sides show.
    pub double_sided: bool,
    /// Transmittance of glass; `None` for other materials.
    pub transmittance: Option<Bands>,
}

/// The appearance of a material.
pub(crate) fn appearance(stuff: ChurchMaterial) -> MaterialAppearance {
    let plain = |name: &str, reflectance: [f64; 3]| MaterialAppearance {
        name: name.into(),
        reflectance: Bands::from_rgb(reflectance),
        texture: None,
        emission: Bands::ZERO,
        double_sided: false,
        transmittance: None,
    };
    let on = |name: &str, reflectance, texture, side| MaterialAppearance {
        texture: Some((texture, side)),
        ..plain(name, reflectance)
    };
    match stuff {
        ChurchMaterial::Ashlar => on("ashlar", [0.76, 0.70, 0.60], textures::ashlar(), 3.2),
        ChurchMaterial::Dressed => on("dressed stone", [0.74, 0.69, 0.60], textures::dressed(), 1.5),
        ChurchMaterial::Web => on("web", [0.84, 0.80, 0.72], textures::web(), 3.0),
        ChurchMaterial::Tiles => on("tiles", [0.66, 0.62, 0.56], textures::tiles(), 2.0),
        ChurchMaterial::Oak => on("oak", [0.36, 0.20, 0.10], textures::oak(), 1.0),
        ChurchMaterial::Iron => {
            MaterialAppearance { double_sided: true, ..plain("iron", [0.06, 0.06, 0.065]) }
        }
        ChurchMaterial::Linen => plain("linen", [0.85, 0.83, 0.78]),
        ChurchMaterial::Carpet => plain("carpet", [0.40, 0.04, 0.05]),
        ChurchMaterial::Wax => plain("wax", [0.82, 0.76, 0.60]),
        ChurchMaterial::Flame => MaterialAppearance {
            emission: Bands::from_rgb([5200.0, 2900.0, 1000.0]),
            ..plain("flame", [0.0; 3])
        },
        ChurchMaterial::Glass(hue) => MaterialAppearance {
            transmittance: Some(HUES[hue].transmittance),
            double_sided: true,
            ..plain(&format!("glass {}", HUES[hue].name), [0.0; 3])
        },
    }
}

/// Size of the zones of a church, and the tolerance of its solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChurchResolution {
    /// Wanted root of a patch's area, m.
    pub patch: f64,
    /// Edge of a voxel, m.
    pub cell: f64,
    /// Relative tolerance.
    pub tolerance: f64,
    /// Treatment of row sums that miss closure: "measure" or "restore".
    pub closure: &'static str,
}

/// The scene file: `mesh` is the name of the mesh beside it.
pub fn scene_text(plan: &ChurchPlan, mesh: &str, resolution: &ChurchResolution) -> String {
    let ChurchResolution { patch, cell, tolerance, closure } = *resolution;
    let mut out = format!(
        "# A church of {} bays: nave and aisles under ribbed vaults, an apse, stained glass, dusty air. z is up, the nave runs along y.
#
# Written by `zonal demo church`. Change it and solve it again: zonal check, zonal solve, zonal render.
name = \"church\"

[solve]
tolerance = {tolerance}
closure = \"{closure}\"
patch_size = {patch}         # metres: the root of a patch's area
patch_rule = \"area\"
light_groups = \"each\"

[[surface]]
name = \"church\"
mesh = {{ file = \"{mesh}\", rotate_degrees = [90, 0, 0] }}   # glTF has y up
",
        plan.bays
    );
    for hue in &HUES {
        let kappa =
            hue.transmittance.map(|t| format!("{:.1}", -t.ln() / GLASS_THICKNESS)).as_slice().join(", ");
        let pane = format!(
            "pane = {{ thickness = {GLASS_THICKNESS}, extinction = [{kappa}], albedo = {GLASS_ALBEDO} }}"
        );
        out += &format!("materials.\"glass {}\".{pane}\n", hue.name);
    }
    out += &medium_and_lights(plan, cell);
    out += &cameras(plan);
    out
}

/// The dusty air, the sun, the candles and the sky.
fn medium_and_lights(plan: &ChurchPlan, cell: f64) -> String {
    let l = plan.length();
    let (x, y1) = (OUTER_WALL_OFFSET + 0.1, l + NAVE_WALL_OFFSETS.0 + 0.1);
    let top = NAVE_VAULT.0 + NAVE_VAULT.1 + 0.1;
    let inner = 0.5 * (NAVE_WALL_OFFSETS.0 + NAVE_WALL_OFFSETS.1);
    format!(
        "
[medium]                  # the voxel grid; what lies outside the walls is empty
min = [-{x}, -0.1, 0]
max = [{x}, {y1}, {top}]
cell_size = {cell}

[[medium.region]]         # dusty air: slightly absorbing, strongly scattering
box = {{ min = [-{inner}, -0.1, 0], max = [{inner}, {y1}, {top}] }}
extinction = 0.02         # 1/m
albedo = 0.92

[[medium.region]]
box = {{ min = [-{x}, -0.1, 0], max = [{x}, {l}, 8] }}
extinction = 0.02
albedo = 0.92

[[light]]
kind = \"sun\"
name = \"sun\"
direction = [-0.70, 0.36, -0.62]
irradiance = [1000, 900, 740]   # W/m2 on a plane square to it
angular_diameter = 0.53

[[light]]
kind = \"emitter\"
name = \"candles\"
surface = \"church/flame\"

[surroundings]            # the sky, a zone of its own
name = \"sky\"
radiance = [26, 33, 44]   # W/(m2 sr)

"
    )
}

fn cameras(plan: &ChurchPlan) -> String {
    let l = plan.length();
    format!(
        "[[camera]]
name = \"nave\"
origin = [-0.6, 1.2, 2.4]
target = [0.25, {:.1}, 4.6]
fov = 70

[[camera]]
name = \"aisle\"
origin = [-7.0, {:.1}, 2.0]
target = [4.4, {:.1}, 5.2]
fov = 74

[[camera]]
name = \"rose\"
origin = [1.4, {:.1}, 2.2]
target = [-0.7, 0, 6.2]
fov = 66
",
        l * 0.75,
        l * 0.80,
        l * 0.38,
        l - 3.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_alone_transmits() {
        assert!(appearance(ChurchMaterial::Glass(0)).transmittance.is_some());
        assert!(appearance(ChurchMaterial::Ashlar).transmittance.is_none());
    }
}
