//! Straight edges of contours, and the mean of ln r over two of them with its error.

use zonal_math::Vec3;

/// A straight edge; lengths in units of the pair's size, about one.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContourEdge {
    pub start: Vec3,
    pub edge: Vec3,
    pub length: f64,
}

impl ContourEdge {
    pub(super) fn between(a: Vec3, b: Vec3) -> ContourEdge {
        let edge = b - a;
        ContourEdge { start: a, edge, length: edge.length() }
    }
    pub(super) fn end(&self) -> Vec3 {
        self.start + self.edge
    }
    pub(super) fn halves(&self) -> [ContourEdge; 2] {
        let (edge, length) = (self.edge * 0.5, 0.5 * self.length);
        [
            ContourEdge { start: self.start, edge, length },
            ContourEdge { start: self.start + edge, edge, length },
        ]
    }
}

/// J, its proved error and the logarithms or dilogarithms that it took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EdgeIntegral {
    pub value: f64,
    pub error: f64,
    pub evaluations: u64,
}
