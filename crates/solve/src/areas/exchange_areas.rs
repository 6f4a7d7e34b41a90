//! Direct and total exchange areas of all pairs of zones of a scene, as matrices.
//!
//! With n zones in the order of a solution (patches, voxel zones, pane zones), the direct area F_ij (m²) leaves out reflection and scattering; the
//! total area T_ij is the net power from zone i to zone j per unit of σT_i⁴ − σT_j⁴, all reflections and scattering included
//! ([`crate::areas::total_exchange_areas`]). In a scene with symmetry planes they are sums over the mirror images of j. Both are symmetric to the bit. There is one matrix where the bands do not differ, else one for each band.
//!
//! Cost: n²/2 pairs; total areas take about 4n³ multiplications. Memory: 16 n² bytes for each direct matrix, 32 n² and 24 n² of work with total ones.

use crate::areas::total_exchange_areas::{NUMBERS_PER_PAIR, sum_by_group, total_exchange_areas};
use crate::engines::dense::image_sums::ImageSums;
use crate::engines::selection::{MIN_LINEAR_BASIS_THICKNESS, check_periodic_pairs};
use crate::pipeline::symmetry_planes::{self, SymmetricSolve};
use crate::pipeline::zone_division;
use crate::settings::check_interrupted;
use crate::settings::zone_power::fluence_factor;
use crate::thermal::emissivity::set_known_reflectances;
use zonal_exchange::pair::{
    Exchange, PairCounts, PairSettings, closure_target, scaled_radiosity_coefficient,
};
use zonal_math::Grade;
use zonal_math::parallel;
use zonal_scene::{Band, Diagnostic, Progress, Scene, SceneError, Zones};
use zonal_transport::{Transport, build_zones};

/// Bytes of an entry of one band: the area and its radius.
const BYTES_PER_ENTRY: u64 = 16;
/// Bytes of an entry of one band while total areas are computed.
const WORK_BYTES_PER_ENTRY: u64 = 8 * (NUMBERS_PER_PAIR - 2);

/// Which exchange areas to compute.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExchangeAreaContents {
    /// Direct areas.
    Direct,
    /// Direct and total areas.
    #[default]
    DirectAndTotal,
}

/// How exchange areas are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExchangeAreaSettings {
    /// Wanted relative error of the factors of axis-aligned pairs and of pairs of plates, 0 < tolerance < 1; 1e-9. What rays measure has the
    /// scene's tolerance.
    pub tolerance: f64,
    /// Largest memory of the matrices, bytes; 12 GB.
    pub memory_limit: u64,
    /// Which areas.
    pub contents: ExchangeAreaContents,
}

impl Default for ExchangeAreaSettings {
    fn default() -> ExchangeAreaSettings {
        ExchangeAreaSettings {
            tolerance: 1e-9,
            memory_limit: 12_000_000_000,
            contents: ExchangeAreaContents::DirectAndTotal,
        }
    }
}

/// Square matrices of exchange areas and their error radii, m², one matrix after the other, row by row.
#[derive(Clone, Debug, Default)]
pub struct AreaMatrices {
    /// Areas.
    pub areas: Vec<f64>,
    /// Error radii.
    pub radii: Vec<f64>,
    /// The sum of each row in a closed scene: A and 4κV of direct areas, εA and 4κ_aV of total ones.
    pub closure: Vec<f64>,
}

impl AreaMatrices {
    /// Largest relative distance of a row's sum from its sum in a closed scene; an open scene loses the power that leaves it.
    #[must_use]
    pub fn largest_row_defect(&self) -> f64 {
        let rows = self.closure.len();
        let n = self.areas.len().checked_div(rows).unwrap_or(0);
        (0..rows).filter(|&k| self.closure[k] > 0.0).fold(0.0f64, |worst, k| {
            let sum: f64 = self.areas[k * n..(k + 1) * n].iter().sum();
            worst.max((sum / self.closure[k] - 1.0).abs())
        })
    }
}

/// The exchange areas of a scene.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ExchangeAreas {
    /// The zones: rows and columns.
    pub zones: Zones,
    /// Number of matrices: 1, or one for each band.
    pub matrices: usize,
    /// Direct areas.
    pub direct: AreaMatrices,
    /// Total areas, where they were requested.
    pub total: Option<AreaMatrices>,
    /// Names of the surfaces, of the medium and of the panes.
    pub names: Vec<String>,
    /// The name of each zone, as an index into `names`.
    pub name_of_zone: Vec<usize>,
    /// Number of pairs by method.
    pub counts: PairCounts,
    /// Notes and warnings.
    pub diagnostics: Vec<Diagnostic>,
}

impl ExchangeAreas {
    /// Computes the exchange areas of a scene.
    ///
    /// # Errors
    /// If the scene has no zones of this kind, if the matrices exceed the memory limit, if an area is not a finite number, if nothing absorbs in a
    /// closed scene, so that total areas do not exist, or if the observer interrupts the computation.
    pub fn compute(
        scene: &Scene,
        settings: &ExchangeAreaSettings,
        progress: &dyn Progress,
    ) -> Result<ExchangeAreas, SceneError> {
        let transport = Transport::new(scene);
        let zones = build_zones(scene, &transport)?;
        let blocks = scene.bands().block_count();
        if blocks == 1 {
            return ExchangeAreas::of_block(&transport, zones, settings, progress);
        }
        // Each block of bands has matrices of its own.
        let memory_limit = settings.memory_limit / blocks as u64;
        let settings = ExchangeAreaSettings { memory_limit, ..*settings };
        let mut all: Option<ExchangeAreas> = None;
        for block in scene.blocks() {
            let (transport, zones) = zone_division::of_block(&block, &transport, &zones);
            let own = ExchangeAreas::of_block(&transport, zones, &settings, progress)?;
            let own = own.expanded(block.window().len());
            match &mut all {
                None => all = Some(own),
                Some(all) => all.append(own),
            }
        }
        all.ok_or_else(|| SceneError::new("bands", "the scene has no bands; give at least one"))
    }

    /// The areas of one block of bands.
    fn of_block(
        transport: &Transport,
        mut zones: Zones,
        settings: &ExchangeAreaSettings,
        progress: &dyn Progress,
    ) -> Result<ExchangeAreas, SceneError> {
        // Zones and the diagnostics that concern them.
        let scene = transport.scene();
        set_known_reflectances(scene, &mut zones)?;
        let mut diagnostics = scene.notes().to_vec();
        diagnostics.extend(symmetry_planes::excluded_parts_of(scene, transport, &zones)?);
        diagnostics.extend(thick_voxels(scene, &zones));
        let mirrored = SymmetricSolve::of(scene, &zones)?;
        diagnostics
            .extend(mirrored.as_ref().map(|m| symmetry_planes::symmetry_note(scene, m.images.image_count())));
        match &mirrored {
            Some(m) => check_periodic_pairs(&m.extension.scene, &m.zones)
                .map_err(|e| symmetry_planes::explain(scene, e))?,
            None => check_periodic_pairs(scene, &zones)?,
        }

        if settings.contents != ExchangeAreaContents::Direct && !zones.sheets.is_empty() {
            let text = "total exchange areas of sheets that transmit diffusely are not computed; write --direct-only, or remove transmittance";
            return Err(SceneError::new("surface.transmittance", text));
        }

        // Direct areas of all pairs.
        let matrices = matrix_count(&zones, settings.contents);
        check_memory(&zones, matrices, settings)?;
        let pair_settings = PairSettings {
            aligned_tolerance: settings.tolerance,
            plate_tolerance: settings.tolerance,
            ..PairSettings::default()
        };
        let extension = mirrored.as_ref().map(|m| (m, Transport::new(&m.extension.scene)));
        let exchange = match &extension {
            Some((m, rays)) => Exchange::with_settings(&m.extension.scene, &m.zones, rays, pair_settings),
            None => Exchange::with_settings(scene, &zones, transport, pair_settings),
        };
        let sums = ImageSums { exchange: &exchange, images: mirrored.as_ref().map(|m| &m.images) };
        let (direct, counts) = direct_areas(&sums, &zones, matrices, progress);
        check_interrupted(progress)?;
        if !direct.areas.iter().chain(&direct.closure).all(|x| x.is_finite())
            || direct.radii.iter().any(|r| r.is_nan())
        {
            let what = "an exchange area is not a finite number: lengths or extinctions are too far apart for double precision; bring them closer together";
            return Err(SceneError::new("scene", what));
        }

        // Total areas, band by band.
        let (names, name_of_zone) = zone_names(scene, &zones);
        drop(exchange);
        drop(extension);
        let mut areas =
            ExchangeAreas { zones, matrices, direct, total: None, names, name_of_zone, counts, diagnostics };
        if settings.contents == ExchangeAreaContents::DirectAndTotal {
            progress.begin("total exchange areas", matrices as u64);
            areas.total = Some(areas.total_areas(progress).ok_or_else(|| {
                let what = "nothing in a closed scene absorbs, so that total exchange areas do not exist; lower a reflectance or albedo, or compute direct areas only";
                SceneError::new("scene", what)
            })?);
            progress.end();
            check_interrupted(progress)?;
        }
        Ok(areas)
    }

    /// With one matrix for each of the first `bands` bands of a block.
    fn expanded(mut self, bands: usize) -> ExchangeAreas {
        let n = self.zone_count();
        let count = self.matrices;
        let expand = |m: &mut AreaMatrices| {
            for (list, length) in [(&mut m.areas, n * n), (&mut m.radii, n * n), (&mut m.closure, n)] {
                let one: Vec<f64> = list[..length].to_vec();
                (count..bands).for_each(|_| list.extend(&one));
                list.truncate(bands * length);
            }
        };
        expand(&mut self.direct);
        self.total.iter_mut().for_each(expand);
        self.matrices = bands;
        self
    }

    /// Adds the matrices of further bands on the same zones.
    fn append(&mut self, other: ExchangeAreas) {
        let join = |own: &mut AreaMatrices, more: AreaMatrices| {
            own.areas.extend(more.areas);
            own.radii.extend(more.radii);
            own.closure.extend(more.closure);
        };
        join(&mut self.direct, other.direct);
        if let (Some(own), Some(more)) = (&mut self.total, other.total) {
            join(own, more);
        }
        self.matrices += other.matrices;
        self.counts.merge(other.counts);
        let new = other.diagnostics.into_iter().filter(|d| !self.diagnostics.contains(d));
        let new: Vec<Diagnostic> = new.collect();
        self.diagnostics.extend(new);
    }

    /// Number of zones.
    #[must_use]
    pub fn zone_count(&self) -> usize {
        self.zones.len()
    }

    /// Sums of matrices over names: k × k numbers for each matrix, in the order of [`ExchangeAreas::names`].
    #[must_use]
    pub fn by_name(&self, matrices: &[f64]) -> Vec<f64> {
        let n = self.zone_count();
        matrices
            .chunks((n * n).max(1))
            .flat_map(|m| sum_by_group(m, &self.name_of_zone, self.names.len()))
            .collect()
    }

    /// Direct exchange area between two named parts in the first matrix and its error radius, m²; none where a name does not exist.
    #[must_use]
    pub fn direct_between(&self, from: &str, to: &str) -> Option<(f64, f64)> {
        self.between(&self.direct, from, to)
    }

    /// Total exchange area between two named parts in the first matrix and its error radius, m²; none where a name does not exist or total areas
    /// were not requested.
    #[must_use]
    pub fn total_between(&self, from: &str, to: &str) -> Option<(f64, f64)> {
        self.total.as_ref().and_then(|t| self.between(t, from, to))
    }

    fn between(&self, matrices: &AreaMatrices, from: &str, to: &str) -> Option<(f64, f64)> {
        let [from, to] = [from, to].map(|name| self.names.iter().position(|n| n == name));
        let (from, to) = (from?, to?);
        let n = self.zone_count();
        let zones_of = |name: usize| (0..n).filter(move |&i| self.name_of_zone[i] == name);
        let mut sum = (0.0, 0.0);
        for i in zones_of(from) {
            for j in zones_of(to) {
                sum = (sum.0 + matrices.areas[i * n + j], sum.1 + matrices.radii[i * n + j]);
            }
        }
        Some(sum)
    }

    /// None where nothing absorbs in some band.
    fn total_areas(&self, progress: &dyn Progress) -> Option<AreaMatrices> {
        let (n, zones) = (self.zone_count(), &self.zones);
        let capacity = || Vec::with_capacity(self.matrices * n * n);
        let mut out = AreaMatrices { areas: capacity(), radii: capacity(), closure: Vec::new() };
        for (b, band) in Band::all().enumerate().take(self.matrices) {
            let (rows, pairs) = (b * n..(b + 1) * n, b * n * n..(b + 1) * n * n);
            // ρ of a patch; the response of a volume is Ω/4.
            let reflected: Vec<f64> =
                (0..n).map(|i| zones.response(i).0[band] * fluence_factor(zones, i)).collect();
            let c = &self.direct.closure[rows];
            let t = total_exchange_areas(
                &self.direct.areas[pairs.clone()],
                &self.direct.radii[pairs],
                c,
                &reflected,
            )?;
            out.closure.extend(c.iter().zip(&reflected).map(|(c, r)| c * (1.0 - r)));
            out.areas.extend(t.areas);
            out.radii.extend(t.radii);
            progress.advance(1);
        }
        Some(out)
    }

    /// The weakest grade among the direct areas.
    #[must_use]
    pub fn grade(&self) -> Grade {
        if self.counts.all_proved() { Grade::Proved } else { Grade::Estimated }
    }
}

/// One matrix where the bands do not differ. Where they differ in reflection alone, total areas need a matrix for each band.
fn matrix_count(zones: &Zones, contents: ExchangeAreaContents) -> usize {
    let grey_extinction = (0..zones.len()).all(|i| scaled_radiosity_coefficient(zones, i).is_grey());
    let grey_reflection = (0..zones.len()).all(|i| zones.response(i).0.is_grey());
    if grey_extinction && (grey_reflection || contents == ExchangeAreaContents::Direct) {
        1
    } else {
        Band::count()
    }
}

fn check_memory(zones: &Zones, matrices: usize, settings: &ExchangeAreaSettings) -> Result<(), SceneError> {
    let n = zones.len();
    let direct_only = settings.contents == ExchangeAreaContents::Direct;
    let bytes = if direct_only {
        BYTES_PER_ENTRY * (matrices * n * n) as u64
    } else {
        (2 * BYTES_PER_ENTRY * matrices as u64 + WORK_BYTES_PER_ENTRY) * (n * n) as u64
    };
    if bytes <= settings.memory_limit {
        return Ok(());
    }
    let hint = if direct_only { "" } else { ", or leave out the total ones (--direct-only)" };
    let [needed, allowed] = [bytes, settings.memory_limit].map(|b| b as f64 / 1e9);
    let what = format!(
        "{n} zones need {needed:.3} GB for their matrices, more than the {allowed:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory){hint}"
    );
    Err(SceneError::out_of_memory("memory", what))
}

fn direct_areas(
    exchange: &ImageSums,
    zones: &Zones,
    bands: usize,
    progress: &dyn Progress,
) -> (AreaMatrices, PairCounts) {
    let n = zones.len();
    progress.begin("exchange areas", (n * n) as u64 / 2);
    let row = |i: usize| {
        let (pairs, mut counts, ci) =
            (exchange.row(i), PairCounts::default(), scaled_radiosity_coefficient(zones, i));
        let mut out = Vec::with_capacity((i + 1) * bands);
        for j in 0..=i {
            let (f, cj) =
                (exchange.pair_in_row(&pairs, j, &mut counts), scaled_radiosity_coefficient(zones, j));
            let area = |b: Band| (f.value[b] * (ci[b] * cj[b]), f.radius[b] * (ci[b] * cj[b]));
            out.extend(Band::all().take(bands).map(area));
        }
        progress.advance(i as u64 + 1);
        (out, counts)
    };
    let rows: Vec<(Vec<(f64, f64)>, PairCounts)> = parallel::collect(n, row);
    progress.end();
    let closure =
        |band: Band, i: usize| closure_target(zones, i) * scaled_radiosity_coefficient(zones, i)[band];
    let mut m = AreaMatrices {
        areas: vec![0.0; bands * n * n],
        radii: vec![0.0; bands * n * n],
        closure: Band::all().take(bands).flat_map(|b| (0..n).map(move |i| closure(b, i))).collect(),
    };
    let mut total_counts = PairCounts::default();
    for (i, (row, counts)) in rows.into_iter().enumerate() {
        total_counts.merge(counts);
        for (k, (area, radius)) in row.into_iter().enumerate() {
            let (j, b) = (k / bands, k % bands);
            for at in [(b * n + i) * n + j, (b * n + j) * n + i] {
                (m.areas[at], m.radii[at]) = (area, radius);
            }
        }
    }
    (m, total_counts)
}

/// Names of surfaces, medium and panes, and the name of each zone as an index into them.
fn zone_names(scene: &Scene, zones: &Zones) -> (Vec<String>, Vec<usize>) {
    let mut names: Vec<String> = scene.surfaces().iter().map(|s| s.name.clone()).collect();
    let mut of: Vec<usize> = zones.patches.iter().map(|p| p.surface).collect();
    if !zones.voxels.is_empty() {
        of.extend(std::iter::repeat_n(names.len(), zones.voxels.len()));
        names.push("medium".into());
    }
    of.extend(zones.panes.iter().map(|p| names.len() + p.pane));
    names.extend(scene.panes().iter().map(|p| p.name.clone()));
    (names, of)
}

/// A note on optically thick voxels: the areas are those of constant radiosity in each zone.
fn thick_voxels(scene: &Scene, zones: &Zones) -> Option<Diagnostic> {
    let thickness = zones.voxels.max_thickness(scene.voxel_grid());
    (thickness > MIN_LINEAR_BASIS_THICKNESS).then(|| {
        Diagnostic::note("thick-voxels", format!(
            "voxels are up to {thickness:.2e} optical depths across, and the areas assume constant radiosity in each zone; `solve` uses a linear basis in such voxels where it can (zone_basis), and its fluxes are then more accurate"
        ))
    })
}
