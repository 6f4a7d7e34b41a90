//! Minimum errors: differences of two solves that pass through zero hide errors, so an error is at least a share of the mean relative error of its
//! kind.

use super::difference_error::DifferenceError;
use zonal_scene::{Bands, EnergyBalance, HeatRow, Report};

/// Minimum error over the mean relative error of its kind.
const MIN_SHARE_OF_MEAN: f64 = 0.3;

/// Minimum relative errors of temperatures, net powers and powers of light.
pub(super) struct ErrorFloor {
    temperature: f64,
    power: f64,
    energy: Bands,
}

impl ErrorFloor {
    /// From the reports of two solves; `error` is the error of two values of a quantity.
    pub(super) fn new(own: &Report, other: &Report, error: &DifferenceError) -> ErrorFloor {
        let rows = || own.heat.iter().zip(&other.heat).flat_map(|(a, b)| a.rows.iter().zip(&b.rows));
        let share = |error: f64, all: f64| if all > 0.0 { MIN_SHARE_OF_MEAN * error / all } else { 0.0 };
        let sum = |of: &dyn Fn(&HeatRow) -> f64, error: &dyn Fn(f64, f64) -> f64| {
            let terms = rows().map(|(a, b)| (error(of(a), of(b)), of(a).abs()));
            let (error, all) = terms.filter(|x| x.0 > 0.0).fold((0.0, 0.0), |s, x| (s.0 + x.0, s.1 + x.1));
            share(error, all)
        };
        let (a, b) = (&own.energy, &other.energy);
        let surfaces = a.absorbed_surfaces.iter().zip(&b.absorbed_surfaces).map(|(x, y)| (x.1, y.1));
        let rest = [(a.absorbed_volumes, b.absorbed_volumes), (a.absorbed_panes, b.absorbed_panes)];
        let all: Vec<_> = surfaces.chain(rest).collect();
        let energy = Bands::from_fn(|k| {
            share(
                all.iter().map(|x| error.of_powers(x.0[k], x.1[k])).sum(),
                all.iter().map(|x| x.0[k].abs()).sum(),
            )
        });
        let temperature = sum(&|row| row.temperature.unwrap_or(0.0), &|a, b| error.of_temperatures(a, b));
        let power = sum(&|row| row.power, &|a, b| error.of_powers(a, b));
        ErrorFloor { temperature, power, energy }
    }

    /// Raises the error of a temperature, K; an error of exactly 0 stays.
    pub(super) fn temperature(&self, value: f64, error: f64) -> f64 {
        if error > 0.0 { error.max(self.temperature * value.abs()) } else { error }
    }

    /// Raises the error of a power, W.
    pub(super) fn power(&self, value: f64, error: f64) -> f64 {
        if error > 0.0 { error.max(self.power * value.abs()) } else { error }
    }

    /// Raises the errors of powers of light.
    pub(super) fn widen(&self, errors: &mut EnergyBalance, values: &EnergyBalance) {
        let widen = |e: &mut Bands, x: Bands| {
            *e = e.zip_map(self.energy * x.abs(), |e, floor| if e > 0.0 { e.max(floor) } else { e });
        };
        errors
            .absorbed_surfaces
            .iter_mut()
            .zip(&values.absorbed_surfaces)
            .for_each(|(e, x)| widen(&mut e.1, x.1));
        widen(&mut errors.absorbed_volumes, values.absorbed_volumes);
        widen(&mut errors.absorbed_panes, values.absorbed_panes);
        widen(&mut errors.escaped, values.escaped);
        widen(&mut errors.absorbed_backfaces, values.absorbed_backfaces);
    }
}
