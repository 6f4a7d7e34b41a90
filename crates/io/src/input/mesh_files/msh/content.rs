//! Nodes, elements and physical groups of a file of Gmsh.

use super::element_types::{ElementShape, MshElementType};
use std::collections::HashMap;
use zonal_math::Vec3;

/// Physical group of elements without one.
pub(super) const NO_GROUP: i64 = 0;
/// Name of the material of elements without a group.
const UNGROUPED: &str = "ungrouped";

/// The contents of a file.
#[derive(Default)]
pub(super) struct MshContent {
    /// Names of physical groups by dimension and number.
    pub(super) group_names: HashMap<(u8, i64), String>,
    /// First physical group of each entity, by dimension and number; negative if its elements are turned.
    pub(super) entity_groups: HashMap<(i64, i64), i64>,
    pub(super) nodes: HashMap<u64, Vec3>,
    pub(super) elements: Vec<MshElement>,
    /// Nodes of the corners of all elements.
    corners: Vec<u64>,
    /// Surfaces and volumes that belong to several physical groups.
    pub(super) entities_of_several_groups: usize,
}

/// A face or a volume.
#[derive(Clone, Copy)]
pub(super) struct MshElement {
    pub(super) shape: ElementShape,
    /// Number of its physical group, or [`NO_GROUP`].
    pub(super) group: i64,
    /// True if it has nodes besides its corners.
    pub(super) curved: bool,
    /// Its first corner among all.
    first: usize,
}

impl MshContent {
    /// Adds an element by its nodes; points and lines are passed over. `group` is negative for elements that are turned.
    pub(super) fn push(&mut self, kind: MshElementType, group: i64, nodes: &[u64]) {
        let count = kind.shape.corners();
        if kind.shape.dimension() < 2 || nodes.len() < count {
            return;
        }
        let first = self.corners.len();
        self.corners.extend(&nodes[..count]);
        if group < 0 && kind.shape.dimension() == 2 {
            self.corners[first..].reverse();
        }
        let curved = kind.nodes > count;
        self.elements.push(MshElement { shape: kind.shape, group: group.saturating_abs(), curved, first });
    }

    /// The nodes of an element's corners.
    pub(super) fn corners(&self, element: &MshElement) -> &[u64] {
        &self.corners[element.first..element.first + element.shape.corners()]
    }

    /// The name of an element's physical group.
    pub(super) fn group_name(&self, element: &MshElement) -> String {
        match (element.group, self.group_names.get(&(element.shape.dimension(), element.group))) {
            (NO_GROUP, _) => UNGROUPED.to_string(),
            (_, Some(name)) => name.clone(),
            (group, None) => format!("physical-{group}"),
        }
    }
}
