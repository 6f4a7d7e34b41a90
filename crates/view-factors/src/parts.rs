//! View factors as plain lists, to hand over and to restore.

use crate::matrix::ExchangeRows;
use crate::view_factors::{ViewFactorCounts, ViewFactors};
use zonal_math::{Bounded, Grade};
use zonal_scene::SceneError;

/// The lists of [`ViewFactors`] of n facets with m stored entries.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewFactorParts {
    /// Areas A, m²; n.
    pub areas: Vec<f64>,
    /// First entry of each row, and m; n + 1.
    pub row_starts: Vec<u64>,
    /// Column of each entry, ascending within a row; m.
    pub columns: Vec<u32>,
    /// A_i F_ij, m²; m.
    pub exchange_areas: Vec<f64>,
    /// Their error radii, m²; m.
    pub radii: Vec<f32>,
    /// A_i F_i,sky and its error radius, m²; n.
    pub sky: Vec<[f64; 2]>,
    /// A_i F_i,ground and its error radius, m²; n.
    pub ground: Vec<[f64; 2]>,
    /// Row sum minus one before closing; n.
    pub defects: Vec<f64>,
    /// Rows that are not closed.
    pub open_rows: Vec<usize>,
    /// Largest defect after closing.
    pub remaining_defect: f64,
    /// Evidence for the radii.
    pub grade: Grade,
    /// Numbers of pairs.
    pub counts: ViewFactorCounts,
}

impl ViewFactorParts {
    /// True if all lists fit together.
    fn is_consistent(&self) -> bool {
        let (n, m) = (self.areas.len(), self.columns.len());
        let rows = self.row_starts.len() == n + 1
            && self.row_starts[0] == 0
            && self.row_starts.is_sorted()
            && self.row_starts[n] == m as u64;
        let lengths = [self.sky.len(), self.ground.len(), self.defects.len()];
        rows && self.exchange_areas.len() == m
            && self.radii.len() == m
            && lengths.iter().all(|l| *l == n)
            && self.columns.iter().all(|j| (*j as usize) < n)
            && self.open_rows.iter().all(|i| *i < n)
    }
}

impl ViewFactors {
    /// The lists, with their memory.
    pub fn into_parts(self) -> ViewFactorParts {
        let ViewFactors { areas, rows, defects, open_rows, remaining_defect, grade, counts } = self;
        let pairs = |list: Vec<Bounded>| list.iter().map(|b| [b.value, b.radius]).collect();
        ViewFactorParts {
            areas,
            row_starts: rows.starts,
            columns: rows.columns,
            exchange_areas: rows.values,
            radii: rows.radii,
            sky: pairs(rows.sky),
            ground: pairs(rows.ground),
            defects,
            open_rows,
            remaining_defect,
            grade,
            counts,
        }
    }

    /// View factors from their lists.
    ///
    /// # Errors
    /// Lists that do not fit together.
    pub fn from_parts(parts: ViewFactorParts) -> Result<ViewFactors, SceneError> {
        if !parts.is_consistent() {
            return Err(SceneError::new(
                "view factors",
                "the arrays do not fit together; save the view factors again",
            ));
        }
        let ViewFactorParts { areas, defects, open_rows, remaining_defect, grade, counts, .. } = parts;
        let bounded = |list: Vec<[f64; 2]>| {
            list.into_iter().map(|[value, radius]| Bounded { value, radius, grade }).collect()
        };
        let rows = ExchangeRows {
            starts: parts.row_starts,
            columns: parts.columns,
            values: parts.exchange_areas,
            radii: parts.radii,
            sky: bounded(parts.sky),
            ground: bounded(parts.ground),
        };
        Ok(ViewFactors { areas, rows, defects, open_rows, remaining_defect, grade, counts })
    }
}

#[cfg(test)]
mod tests {
    use crate::{FacetSet, ViewFactorSettings, ViewFactors};
    use zonal_math::vec3;
    use zonal_scene::{NoCheckpoints, NoProgress};

    #[test]
    fn factors_are_restored_from_their_lists_and_damaged_lists_are_refused() {
        let mut set = FacetSet::new();
        for (z, turn) in [(0.0, [0, 1, 2, 3]), (0.5, [3, 2, 1, 0])] {
            let c = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            set.add_surface(&turn.map(|k: usize| vec3(c[k][0], c[k][1], z)));
        }
        let f =
            set.compute(&ViewFactorSettings::default(), &NoProgress, &NoCheckpoints).expect("valid settings");
        let parts = f.clone().into_parts();
        let back = ViewFactors::from_parts(parts.clone()).expect("the lists of a computation");
        assert_eq!(back.row(0).collect::<Vec<_>>(), f.row(0).collect::<Vec<_>>());
        assert_eq!(back.into_parts(), parts);
        let mut damaged = parts.clone();
        damaged.columns[0] = 2;
        assert!(ViewFactors::from_parts(damaged).is_err());
        let mut damaged = parts;
        damaged.row_starts[1] = 9;
        assert!(ViewFactors::from_parts(damaged).is_err());
    }
}
