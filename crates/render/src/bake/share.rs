//! What each light group gives to a zone.
//!
//! B_g = E_g + response · (G_g + G_dir,g), with ρ or Ω/4 in place of `response`; one share of everything where groups were not kept.
//! H of patches may be taken without the noise that the solution tells of, as in pictures.

use crate::calm::calmed;
use zonal_scene::group::ALL;
use zonal_scene::{Bands, Group, Kind, Light, Scene, Solution, Values, bands};

/// One group of a solution.
pub(super) struct Share<'a> {
    pub name: &'a str,
    pub kind: Kind,
    s: &'a Solution,
    /// `None` for everything together.
    group: Option<&'a Group>,
    /// H of the patches without direct light and without noise, W/m²; empty where it is taken as it is.
    calm: Vec<Bands>,
}

impl<'a> Share<'a> {
    /// All of them, at least one.
    pub(super) fn all(s: &'a Solution) -> Vec<Share<'a>> {
        if s.groups.is_empty() {
            return vec![Share { name: ALL, kind: Kind::All, s, group: None, calm: Vec::new() }];
        }
        let share = |g: &'a Group| Share { name: &g.name, kind: g.kind, s, group: Some(g), calm: Vec::new() };
        s.groups.iter().map(share).collect()
    }

    /// The same without the noise of the patches.
    pub(super) fn calmed(self) -> Share<'a> {
        let patches = &self.s.zones.patches;
        let calm = match self.group {
            None => calmed(patches, &self.s.fields.incident, &self.s.fields.error),
            Some(g) => {
                let all = |v: &Values| (0..patches.len()).map(|i| times(v.at(i), g.incident_scale)).collect();
                let (incident, error): (Vec<Bands>, Vec<Bands>) = (all(&g.incident), all(&g.error));
                calmed(patches, &incident, &error)
            }
        };
        Share { calm, ..self }
    }

    /// H or G of a zone without direct light, W/m².
    pub(super) fn incident(&self, zone: usize) -> Bands {
        match self.group {
            _ if zone < self.calm.len() => self.calm[zone],
            None => self.s.fields.incident[zone],
            Some(g) => times(g.incident.at(zone), g.incident_scale),
        }
    }

    /// H_dir or G_dir of a zone, W/m².
    pub(super) fn direct(&self, zone: usize) -> Bands {
        match self.group {
            None => self.s.fields.direct[zone],
            Some(g) => times(g.direct.at(zone), g.direct_scale),
        }
    }

    /// G + G_dir, W/m².
    pub(super) fn fluence(&self, zone: usize) -> Bands {
        let (g, d) = (self.incident(zone), self.direct(zone));
        bands(|b| g[b] + d[b])
    }

    /// B, direct light included, W/m².
    pub(super) fn radiosity(&self, zone: usize) -> Bands {
        let zones = &self.s.zones;
        let (g, (rho, _)) = (self.fluence(zone), zones.response(zone));
        let e = if self.kind.emits(zones, zone) { zones.emission(zone) } else { [0.0; 3] };
        bands(|b| e[b] + rho[b] * g[b])
    }

    /// True where its direct light is so smooth that the zones' own values serve: a sky by itself.
    pub(super) fn is_smooth(&self) -> bool {
        matches!(self.kind, Kind::Light(l) if matches!(self.s.scene.lights()[l], Light::Sky { .. }))
    }

    /// True where the emission of a surface belongs to the group.
    pub(super) fn owns_surface(&self, scene: &Scene, surface: usize) -> bool {
        match self.kind {
            Kind::All => true,
            Kind::Surface(s) => s == surface,
            Kind::Light(l) => matches!(scene.lights()[l], Light::Emitter { surface: s, .. } if s == surface),
            Kind::Medium | Kind::Panes | Kind::Surroundings => false,
        }
    }
}

fn times(a: Bands, f: Bands) -> Bands {
    bands(|b| a[b] * f[b])
}
