//! The tree of a grid: root, nodes of 32³ and 16³ children, leaves of 8³ voxels.
//!
//! First comes the topology: background, root tiles and children; of every inner node a mask of children, a mask of active
//! values, the values (tiles, each the whole of a child's place), then the children in order; of a leaf its mask. Then, from
//! another place, the leaves in the same order: mask and values. Within a node x runs slowest.

use super::bytes::{Cursor, SAVE_AGAIN, bit};
use super::values::Coding;
use crate::input::error::Fault;
use std::collections::HashSet;

/// log₂ of the voxels along an edge of a root's child, of a node below it, of a leaf.
const EDGES: [u32; 3] = [12, 7, 3];
/// log₂ of the children along an edge of these.
const CHILDREN: [u32; 2] = [5, 4];
/// Voxels of a leaf.
const LEAF: usize = 512;

/// Values of equal cubes in a cubic block: one tile, or a leaf's 8³ voxels.
pub(crate) struct Block<'a> {
    /// The index of its first voxel.
    pub(crate) origin: [i64; 3],
    /// Voxels along the edge of one value.
    pub(crate) edge: i64,
    /// Values along the edge of the block.
    pub(crate) count: usize,
    /// count³ values, x slowest.
    pub(crate) values: &'a [f64],
    /// Which are active.
    pub(crate) active: &'a [u64],
}

/// Shows all tiles and leaves to `visit`, disjoint blocks in the order of the file. Memory: a node's values, and a place for each leaf.
pub(crate) fn scan(
    mut topology: Cursor<'_>,
    mut leaves: Cursor<'_>,
    mut coding: Coding,
    visit: &mut dyn FnMut(&Block<'_>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let c = &mut topology;
    if c.u32()? != 1 {
        return Err(c.fault(format!("this tree has several buffers, which is not read; {SAVE_AGAIN}")));
    }
    coding.background = coding.one(c)?;
    let (tiles, children) = (c.u32()?, c.u32()?);
    let mut taken = HashSet::new();
    for _ in 0..tiles {
        let origin = root_place(c, &mut taken)?;
        let value = coding.one(c)?;
        let active = c.u8()? != 0;
        let (values, active) = ([value], [u64::from(active)]);
        visit(&Block { origin, edge: 1 << EDGES[0], count: 1, values: &values, active: &active })?;
    }
    let mut places = Vec::new();
    for _ in 0..children {
        let origin = root_place(c, &mut taken)?;
        node(c, 0, origin, &coding, visit, &mut places)?;
    }
    let mut values = Vec::new();
    for origin in places {
        let active = leaves.mask(LEAF)?;
        coding.node(&mut leaves, LEAF, &active, &mut values)?;
        visit(&Block { origin, edge: 1, count: 8, values: &values, active: &active })?;
    }
    Ok(())
}

/// The place of an entry of the root: on its lattice, and not taken before, so that no two blocks overlap.
fn root_place(c: &mut Cursor<'_>, taken: &mut HashSet<[i64; 3]>) -> Result<[i64; 3], Fault> {
    let place = c.coordinates()?;
    if place.iter().any(|x| x & ((1 << EDGES[0]) - 1) != 0) || !taken.insert(place) {
        return Err(c.fault(format!("{place:?} is no place for a node of the root; {SAVE_AGAIN}")));
    }
    Ok(place)
}

/// An inner node with all below it; notes the places of leaves.
fn node(
    c: &mut Cursor<'_>,
    level: usize,
    origin: [i64; 3],
    coding: &Coding,
    visit: &mut dyn FnMut(&Block<'_>) -> Result<(), Fault>,
    leaves: &mut Vec<[i64; 3]>,
) -> Result<(), Fault> {
    let bits = CHILDREN[level];
    let n = 1usize << (3 * bits);
    let (children, active) = (c.mask(n)?, c.mask(n)?);
    let mut values = Vec::new();
    coding.node(c, n, &active, &mut values)?;
    let edge = 1i64 << EDGES[level + 1];
    let place = |i: usize| {
        let along = |shift: u32| (i >> shift & ((1 << bits) - 1)) as i64 * edge;
        [origin[0] + along(2 * bits), origin[1] + along(bits), origin[2] + along(0)]
    };
    for i in (0..n).filter(|i| !bit(&children, *i)) {
        let active = [u64::from(bit(&active, i))];
        visit(&Block { origin: place(i), edge, count: 1, values: &values[i..=i], active: &active })?;
    }
    drop(values);
    for i in (0..n).filter(|i| bit(&children, *i)) {
        if level == 0 {
            node(c, 1, place(i), coding, visit, leaves)?;
        } else {
            // Its mask comes again with its values.
            c.take(LEAF / 8)?;
            leaves.push(place(i));
        }
    }
    Ok(())
}
