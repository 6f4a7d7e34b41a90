//! The ray table as stages of a checkpoint.
//!
//! The ends of rays depend on the geometry, the extinctions and the lights of a scene alone, so a checkpoint also serves a scene with other
//! reflectances and albedos. The table is cut into stages of at most about [`STAGE_BYTES`], named `views-P-V-KIND-NUMBER` with P rays of a patch
//! and V of a volume zone; stages are traced several at a time, and an interrupted solve loses at most one a thread. A stage holds the ends (u32), the weights (f32, three a ray, or
//! none), and for each block of zones its path vertices.

use super::path_continuation::{PathVertex, ZONES_PER_BLOCK, vertex_index};
use super::ray_sampling::RaysPerZone;
use super::ray_tracer::FIRST_CODE;
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_scene::{Band, PerBand};

/// Most bytes of a stage, about: some seconds of work.
const STAGE_BYTES: usize = 64 << 20;
/// Least number of stages of many zones of a kind: ranks share the stages.
const MIN_STAGES: usize = 64;
/// Most bytes of a ray in a stage, without path vertices.
const RAY_BYTES: usize = 16;

/// Sizes by which a stage is checked.
#[derive(Clone, Copy)]
pub(crate) struct StageLimits {
    /// Rays of a block, except the last.
    pub rays_per_block: usize,
    /// Number of patches.
    pub patches: usize,
    /// Number of zones.
    pub zones: usize,
}

/// Zones of a stage, whole blocks, of `zones` zones of a kind with `rays` rays each.
pub(crate) fn zones_per_stage(zones: usize, rays: usize) -> usize {
    let blocks = STAGE_BYTES / (RAY_BYTES * ZONES_PER_BLOCK * rays.max(1));
    ZONES_PER_BLOCK * blocks.min(zones / (ZONES_PER_BLOCK * MIN_STAGES)).max(1)
}

/// Name of stage `number` of the patches (kind 0) or volume zones (kind 1).
pub(crate) fn stage_name(rays: RaysPerZone, kind: usize, number: usize) -> String {
    format!("views-{}-{}-{kind}-{number}", rays[0], rays[1])
}

/// Encodes ends, weights and the path vertices of every block.
pub(crate) fn encode(ends: &[u32], weights: &[PerBand<f32>], vertices: &[Vec<PathVertex>]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.words(ends.len(), ends.iter().copied());
    encoder.words(Band::count() * weights.len(), weights.iter().flatten().map(|w| w.to_bits()));
    encoder.int(vertices.len());
    for block in vertices {
        encoder.words(PathVertex::WORDS_PER_VERTEX * block.len(), block.iter().flat_map(PathVertex::words));
    }
    encoder.bytes()
}

/// Decodes a stage of [`encode`] into `ends` and `weights` and returns the path vertices of the blocks. `None` for other bytes; ends and
/// weights are then undefined.
pub(crate) fn decode(
    bytes: &[u8],
    ends: &mut [u32],
    weights: &mut [PerBand<f32>],
    limits: StageLimits,
) -> Option<Vec<Vec<PathVertex>>> {
    let mut r = Decoder::new(bytes);
    let end_words = r.words().filter(|w| w.len() == ends.len())?;
    let weight_words = r.words().filter(|w| w.len() == Band::count() * weights.len())?;
    let number = r.int().filter(|n| *n == ends.len().div_ceil(limits.rays_per_block))?;
    let vertices: Option<Vec<Vec<PathVertex>>> = (0..number)
        .map(|_| {
            let words = r.words()?;
            let (whole, rest) = words.as_chunks();
            let vertex = |w: &[[u8; 4]; PathVertex::WORDS_PER_VERTEX]| {
                PathVertex::from_words(w.map(u32::from_le_bytes))
            };
            rest.is_empty().then(|| whole.iter().map(vertex).collect())
        })
        .collect();
    let vertices = vertices.filter(|_| r.at_end())?;
    ends.iter_mut().zip(end_words).for_each(|(m, w)| *m = u32::from_le_bytes(*w));
    let flat = weights.iter_mut().flatten();
    flat.zip(weight_words).for_each(|(m, w)| *m = f32::from_bits(u32::from_le_bytes(*w)));
    let mut blocks = ends.chunks(limits.rays_per_block).zip(&vertices);
    blocks.all(|(ends, vertices)| references_are_valid(ends, vertices, limits)).then_some(vertices)
}

/// True where every zone and vertex referred to exists, and vertices refer to later ones only, so that no path is a cycle.
fn references_are_valid(ends: &[u32], vertices: &[PathVertex], limits: StageLimits) -> bool {
    let exists = |end: u32, after: usize| match vertex_index(end) {
        Some(v) => (after..vertices.len()).contains(&v),
        None => end >= FIRST_CODE || (end as usize) < limits.zones,
    };
    let valid = |(k, v): (usize, &PathVertex)| v.has_patch_below(limits.patches) && exists(v.next(), k + 1);
    ends.iter().all(|e| exists(*e, 0)) && vertices.iter().enumerate().all(valid)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decode_returns_an_encoded_stage_and_rejects_everything_else() {
        let vertex = |patch, next| PathVertex::from_words([patch, next, 7, 1, 2, 3, 4, 5, 6]);
        // Five rays in blocks of three; one path has two vertices.
        let first = 1 << 31;
        let ends = [2, first, FIRST_CODE, 0, 9];
        let weights = [0.1, 0.2, 0.3, 0.4, 0.5].map(|w: f32| PerBand::from_rgb([w, -0.0, 1.0]));
        let vertices = vec![vec![vertex(0, first | 1), vertex(1, 9)], Vec::new()];
        let bytes = encode(&ends, &weights, &vertices);
        let limits = |zones| StageLimits { rays_per_block: 3, patches: 2, zones };
        let read = |bytes: &[u8], zones: usize| {
            let (mut e, mut w) = ([0; 5], [PerBand::splat(0.0); 5]);
            decode(bytes, &mut e, &mut w, limits(zones)).map(|v| (e, w, encode(&e, &w, &v)))
        };
        let (e, w, encoded) = read(&bytes, 10).unwrap();
        assert!(e == ends && w == weights && encoded == bytes);
        assert!(w.iter().all(|w| w.into_rgb()[1].to_bits() == (-0.0f32).to_bits()));
        assert!(read(&bytes, 9).is_none(), "a zone that does not exist");
        assert!((0..bytes.len()).all(|cut| read(&bytes[..cut], 10).is_none()));
        let cycle = encode(&ends, &weights, &[vec![vertex(0, first), vertex(1, 9)], Vec::new()]);
        assert!(read(&cycle, 10).is_none(), "a vertex that refers to itself");
        let missing = encode(&ends, &weights, &[vec![vertex(0, first | 2), vertex(1, 9)], Vec::new()]);
        assert!(read(&missing, 10).is_none(), "a vertex that does not exist");
        let no_patch = encode(&ends, &weights, &[vec![vertex(2, 3), vertex(1, 9)], Vec::new()]);
        assert!(read(&no_patch, 10).is_none(), "a vertex on no patch");
        let short = (&mut [0; 5], &mut [PerBand::splat(0.0); 4]);
        assert!(decode(&bytes, short.0, short.1, limits(10)).is_none());
    }
}
