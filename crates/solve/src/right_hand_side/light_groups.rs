//! Light groups: lights that are solved as separate right-hand sides, and their source strengths.
//!
//! Order of the groups: the lights of the scene by name, surfaces that emit as zones by name, then the medium, the panes and the surroundings
//! if they emit. The right-hand side of a group holds the contributions of that group alone:
//!
//! ```text
//!     s⁰_i = c_i [ E_i + ρ_i (H_dir,i + g_i,sky B_sky / A_i) ]        (volumes: (1−Ω)E + q/(4κ) and Ω/4 in place of E and ρ)
//! ```
//!
//! A source q where κ = 0 has the strength κB = q/4.

use crate::right_hand_side::direct_light::light_field::DirectLight;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_math::parallel;
use zonal_scene::light_group::{ALL_LIGHTS_GROUP, MEDIUM_GROUP, PANES_GROUP};
use zonal_scene::{
    Bands, Diagnostic, EnergyBalance, LightGroup, LightGroupKind, LightGrouping, Scene, SceneError, Solution,
    Zones,
};

/// Number of groups above which the lights are merged, unless the scene requests separate groups: every group costs a solve and two fields.
const MAX_GROUPS: usize = 8;

/// Product of groups and zones above which the lights are merged likewise: the solver holds about 150 bytes for each, hence one gigabyte.
const MAX_GROUP_ZONES: usize = 7_000_000;

/// A group of lights with a right-hand side of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceGroup {
    /// Its name, unique among the groups.
    pub name: String,
    /// The emitters that it consists of.
    pub kind: LightGroupKind,
}

impl SourceGroup {
    /// True if the emission of zone `i` belongs to the group.
    pub fn emits(&self, zones: &Zones, i: usize) -> bool {
        self.kind.emits(zones, i)
    }
    /// True if light number `l` of the scene belongs to the group.
    pub fn has_light(&self, l: usize) -> bool {
        self.kind.has_light(l)
    }
    /// The radiosity of the surroundings that belongs to the group, W/m².
    pub fn sky(&self, scene: &Scene) -> Bands {
        match self.kind {
            LightGroupKind::All | LightGroupKind::Surroundings => scene.surroundings().radiosity(),
            _ => Bands::ZERO,
        }
    }
    /// H_dir and G_dir of the group's lights, W/m²; empty if it has none.
    pub fn direct(&self, direct: &DirectLight) -> Vec<Bands> {
        let mut own = direct.lights.iter().enumerate().filter(|(l, _)| self.has_light(*l)).map(|(_, x)| x);
        let Some(first) = own.next() else { return Vec::new() };
        let mut out = first.fields.clone();
        for light in own {
            out.iter_mut().zip(&light.fields).for_each(|(o, f)| *o += f);
        }
        out
    }
}

/// True if some voxel zone emits, also one of another process.
fn medium_emits(scene: &Scene, zones: &Zones) -> bool {
    let is_source = |emission: Bands, source: Bands| emission != Bands::ZERO || source != Bands::ZERO;
    match scene.voxel_grid() {
        Some(grid) if zones.voxels.is_divided() => {
            (0..grid.len()).any(|i| is_source(grid.emission(i), grid.source(i)))
        }
        _ => zones.voxels.distinct_media().any(|v| is_source(v.emission, v.source)),
    }
}

/// All emitters of a scene, each a group of its own.
fn separate_groups(scene: &Scene, zones: &Zones) -> Vec<SourceGroup> {
    let mut out: Vec<SourceGroup> = Vec::new();
    let mut add = |name: &str, kind: LightGroupKind| {
        let taken = |n: &str| out.iter().any(|s: &SourceGroup| s.name == n);
        let mut unique = name.to_string();
        for k in 2.. {
            if !taken(&unique) {
                break;
            }
            unique = format!("{name}-{k}");
        }
        out.push(SourceGroup { name: unique, kind });
    };
    let surfaces = scene.surfaces();
    for (l, light) in scene.lights().iter().enumerate().filter(|(_, l)| l.is_emitting(surfaces)) {
        add(light.name(surfaces), LightGroupKind::Light(l));
    }
    let mut emitting = vec![false; scene.surfaces().len()];
    zones.patches.iter().for_each(|p| emitting[p.surface] |= p.emission != Bands::ZERO);
    for (s, surface) in scene.surfaces().iter().enumerate().filter(|(s, _)| emitting[*s]) {
        add(&surface.name, LightGroupKind::Surface(s));
    }
    if medium_emits(scene, zones) {
        add(MEDIUM_GROUP, LightGroupKind::Medium);
    }
    if zones.panes.iter().any(|p| p.emission != Bands::ZERO) {
        add(PANES_GROUP, LightGroupKind::Panes);
    }
    if scene.surroundings().has_radiance() {
        add(scene.surroundings().name(), LightGroupKind::Surroundings);
    }
    out
}

/// The groups that are solved, and a diagnostic if they were merged to save memory. A thermal scene has one group: temperatures do not
/// superpose.
#[must_use]
pub fn select_groups(scene: &Scene, zones: &Zones) -> (Vec<SourceGroup>, Option<Diagnostic>) {
    let all = || vec![SourceGroup { name: ALL_LIGHTS_GROUP.into(), kind: LightGroupKind::All }];
    if scene.thermal().is_some() {
        return (all(), None);
    }
    let separate = separate_groups(scene, zones);
    let many = separate.len() > MAX_GROUPS || separate.len() * zones.total() > MAX_GROUP_ZONES;
    match scene.options().light_grouping {
        LightGrouping::All => (all(), None),
        LightGrouping::Auto if many && separate.len() > 1 => {
            let note = format!(
                "{} light groups on {} zones were solved as one sum, which cannot be relit light by light; use --light-groups each",
                separate.len(),
                zones.total()
            );
            (all(), Some(Diagnostic::note("groups-merged", note)))
        }
        _ if separate.is_empty() => (all(), None),
        _ => (separate, None),
    }
}

/// Gives the solutions of all blocks of bands the same light groups: a light that emits nothing in the bands of one block has a group of zeros there.
///
/// # Errors
/// If the lights of some blocks were solved as one sum and those of others were not.
pub(crate) fn unify_groups(blocks: &mut [Solution]) -> Result<(), SceneError> {
    let mut all: Vec<(LightGroupKind, String)> = Vec::new();
    for group in blocks.iter().flat_map(|s| &s.groups) {
        if !all.iter().any(|(kind, _)| *kind == group.kind) {
            all.push((group.kind, group.name.clone()));
        }
    }
    let merged = blocks.iter().filter(|s| s.groups.iter().any(|g| g.kind == LightGroupKind::All)).count();
    if merged == blocks.len() || all.len() == 1 {
        return Ok(());
    }
    if merged > 0 {
        let what = "the lights of some bands are one group, and those of other bands are several; give light_groups = \"all\" or \"each\"";
        return Err(SceneError::new("solve.light_groups", what));
    }
    for s in blocks {
        let mut own = std::mem::take(&mut s.groups);
        let energy = EnergyBalance::of_surfaces(s.scene.surfaces());
        let group = |(kind, name): &(LightGroupKind, String)| match own.iter().position(|g| g.kind == *kind) {
            Some(k) => own.swap_remove(k),
            None => LightGroup {
                kind: *kind,
                name: name.clone(),
                energy: energy.clone(),
                ..LightGroup::default()
            },
        };
        s.groups = all.iter().map(group).collect();
    }
    Ok(())
}

/// The source strengths s⁰ of a group with the direct light `direct` (empty for none).
pub(crate) fn source_strengths(
    source: &SourceGroup,
    scene: &Scene,
    zones: &Zones,
    surroundings: &SurroundingsExchange,
    direct: &[Bands],
) -> Vec<Bands> {
    let sky = source.sky(scene);
    parallel::collect(zones.len(), |i| {
        let emits = source.emits(zones, i);
        let e = if emits { zones.emission(i) } else { Bands::ZERO };
        let glow = if emits { zones.transparent_source(i) } else { Bands::ZERO };
        let arrives = |k: usize| {
            let d = direct.get(k).copied().unwrap_or_default();
            d + surroundings.sky_of(k) * sky / zones.response(k).1
        };
        scaled_radiosity_coefficient(zones, i) * (e + zones.scattered(i, arrives)) + glow
    })
}
