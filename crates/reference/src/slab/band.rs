//! One band of a slab: sweeps along the ordinates, scattering and reflection, fluxes.
//!
//! Elements are the layers from x = 0 on, then the wall at x = 0 and the wall at the other end.

use super::linear;
use super::ordinates::{Ordinate, half_range};
use std::f64::consts::PI;

/// Properties of one band.
#[derive(Clone, Debug, PartialEq)]
pub struct SlabBand {
    /// Extinction coefficients β of the layers, 1/m, 0 or more.
    pub extinction: Vec<f64>,
    /// Albedos ω of the layers, 0 to 1.
    pub albedo: Vec<f64>,
    /// Emissivities ε of the walls, 0 to 1.
    pub wall_emissivity: [f64; 2],
}

/// Black-body emission of one band, a σT⁴, W/m². A wall emits ε times as much, a layer 4(1−ω)β times as much in a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct BandEmission {
    /// Of the layers.
    pub layers: Vec<f64>,
    /// Of the walls.
    pub walls: [f64; 2],
}

/// Solution of one band.
#[derive(Clone, Debug, PartialEq)]
pub struct BandSolution {
    /// Net flux q in the direction of x at the layer boundaries, W/m².
    pub flux: Vec<f64>,
    /// Mean incident radiation G of the layers, the integral of the intensity over all directions, W/m².
    pub incident: Vec<f64>,
    /// Source Q = −dq/dx of the layers, W/m³.
    pub source: Vec<f64>,
    /// Irradiance H of the walls, W/m².
    pub wall_incident: [f64; 2],
}

/// Result of a sweep: mean intensities J of the layers and H/π of the walls by element, and net fluxes at the layer boundaries.
struct Sweep {
    elements: Vec<f64>,
    flux: Vec<f64>,
}

/// The optical path of each layer along an ordinate.
struct Path {
    /// (1 − e^−t)/t by layer.
    mean: Vec<f64>,
    /// 1 − e^−t by layer.
    absorbed: Vec<f64>,
    ordinate: Ordinate,
}

/// A band with the optical paths of its ordinates.
pub(super) struct BandSweeper<'a> {
    band: &'a SlabBand,
    thickness: &'a [f64],
    paths: Vec<Path>,
}

impl SlabBand {
    /// The solution for layers of these thicknesses, m.
    pub(super) fn solve(&self, thickness: &[f64], emission: &BandEmission) -> BandSolution {
        assert_eq!(emission.layers.len(), thickness.len(), "one emission a layer");
        let sweeper = BandSweeper::new(self, thickness);
        let own: Vec<f64> = emission.layers.iter().chain(&emission.walls).map(|e| e / PI).collect();
        let returned = self.returned();
        let mut source: Vec<f64> = own.iter().zip(&returned).map(|(e, w)| (1.0 - w) * e).collect();
        if returned.iter().any(|w| *w > 0.0) {
            let arriving = sweeper.arriving();
            for (i, s) in source.iter_mut().enumerate() {
                *s += returned[i] * arriving[i].iter().zip(&own).map(|(x, e)| x * e).sum::<f64>();
            }
        }
        let Sweep { elements, flux } = sweeper.sweep(&source);
        let n = thickness.len();
        let net = |i: usize| 4.0 * PI * self.extinction[i] * (1.0 - returned[i]) * (elements[i] - own[i]);
        BandSolution {
            flux,
            incident: elements[..n].iter().map(|j| 4.0 * PI * j).collect(),
            source: (0..n).map(net).collect(),
            wall_incident: [PI * elements[n], PI * elements[n + 1]],
        }
    }

    /// Fraction of the arriving radiation that each element returns: albedo or reflectance.
    fn returned(&self) -> Vec<f64> {
        self.albedo.iter().copied().chain(self.wall_emissivity.map(|e| 1.0 - e)).collect()
    }
}

impl<'a> BandSweeper<'a> {
    pub(super) fn new(band: &'a SlabBand, thickness: &'a [f64]) -> BandSweeper<'a> {
        assert_eq!(band.extinction.len(), thickness.len(), "one extinction a layer");
        assert_eq!(band.albedo.len(), thickness.len(), "one albedo a layer");
        let path = |ordinate: Ordinate| {
            let depths = band.extinction.iter().zip(thickness).map(|(k, d)| k * d / ordinate.cosine);
            let absorbed: Vec<f64> = depths.clone().map(|t| -(-t).exp_m1()).collect();
            let mean = depths.zip(&absorbed).map(|(t, a)| if t > 0.0 { a / t } else { 1.0 }).collect();
            Path { mean, absorbed, ordinate }
        };
        BandSweeper { band, thickness, paths: half_range().into_iter().map(path).collect() }
    }

    /// One sweep in both directions, with intensities S as sources of the layers and of the walls.
    fn sweep(&self, source: &[f64]) -> Sweep {
        let n = self.thickness.len();
        let mut out = Sweep { elements: vec![0.0; n + 2], flux: vec![0.0; n + 1] };
        for path in &self.paths {
            let Ordinate { cosine, weight } = path.ordinate;
            let [mean_weight, flux_weight] = [0.5 * weight, 2.0 * PI * weight * cosine];
            let mut step = |intensity: &mut f64, i: usize| {
                let excess = *intensity - source[i];
                out.elements[i] += mean_weight * (source[i] + excess * path.mean[i]);
                *intensity -= excess * path.absorbed[i];
            };
            let mut intensity = source[n];
            out.flux[0] += flux_weight * intensity;
            for i in 0..n {
                step(&mut intensity, i);
                out.flux[i + 1] += flux_weight * intensity;
            }
            let end = intensity;
            let mut intensity = source[n + 1];
            out.flux[n] -= flux_weight * intensity;
            for i in (0..n).rev() {
                step(&mut intensity, i);
                out.flux[i] -= flux_weight * intensity;
            }
            out.elements[n] += flux_weight / PI * intensity;
            out.elements[n + 1] += flux_weight / PI * end;
        }
        out
    }

    /// J and H/π of each element (row) for a unit of e/π in each element (column), with scattering and reflection: X = R (1−W) + R W X.
    fn arriving(&self) -> Vec<Vec<f64>> {
        let n = self.thickness.len() + 2;
        let returned = self.band.returned();
        let column = |j: usize| {
            let mut source = vec![0.0; n];
            source[j] = 1.0;
            self.sweep(&source).elements
        };
        let columns: Vec<Vec<f64>> = (0..n).map(column).collect();
        let entry = |f: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
            (0..n).map(|i| (0..n).map(|j| f(i, j)).collect()).collect()
        };
        let matrix = entry(&|i, j| f64::from(u8::from(i == j)) - columns[j][i] * returned[j]);
        let right = entry(&|i, j| columns[j][i] * (1.0 - returned[j]));
        linear::solve(matrix, right).expect("a layer or a wall absorbs, or the slab is open")
    }

    /// Net power of each element (row) for a unit of emission, W/m², in each element (column): by volume in layers, by area on walls.
    pub(super) fn net_power(&self) -> Vec<Vec<f64>> {
        let returned = self.band.returned();
        let mut rows = self.arriving();
        for (i, row) in rows.iter_mut().enumerate() {
            let scale = self.band.extinction.get(i).map_or(1.0, |k| 4.0 * k) * (1.0 - returned[i]);
            row.iter_mut().for_each(|x| *x *= -scale);
            row[i] += scale;
        }
        rows
    }
}
