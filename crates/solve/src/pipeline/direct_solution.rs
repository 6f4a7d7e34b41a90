//! A solution of direct light alone: the first of a series that a viewer shows while the exchange between the zones is computed.
//!
//! ```text
//!     B_i = E_i + ρ_i (H_dir,i + g_i,sky B_sky / A_i)        (volumes: Ω/4 in place of ρ, and κ_i V_i in place of A_i)
//! ```
//!
//! It is the right-hand side of the zonal equations as a solution: lights by shadow rays, and the radiance of the surroundings in `incident`. No engine is
//! built. The light that zones exchange is missing, so that the errors of `incident` are unknown: infinite. Cost: the shadow rays of all lights, and the rays
//! to the surroundings if they have a radiance. Still earlier there are zones without that light, B_i = E_i, for a viewer that draws suns itself.

use crate::context::zonal_solution::ZonalSolution;
use crate::pipeline::BandBlock;
use crate::pipeline::symmetry_planes::{self, SymmetricSolve};
use crate::pipeline::zone_division;
use crate::right_hand_side::direct_light::light_field::{DirectLight, LightField};
use crate::right_hand_side::light_groups::{self, SourceGroup};
use crate::right_hand_side::surroundings::stage::measure;
use crate::settings::named_stages::{NamedStages, SolvePart};
use crate::settings::{SolveSettings, check_interrupted};
use zonal_math::Grade;
use zonal_scene::{
    Bands, Diagnostic, EnergyBalance, ErrorEstimate, Fields, LightGroup, PerBand, Report, Scene, SceneError,
    Solution, SolveStatus, ZoneValues, Zones,
};
use zonal_transport::Transport;

/// Name of the engine in the report of a solution of direct light, and of one without it.
const ENGINE: &str = "direct light";
const ENGINE_OF_NO_LIGHT: &str = "emission";

/// The direct light of a scene in light mode, and the light that reaches its zones from the surroundings, without interreflection.
///
/// # Errors
/// If the scene is in thermal mode, cannot be cut into zones, or if the observer interrupts.
pub fn solve_direct_light(scene: Scene, settings: &SolveSettings) -> Result<Solution, SceneError> {
    solve_first_light(scene, settings, FirstLight::Direct)
}

/// The zones of a scene in light mode with their emission, before any light on them is known.
///
/// # Errors
/// As [`solve_direct_light`].
pub fn solve_without_light(scene: Scene, settings: &SolveSettings) -> Result<Solution, SceneError> {
    solve_first_light(scene, settings, FirstLight::None)
}

/// The light on the zones of a first solution.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FirstLight {
    /// None.
    None,
    /// That of lights by shadow rays, and of the surroundings.
    Direct,
}

fn solve_first_light(
    scene: Scene,
    settings: &SolveSettings,
    light: FirstLight,
) -> Result<Solution, SceneError> {
    if scene.thermal().is_some() {
        return Err(SceneError::new("mode", "direct light alone is a solution in light mode only"));
    }
    let (transport, zones) = zone_division::cut(&scene, settings)?;
    let mut solved = Vec::new();
    for (b, block) in scene.blocks().enumerate() {
        let checkpoints = NamedStages { store: settings.checkpoints, part: SolvePart::Block(b) };
        let (transport, zones) = zone_division::of_block(&block, &transport, &zones);
        solved.push(solve_block(&block, &transport, zones, &settings.of_block(b, &checkpoints), light)?);
    }
    light_groups::unify_groups(&mut solved)?;
    Ok(Solution::of_blocks(scene, solved))
}

/// The solution of one block of bands.
fn solve_block(
    scene: &Scene,
    transport: &Transport,
    zones: Zones,
    settings: &SolveSettings,
    light: FirstLight,
) -> Result<Solution, SceneError> {
    let mut warnings = symmetry_planes::excluded_parts_of(scene, transport, &zones)?;
    // Compute the light of the scene, or of its even extension.
    let (fields, groups) = match SymmetricSolve::of(scene, &zones)? {
        Some(m) => {
            let transport = &Transport::new(&m.extension.scene);
            let (fields, groups) = BandBlock::extended(&m, transport).first_fields(settings, light)?;
            (m.fields_of_part(fields), m.groups_of_part(groups))
        }
        None => {
            let whole = BandBlock { scene, zones: &zones, transport, mirrored: None };
            whole.first_fields(settings, light)?
        }
    };
    let (engine, text) = match light {
        FirstLight::Direct => (
            ENGINE,
            "direct light and the light of the surroundings alone: the light that surfaces and medium exchange is being computed",
        ),
        FirstLight::None => (ENGINE_OF_NO_LIGHT, "emission alone: the light on the zones is being computed"),
    };
    warnings.push(Diagnostic::note("direct-light", text));
    let unknown = Bands::splat(f64::INFINITY);
    let report = Report {
        engine: engine.into(),
        reason: "a preview before the exchange of light is known".into(),
        status: PerBand::splat(SolveStatus::FixedOrder),
        estimate: ErrorEstimate {
            patches: unknown,
            volumes: unknown,
            grade: Grade::Statistical,
            parts: None,
        },
        warnings,
        grade: Grade::Statistical,
        ..Report::default()
    };
    let solved = ZonalSolution {
        scene: scene.clone(),
        zones,
        fields,
        groups,
        report,
        emitters: Bands::ZERO,
        has_slopes: false,
    };
    Ok(solved.into_solution())
}

impl BandBlock<'_> {
    /// The fields of direct light and of the surroundings where they are wanted, and those of each light group; on an even extension averaged over the images.
    fn first_fields(
        &self,
        settings: &SolveSettings,
        first_light: FirstLight,
    ) -> Result<(Fields, Vec<LightGroup>), SceneError> {
        let (scene, zones, n) = (self.scene, self.zones, self.zones.len());
        // Trace shadow rays to all lights.
        let light = |l: usize| match first_light {
            FirstLight::None => Ok(LightField::default()),
            FirstLight::Direct => self.light(l, settings),
        };
        let lights = (0..scene.lights().len()).map(light).collect::<Result<Vec<_>, _>>()?;
        let direct = DirectLight { lights };
        // Measure the light of the surroundings.
        let (incoming, error) = match first_light {
            FirstLight::Direct => self.incoming(settings)?,
            FirstLight::None => (vec![Bands::ZERO; n], Vec::new()),
        };
        let (sources, _) = light_groups::select_groups(scene, zones);
        let groups = sources.iter().map(|s| self.group(s, &direct, &incoming)).collect();
        // Sum.
        let all = direct.fields(n);
        let radiosity = (0..n).map(|i| {
            let (e, (rho, _)) = (zones.emission(i), zones.response(i));
            e + rho * (incoming[i] + all[i])
        });
        let direct_error: Vec<Bands> =
            (0..n).map(|i| direct.lights.iter().map(|l| l.error_of(i)).sum()).collect();
        let fields = Fields {
            radiosity: radiosity.collect(),
            direct_error: if direct.lights.is_empty() { Vec::new() } else { direct_error },
            direct: Fields::direct_unless_zero(all),
            incident: incoming,
            error: vec![Bands::splat(f64::INFINITY); n],
            surroundings_error: error,
            heat: None,
        };
        Ok((fields, groups))
    }

    /// H or G of the light of the surroundings, W/m², and its error, empty for black surroundings.
    fn incoming(&self, settings: &SolveSettings) -> Result<(Vec<Bands>, Vec<Bands>), SceneError> {
        let (scene, zones, n) = (self.scene, self.zones, self.zones.len());
        if !scene.surroundings().has_radiance() {
            return Ok((vec![Bands::ZERO; n], Vec::new()));
        }
        let mut exchange = measure(zones, self.transport, settings);
        check_interrupted(settings.progress)?;
        if let Some(m) = self.mirrored {
            exchange = m.even_surroundings(&exchange);
        }
        let sky = scene.surroundings().radiosity();
        let field = |i: usize| exchange.incoming(i, sky).map(|v| v / zones.response(i).1);
        Ok((0..n).map(field).map(|[h, error]| (h, error)).unzip())
    }

    /// The fields of one light group.
    fn group(&self, source: &SourceGroup, direct: &DirectLight, incoming: &[Bands]) -> LightGroup {
        let has_sky = source.sky(self.scene) != Bands::ZERO;
        let incident = if has_sky { incoming.to_vec() } else { vec![Bands::ZERO; incoming.len()] };
        LightGroup {
            name: source.name.clone(),
            kind: source.kind,
            incident: ZoneValues::Double(incident),
            direct: ZoneValues::Double(source.direct(direct)),
            status: PerBand::splat(SolveStatus::FixedOrder),
            energy: EnergyBalance::of_surfaces(self.scene.surfaces()),
            ..LightGroup::default()
        }
    }
}
