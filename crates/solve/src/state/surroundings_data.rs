//! Exchange with the surroundings, as plain arrays.

/// Exchange with the surroundings and closure of the rows, matrix after matrix, one number for each zone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurroundingsData {
    /// Exchange areas with the surroundings F_s, m², scaled with the rows.
    pub areas: Vec<f64>,
    /// Their standard errors, m².
    pub radii: Vec<f64>,
    /// Exchange areas with the black backs of one-sided surfaces, m², scaled with the rows.
    pub backfaces: Vec<f64>,
    /// Scaling d of the rows that restores closure: F' = d F d; 1 where closure is not restored.
    pub scaling: Vec<f64>,
    /// Error of the incident power by closure, relative to it; infinite if unknown.
    pub closure_error: Vec<f64>,
}
