//! STL in binary form: 84 bytes, then 50 for each facet.

use super::facets::{StlBuilder, UNNAMED_PART};
use crate::input::reading::error::FileFault;
use zonal_math::{Vec3, vec3};

/// Bytes before the number of facets.
const HEADER_BYTES: usize = 80;
/// Bytes before the first facet.
const FACETS_START: usize = HEADER_BYTES + 4;
/// Bytes of a facet.
const FACET_BYTES: usize = 50;

/// The number of facets that the bytes declare.
fn declared_count(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(HEADER_BYTES..FACETS_START)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]))
}

/// True if the length is that of a binary file of the declared number of facets.
pub(super) fn has_declared_length(bytes: &[u8]) -> bool {
    declared_count(bytes).is_some_and(|n| length_of(n) == bytes.len() as u64)
}

/// Length of a file of `count` facets, bytes.
fn length_of(count: u32) -> u64 {
    FACETS_START as u64 + FACET_BYTES as u64 * u64::from(count)
}

/// Reads all facets, as one part.
pub(super) fn read(file: &str, bytes: &[u8], builder: &mut StlBuilder) -> Result<(), FileFault> {
    let Some(count) = declared_count(bytes) else {
        let message = format!(
            "this is no STL: neither a text that begins with solid nor {FACETS_START} bytes of a binary header; export the mesh again"
        );
        return Err(FileFault::new(file, "", message));
    };
    let (wanted, found) = (length_of(count), bytes.len());
    if (found as u64) < wanted || count == 0 && found > FACETS_START {
        let message = format!(
            "{count} facets take {wanted} bytes, but the file has {found}; it is cut short or no STL: export the mesh again; a text begins with solid"
        );
        return Err(FileFault::new(file, format!("byte {HEADER_BYTES}"), message));
    }
    let excess = found as u64 - wanted;
    if excess > 0 {
        builder.note(format!("{file}: {excess} byte(s) behind the {count} declared facets were not read"));
    }
    let part = builder.part(UNNAMED_PART);
    let facets = bytes[FACETS_START..].as_chunks::<FACET_BYTES>().0;
    for (number, facet) in facets.iter().take(count as usize).enumerate() {
        let [normal, a, b, c] = [0, 1, 2, 3].map(|k| vector(facet, 12 * k));
        if let Some(k) = [a, b, c].iter().position(|p| !p.is_finite()) {
            let place = format!("byte {}", FACETS_START + FACET_BYTES * number + 12 * (k + 1));
            let message =
                format!("a corner of facet {} is not finite; mend it or export the mesh again", number + 1);
            return Err(FileFault::new(file, place, message));
        }
        builder.push(part, normal, [a, b, c]);
    }
    Ok(())
}

/// Three floats at a position.
fn vector(facet: &[u8; FACET_BYTES], at: usize) -> Vec3 {
    let float = |k: usize| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|i| facet[at + 4 * k + i])));
    vec3(float(0), float(1), float(2))
}
