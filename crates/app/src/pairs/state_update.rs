//! Fluxes and temperatures of a geometry for other temperatures, powers or emissivities, from stored exchange areas.
//!
//! | rows of a table | meaning |
//! |---|---|
//! | by zone | one value for each zone, in the order of the exchange areas; emissivities for each patch |
//! | by face | one value for each face of the meshes, in the order of the mesh files |
//! | by name | a name of a surface, of the medium or of a pane, or its part before a dot or a slash, and a value; other names keep theirs |
//!
//! The output has the rows of the first table: zones, faces, or all names.

use crate::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zonal_io::input::{Quantity, RowKeys, ValueTable, read_values};
use zonal_io::output::{self, FileError};
use zonal_report::Failure;
use zonal_scene::{SceneError, ThermalCondition, printable};
use zonal_solve::state::{ExchangeData, StatePart, StateSolver, ThermalState};

/// New values of a geometry.
#[derive(Clone, Debug)]
pub struct StateChanges {
    /// Tables of values by quantity (.csv, .npy, .vtu, .vtp).
    pub tables: Vec<(Quantity, PathBuf)>,
    /// Column of the tables by name or number; if `None`, the only one, or the one named like the quantity.
    pub column: Option<String>,
    /// Meaning of the rows of the tables; if `None`, it follows from names in the first column or from the number of rows.
    pub rows: Option<Rows>,
    /// Temperature of the surroundings, K.
    pub surroundings_temperature: Option<f64>,
}

impl StateChanges {
    /// The state of a geometry with these values.
    ///
    /// # Errors
    /// For tables that are not valid or do not agree with the geometry, and for states that are not determined.
    pub fn apply(&self, data: ExchangeData) -> Result<UpdatedState, Error> {
        let mut solver = StateSolver::new(data)?;
        let mut layout = self.rows;
        for (quantity, path) in &self.tables {
            let keys = match self.rows {
                Some(Rows::Name) => RowKeys::Name,
                Some(_) => RowKeys::Position,
                None => RowKeys::NameOrPosition,
            };
            let table = read_values(path, self.column.as_deref(), *quantity, keys)?;
            let rows = NewValues { table: &table, quantity: *quantity, by: self.rows }.apply(&mut solver)?;
            layout = layout.or(Some(rows));
        }
        if let Some(t) = self.surroundings_temperature {
            solver
                .set_surroundings_temperature(Some(t))
                .map_err(|e| Failure::new(format!("--surroundings-temperature: {}", e.message())))?;
        }
        let state = solver.solve()?;
        Ok(UpdatedState { solver, state, rows: layout.unwrap_or(Rows::Name) })
    }
}

/// Meaning of the rows of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Rows {
    /// Zones.
    Zone,
    /// Faces of the meshes.
    Face,
    /// Names of surfaces, medium and panes.
    Name,
}

/// Columns of numbers in the output.
const COLUMNS: [&str; 11] = [
    "size",
    "net_power_W",
    "net_power_exchange_error_W",
    "net_flux",
    "net_flux_exchange_error",
    "temperature_K",
    "temperature_exchange_error_K",
    "incident_flux_W_m2",
    "incident_flux_exchange_error_W_m2",
    "radiosity_W_m2",
    "radiosity_exchange_error_W_m2",
];

/// The values of a table.
struct NewValues<'a> {
    table: &'a ValueTable,
    quantity: Quantity,
    by: Option<Rows>,
}

impl NewValues<'_> {
    /// Sets the values; returns what the rows stand for.
    fn apply(&self, solver: &mut StateSolver) -> Result<Rows, Failure> {
        let data = solver.data();
        let (rows, zones_of_row) = match self.table.names() {
            Some(names) => (Rows::Name, self.zones_by_name(names, data)?),
            None => self.zones_by_position(data)?,
        };
        for (row, zones) in zones_of_row.iter().enumerate() {
            let size: f64 = zones.iter().map(|i| solver.data().sizes[*i]).sum();
            for &i in zones {
                self.set(solver, i, self.table.values()[row], size)
                    .map_err(|e| self.table.error(row, e.message()))?;
            }
        }
        Ok(rows)
    }

    /// Sets the value of zone `i` of a row whose zones have the size `size`.
    fn set(&self, solver: &mut StateSolver, i: usize, x: f64, size: f64) -> Result<(), SceneError> {
        match self.quantity {
            Quantity::Temperature => solver.set_condition(i, ThermalCondition::Temperature(x)),
            Quantity::NetPower => solver.set_condition(i, ThermalCondition::Flux(x / size)),
            Quantity::HeatFlux => solver.set_condition(i, ThermalCondition::Flux(x)),
            _ => solver.set_reflectance(i, &[1.0 - x]),
        }
    }

    /// The zones of each row of names.
    fn zones_by_name(&self, names: &[String], data: &ExchangeData) -> Result<Vec<Vec<usize>>, Failure> {
        const MAX_LISTED_NAMES: usize = 24;
        let mut row_of_name: Vec<Option<usize>> = vec![None; data.names.len()];
        for (row, name) in names.iter().enumerate() {
            let belongs = |s: &str| {
                s.strip_prefix(name.as_str()).is_some_and(|r| r.is_empty() || r.starts_with(['.', '/']))
            };
            let mut found = false;
            for (k, own) in data.names.iter().enumerate().filter(|(_, n)| belongs(n)) {
                if row_of_name[k].replace(row).is_some() {
                    return Err(self.table.error(row, &format!("'{own}' has two rows; keep one")).into());
                }
                found = true;
            }
            if !found {
                let known = data.names[..data.names.len().min(MAX_LISTED_NAMES)].join(", ");
                return Err(self
                    .table
                    .error(row, &format!("there is no '{}'; the names are: {known}", printable(name)))
                    .into());
            }
        }
        let mut zones = vec![Vec::new(); names.len()];
        for i in self.zones(data) {
            if let Some(row) = row_of_name[data.name_of_zone[i]] {
                zones[row].push(i);
            }
        }
        Ok(zones)
    }

    /// The zones that can have the quantity: emissivities belong to patches.
    fn zones(&self, data: &ExchangeData) -> std::ops::Range<usize> {
        0..if self.quantity == Quantity::Emissivity { data.patches } else { data.zone_count() }
    }

    /// The zones of each row by position, and whether rows are zones or faces.
    fn zones_by_position(&self, data: &ExchangeData) -> Result<(Rows, Vec<Vec<usize>>), Failure> {
        let (rows, zones, faces) = (self.table.values().len(), self.zones(data), data.face_count());
        let same_order = || (0..zones.len()).all(|i| data.face_of_zone[i] == Some(i));
        let by = match self.by {
            Some(by) => by,
            None if rows == zones.len() && rows == faces && !same_order() => {
                let what = format!(
                    "there are {rows} zones and {rows} faces, in different orders; add --by zone or --by face"
                );
                return Err(self.table.error(0, &what).into());
            }
            None if rows == zones.len() && rows != faces => Rows::Zone,
            None if rows == faces || faces > 0 => Rows::Face,
            None => Rows::Zone,
        };
        let (count, things) = match by {
            Rows::Face => (faces, "faces in the meshes".to_string()),
            _ => (zones.len(), format!("zones (and {faces} faces)")),
        };
        if rows != count {
            return Err(self.table.count_error(count, &things).into());
        }
        if by != Rows::Face {
            return Ok((by, zones.map(|i| vec![i]).collect()));
        }
        let mut of_face = vec![Vec::new(); faces];
        zones.for_each(|i| data.face_of_zone[i].into_iter().for_each(|f| of_face[f].push(i)));
        Ok((by, of_face))
    }
}

/// The state of changed values, and the rows of its table.
pub struct UpdatedState {
    solver: StateSolver,
    /// The state.
    pub state: ThermalState,
    rows: Rows,
}

impl UpdatedState {
    /// Geometry and exchange areas.
    #[must_use]
    pub fn data(&self) -> &ExchangeData {
        self.solver.data()
    }

    /// Writes the table: .npy as an array of the columns of numbers, otherwise .csv.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        let parts = self.parts();
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npy")) {
            let values: Vec<f64> = parts.iter().flat_map(numbers).collect();
            return output::write_array(path, &[parts.len(), COLUMNS.len()], &values);
        }
        let mut out = String::from(match self.rows {
            Rows::Zone => "zone,name",
            Rows::Face => "mesh,face",
            Rows::Name => "name",
        });
        COLUMNS.iter().for_each(|c| out.extend([",", c]));
        out.push('\n');
        for (key, part) in self.keys().iter().zip(&parts) {
            out.push_str(key);
            for x in numbers(part) {
                // A text never fails to grow.
                let _ = if x.is_nan() { write!(out, ",") } else { write!(out, ",{x}") };
            }
            out.push('\n');
        }
        output::write_bytes(path, out.as_bytes())
    }

    /// The rows.
    fn parts(&self) -> Vec<StatePart> {
        let (data, state) = (self.data(), &self.state);
        match self.rows {
            Rows::Zone => state.sums(&data.sizes, data.zone_count(), Some),
            Rows::Face => state.by_face(data),
            Rows::Name => state.by_name(data),
        }
    }

    /// The first columns of each row.
    fn keys(&self) -> Vec<String> {
        let d = self.data();
        let cell = |name: &str| output::csv_name(name);
        match self.rows {
            Rows::Zone => {
                let names: Vec<String> = d.names.iter().map(|n| cell(n)).collect();
                d.name_of_zone.iter().enumerate().map(|(i, k)| format!("{i},{}", names[*k])).collect()
            }
            Rows::Face => {
                let faces = d.meshes.iter().map(|m| (cell(&m.name), m.faces));
                faces.flat_map(|(name, n)| (0..n).map(move |f| format!("{name},{f}"))).collect()
            }
            Rows::Name => d.names.iter().map(|n| cell(n)).collect(),
        }
    }
}

/// The columns of a row.
fn numbers(part: &StatePart) -> [f64; COLUMNS.len()] {
    let ([p, dp], [q, dq], [t, dt]) = (part.power, part.flux(), part.temperature);
    let ([h, dh], [b, db]) = (part.incident, part.radiosity);
    [part.size, p, dp, q, dq, t, dt, h, dh, b, db]
}
