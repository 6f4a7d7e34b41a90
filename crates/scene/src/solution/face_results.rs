//! Results of a solution by face of its mesh files.
//!
//! With the patches i of a face, A = Σ A_i and, for a flux x with the error δx (net, incident, radiosity),
//!
//! ```text
//!     x = Σ A_i x_i / A        δx = Σ A_i δx_i / A        T = (Σ A_i T_i⁴ / A)^¼        δT = Σ A_i T_i³ δT_i / (A T³)
//! ```
//!
//! Errors add up as if they had one sign. They are those of the exchange, of direct light and of the solver; the error of the finite zones is known by
//! surface only ([`crate::SurfaceResult`]). The error of B = (1−ρ) w(T) + ρ H is (1−ρ) (dw/dE) δE + ρ δH, E = σT⁴. A face that exchanges on both sides
//! has the patches of both. Cost: linear in the number of patches.

use crate::bands::Bands;
use crate::solution::Solution;
use crate::solution::fields::ThermalFields;
use crate::thermal::blackbody_emissive_power;

/// Results of one face of a mesh file. A face without patches has the area 0 and no other values.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceResult {
    /// Index of the surface of its patches; none without patches.
    pub surface: Option<usize>,
    /// Area of its patches, m².
    pub area: f64,
    /// Net flux that leaves, W/m² per band, and its error; in thermal mode the total in every band.
    pub net: [Bands; 2],
    /// Incident flux, direct light included, W/m² per band, and its error.
    pub incident: [Bands; 2],
    /// Radiosity, W/m² per band, and its error.
    pub radiosity: [Bands; 2],
    /// Temperature and its error, K; none in light mode, NaN where it is undefined.
    pub temperature: Option<[f64; 2]>,
    /// Absorbed sunlight, W, which the net flux contains with a negative sign; none in scenes without sunlight.
    pub absorbed_sunlight: Option<f64>,
}

/// Sums over the patches of a face, times area.
#[derive(Clone, Copy, Default)]
struct FaceSums {
    surface: Option<usize>,
    area: f64,
    net: [Bands; 2],
    incident: [Bands; 2],
    radiosity: [Bands; 2],
    /// T⁴ and T³ δT.
    powers: [f64; 2],
    /// Absorbed sunlight, W.
    sunlight: f64,
}

impl Solution {
    /// Results of all faces of the mesh files of the scene, in the order of [`crate::FaceTable`]; by band in the first three of more bands.
    #[must_use]
    pub fn faces(&self) -> Vec<FaceResult> {
        self.faces_of(self)
    }

    /// [`Solution::faces`] of every block of bands. Areas, temperatures and sunlight are the same in all.
    #[must_use]
    pub fn faces_by_block(&self) -> Vec<Vec<FaceResult>> {
        self.blocks().map(|t| self.faces_of(t)).collect()
    }

    fn faces_of(&self, block: &Solution) -> Vec<FaceResult> {
        let table = self.scene.faces();
        let mut sums = vec![FaceSums::default(); table.len()];
        let heat = self.fields.heat.as_ref();
        for (i, p) in self.zones.patches.iter().enumerate() {
            if let Some(face) = table.face_of(p.facet) {
                block.add_patch(i, heat, &mut sums[face]);
                sums[face].sunlight += p.area * self.absorbed_sunlight(i);
            }
        }
        let is_thermal = heat.is_some();
        let has_sunlight = self.scene.bands().has_solar_band();
        sums.into_iter().map(|s| s.result(is_thermal, has_sunlight)).collect()
    }

    fn add_patch(&self, i: usize, heat: Option<&ThermalFields>, s: &mut FaceSums) {
        let (p, f) = (&self.zones.patches[i], &self.fields);
        let (area, h, dh) = (p.area, f.incident[i] + f.direct_light(i), f.total_error(i));
        let absorb = 1.0 - p.reflectance;
        let mut radiosity_error = p.reflectance * dh;
        let net = match (heat, self.scene.thermal()) {
            (Some(heat), Some(thermal)) => {
                let (t, dt) = (heat.temperature[i], heat.temperature_error[i]);
                let e = blackbody_emissive_power(t);
                // dE = 4 E dT/T; a prescribed temperature has no error.
                let de = if dt > 0.0 { 4.0 * e * dt / t } else { 0.0 };
                if de > 0.0 {
                    radiosity_error += absorb * thermal.band_fractions.emissive_powers(e)[1].abs() * de;
                }
                s.powers[0] += area * t.powi(4);
                s.powers[1] += area * t.powi(3) * if dt.is_nan() { 0.0 } else { dt };
                [heat.net[i], heat.net_error[i]].map(Bands::splat)
            }
            _ => [self.emitted_flux(i) - absorb * h, absorb * dh],
        };
        s.surface = Some(p.surface);
        s.area += area;
        let add =
            |sum: &mut [Bands; 2], x: [Bands; 2]| [0, 1].into_iter().for_each(|k| sum[k] += area * x[k]);
        add(&mut s.net, net);
        add(&mut s.incident, [h, dh]);
        add(&mut s.radiosity, [f.radiosity[i], radiosity_error]);
    }

    /// Sunlight that patch `i` absorbs, W/m²: (1 − ρ) (H + direct light) in the band of sunlight; 0 without one.
    fn absorbed_sunlight(&self, i: usize) -> f64 {
        let of_block = |(t, s): (usize, &Solution)| {
            let own = self.scene.bands().in_solar_band(t, 1.0);
            let incident = s.fields.incident[i] + s.fields.direct_light(i);
            (own * (1.0 - s.zones.patches[i].reflectance) * incident).sum()
        };
        self.blocks().enumerate().map(of_block).sum()
    }

    /// Flux that patch `i` emits in light mode, W/m²; that of a direct emitter is taken at the centre of the patch.
    pub(crate) fn emitted_flux(&self, i: usize) -> Bands {
        let p = &self.zones.patches[i];
        if !self.scene.is_direct_emitter(p.surface) {
            return p.emission;
        }
        let [u, v] = self.scene.facets()[p.facet].plate.parameters(p.plate.centre());
        self.scene.emission_at(p.facet, u, v)
    }
}

impl FaceSums {
    fn result(self, is_thermal: bool, has_sunlight: bool) -> FaceResult {
        let mean = |x: [Bands; 2]| if self.area > 0.0 { x.map(|x| x / self.area) } else { [Bands::ZERO; 2] };
        let kelvin = || {
            let t = (self.powers[0] / self.area).sqrt().sqrt();
            [t, self.powers[1] / (self.area * t.powi(3))]
        };
        FaceResult {
            surface: self.surface,
            area: self.area,
            net: mean(self.net),
            incident: mean(self.incident),
            radiosity: mean(self.radiosity),
            temperature: is_thermal.then(kelvin),
            absorbed_sunlight: has_sunlight.then_some(self.sunlight),
        }
    }
}
