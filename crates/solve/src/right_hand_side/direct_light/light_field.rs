//! Direct light of every light of a scene on all zones, with errors and with the power that the light sends in and loses.

use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_scene::{Bands, Diagnostic};

/// Direct light of one light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightField {
    /// Name of a sun or a sky, or of the surface of an emitter.
    pub name: String,
    /// H_dir of patches and G_dir of volume zones, W/m², one entry per zone.
    pub fields: Vec<Bands>,
    /// Standard error of `fields`, W/m², one entry per zone; independent from zone to zone unless `by_exchange`.
    pub error: Vec<Bands>,
    /// Relative error of `fields` that all zones have in common.
    pub common_error: Bands,
    /// True if the fields come from exchange areas, false if they come from shadow rays.
    pub by_exchange: bool,
    /// Power P incident on the higher-order unknowns, W ([`crate::ExchangeOperator::slope_zones`]); empty for none.
    pub slope_power: Vec<Bands>,
    /// Number of shadow rays.
    pub rays: u64,
    /// Power that a sun or a sky sends in, W per band.
    pub incoming: Bands,
    /// Power that a surface emits, W per band.
    pub emitted: Bands,
    /// Power that leaves the scene unscattered, W per band.
    pub escaped: Bands,
    /// Power on black backs, W per band.
    pub absorbed_backfaces: Bands,
    /// Standard errors of the power sent in or emitted, of `escaped`, and of `absorbed_backfaces`, W per band.
    pub power_error: [Bands; 3],
    /// Largest relative change of the fields by normalization to the measured power; 0 without.
    pub largest_change: f64,
    /// Diagnostic text: fields and power disagree too much for normalization, or the sampling error exceeds the tolerance.
    pub warning: Option<String>,
}

impl LightField {
    /// Error of the field of zone `i`, W/m²: its own and its part of the common one.
    pub fn error_of(&self, i: usize) -> Bands {
        let own = self.error.get(i).copied().unwrap_or_default();
        let field = self.fields.get(i).copied().unwrap_or_default();
        own + self.common_error * field.abs()
    }

    /// The same with all powers times `factor`.
    pub(crate) fn with_powers_times(self, factor: f64) -> LightField {
        LightField {
            incoming: self.incoming * factor,
            emitted: self.emitted * factor,
            escaped: self.escaped * factor,
            absorbed_backfaces: self.absorbed_backfaces * factor,
            power_error: self.power_error.map(|e| e * factor),
            ..self
        }
    }

    /// Encodes a light field from shadow rays as a stage.
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut encoder = Encoder::default();
        encoder.text(&self.name);
        encoder.bands(&self.fields);
        encoder.bands(&self.error);
        encoder.int(self.rays as usize);
        let [sent, escaped, backs] = self.power_error;
        encoder.bands(&[
            self.incoming,
            self.emitted,
            self.escaped,
            self.absorbed_backfaces,
            // The stage holds this number in the place of the first band.
            Bands::from_rgb([self.largest_change, 0.0, 0.0]),
            self.common_error,
            sent,
            escaped,
            backs,
        ]);
        encoder.text(self.warning.as_deref().unwrap_or(""));
        encoder.bytes()
    }

    /// Decodes a stage of [`LightField::encode`] for `zones` zones.
    pub(crate) fn decode(bytes: &[u8], zones: usize) -> Option<LightField> {
        let mut decoder = Decoder::new(bytes);
        let (name, fields, error) = (decoder.text()?, decoder.bands()?, decoder.bands()?);
        let rays = decoder.int()? as u64;
        let (powers, warning) = (decoder.bands()?, decoder.text()?);
        let [incoming, emitted, escaped, backs, largest_change, common_error, e0, e1, e2] = powers[..] else {
            return None;
        };
        let warning = (!warning.is_empty()).then_some(warning);
        let complete = decoder.at_end() && fields.len() == zones && error.len() == zones;
        complete.then_some(LightField {
            name,
            fields,
            error,
            common_error,
            rays,
            incoming,
            emitted,
            escaped,
            absorbed_backfaces: backs,
            power_error: [e0, e1, e2],
            largest_change: largest_change.first(),
            warning,
            ..LightField::default()
        })
    }
}

/// Direct light of all lights of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirectLight {
    /// The light fields, in the order of `scene.lights()`.
    pub lights: Vec<LightField>,
}

impl DirectLight {
    /// Sum of the fields of all lights over `zones` zones, W/m², in the order of the lights.
    pub fn fields(&self, zones: usize) -> Vec<Bands> {
        let mut out = vec![Bands::ZERO; zones];
        for light in &self.lights {
            out.iter_mut().zip(&light.fields).for_each(|(o, f)| *o += f);
        }
        out
    }
    /// Power that emitters send, W per band.
    pub(crate) fn emitted_power(&self) -> Bands {
        self.lights.iter().map(|l| l.emitted).sum()
    }
    /// Largest relative change of the fields of any light by normalization.
    pub(crate) fn largest_change(&self) -> f64 {
        self.lights.iter().fold(0.0, |m, l| m.max(l.largest_change))
    }
    /// Diagnostics of the lights.
    pub(crate) fn warnings(&self) -> impl Iterator<Item = Diagnostic> {
        let texts = self.lights.iter().filter_map(|l| l.warning.as_ref());
        texts.map(|text| Diagnostic::warning("light-power", text.as_str()))
    }
}
