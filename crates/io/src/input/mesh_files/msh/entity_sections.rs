//! Entities, nodes and elements of versions 4.0 and 4.1: nodes and elements stand in blocks of one entity, whose physical groups `$Entities` gives.
//!
//! | | 4.0 | 4.1 |
//! |---|---|---|
//! | bounds of a point | six numbers | three |
//! | header of a block | entity, dimension, … | dimension, entity, … |
//! | nodes of a block | each number with its coordinates | all numbers, then all coordinates |
//! | counts of `$Nodes` and `$Elements` | blocks, all | blocks, all, smallest and largest number |
//! | numbers of nodes and elements | four bytes | eight bytes |

use super::content::{MshContent, NO_GROUP};
use super::values::{DOUBLE, INT, MshVersion, SIZE, element_type, read_position};
use crate::input::reading::error::FileFault;
use crate::input::reading::number_cursor::{NumberCursor, ScalarType};

/// Reads a section of this name: `Entities`, `Nodes` or `Elements`.
pub(super) fn read(
    name: &str,
    version: MshVersion,
    cursor: &mut NumberCursor<'_>,
    content: &mut MshContent,
) -> Result<(), FileFault> {
    let mut reader = EntityReader { version, cursor, content };
    match name {
        "Entities" => reader.read_entities(),
        "Nodes" => reader.read_nodes(),
        _ => reader.read_elements(),
    }
}

/// Reads the sections of one version.
struct EntityReader<'a, 'b> {
    version: MshVersion,
    cursor: &'a mut NumberCursor<'b>,
    content: &'a mut MshContent,
}

/// Dimension and number of the entity of a block, and the two numbers behind them but for the last.
struct BlockHeader {
    dimension: i64,
    entity: i64,
    /// Of nodes: whether they have parameters; of elements: their type.
    kind: i64,
    /// Number of nodes or elements.
    count: u64,
}

impl EntityReader<'_, '_> {
    /// The type of the numbers of nodes and elements.
    fn tag_type(&self) -> ScalarType {
        if self.version == MshVersion::V40 { INT } else { SIZE }
    }

    /// Reads entities: number, bounds, physical groups, entities of their boundary.
    fn read_entities(&mut self) -> Result<(), FileFault> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = self.cursor.count(SIZE)?;
        }
        for (dimension, count) in (0u8..).zip(counts) {
            let bounds = if dimension == 0 && self.version == MshVersion::V41 { 3 } else { 6 };
            for _ in 0..count {
                let entity = self.cursor.integer(INT)?;
                for _ in 0..bounds {
                    self.cursor.number(DOUBLE)?;
                }
                self.read_groups(dimension, entity)?;
                let boundary = if dimension == 0 { 0 } else { self.cursor.count(SIZE)? };
                for _ in 0..boundary {
                    self.cursor.integer(INT)?;
                }
            }
        }
        Ok(())
    }

    /// Reads the physical groups of an entity and keeps the first.
    fn read_groups(&mut self, dimension: u8, entity: i64) -> Result<(), FileFault> {
        let groups = self.cursor.count(SIZE)?;
        for k in 0..groups {
            let group = self.cursor.integer(INT)?;
            if k == 0 {
                self.content.entity_groups.insert((i64::from(dimension), entity), group);
            }
        }
        self.content.entities_of_several_groups += usize::from(dimension >= 2 && groups > 1);
        Ok(())
    }

    /// Reads the counts before the blocks; returns the number of blocks.
    fn block_count(&mut self) -> Result<u64, FileFault> {
        let blocks = self.cursor.count(SIZE)?;
        let others = if self.version == MshVersion::V40 { 1 } else { 3 };
        for _ in 0..others {
            self.cursor.number(SIZE)?;
        }
        Ok(blocks)
    }

    fn block_header(&mut self) -> Result<BlockHeader, FileFault> {
        let (first, second) = (self.cursor.integer(INT)?, self.cursor.integer(INT)?);
        let (dimension, entity) = match self.version {
            MshVersion::V40 => (second, first),
            _ => (first, second),
        };
        let kind = self.cursor.integer(INT)?;
        Ok(BlockHeader { dimension, entity, kind, count: self.cursor.count(SIZE)? })
    }

    fn read_nodes(&mut self) -> Result<(), FileFault> {
        let mut tags = Vec::new();
        for _ in 0..self.block_count()? {
            let block = self.block_header()?;
            let parameters = if block.kind == 0 { 0 } else { block.dimension.clamp(0, 3) };
            tags.clear();
            if self.version == MshVersion::V41 {
                for _ in 0..block.count {
                    tags.push(self.cursor.count(SIZE)?);
                }
            }
            for k in 0..block.count {
                let tag = match usize::try_from(k).ok().and_then(|k| tags.get(k)) {
                    Some(tag) => *tag,
                    None => self.cursor.count(INT)?,
                };
                read_position(self.cursor, tag, self.content)?;
                for _ in 0..parameters {
                    self.cursor.number(DOUBLE)?;
                }
            }
        }
        Ok(())
    }

    fn read_elements(&mut self) -> Result<(), FileFault> {
        let of_tag = self.tag_type();
        let mut nodes = Vec::new();
        for _ in 0..self.block_count()? {
            let block = self.block_header()?;
            let kind = element_type(self.cursor, block.kind)?;
            let group = self.content.entity_groups.get(&(block.dimension, block.entity));
            let group = group.copied().unwrap_or(NO_GROUP);
            for _ in 0..block.count {
                self.cursor.number(of_tag)?;
                nodes.clear();
                for _ in 0..kind.nodes {
                    nodes.push(self.cursor.count(of_tag)?);
                }
                self.content.push(kind, group, &nodes);
            }
        }
        Ok(())
    }
}
