//! The solution: inert data that solvers write, and pictures, tables and files read.

use crate::{Bands, Group, Note, Scene, Zones, bands};
use zonal_math::Grade;

/// How the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveStatus {
    /// The residual fell below what was asked for.
    Converged,
    /// The residual stopped falling before.
    Stalled,
    /// The iterations ran out.
    Budget,
    /// The number of sweeps asked for has been done: light of so many segments, not of all.
    Swept,
}

impl SolveStatus {
    /// The word that reports use.
    pub fn word(self) -> &'static str {
        match self {
            SolveStatus::Converged => "converged",
            SolveStatus::Stalled => "stalled",
            SolveStatus::Budget => "budget",
            SolveStatus::Swept => "swept",
        }
    }
    /// All of them.
    pub const ALL: [SolveStatus; 4] =
        [SolveStatus::Converged, SolveStatus::Swept, SolveStatus::Budget, SolveStatus::Stalled];
}

/// One array a quantity, over all zones in the order of [`Zones`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// Radiosity B, W/m², direct light included.
    pub radiosity: Vec<Bands>,
    /// Irradiance H of patches, fluence G of volume zones, W/m², **without** direct light.
    pub incident: Vec<Bands>,
    /// H_dir of patches, G_dir of volume zones, W/m²: direct light alone.
    pub direct: Vec<Bands>,
    /// Estimated error of `incident`, W/m²; what the error of `direct` costs it is in it.
    pub error: Vec<Bands>,
    /// Estimated error of `direct`, W/m²: of shadow rays, or of the exchange areas that it comes from. Empty where there is no direct light.
    pub direct_error: Vec<Bands>,
    /// The part of `error` that comes in from the surroundings, W/m²; the rest joins it as √(rest² + part²). Empty where they are dark.
    pub surroundings_error: Vec<Bands>,
    /// Temperatures and net powers; none in light mode.
    pub heat: Option<Heat>,
}

impl Fields {
    /// Estimated error of all that arrives at zone `i`, direct light included, W/m².
    pub fn error_of_all(&self, i: usize) -> Bands {
        let direct = self.direct_error.get(i).copied().unwrap_or_default();
        bands(|b| self.error[i][b] + direct[b])
    }
}

/// What thermal mode finds on the zones, all bands together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heat {
    /// T, K; not a number where none is defined: perfect mirrors, volumes that absorb nothing, heat taken from where there is none.
    pub temperature: Vec<f64>,
    /// Estimated error of T, K; 0 where it is known, not a number where T is.
    pub temperature_error: Vec<f64>,
    /// Net power that the zone gives: W/m² of patches, W/m³ of volume zones.
    pub net: Vec<f64>,
    /// Estimated error of `net`; 0 where it is known.
    pub net_error: Vec<f64>,
}

/// Where the power went, W a band.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energy {
    /// Emitted by surfaces, volumes, panes and volumetric sources.
    pub emitted: Bands,
    /// Come in: from the surroundings' zone, and as direct light.
    pub incoming: Bands,
    /// Absorbed by each named surface, in the scene's order.
    pub absorbed_surfaces: Vec<(String, Bands)>,
    /// Absorbed by the voxels.
    pub absorbed_volumes: Bands,
    /// Absorbed by the panes.
    pub absorbed_panes: Bands,
    /// Gone to the surroundings, measured by rays.
    pub escaped: Bands,
    /// Absorbed by the black backs of one-sided surfaces, measured by rays.
    pub backs: Bands,
    /// emitted + incoming − absorbed − escaped, relative to emitted + incoming.
    pub residual: Bands,
}

impl Energy {
    fn all(&mut self) -> impl Iterator<Item = &mut Bands> {
        [
            &mut self.emitted,
            &mut self.incoming,
            &mut self.absorbed_volumes,
            &mut self.absorbed_panes,
            &mut self.escaped,
            &mut self.backs,
        ]
        .into_iter()
        .chain(self.absorbed_surfaces.iter_mut().map(|s| &mut s.1))
    }
    /// The balance of lights that shine `factor` times as strongly, a band.
    pub fn scale(&mut self, factor: Bands) {
        self.all().for_each(|x| *x = bands(|b| x[b] * factor[b]));
    }
    /// Adds the balance of other light on the same surfaces; the residual is that of both.
    pub fn add(&mut self, other: &Energy) {
        if self.absorbed_surfaces.is_empty() {
            self.absorbed_surfaces =
                other.absorbed_surfaces.iter().map(|s| (s.0.clone(), [0.0; 3])).collect();
        }
        let mut more = other.clone();
        self.all().zip(more.all()).for_each(|(x, y)| *x = bands(|b| x[b] + y[b]));
        self.balance();
    }
    /// Every power of this balance `with` that of another on the same surfaces; the residual is 0.
    pub fn compared(&self, other: &Energy, with: impl Fn(f64, f64) -> f64) -> Energy {
        let (mut out, mut other) = (self.clone(), other.clone());
        out.all().zip(other.all()).for_each(|(x, y)| *x = bands(|b| with(x[b], y[b])));
        out.residual = [0.0; 3];
        out
    }
    /// Sets the residual from the rest.
    pub fn balance(&mut self) {
        self.residual = bands(|b| {
            let given = self.emitted[b] + self.incoming[b];
            let surfaces: f64 = self.absorbed_surfaces.iter().map(|s| s.1[b]).sum();
            let taken = surfaces
                + self.absorbed_volumes[b]
                + self.absorbed_panes[b]
                + self.escaped[b]
                + self.backs[b];
            // What is not a number stays so.
            if given <= 0.0 { 0.0 } else { (given - taken) / given }
        });
    }
}

/// Closure: how far Σ_j F_ij is from A_i or 4 κ_i V_i, surroundings and backs included.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Closure {
    /// Largest relative defect before any restoration, a band.
    pub worst: Bands,
    /// Root mean square of the relative defect before any restoration, a band.
    pub rms: Bands,
    /// Largest relative change of a factor made by the restoration; zero without.
    pub largest_change: Bands,
    /// Largest relative defect after the restoration, a band.
    pub after: Bands,
    /// True when closure was restored.
    pub restored: bool,
}

impl Closure {
    /// Notes that all that arrives of a light group was changed by a share, a band.
    pub fn evened(&mut self, change: Bands) {
        self.largest_change = bands(|b| self.largest_change[b].max(change[b].abs()));
        self.restored = true;
    }
}

/// Estimated error of a solution as a whole: root mean square of the estimated error of `incident` over the zones, relative to
/// the root mean square of `incident`, or the same of all that arrives, direct light included, whichever is larger; a band.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Over the patches: of H, without and with direct light.
    pub patches: Bands,
    /// Over voxel zones and pane zones: of G, without and with direct light.
    pub volumes: Bands,
    /// How sure the estimate is.
    pub grade: Grade,
}

impl Estimate {
    /// The estimate over fields of which the first `patches` zones are patches.
    pub fn of(fields: &Fields, patches: usize, grade: Grade) -> Estimate {
        let square = |x: &[Bands]| x.iter().fold([0.0; 3], |s, x| bands(|b| s[b] + x[b] * x[b]));
        let part = |range: std::ops::Range<usize>| {
            let ratio = |e: Bands, h: Bands| bands(|b| relative(e[b], h[b]).sqrt());
            let own = ratio(square(&fields.error[range.clone()]), square(&fields.incident[range.clone()]));
            if fields.direct_error.is_empty() {
                return own;
            }
            let sum = |x: &[Bands], y: &[Bands]| {
                let both = range.clone().map(|i| bands(|b| x[i][b] + y[i][b]));
                square(&both.collect::<Vec<_>>())
            };
            let all = ratio(sum(&fields.error, &fields.direct_error), sum(&fields.incident, &fields.direct));
            bands(|b| own[b].max(all[b]))
        };
        Estimate { patches: part(0..patches), volumes: part(patches..fields.incident.len()), grade }
    }
}

impl Default for Estimate {
    fn default() -> Estimate {
        Estimate { patches: [0.0; 3], volumes: [0.0; 3], grade: Grade::Estimated }
    }
}

/// `error` over `value`, both from 0: nothing of nothing is known, an error of nothing is not, and what is not a number is infinite.
fn relative(error: f64, value: f64) -> f64 {
    match () {
        () if error.is_nan() || value.is_nan() => f64::INFINITY,
        () if value > 0.0 => error / value,
        () if error == 0.0 => 0.0,
        () => f64::INFINITY,
    }
}

/// What a row of [`HeatReport`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeatKind {
    /// A named surface.
    Surface,
    /// All voxels.
    Medium,
    /// A named pane.
    Pane,
}

impl HeatKind {
    /// All of them.
    pub const ALL: [HeatKind; 3] = [HeatKind::Surface, HeatKind::Medium, HeatKind::Pane];
    /// The word that reports use.
    pub fn word(self) -> &'static str {
        ["surface", "medium", "pane"][self as usize]
    }
}

/// Temperature and heat of a named surface, of the medium or of a pane. Errors are bounds by the estimated errors of all that arrives, added
/// up as if they had one sign.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatRow {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: HeatKind,
    /// Area of all its patches, m²; volume of media and panes, m³.
    pub size: f64,
    /// (mean of T⁴ over area or volume)^¼, K, of what has a temperature; none where nothing has.
    pub temperature: Option<f64>,
    /// Its error, K.
    pub temperature_error: Option<f64>,
    /// Net power that it gives, W.
    pub power: f64,
    /// Its error, W.
    pub power_error: f64,
}

impl HeatRow {
    /// Net power over size: W/m² of surfaces, W/m³ of media and panes, and its error.
    pub fn flux(&self) -> [f64; 2] {
        [self.over_size(self.power), self.over_size(self.power_error)]
    }
    /// A power (W) over the size: W/m² or W/m³; 0 of what has none.
    pub fn over_size(&self, power: f64) -> f64 {
        if self.size > 0.0 { power / self.size } else { 0.0 }
    }
}

/// Temperatures and heat by name, and their balance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatReport {
    /// Surfaces in the scene's order, then the medium, then panes.
    pub rows: Vec<HeatRow>,
    /// Power that comes in from the surroundings less what escapes to them, W.
    pub surroundings: f64,
    /// Power lost on the black, cold backs of one-sided surfaces, W.
    pub backs: f64,
}

impl HeatReport {
    /// Σ of all net powers, which would be 0 but for errors, W.
    pub fn balance(&self) -> f64 {
        self.rows.iter().map(|r| r.power).sum::<f64>() + self.surroundings - self.backs
    }
}

/// What the size of the zones costs, estimated from a second solve on zones about twice as large. With Q of the zones as they are, Q' of
/// those that are `ratio` times as large across, and an error that is proportional to the size of the zones or falls faster, Q errs by at
/// most |Q − Q'|/(ratio − 1).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Zoning {
    /// Zones of the second solve.
    pub zones: usize,
    /// How many times as large they are across, above 1.
    pub ratio: f64,
    /// Errors of temperature (K) and net power (W) of each row of [`HeatReport`]; 0 of what is known, empty in light mode.
    pub heat: Vec<[f64; 2]>,
    /// Errors of the powers in [`Report::energy`], W a band; its residual is 0.
    pub energy: Energy,
    /// What these errors do not tell: of which zones, and why.
    pub notes: Vec<Note>,
}

/// What was done, and how well it went.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The engine: `dense`, `hierarchical` or `spectral`.
    pub engine: String,
    /// Why it was chosen.
    pub reason: String,
    /// How the iteration ended, a band; the worst of all light groups.
    pub status: [SolveStatus; 3],
    /// Power not yet distributed before the first and after each iteration, relative to the power that the sources give, a band.
    pub residuals: [Vec<f64>; 3],
    /// Estimated error of the whole.
    pub estimate: Estimate,
    /// Closure.
    pub closure: Closure,
    /// Energy balance.
    pub energy: Energy,
    /// Stated errors of the powers in `energy`, W a band: of the exchange, of direct light, of the solver, and of what does not add up. Infinite
    /// where they are not known; the residual is 0.
    pub energy_error: Energy,
    /// Temperatures and heat by name; none in light mode.
    pub heat: Option<HeatReport>,
    /// What the size of the zones costs, where it was asked for and can be told.
    pub zoning: Option<Zoning>,
    /// Name and count of what was counted: pairs by method, rays, tables.
    pub counts: Vec<(String, u64)>,
    /// Notes and warnings: zones too thick, open enclosures, dropped triangles.
    pub warnings: Vec<Note>,
    /// The weakest grade among the exchange areas used.
    pub grade: Grade,
}

impl Default for Report {
    fn default() -> Report {
        Report {
            engine: "dense".into(),
            reason: String::new(),
            status: [SolveStatus::Converged; 3],
            residuals: Default::default(),
            estimate: Estimate::default(),
            closure: Closure::default(),
            energy: Energy::default(),
            energy_error: Energy::default(),
            heat: None,
            zoning: None,
            counts: Vec::new(),
            warnings: Vec::new(),
            grade: Grade::Estimated,
        }
    }
}

/// A solved scene.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The scene.
    pub scene: Scene,
    /// Its zones.
    pub zones: Zones,
    /// What was found on them, all lights together.
    pub fields: Fields,
    /// The same for each group of lights; empty where they were not kept.
    pub groups: Vec<Group>,
    /// What was done.
    pub report: Report,
    /// Hash of the scene's ingredients, 64 hexadecimal digits or fewer.
    pub scene_hash: String,
    /// Version of the program.
    pub version: String,
}
