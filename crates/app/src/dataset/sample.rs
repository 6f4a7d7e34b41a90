//! One sample of a data set: the numbers of a solution that a data set keeps, and their arrays over all samples.

use zonal_scene::{Bands, EnergyBalance, HeatReport, HeatRow, Solution, SolveStatus, ThermalFields, Zones};

/// How a sample ended, as the number in the array `status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SampleStatus {
    /// All iterations converged.
    Converged = 0,
    /// An iteration ended early; the errors contain the effect.
    NotConverged = 1,
    /// The scene or the solve was refused; all results are NaN.
    Refused = 2,
}

impl SampleStatus {
    /// The status of a number in the array.
    pub(super) fn of(number: f64) -> SampleStatus {
        [SampleStatus::Converged, SampleStatus::NotConverged]
            .into_iter()
            .find(|s| *s as u8 as f64 == number)
            .unwrap_or(SampleStatus::Refused)
    }
}

/// Name and shape of an array of one sample, and its unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ArrayLayout {
    /// Name.
    pub(super) name: &'static str,
    /// Shape.
    pub(super) shape: Vec<usize>,
    /// Unit.
    pub(super) unit: &'static str,
}

/// The numbers of one sample.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sample {
    /// How it ended.
    pub(super) status: SampleStatus,
    /// Power that the balance misses over the power exchanged.
    pub(super) energy_residual: f64,
    /// The arrays, one after the other; empty if the sample was refused.
    pub(super) numbers: Vec<f64>,
}

/// What all samples have in common.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    /// The arrays of a sample.
    pub(super) arrays: Vec<ArrayLayout>,
    /// Names of the rows of arrays by name.
    pub(super) names: Vec<String>,
}

impl Sample {
    /// A sample without results.
    pub(super) fn refused() -> Sample {
        Sample { status: SampleStatus::Refused, energy_residual: f64::NAN, numbers: Vec::new() }
    }

    /// The sample of a solution, with its layout.
    pub(super) fn of(solution: &Solution) -> (Sample, Layout) {
        let mut own = SampleArrays::default();
        let names = match (&solution.fields.heat, &solution.report.heat) {
            (Some(heat), Some(report)) => own.add_thermal(solution, heat, report),
            _ => own.add_light(solution),
        };
        let converged =
            solution.blocks().all(|s| s.report.status.iter().all(|x| *x == SolveStatus::Converged));
        let status = if converged { SampleStatus::Converged } else { SampleStatus::NotConverged };
        let SampleArrays { arrays, numbers } = own;
        (Sample { status, energy_residual: energy_residual(solution), numbers }, Layout { arrays, names })
    }
}

/// The arrays of one sample.
#[derive(Default)]
struct SampleArrays {
    arrays: Vec<ArrayLayout>,
    /// Their numbers, one array after the other.
    numbers: Vec<f64>,
}

impl SampleArrays {
    fn add(&mut self, name: &'static str, shape: Vec<usize>, unit: &'static str, values: Vec<f64>) {
        self.arrays.push(ArrayLayout { name, shape, unit });
        self.numbers.extend(values);
    }

    /// Adds the temperatures and net powers of a thermal solution; returns the names of the rows.
    fn add_thermal(&mut self, solution: &Solution, heat: &ThermalFields, report: &HeatReport) -> Vec<String> {
        let n = solution.zones.len();
        self.add("temperature", vec![n], "K", heat.temperature.clone());
        self.add("temperature_error", vec![n], "K", heat.temperature_error.clone());
        self.add("net_flux", vec![n], "W/m2 of surfaces, W/m3 of volumes", heat.net.clone());
        self.add("net_flux_error", vec![n], "W/m2, W/m3", heat.net_error.clone());
        let rows = &report.rows;
        let of = |f: &dyn Fn(&HeatRow) -> f64| rows.iter().map(f).collect::<Vec<_>>();
        self.add("named_power", vec![rows.len()], "W", of(&|r| r.power));
        self.add("named_power_exchange_error", vec![rows.len()], "W", of(&|r| r.power_error));
        let kelvin = |t: Option<f64>| t.unwrap_or(f64::NAN);
        self.add("named_temperature", vec![rows.len()], "K", of(&|r| kelvin(r.temperature)));
        let exchange = of(&|r| kelvin(r.temperature_error));
        self.add("named_temperature_exchange_error", vec![rows.len()], "K", exchange);
        if solution.scene.options().discretization_error == Some(true) {
            // Unknown errors are infinite.
            let errors = solution.report.discretization_error.as_ref().map(|d| &d.heat);
            let of = |r: usize| errors.and_then(|e| e.get(r)).copied().unwrap_or([f64::INFINITY; 2]);
            let column = |k: usize| (0..rows.len()).map(|r| of(r)[k]).collect::<Vec<_>>();
            let whole = |k: usize| (0..rows.len()).map(|r| rows[r].errors(Some(of(r)))[k]).collect();
            self.add("named_temperature_discretization_error", vec![rows.len()], "K", column(0));
            self.add("named_power_discretization_error", vec![rows.len()], "W", column(1));
            self.add("named_temperature_error", vec![rows.len()], "K", whole(0));
            self.add("named_power_error", vec![rows.len()], "W", whole(2));
        }
        rows.iter().map(|r| r.name.clone()).collect()
    }

    /// Adds the radiosities and absorbed powers of a solution in light mode; returns the names of the rows.
    fn add_light(&mut self, solution: &Solution) -> Vec<String> {
        let (n, bands) = (solution.zones.len(), solution.scene.bands().count());
        let of = |count: usize, value: &dyn Fn(&Solution, usize) -> Bands| {
            (0..count).flat_map(|i| solution.all_bands(|s| value(s, i))).collect::<Vec<_>>()
        };
        let incident = |s: &Solution, i: usize| s.fields.incident[i] + s.fields.direct_light(i);
        let shape = || vec![n, bands];
        self.add("radiosity", shape(), "W/m2", of(n, &|s, i| s.fields.radiosity[i]));
        self.add("incident", shape(), "W/m2", of(n, &incident));
        self.add("incident_error", shape(), "W/m2", of(n, &|s, i| s.fields.total_error(i)));
        let named = absorbed_powers(&solution.report.energy);
        let rows = named.len();
        let absorbed = of(rows, &|s, r| absorbed_powers(&s.report.energy)[r].1);
        self.add("absorbed_power", vec![rows, bands], "W", absorbed);
        let exchange = |s: &Solution, r: usize| power_error(&s.report.energy_error, r, rows);
        self.add("absorbed_power_exchange_error", vec![rows, bands], "W", of(rows, &exchange));
        if solution.scene.options().discretization_error == Some(true) {
            let error = |s: &Solution, r: usize| {
                let errors = s.report.discretization_error.as_ref();
                errors.map_or(UNKNOWN_ERROR, |d| power_error(&d.energy, r, rows))
            };
            let whole = |s: &Solution, r: usize| error(s, r) + exchange(s, r);
            self.add("absorbed_power_discretization_error", vec![rows, bands], "W", of(rows, &error));
            self.add("absorbed_power_error", vec![rows, bands], "W", of(rows, &whole));
        }
        named.into_iter().map(|(name, _)| name.to_string()).collect()
    }
}

/// An error that is not known.
const UNKNOWN_ERROR: Bands = Bands::splat(f64::INFINITY);

/// The error of absorbed power number `row` of `rows`, W; errors that a report lacks are unknown.
fn power_error(errors: &EnergyBalance, row: usize, rows: usize) -> Bands {
    let errors = absorbed_powers(errors);
    if errors.len() == rows { errors[row].1 } else { UNKNOWN_ERROR }
}

/// Absorbed powers by name: the surfaces, the medium and the panes, W.
fn absorbed_powers(energy: &EnergyBalance) -> Vec<(&str, Bands)> {
    let surfaces = energy.absorbed_surfaces.iter().map(|(name, power)| (name.as_str(), *power));
    surfaces.chain([("medium", energy.absorbed_volumes), ("panes", energy.absorbed_panes)]).collect()
}

/// The power that the balance of a solution misses, over the power exchanged.
fn energy_residual(solution: &Solution) -> f64 {
    let Some(heat) = &solution.report.heat else {
        let residuals = solution.blocks().flat_map(|s| s.report.energy.residual);
        return residuals.fold(0.0, |m, r| if r.abs() <= m { m } else { r.abs() });
    };
    let outside = [heat.surroundings, heat.emitters, -heat.absorbed_backfaces];
    let powers = heat.rows.iter().map(|r| r.power).chain(outside);
    let exchanged = 0.5 * powers.map(f64::abs).sum::<f64>();
    if exchanged > 0.0 { heat.balance().abs() / exchanged } else { 0.0 }
}

/// Centres (m) of all zones, one after the other, and their sizes, m² of patches, m³ of volumes.
pub(super) fn zone_geometry(zones: &Zones) -> [Vec<f64>; 2] {
    let patches = zones.patches.iter().map(|p| p.plate.centre());
    let voxels = zones.voxels.iter().map(|v| v.centre);
    let panes = zones.panes.iter().map(|p| p.plate.centre());
    let centres = patches.chain(voxels).chain(panes).flat_map(|c| [c.x, c.y, c.z]).collect();
    [centres, (0..zones.len()).map(|i| zones.response(i).1).collect()]
}
