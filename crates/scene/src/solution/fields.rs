//! Fields of a solution: one array a quantity over all zones, in the order of [`crate::Zones`].

use crate::bands::Bands;

/// Radiative quantities of all zones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// Radiosity B, W/m², direct light included.
    pub radiosity: Vec<Bands>,
    /// Irradiance H of patches, fluence G of volume zones, W/m², **without** direct light.
    pub incident: Vec<Bands>,
    /// H_dir of patches, G_dir of volume zones, W/m²: direct light only. Empty without direct light.
    pub direct: Vec<Bands>,
    /// Estimated error of `incident`, W/m², including the part caused by the error of `direct`.
    pub error: Vec<Bands>,
    /// Estimated error of `direct`, W/m²: of shadow rays, or of the exchange areas used. Empty without direct light.
    pub direct_error: Vec<Bands>,
    /// The part of `error` due to the surroundings, W/m²; the other part adds as √(other² + part²). Empty for black surroundings.
    pub surroundings_error: Vec<Bands>,
    /// Temperatures and net powers; `None` in light mode.
    pub heat: Option<ThermalFields>,
}

/// One of the lists of bands over all zones, by which files, tables and other programs go through the fields.
#[derive(Clone, Copy)]
pub struct FieldList {
    /// Its name in files and in the Python package.
    pub name: &'static str,
    /// True for an estimated error, which is infinite where it is unknown.
    pub is_error: bool,
    /// True if the list has no rows in files of scenes without the quantity; other lists have zeros there.
    pub is_optional: bool,
    /// True if tables of zones (.csv, .vtu, .vti) have columns of it.
    pub is_in_tables: bool,
    /// The list of some fields.
    pub of: fn(&Fields) -> &Vec<Bands>,
    /// The list of some fields, to change.
    pub of_mut: fn(&mut Fields) -> &mut Vec<Bands>,
}

/// A [`FieldList`] by the name of its field.
macro_rules! list {
    ($name:ident, error $is_error:literal, optional $is_optional:literal, in tables $is_in_tables:literal) => {
        FieldList {
            name: stringify!($name),
            is_error: $is_error,
            is_optional: $is_optional,
            is_in_tables: $is_in_tables,
            of: |f| &f.$name,
            of_mut: |f| &mut f.$name,
        }
    };
}

impl Fields {
    /// All lists of bands, in the order of files.
    pub const LISTS: [FieldList; 6] = [
        list!(radiosity, error false, optional false, in tables true),
        list!(incident, error false, optional false, in tables true),
        list!(direct, error false, optional false, in tables true),
        list!(error, error true, optional false, in tables true),
        list!(direct_error, error true, optional true, in tables true),
        list!(surroundings_error, error true, optional true, in tables false),
    ];

    /// The lists of tables of zones, in the order of their columns.
    pub fn in_tables() -> impl Iterator<Item = FieldList> {
        Fields::LISTS.into_iter().filter(|list| list.is_in_tables)
    }
    /// The field `direct` from the direct light of all zones: empty where there is none.
    #[must_use]
    pub fn direct_unless_zero(all: Vec<Bands>) -> Vec<Bands> {
        if all.iter().all(|b| *b == Bands::ZERO) { Vec::new() } else { all }
    }
    /// The radiative fields, each list over the zones replaced by `f` of it.
    #[must_use]
    pub fn map_lists(&self, f: impl Fn(&[Bands]) -> Vec<Bands>) -> Fields {
        let mut out = Fields::default();
        Fields::LISTS.iter().for_each(|list| *(list.of_mut)(&mut out) = f((list.of)(self)));
        out
    }
    /// Direct light of zone `i`, W/m²; 0 without.
    pub fn direct_light(&self, i: usize) -> Bands {
        self.direct.get(i).copied().unwrap_or_default()
    }
    /// Estimated error of the total incident flux of zone `i`, direct light included, W/m².
    pub fn total_error(&self, i: usize) -> Bands {
        let direct = self.direct_error.get(i).copied().unwrap_or_default();
        self.error[i] + direct
    }
}

/// Thermal quantities of all zones, summed over the bands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThermalFields {
    /// T, K; NaN where undefined: perfect mirrors, volumes that do not absorb, zones that would have to emit negative power.
    pub temperature: Vec<f64>,
    /// Estimated error of T, K; 0 for prescribed temperatures, NaN where T is.
    pub temperature_error: Vec<f64>,
    /// Net emitted power: W/m² of patches, W/m³ of volume zones.
    pub net: Vec<f64>,
    /// Estimated error of `net`; 0 for prescribed powers.
    pub net_error: Vec<f64>,
}
