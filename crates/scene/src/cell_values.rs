//! Storage of one value for each cell of a grid.

/// One value per cell, stored once if it is the same in all cells.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CellValues<T> {
    /// The value of all cells.
    Uniform(T),
    /// The value of each cell.
    PerCell(Vec<T>),
}

impl<T: Copy + PartialEq> CellValues<T> {
    /// The value of a cell.
    pub(crate) fn get(&self, index: usize) -> T {
        match self {
            CellValues::Uniform(v) => *v,
            CellValues::PerCell(list) => list[index],
        }
    }
    /// Sets the value of a cell of a grid of `len` cells.
    pub(crate) fn set(&mut self, index: usize, value: T, len: usize) {
        match self {
            CellValues::Uniform(v) if *v == value => {}
            CellValues::Uniform(v) => {
                let mut list = vec![*v; len];
                list[index] = value;
                *self = CellValues::PerCell(list);
            }
            CellValues::PerCell(list) => list[index] = value,
        }
    }
    /// The values of a list of cells.
    pub(crate) fn gathered(&self, cells: &[usize]) -> CellValues<T> {
        match self {
            CellValues::Uniform(v) => CellValues::Uniform(*v),
            CellValues::PerCell(list) => CellValues::PerCell(cells.iter().map(|&c| list[c]).collect()),
        }
    }
    /// Stores a single value if all are equal.
    pub(crate) fn seal(&mut self) {
        if let CellValues::PerCell(list) = self
            && list.iter().all(|v| *v == list[0])
        {
            *self = CellValues::Uniform(list[0]);
        }
    }
}
