//! Which lights are solved apart, and what each of them gives to the zones.
//!
//! Groups, in this order: the lights of the scene by name, surfaces that emit as zones by name, then the medium, the panes and the
//! surroundings where they shine. Each is a right-hand side of its own: the strengths
//!
//! ```text
//!     s⁰_i = c_i [ E_i + ρ_i (H_dir,i + g_i,sky B_sky / A_i) ]        (volumes: (1−Ω)E + q/(4κ) and Ω/4 in place of E and ρ)
//! ```
//!
//! with only what belongs to the group.

use crate::direct::Direct;
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::strength;
use zonal_scene::group::{ALL, MEDIUM, PANES};
use zonal_scene::{Bands, Groups, Kind, Light, Note, Scene, Zones, bands};

/// Groups beyond which the lights are merged unless each is asked for: every one costs a solve and two fields.
pub const MOST_GROUPS: usize = 8;

/// Groups times zones beyond which they are merged likewise: the solver holds about 150 bytes for each, so this is one gigabyte.
pub const MOST_VALUES: usize = 7_000_000;

/// A group of lights.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Its name, unique among the groups.
    pub name: String,
    /// What it consists of.
    pub kind: Kind,
}

impl Source {
    /// True where the own emission of zone `i` belongs to the group.
    pub fn emits(&self, zones: &Zones, i: usize) -> bool {
        self.kind.emits(zones, i)
    }
    /// True where light number `l` of the scene belongs to the group.
    pub fn has_light(&self, l: usize) -> bool {
        self.kind.has_light(l)
    }
    /// The radiosity that stands for what the surroundings send in, W/m².
    pub fn sky(&self, scene: &Scene) -> Bands {
        match self.kind {
            Kind::All | Kind::Surroundings => scene.surroundings().radiosity(),
            _ => [0.0; 3],
        }
    }
    /// H_dir and G_dir of the group's lights; an empty list where it has none.
    pub fn direct(&self, direct: &Direct) -> Vec<Bands> {
        let mut own = direct.lights.iter().enumerate().filter(|(l, _)| self.has_light(*l)).map(|(_, x)| x);
        let Some(first) = own.next() else { return Vec::new() };
        let mut out = first.fields.clone();
        for light in own {
            out.iter_mut().zip(&light.fields).for_each(|(o, f)| *o = bands(|b| o[b] + f[b]));
        }
        out
    }
}

fn shines(light: &Light, scene: &Scene) -> bool {
    match light {
        Light::Sun { irradiance, .. } => *irradiance != [0.0; 3],
        Light::Sky { radiance, .. } => *radiance != [0.0; 3],
        Light::Emitter { surface, .. } => scene.surfaces()[*surface].emission != [0.0; 3],
    }
}

/// Everything that shines, each by its name.
pub fn each(scene: &Scene, zones: &Zones) -> Vec<Source> {
    let mut out: Vec<Source> = Vec::new();
    let mut add = |name: &str, kind: Kind| {
        let taken = |n: &str| out.iter().any(|s: &Source| s.name == n);
        let mut unique = name.to_string();
        for k in 2.. {
            if !taken(&unique) {
                break;
            }
            unique = format!("{name}-{k}");
        }
        out.push(Source { name: unique, kind });
    };
    for (l, light) in scene.lights().iter().enumerate().filter(|(_, l)| shines(l, scene)) {
        add(light.name(scene), Kind::Light(l));
    }
    let mut emitting = vec![false; scene.surfaces().len()];
    zones.patches.iter().for_each(|p| emitting[p.surface] |= p.emission != [0.0; 3]);
    for (s, surface) in scene.surfaces().iter().enumerate().filter(|(s, _)| emitting[*s]) {
        add(&surface.name, Kind::Surface(s));
    }
    if zones.voxels.par_iter().any(|v| v.emission != [0.0; 3] || v.source != [0.0; 3]) {
        add(MEDIUM, Kind::Medium);
    }
    if zones.panes.iter().any(|p| p.emission != [0.0; 3]) {
        add(PANES, Kind::Panes);
    }
    if scene.surroundings().shine() {
        add(scene.surroundings().name(), Kind::Surroundings);
    }
    out
}

/// The groups that are solved, and a note where they were merged for want of room. Heat is one sum: temperatures do not add up.
pub fn chosen(scene: &Scene, zones: &Zones) -> (Vec<Source>, Option<Note>) {
    let all = || vec![Source { name: ALL.into(), kind: Kind::All }];
    if scene.thermal().is_some() {
        return (all(), None);
    }
    let each = each(scene, zones);
    let many = each.len() > MOST_GROUPS || each.len() * zones.len() > MOST_VALUES;
    match scene.options().groups {
        Groups::All => (all(), None),
        Groups::Auto if many && each.len() > 1 => {
            let note = format!(
                "{} light groups on {} zones were solved as one sum, which cannot be relit light by light; ask for --groups each",
                each.len(),
                zones.len()
            );
            (all(), Some(Note::new("groups-merged", note)))
        }
        _ if each.is_empty() => (all(), None),
        _ => (each, None),
    }
}

/// ρ or Ω/4, and the measure (A or V) of zone `i`, m² or m³.
pub fn response(zones: &Zones, i: usize) -> (Bands, f64) {
    zones.response(i)
}

/// Own emission of zone `i` as a radiosity, W/m²: E, (1−Ω)E + q/(4κ).
pub fn emission(zones: &Zones, i: usize) -> Bands {
    zones.emission(i)
}

/// The strengths s⁰ of a group, whose direct light is `direct` (empty for none).
pub fn strengths(
    source: &Source,
    scene: &Scene,
    zones: &Zones,
    escape: &Escape,
    direct: &[Bands],
) -> Vec<Bands> {
    let sky = source.sky(scene);
    (0..zones.len())
        .into_par_iter()
        .map(|i| {
            let (c, (rho, measure)) = (strength(zones, i), response(zones, i));
            let e = if source.emits(zones, i) { emission(zones, i) } else { [0.0; 3] };
            let d = direct.get(i).copied().unwrap_or_default();
            let to_sky = escape.sky_of(i);
            bands(|b| c[b] * (e[b] + rho[b] * (d[b] + to_sky[b] * sky[b] / measure)))
        })
        .collect()
}

/// w of every zone: c ρ/A, c Ω/(4V).
pub fn weights(zones: &Zones) -> Vec<Bands> {
    let one = |i: usize| {
        let (c, (rho, measure)) = (strength(zones, i), response(zones, i));
        bands(|b| c[b] * rho[b] / measure)
    };
    (0..zones.len()).into_par_iter().map(one).collect()
}
