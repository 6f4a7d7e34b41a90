//! The lanes of wide nodes, chosen at least cost.
//!
//! A wide node over a binary node of surface S costs c_n S, a leaf c_l S, as the chance that a line meets a box is proportional to its
//! surface. C(n, k), the least cost of binary node n as at most k lanes of a wide node above it, follows from the children l and r
//! (Ylitie, Karras and Laine 2017):
//!
//! ```text
//! D(n, k) = min_{0<j<k} C(l, j) + C(r, k − j)        lanes on both sides
//! C(n, 1) = c_n S + D(n, 8)                          a node of its own
//! C(n, k) = min(C(n, k − 1), D(n, k))
//! ```

use super::node::NODE_WIDTH;

/// Cost of a wide node, in tests of a leaf.
pub(super) const NODE_COST: f32 = 0.6;

/// Least costs C(n, k) of a fork, and the lanes j of its left child in the cheapest cut into k lanes; 0 where fewer lanes cost less.
pub(super) struct WideCuts {
    pub cost: [f32; NODE_WIDTH],
    pub left: [u8; NODE_WIDTH + 1],
}

impl WideCuts {
    /// The cuts of a fork of half surface `half_area` from the costs of its children.
    pub(super) fn new(half_area: f32, l: &[f32; NODE_WIDTH], r: &[f32; NODE_WIDTH]) -> WideCuts {
        let mut cuts = WideCuts { cost: [0.0; NODE_WIDTH], left: [0; NODE_WIDTH + 1] };
        let cheapest = |lanes: usize| {
            let mut best = (f32::INFINITY, 0);
            for j in 1..lanes {
                let cost = l[j] + r[lanes - j];
                if cost < best.0 {
                    best = (cost, j as u8);
                }
            }
            best
        };
        let (below, left) = cheapest(NODE_WIDTH);
        cuts.left[NODE_WIDTH] = left;
        cuts.cost[1] = NODE_COST * half_area + below;
        for lanes in 2..NODE_WIDTH {
            let (cost, left) = cheapest(lanes);
            cuts.cost[lanes] = cuts.cost[lanes - 1];
            if cost < cuts.cost[lanes] {
                cuts.cost[lanes] = cost;
                cuts.left[lanes] = left;
            }
        }
        cuts
    }
}
