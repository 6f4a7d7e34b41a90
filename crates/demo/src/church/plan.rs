//! Dimensions and resolution of the church.

/// Size and resolution of the church.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChurchPlan {
    /// Bays of the nave.
    pub bays: usize,
    /// Pieces from the springing of a vault to its crown.
    pub pieces: usize,
    /// Sides of a column.
    pub sides: usize,
    /// Straight pieces of half an arch.
    pub arc: usize,
    /// Side of a cell of glass, m.
    pub cell: f64,
    /// True with the cames and bars of the windows, and all mouldings.
    pub fine: bool,
}

impl ChurchPlan {
    /// The church of the pictures.
    pub const SIX_BAYS: ChurchPlan =
        ChurchPlan { bays: 6, pieces: 10, sides: 20, arc: 8, cell: 0.24, fine: true };
    /// Two bays in the detail of six.
    pub const TWO_FINE_BAYS: ChurchPlan = ChurchPlan { bays: 2, ..ChurchPlan::SIX_BAYS };
    /// Two bays with larger panes, for tests.
    pub const TWO_BAYS: ChurchPlan =
        ChurchPlan { bays: 2, pieces: 4, sides: 8, arc: 3, cell: 0.5, fine: false };

    /// Length of the nave L, m.
    pub fn length(&self) -> f64 {
        BAY_LENGTH * self.bays as f64
    }
}

pub(super) const BAY_LENGTH: f64 = 5.0;
/// Half width of the nave between its walls, and of the outer faces of these, m.
pub(super) const NAVE_WALL_OFFSETS: (f64, f64) = (3.65, 4.35);
/// Outer walls, m from the axis.
pub(super) const OUTER_WALL_OFFSET: f64 = 8.2;
/// Springing and rise of the nave's vault, m.
pub(super) const NAVE_VAULT: (f64, f64) = (9.6, 4.4);
/// Rise of the aisles' vaults, m.
pub(super) const AISLE_VAULT_RISE: f64 = 2.6;
/// Arches of the arcades: half span and rise, m.
pub(super) const ARCADE_ARCH: (f64, f64) = (2.1, 2.3);
pub(super) const SIDES: [f64; 2] = [-1.0, 1.0];
