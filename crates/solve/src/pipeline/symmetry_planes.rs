//! Scenes with symmetry_planes: the zonal equations of the even extension ([`zonal_scene::EvenExtension`]), and the part of its solution on the scene.
//!
//! All sources are even, and so is the solution. With g·i the images of zone i and |G| their number, a field of the scene and a power are
//!
//! ```text
//!     H_i = 1/|G| Σ_g H'(g·i)          P = P'/|G|
//! ```
//!
//! Noise of rays makes images differ; direct light and the exchange with the surroundings are averaged over the images before the equations are
//! solved. A sun or a point light has the extension's direct light of all its images: with n distinct ones among them, D_i = n/|G| Σ_g D'(g·i) of one.
//!
//! The dense engine keeps sums over images only, F_ij = Σ_g F'(i, g·j): a matrix of the scene's zones (`dense/image_sums.rs`).

use crate::context::zonal_solution::ZonalSolution;
use crate::distribution::sum_order::SharedZones;
use crate::errors::estimate::error_estimate;
use crate::right_hand_side::direct_light::light_field::LightField;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::SolveSettings;
use zonal_scene::{
    Bands, Diagnostic, EnergyBalance, ErrorEstimate, EvenExtension, Fields, LightGroup, Report, Scene,
    SceneError, ZoneImages, Zones,
};
use zonal_transport::Transport;
use zonal_transport::zoning::excluded_parts;

/// The even extension that stands for a scene with symmetry planes while its equations are solved.
pub struct SymmetricSolve {
    /// The extension.
    pub extension: EvenExtension,
    /// Its zones.
    pub zones: Zones,
    /// The zones of the scene that they are images of.
    pub images: ZoneImages,
}

impl SymmetricSolve {
    /// The extension of a scene and of its zones, with boundary conditions applied; `None` without symmetry planes.
    ///
    /// # Errors
    /// If the medium of the extension has too many cells.
    pub fn of(scene: &Scene, zones: &Zones) -> Result<Option<SymmetricSolve>, SceneError> {
        Ok(EvenExtension::of(scene)?.map(|extension| {
            let (zones, images) = extension.extended_zones(zones);
            SymmetricSolve { extension, zones, images }
        }))
    }

    /// Direct light of light number `l` with all its images, even to the bit.
    pub(crate) fn even_light(&self, l: usize, light: LightField) -> LightField {
        let count = self.extension.light_images(&self.extension.scene.lights()[l]) as f64;
        let even = |list: Vec<Bands>| -> Vec<Bands> {
            self.images.extended(&list).into_iter().map(|x| x * count).collect()
        };
        LightField {
            fields: even(self.images.mean(&light.fields)),
            error: even(self.images.root_mean_square(&light.error)),
            ..light.with_powers_times(count)
        }
    }

    /// The exchange with the surroundings, even to the bit.
    pub(crate) fn even_surroundings(&self, exchange: &SurroundingsExchange) -> SurroundingsExchange {
        let even = |list: &[Bands]| self.images.extended(&self.images.mean(list));
        SurroundingsExchange {
            sky: even(&exchange.sky),
            backfaces: even(&exchange.backfaces),
            error: self.images.extended(&self.images.root_mean_square(&exchange.error)),
            rays: exchange.rays,
        }
    }

    /// The exchange of the zones of the scene with the surroundings.
    pub(crate) fn surroundings_of_part(&self, exchange: &SurroundingsExchange) -> SurroundingsExchange {
        SurroundingsExchange {
            sky: self.images.mean(&exchange.sky),
            backfaces: self.images.mean(&exchange.backfaces),
            error: self.images.root_mean_square(&exchange.error),
            rays: exchange.rays,
        }
    }

    /// Direct light of light number `l` on the zones of the scene, with the powers of one image.
    pub(crate) fn light_of_part(&self, l: usize, light: LightField) -> LightField {
        let light = self.even_light(l, light);
        let share = 1.0 / self.images.image_count() as f64;
        LightField {
            fields: self.images.mean(&light.fields),
            error: self.images.mean(&light.error),
            ..light.with_powers_times(share)
        }
    }

    /// Fields of the scene from those of the extension.
    pub(crate) fn fields_of_part(&self, fields: Fields) -> Fields {
        fields.map_lists(|list| self.images.mean(list))
    }

    /// Light groups of the scene from those of the extension.
    pub(crate) fn groups_of_part(&self, groups: Vec<LightGroup>) -> Vec<LightGroup> {
        groups.into_iter().map(|g| self.images.mean_group(g)).collect()
    }

    /// The solution of the scene from that of the extension.
    pub(crate) fn part_of(&self, solved: ZonalSolution, scene: &Scene, zones: &Zones) -> ZonalSolution {
        let fields = self.fields_of_part(solved.fields);
        ZonalSolution {
            scene: scene.clone(),
            groups: self.groups_of_part(solved.groups),
            report: self.report_of_part(solved.report, scene, zones, &fields),
            emitters: solved.emitters / self.images.image_count() as f64,
            fields,
            ..solved
        }
    }

    /// The report of the scene from that of the extension; `fields` and `zones` are those of the scene.
    pub(crate) fn report_of_part(
        &self,
        report: Report,
        scene: &Scene,
        zones: &Zones,
        fields: &Fields,
    ) -> Report {
        let one_image = |mut powers: EnergyBalance| {
            powers.scale(Bands::splat(1.0 / self.images.image_count() as f64));
            powers
        };
        let mut out = Report {
            energy: one_image(report.energy),
            energy_error: one_image(report.energy_error),
            estimate: ErrorEstimate {
                parts: report.estimate.parts,
                ..error_estimate(SharedZones::alone(zones), fields, report.estimate.grade)
            },
            ..report
        };
        let of_part = [
            ("zones", zones.len()),
            ("patches", zones.patches.len()),
            ("voxel zones", zones.voxels.len()),
            ("pane zones", zones.panes.len()),
        ];
        for (name, count) in &mut out.counts {
            if let Some(part) = of_part.iter().find(|p| p.0 == name.as_str()) {
                *count = part.1 as u64;
            }
        }
        out.counts.push(("zones with their mirror images".into(), self.zones.len() as u64));
        out.warnings.insert(0, symmetry_note(scene, self.images.image_count()));
        out
    }
}

/// The parts of a scene that have no zones ([`excluded_parts`]); with symmetry planes those of the even extension, whose solids continue behind them.
///
/// # Errors
/// As [`excluded_parts`].
pub fn excluded_parts_of(
    scene: &Scene,
    transport: &Transport,
    zones: &Zones,
) -> Result<Vec<Diagnostic>, SceneError> {
    match SymmetricSolve::of(scene, zones)? {
        Some(m) => excluded_parts(&m.extension.scene, &Transport::new(&m.extension.scene), &m.zones),
        None => excluded_parts(scene, transport, zones),
    }
}

/// Refuses formulas of the paper, which have no mirror images.
pub(crate) fn check_settings(settings: &SolveSettings) -> Result<(), SceneError> {
    match settings.pair_settings.volume_factors {
        Some(_) => Err(SceneError::new(
            "boundary",
            "formulas of the paper have no images of a scene with symmetry planes; use --factors exact",
        )),
        None => Ok(()),
    }
}

/// The error of an extension, in terms of the scene with symmetry planes: what is wrong with periodic axes concerns symmetry planes that face each other.
pub(crate) fn explain(scene: &Scene, error: SceneError) -> SceneError {
    let facing = scene.symmetry_planes().contains(&[true; 2]);
    if !facing || error.key() != "boundary" {
        return error;
    }
    let what = format!("symmetry planes that face each other make the scene periodic: {}", error.message());
    SceneError::new("boundary", what)
}

/// The note that names the symmetry planes of a scene.
pub fn symmetry_note(scene: &Scene, images: usize) -> Diagnostic {
    let name = |k: usize| match scene.symmetry_planes()[k] {
        [true, true] => Some(format!("{} (both ends)", AXES[k])),
        [true, false] => Some(format!("{}0", AXES[k])),
        [false, true] => Some(format!("{}1", AXES[k])),
        _ => None,
    };
    let names: Vec<String> = (0..3).filter_map(name).collect();
    let text = format!(
        "symmetry planes at {}: the scene is the part of an even extension of {images} images; zones and powers are those of the part",
        names.join(", ")
    );
    Diagnostic::note("symmetry-planes", text)
}

const AXES: [&str; 3] = ["x", "y", "z"];
