//! Storage of one value for each cell of a grid, or for each zone of it.

use crate::bands::Bands;

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
    #[inline]
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
    pub(crate) fn gathered(&self, cells: impl Iterator<Item = usize>) -> CellValues<T> {
        match self {
            CellValues::Uniform(v) => CellValues::Uniform(*v),
            CellValues::PerCell(list) => CellValues::PerCell(cells.map(|c| list[c]).collect()),
        }
    }
    /// Heap memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            CellValues::Uniform(_) => 0,
            CellValues::PerCell(list) => size_of_val(list.as_slice()),
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

impl CellValues<Bands> {
    /// Replaces each of `len` values by a function of its index and value; stored once if all results have the same bits.
    pub(crate) fn update(&mut self, len: usize, value: impl Fn(usize, Bands) -> Bands) {
        if len == 0 {
            return;
        }
        let new = |i: usize| value(i, self.get(i));
        let (first, bits) = (new(0), |x: Bands| x.map(f64::to_bits));
        if (1..len).all(|i| bits(new(i)) == bits(first)) {
            *self = CellValues::Uniform(first);
            return;
        }
        match self {
            CellValues::Uniform(v) => *self = CellValues::PerCell((0..len).map(|i| value(i, *v)).collect()),
            CellValues::PerCell(list) => list.iter_mut().enumerate().for_each(|(i, x)| *x = value(i, *x)),
        }
    }
}

/// The properties of all cells of a grid, or of all zones of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MediumValues {
    /// Extinction κ, 1/m.
    pub extinction: CellValues<Bands>,
    /// Scattering albedo Ω.
    pub albedo: CellValues<Bands>,
    /// Blackbody emissive power E, W/m².
    pub emission: CellValues<Bands>,
    /// Volumetric source q, W/m³.
    pub source: CellValues<Bands>,
}

impl MediumValues {
    /// The same extinction, albedo, emission and source everywhere.
    pub(crate) fn uniform(values: [Bands; 4]) -> MediumValues {
        let [extinction, albedo, emission, source] = values.map(CellValues::Uniform);
        MediumValues { extinction, albedo, emission, source }
    }
    /// Extinction, albedo, emission and source.
    pub(crate) fn each(&self) -> [&CellValues<Bands>; 4] {
        [&self.extinction, &self.albedo, &self.emission, &self.source]
    }
    /// The same, to be changed.
    pub(crate) fn each_mut(&mut self) -> [&mut CellValues<Bands>; 4] {
        [&mut self.extinction, &mut self.albedo, &mut self.emission, &mut self.source]
    }
    /// The values of a list of cells.
    pub(crate) fn gathered(&self, cells: impl Iterator<Item = usize> + Clone) -> MediumValues {
        let [extinction, albedo, emission, source] = self.each().map(|v| v.gathered(cells.clone()));
        MediumValues { extinction, albedo, emission, source }
    }
    /// True if each property is stored once.
    pub(crate) fn is_uniform(&self) -> bool {
        self.each().into_iter().all(|v| matches!(v, CellValues::Uniform(_)))
    }
    /// Heap memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.each().map(CellValues::bytes).iter().sum()
    }
}
