//! Batches of the computation as bytes, for checkpoints.

use crate::matrix::pairs::{PairExchange, TreatmentCounts};
use crate::sky::SkyExchange;
use zonal_math::{Bounded, Grade};

/// Bytes of a pair, of the counts, and of the surroundings of a facet.
const PAIR_BYTES: usize = 20;
const COUNT_BYTES: usize = 40;
const SURROUNDINGS_BYTES: usize = 46;

/// A batch of pairs: counts, then the pairs.
pub(crate) fn encode_pairs(counts: &TreatmentCounts, pairs: &[PairExchange]) -> Vec<u8> {
    let mut out = Vec::with_capacity(COUNT_BYTES + PAIR_BYTES * pairs.len());
    counts.numbers().iter().for_each(|n| out.extend(n.to_le_bytes()));
    for p in pairs {
        out.extend(p.i.to_le_bytes());
        out.extend(p.j.to_le_bytes());
        out.extend(p.value.to_le_bytes());
        out.extend(p.radius.to_le_bytes());
    }
    out
}

/// The batch, or None if the bytes are not one for `n` facets.
pub(crate) fn decode_pairs(bytes: &[u8], n: usize) -> Option<(TreatmentCounts, Vec<PairExchange>)> {
    let (head, body) = bytes.split_at_checked(COUNT_BYTES)?;
    if !body.len().is_multiple_of(PAIR_BYTES) {
        return None;
    }
    let number = |k: usize| head[8 * k..8 * k + 8].try_into().map(u64::from_le_bytes);
    let counts = TreatmentCounts::from_numbers([0, 1, 2, 3, 4].map(|k| number(k).unwrap_or(0)));
    let pair = |b: &[u8]| {
        let p = PairExchange {
            i: u32::from_le_bytes(b[0..4].try_into().ok()?),
            j: u32::from_le_bytes(b[4..8].try_into().ok()?),
            value: f64::from_le_bytes(b[8..16].try_into().ok()?),
            radius: f32::from_le_bytes(b[16..20].try_into().ok()?),
        };
        ((p.i as usize) < n && (p.j as usize) < n && p.value.is_finite()).then_some(p)
    };
    Some((counts, body.chunks_exact(PAIR_BYTES).map(pair).collect::<Option<_>>()?))
}

/// The surroundings of facets.
pub(crate) fn encode_surroundings(facets: &[(u32, SkyExchange)]) -> Vec<u8> {
    let mut out = Vec::with_capacity(SURROUNDINGS_BYTES * facets.len());
    for (f, s) in facets {
        out.extend(f.to_le_bytes());
        for b in [s.sky, s.ground] {
            out.extend(b.value.to_le_bytes());
            out.extend(b.radius.to_le_bytes());
            out.push(u8::from(b.grade != Grade::Proved));
        }
        out.extend(s.unresolved.to_le_bytes());
    }
    out
}

/// The surroundings, or None if the bytes are not those of some of `n` facets.
pub(crate) fn decode_surroundings(bytes: &[u8], n: usize) -> Option<Vec<(u32, SkyExchange)>> {
    if !bytes.len().is_multiple_of(SURROUNDINGS_BYTES) {
        return None;
    }
    let bounded = |b: &[u8]| {
        let value = f64::from_le_bytes(b[0..8].try_into().ok()?);
        let radius = f64::from_le_bytes(b[8..16].try_into().ok()?);
        Some(if b[16] == 0 { Bounded::proved(value, radius) } else { Bounded::estimated(value, radius) })
    };
    let facet = |b: &[u8]| {
        let f = u32::from_le_bytes(b[0..4].try_into().ok()?);
        let (sky, ground) = (bounded(&b[4..21])?, bounded(&b[21..38])?);
        let unresolved = f64::from_le_bytes(b[38..46].try_into().ok()?);
        ((f as usize) < n).then_some((f, SkyExchange { sky, ground, unresolved }))
    };
    bytes.chunks_exact(SURROUNDINGS_BYTES).map(facet).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_survive_their_bytes_and_damaged_ones_are_refused() {
        let pair = PairExchange { i: 3, j: 7, value: 0.1, radius: 1e-9 };
        let counts = TreatmentCounts::from_numbers([1, 2, 3, 4, 5]);
        let bytes = encode_pairs(&counts, &[pair, pair]);
        let (back, pairs) = decode_pairs(&bytes, 8).expect("a batch");
        assert_eq!((back.numbers(), pairs.len(), pairs[1].j), (counts.numbers(), 2, 7));
        assert!(decode_pairs(&bytes, 7).is_none() && decode_pairs(&bytes[1..], 8).is_none());
        let s = SkyExchange {
            sky: Bounded::proved(0.5, 1e-15),
            ground: Bounded::estimated(0.1, 1e-3),
            unresolved: 0.25,
        };
        let bytes = encode_surroundings(&[(2, s)]);
        let back = decode_surroundings(&bytes, 3).expect("surroundings");
        assert_eq!((back[0].0, back[0].1.sky, back[0].1.ground), (2, s.sky, s.ground));
        assert_eq!(back[0].1.unresolved, 0.25);
        assert!(decode_surroundings(&bytes, 2).is_none() && decode_surroundings(&bytes[2..], 3).is_none());
    }
}
