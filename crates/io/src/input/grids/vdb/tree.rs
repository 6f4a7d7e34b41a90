//! The tree of a grid: root, nodes of 32³ and 16³ children, leaves of 8³ voxels.
//!
//! First comes the topology: background, root tiles and children; of every inner node a mask of children, a mask of active
//! values, the values (tiles, each the whole of a child's place), then the children in order; of a leaf its mask. Then, at
//! another offset, the leaves in the same order: mask and values. Within a node x runs slowest.

use super::bytes::{ByteCursor, SAVE_AGAIN, bit};
use super::values::ValueCodec;
use crate::input::reading::error::FileFault;
use std::collections::HashSet;

/// log₂ of the voxels along an edge of a root's child, of a node below it, of a leaf.
const LOG2_NODE_EDGES: [u32; 3] = [12, 7, 3];
/// log₂ of the children along an edge of these.
const LOG2_CHILDREN: [u32; 2] = [5, 4];
/// Voxels of a leaf.
const LEAF_VOXELS: usize = 512;

/// Values of equal cubes in a cubic block: one tile, or a leaf's 8³ voxels.
pub(crate) struct ValueBlock<'a> {
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

/// Calls `visit` on all tiles and leaves, disjoint blocks in the order of the file. Memory: the values of a node, and the origin of
/// every leaf.
pub(crate) fn scan(
    mut topology: ByteCursor<'_>,
    mut leaves: ByteCursor<'_>,
    mut codec: ValueCodec,
    visit: &mut dyn FnMut(&ValueBlock<'_>) -> Result<(), FileFault>,
) -> Result<(), FileFault> {
    let c = &mut topology;
    if c.u32()? != 1 {
        return Err(c.fault(format!("this tree has several buffers, which is not read; {SAVE_AGAIN}")));
    }
    codec.background = codec.read_value(c)?;
    let (tiles, children) = (c.u32()?, c.u32()?);
    let mut taken = HashSet::new();
    for _ in 0..tiles {
        let origin = read_root_origin(c, &mut taken)?;
        let value = codec.read_value(c)?;
        let active = c.u8()? != 0;
        let (values, active) = ([value], [u64::from(active)]);
        visit(&ValueBlock {
            origin,
            edge: 1 << LOG2_NODE_EDGES[0],
            count: 1,
            values: &values,
            active: &active,
        })?;
    }
    let mut leaf_origins = Vec::new();
    for _ in 0..children {
        let origin = read_root_origin(c, &mut taken)?;
        read_node(c, 0, origin, &codec, visit, &mut leaf_origins)?;
    }
    let mut values = Vec::new();
    for origin in leaf_origins {
        let active = leaves.mask(LEAF_VOXELS)?;
        codec.read_node(&mut leaves, LEAF_VOXELS, &active, &mut values)?;
        visit(&ValueBlock { origin, edge: 1, count: 8, values: &values, active: &active })?;
    }
    Ok(())
}

/// The origin of an entry of the root: on its lattice and not used before, so that no two blocks overlap.
fn read_root_origin(c: &mut ByteCursor<'_>, taken: &mut HashSet<[i64; 3]>) -> Result<[i64; 3], FileFault> {
    let place = c.coordinates()?;
    if place.iter().any(|x| x & ((1 << LOG2_NODE_EDGES[0]) - 1) != 0) || !taken.insert(place) {
        return Err(c.fault(format!("{place:?} is no place for a node of the root; {SAVE_AGAIN}")));
    }
    Ok(place)
}

/// Reads an inner node with its descendants; appends the origins of leaves.
fn read_node(
    c: &mut ByteCursor<'_>,
    level: usize,
    origin: [i64; 3],
    codec: &ValueCodec,
    visit: &mut dyn FnMut(&ValueBlock<'_>) -> Result<(), FileFault>,
    leaves: &mut Vec<[i64; 3]>,
) -> Result<(), FileFault> {
    let bits = LOG2_CHILDREN[level];
    let n = 1usize << (3 * bits);
    let (children, active) = (c.mask(n)?, c.mask(n)?);
    let mut values = Vec::new();
    codec.read_node(c, n, &active, &mut values)?;
    let edge = 1i64 << LOG2_NODE_EDGES[level + 1];
    let origin_of = |i: usize| {
        let along = |shift: u32| (i >> shift & ((1 << bits) - 1)) as i64 * edge;
        [origin[0] + along(2 * bits), origin[1] + along(bits), origin[2] + along(0)]
    };
    for i in (0..n).filter(|i| !bit(&children, *i)) {
        let active = [u64::from(bit(&active, i))];
        visit(&ValueBlock { origin: origin_of(i), edge, count: 1, values: &values[i..=i], active: &active })?;
    }
    drop(values);
    for i in (0..n).filter(|i| bit(&children, *i)) {
        if level == 0 {
            read_node(c, 1, origin_of(i), codec, visit, leaves)?;
        } else {
            // Skip the mask, which is repeated with the values.
            c.take(LEAF_VOXELS / 8)?;
            leaves.push(origin_of(i));
        }
    }
    Ok(())
}
