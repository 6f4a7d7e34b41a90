//! View factors by rows.

/// View factors of n surfaces, in rows of which factors above zero are stored.
#[derive(Clone, Copy, Debug)]
pub struct ViewFactorTable<'a> {
    /// Areas, m², `[n]`.
    pub areas: &'a [f64],
    /// Emissivities, `[n]`.
    pub emissivities: &'a [f64],
    /// Names, `[n]`.
    pub names: &'a [String],
    /// Index of the first stored factor of each row, and behind them the number of all, `[n + 1]`.
    pub row_starts: &'a [u64],
    /// Index of the surface of arrival of each stored factor, ascending in each row, `[stored]`.
    pub columns: &'a [u32],
    /// Factor F_ij from the surface of the row to that of the column, `[stored]`.
    pub values: &'a [f64],
    /// Error radius of each factor, infinite if unknown, `[stored]`.
    pub radii: &'a [f32],
    /// Factor to the sky, `[n]`.
    pub sky: &'a [f64],
    /// Its error radius, `[n]`.
    pub sky_radii: &'a [f64],
    /// Factor to directions below the horizon that meet nothing, `[n]`.
    pub ground: &'a [f64],
    /// Its error radius, `[n]`.
    pub ground_radii: &'a [f64],
    /// Sum of a row, sky and ground included, minus one before the rows were closed, `[n]`.
    pub defects: &'a [f64],
    /// True if the surfaces form an enclosure.
    pub enclosure: bool,
    /// True if the factors include reflections between grey surfaces (script F).
    pub scripted: bool,
}

impl<'a> ViewFactorTable<'a> {
    /// Number of surfaces.
    pub(super) fn len(&self) -> usize {
        self.areas.len()
    }

    /// The stored factors of a row: column, factor, error radius.
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64, f32)> + use<'a> {
        let range = self.row_starts[i] as usize..self.row_starts[i + 1] as usize;
        let (columns, values) = (&self.columns[range.clone()], &self.values[range.clone()]);
        columns.iter().zip(values).zip(&self.radii[range]).map(|((j, f), r)| (*j as usize, *f, *r))
    }

    /// Compares the lengths of the arrays and the order of the columns.
    pub(super) fn check(&self) -> Result<(), String> {
        let (n, stored) = (self.areas.len(), self.values.len());
        let lengths = [
            ("emissivities", self.emissivities.len(), n),
            ("names", self.names.len(), n),
            ("row_starts", self.row_starts.len(), n + 1),
            ("columns", self.columns.len(), stored),
            ("radii", self.radii.len(), stored),
            ("sky", self.sky.len(), n),
            ("sky_radii", self.sky_radii.len(), n),
            ("ground", self.ground.len(), n),
            ("ground_radii", self.ground_radii.len(), n),
            ("defects", self.defects.len(), n),
        ];
        if let Some((name, found, wanted)) = lengths.into_iter().find(|(_, found, wanted)| found != wanted) {
            return Err(format!("{name} has {found} elements where {wanted} are wanted; give one for each"));
        }
        let starts = self.row_starts;
        let ends_fit = starts[0] == 0 && starts[n] == stored as u64;
        if !ends_fit || starts.windows(2).any(|w| w[0] > w[1]) {
            return Err(format!("row_starts does not run from 0 to {stored} without a step back; mend it"));
        }
        let is_sorted = |w: &[u64]| {
            let row = &self.columns[w[0] as usize..w[1] as usize];
            row.windows(2).all(|c| c[0] < c[1]) && row.last().is_none_or(|c| (*c as usize) < n)
        };
        match starts.windows(2).position(|w| !is_sorted(w)) {
            Some(row) => Err(format!("the columns of row {row} do not ascend within 0 to {n}; sort them")),
            None => Ok(()),
        }
    }
}
