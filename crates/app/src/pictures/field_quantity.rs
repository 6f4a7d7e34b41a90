//! Quantities of pictures in false colours, and planes through the medium.

use zonal_io::output::ColourMap;
use zonal_render::PaneVisibility;
use zonal_report::Failure;
use zonal_scene::{Bands, Fields, Solution};

/// Difference of values, relative to the largest temperature or radiosity, that is rounding.
const RELATIVE_ROUNDING: f64 = 1e-7;
/// Quantity of a picture in false colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum FieldQuantity {
    /// Temperature, K, of surfaces and panes (thermal mode).
    Temperature,
    /// Net radiative flux, W/m2, positive where heat leaves, of surfaces and panes (thermal mode).
    NetFlux,
    /// Radiosity B, W/m2, direct light included, of surfaces: mean over the bands; in thermal mode their sum.
    Radiosity,
    /// Irradiance H, W/m2, direct light included, of surfaces: mean over the bands; in thermal mode their sum.
    Irradiance,
}

impl FieldQuantity {
    /// The names in options, in the order of [`FieldQuantity::VARIANTS`].
    pub const NAMES: [&str; 4] = ["temperature", "net-flux", "radiosity", "irradiance"];
    /// All quantities.
    pub const VARIANTS: [FieldQuantity; 4] = [
        FieldQuantity::Temperature,
        FieldQuantity::NetFlux,
        FieldQuantity::Radiosity,
        FieldQuantity::Irradiance,
    ];

    /// The name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        FieldQuantity::NAMES[self as usize]
    }
    pub(super) fn title(self) -> &'static str {
        ["Temperature", "Net flux", "Radiosity", "Irradiance"][self as usize]
    }
    /// The unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        if self == FieldQuantity::Temperature { "K" } else { "W/m2" }
    }
    /// True for quantities of thermal mode alone.
    pub(super) fn is_thermal(self) -> bool {
        matches!(self, FieldQuantity::Temperature | FieldQuantity::NetFlux)
    }
    pub(super) fn colour_map(self) -> ColourMap {
        if self == FieldQuantity::NetFlux { ColourMap::Diverging } else { ColourMap::Sequential }
    }

    /// Whether panes have the quantity, or are looked through.
    pub(super) fn pane_visibility(self) -> PaneVisibility {
        if self.is_thermal() { PaneVisibility::Opaque } else { PaneVisibility::Transparent }
    }

    /// The value of every zone; `None` if the mode of the solution lacks the quantity.
    pub(super) fn values(self, s: &Solution) -> Option<FieldValues> {
        let (f, heat) = (&s.fields, s.fields.heat.as_ref());
        let largest =
            |list: &[f64]| list.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
        // The sum over the bands in thermal mode, the mean in light mode as in the viewer.
        let is_rgb = s.scene.bands().is_rgb();
        let scalar = |i: usize, of: fn(&Fields, usize) -> Bands| {
            if is_rgb {
                let v = of(f, i);
                return s.scene.thermal().map_or(v.mean(), |t| t.band_fractions.total(v));
            }
            let all = s.all_bands(|t| of(&t.fields, i));
            let sum: f64 = all.iter().sum();
            if s.scene.thermal().is_some() { sum } else { sum / all.len() as f64 }
        };
        let zones = 0..s.zones.len();
        let radiosity = || zones.clone().map(|i| scalar(i, |f, i| f.radiosity[i])).collect::<Vec<f64>>();
        let values = match self {
            FieldQuantity::Temperature => heat?.temperature.clone(),
            FieldQuantity::NetFlux => {
                // W/m³ of a pane times its thickness.
                let mut net = heat?.net.clone();
                let panes = net[s.zones.pane_offset()..].iter_mut();
                panes.zip(&s.zones.panes).for_each(|(q, z)| *q *= z.thickness);
                net
            }
            FieldQuantity::Radiosity => radiosity(),
            FieldQuantity::Irradiance => {
                let [indirect, direct]: [fn(&Fields, usize) -> Bands; 2] =
                    [|f, i| f.incident[i], |f, i| f.direct_light(i)];
                zones.clone().map(|i| scalar(i, indirect) + scalar(i, direct)).collect()
            }
        };
        let scale = if self == FieldQuantity::NetFlux { largest(&radiosity()) } else { largest(&values) };
        Some(FieldValues { values, rounding: RELATIVE_ROUNDING * scale })
    }
}

/// Values of a quantity.
pub(super) struct FieldValues {
    /// The value of every zone.
    pub(super) values: Vec<f64>,
    /// Difference of values that is rounding.
    pub(super) rounding: f64,
}

/// A plane through the medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumSlice {
    /// Axis across the plane, 0 to 2.
    pub(super) axis: usize,
    /// Coordinate, m.
    pub(super) coordinate: f64,
    /// The plane in the file of the picture, `AXIS=METRES`.
    pub(super) text: String,
}

impl MediumSlice {
    /// The plane at a coordinate, m, across axis 0, 1 or 2.
    #[must_use]
    pub fn new(axis: usize, coordinate: f64) -> MediumSlice {
        MediumSlice { axis, coordinate, text: format!("{}={coordinate:?}", AXES[axis]) }
    }

    /// The plane of `AXIS=METRES`.
    ///
    /// # Errors
    /// For other text.
    pub fn parse(text: &str) -> Result<MediumSlice, Failure> {
        let read = || {
            let (axis, coordinate) = text.split_once('=')?;
            let axis = AXES.iter().position(|a| *a == axis.trim())?;
            Some((axis, coordinate.trim().parse::<f64>().ok().filter(|x| x.is_finite())?))
        };
        let (axis, coordinate) = read().ok_or_else(|| {
            Failure::new(format!("--slice: '{text}' is not AXIS=METRES; write for example z=1.0"))
        })?;
        Ok(MediumSlice { axis, coordinate, text: text.to_string() })
    }

    /// Refuses a plane outside of the medium.
    pub(super) fn check(&self, s: &Solution) -> Result<(), Failure> {
        let Some(grid) = s.scene.voxel_grid() else {
            return Err(Failure::new("--slice: the scene has no medium to cut; leave it out"));
        };
        let (axis, coordinate) = (self.axis, self.coordinate);
        let (low, high) = (grid.min()[axis], grid.max()[axis]);
        if !(low..=high).contains(&coordinate) {
            let axis = AXES[axis];
            let reason = format!(
                "{axis}={coordinate} does not cut the medium, which is from {axis}={low} to {axis}={high}"
            );
            return Err(Failure::new(format!("--slice: {reason}")));
        }
        Ok(())
    }
}

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];
