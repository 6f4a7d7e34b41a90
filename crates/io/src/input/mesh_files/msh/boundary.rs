//! The boundary of volume elements: the sides that belong to one element alone.

use super::content::MshContent;
use std::collections::HashMap;
use zonal_math::Vec3;

/// Largest number of corners of a side.
const MAX_SIDE_CORNERS: usize = 4;

/// A side by its nodes in ascending order; triangles end with [`u64::MAX`], which no node has.
type SideKey = [u64; MAX_SIDE_CORNERS];

fn side_key(nodes: &[u64]) -> SideKey {
    let mut key = [u64::MAX; MAX_SIDE_CORNERS];
    key.iter_mut().zip(nodes).for_each(|(k, n)| *k = *n);
    key.sort_unstable();
    key
}

/// The sides on the boundary as pairs of an element and the nodes of its side, in the order of the elements; counter-clockwise from outside the element.
/// `position` gives the position of a node that every element has.
pub(super) fn boundary_sides(content: &MshContent, position: &dyn Fn(u64) -> Vec3) -> Vec<(usize, Vec<u64>)> {
    let side_of = |corners: &[u64], side: &[usize]| side.iter().map(|k| corners[*k]).collect::<Vec<u64>>();
    let mut elements_of_side: HashMap<SideKey, u8> = HashMap::new();
    for element in &content.elements {
        let corners = content.corners(element);
        for side in element.shape.sides() {
            let count = elements_of_side.entry(side_key(&side_of(corners, side))).or_default();
            *count = count.saturating_add(1);
        }
    }
    let mut out = Vec::new();
    for (k, element) in content.elements.iter().enumerate() {
        let corners = content.corners(element);
        for side in element.shape.sides() {
            let mut nodes = side_of(corners, side);
            if elements_of_side.get(&side_key(&nodes)) == Some(&1) {
                if faces_inward(&nodes, corners, position) {
                    nodes.reverse();
                }
                out.push((k, nodes));
            }
        }
    }
    out
}

/// True if the normal of a side points to the middle of its element, as in elements of negative volume.
fn faces_inward(side: &[u64], corners: &[u64], position: &dyn Fn(u64) -> Vec3) -> bool {
    let mean = |nodes: &[u64]| {
        nodes.iter().fold(Vec3::ZERO, |sum, n| sum + position(*n)) / nodes.len().max(1) as f64
    };
    let middle = mean(side);
    let from_middle = |k: usize| position(side[k % side.len()]) - middle;
    let area = (0..side.len()).fold(Vec3::ZERO, |sum, k| sum + from_middle(k).cross(from_middle(k + 1)));
    area.dot(middle - mean(corners)) < 0.0
}
