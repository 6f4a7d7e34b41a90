//! Light groups: the share of each group in the fields of a zone.
//!
//! B_g = E_g + response · (G_g + G_dir,g), with ρ or Ω/4 for `response`; a solution without groups has one field of everything. H of
//! patches may be denoised, as in pictures.

use crate::image::denoise::{NoisyField, denoise_patches};
use zonal_scene::light_group::ALL_LIGHTS_GROUP;
use zonal_scene::{Bands, LightGroup, LightGroupKind, Scene, Solution};

/// One group of a solution.
pub(super) struct GroupField<'a> {
    pub name: &'a str,
    pub kind: LightGroupKind,
    s: &'a Solution,
    /// `None` for all groups together.
    group: Option<&'a LightGroup>,
    /// Denoised H of the patches without direct light, W/m²; empty where it is not denoised.
    denoised: Vec<Bands>,
}

impl<'a> GroupField<'a> {
    /// The groups of a solution, at least one.
    pub(super) fn of_solution(s: &'a Solution) -> Vec<GroupField<'a>> {
        if s.groups.is_empty() {
            return vec![GroupField {
                name: ALL_LIGHTS_GROUP,
                kind: LightGroupKind::All,
                s,
                group: None,
                denoised: Vec::new(),
            }];
        }
        let denoised = Vec::new;
        let field = |g: &'a LightGroup| GroupField {
            name: &g.name,
            kind: g.kind,
            s,
            group: Some(g),
            denoised: denoised(),
        };
        s.groups.iter().map(field).collect()
    }

    /// The groups of a solution with denoised irradiances of the patches.
    pub(super) fn denoised_of_solution(s: &'a Solution) -> Vec<GroupField<'a>> {
        let groups = GroupField::of_solution(s);
        let patches = &s.zones.patches;
        let of_group = |g: &GroupField| match g.group {
            None => [s.fields.incident.clone(), s.fields.error.clone()],
            Some(g) => [&g.incident, &g.error].map(|values| {
                let at = |i: usize| values.at(i) * g.incident_scale;
                (0..patches.len()).map(at).collect()
            }),
        };
        let fields: Vec<[Vec<Bands>; 2]> = groups.iter().map(of_group).collect();
        let fields: Vec<NoisyField> =
            fields.iter().map(|[incident, error]| NoisyField { incident, error }).collect();
        let all = groups.into_iter().zip(denoise_patches(patches, &fields));
        all.map(|(group, denoised)| GroupField { denoised, ..group }).collect()
    }

    /// H or G of a zone without direct light, W/m²; of a side of a transmitting sheet the mean of both sides ([`zonal_scene::Zones::mixed`]).
    pub(super) fn incident(&self, zone: usize) -> Bands {
        self.s.zones.mixed(zone, |i| self.own_incident(i))
    }

    fn own_incident(&self, zone: usize) -> Bands {
        match self.group {
            _ if zone < self.denoised.len() => self.denoised[zone],
            None => self.s.fields.incident[zone],
            Some(g) => g.incident_at(zone),
        }
    }

    /// H_dir or G_dir of a zone, W/m², mixed likewise.
    pub(super) fn direct(&self, zone: usize) -> Bands {
        self.s.zones.mixed(zone, |i| match self.group {
            None => self.s.fields.direct_light(i),
            Some(g) => g.direct_at(i),
        })
    }

    /// G + G_dir, W/m².
    pub(super) fn fluence(&self, zone: usize) -> Bands {
        self.incident(zone) + self.direct(zone)
    }

    /// B, direct light included, W/m².
    pub(super) fn radiosity(&self, zone: usize) -> Bands {
        let zones = &self.s.zones;
        let (g, (rho, _)) = (self.fluence(zone), zones.response(zone));
        let e = if self.kind.emits(zones, zone) { zones.emission(zone) } else { Bands::ZERO };
        e + (rho + zones.sheets.transmittance(zone)) * g
    }

    /// True where its direct light is smooth enough for the values of the zones: a light from all directions in a group of its own.
    pub(super) fn is_smooth(&self) -> bool {
        matches!(self.kind, LightGroupKind::Light(l) if self.s.scene.lights()[l].fills_sphere())
    }

    /// True where the emission of a surface belongs to the group.
    pub(super) fn owns_surface(&self, scene: &Scene, surface: usize) -> bool {
        match self.kind {
            LightGroupKind::All => true,
            LightGroupKind::Surface(s) => s == surface,
            LightGroupKind::Light(l) => scene.lights()[l].surface() == Some(surface),
            LightGroupKind::Medium | LightGroupKind::Panes | LightGroupKind::Surroundings => false,
        }
    }
}
