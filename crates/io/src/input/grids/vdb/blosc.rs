//! Blosc 1 frames with the codec LZ4, as OpenVDB writes them.
//!
//! | bytes | contents |
//! |---|---|
//! | 0, 1 | versions of the format and of the codec |
//! | 2 | flags: 1 bytes shuffled, 2 stored uncompressed, 4 bits shuffled, 16 blocks not split; 3 high bits the codec, 1 = LZ4 |
//! | 3 | bytes an element |
//! | 4..16 | bytes of data, bytes a block, bytes of the frame: three whole numbers |
//!
//! Then the offset of each block, four bytes each. A block is one stream, or one for each byte of an element: its length (four bytes),
//! then LZ4, or the plain bytes if the length is that of the data. Shuffled blocks hold all first bytes of their elements, then all
//! second ones, …; the remainder of the last element follows unshuffled.
//!
//! Reference: c-blosc 1.x, README_CHUNK_FORMAT.

/// Bytes of the header.
const HEADER_BYTES: usize = 16;
const FLAG_SHUFFLED: u8 = 1;
const FLAG_STORED: u8 = 2;
const FLAG_BIT_SHUFFLED: u8 = 4;
const FLAG_NOT_SPLIT: u8 = 16;
/// Number of the codec LZ4.
const CODEC_LZ4: u8 = 1;
/// Largest element, bytes, whose blocks are split.
const MAX_SPLITS: usize = 16;
/// Smallest stream of a split block, bytes.
const MIN_STREAM_BYTES: usize = 128;

/// The `size` bytes of a frame; refuses a damaged frame and another number of bytes. Memory: at most twice `size`.
pub(crate) fn decode(frame: &[u8], size: usize) -> Result<Vec<u8>, &'static str> {
    const DAMAGED: &str = "this Blosc frame is damaged";
    let number = |at: usize| -> Option<usize> {
        let b = frame.get(at..at + 4)?;
        usize::try_from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])).ok()
    };
    let (Some(&flags), Some(&element)) = (frame.get(2), frame.get(3)) else {
        return Err(DAMAGED);
    };
    let (bytes, block) = (number(4).ok_or(DAMAGED)?, number(8).ok_or(DAMAGED)?);
    let element = usize::from(element).max(1);
    if bytes != size {
        return Err("this Blosc frame holds another number of values than its node");
    }
    if flags & FLAG_STORED != 0 {
        return Ok(frame.get(HEADER_BYTES..HEADER_BYTES + size).ok_or(DAMAGED)?.to_vec());
    }
    if flags >> 5 != CODEC_LZ4 || flags & FLAG_BIT_SHUFFLED != 0 {
        return Err("this Blosc frame is not LZ4 with shuffled bytes, which is all that is read");
    }
    if block == 0 && size > 0 {
        return Err(DAMAGED);
    }
    let mut out = vec![0; size];
    let mut scratch = Vec::new();
    for (k, part) in out.chunks_mut(block.max(1)).enumerate() {
        let at = number(HEADER_BYTES + 4 * k).ok_or(DAMAGED)?;
        let split = flags & FLAG_NOT_SPLIT == 0
            && element <= MAX_SPLITS
            && block / element >= MIN_STREAM_BYTES
            && part.len() == block;
        let streams = if split { element } else { 1 };
        if flags & FLAG_SHUFFLED == 0 || element == 1 {
            decode_block(frame, at, streams, part).ok_or(DAMAGED)?;
        } else {
            scratch.resize(part.len(), 0);
            decode_block(frame, at, streams, &mut scratch).ok_or(DAMAGED)?;
            unshuffle(&scratch, element, part);
        }
    }
    Ok(out)
}

/// Decodes the streams of a block, one after the other.
fn decode_block(frame: &[u8], mut at: usize, streams: usize, out: &mut [u8]) -> Option<()> {
    let each = out.len() / streams;
    if each * streams != out.len() {
        return None;
    }
    for part in out.chunks_mut(each.max(1)) {
        let b = frame.get(at..at.checked_add(4)?)?;
        let length = usize::try_from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])).ok()?;
        let stream = frame.get(at + 4..(at + 4).checked_add(length)?)?;
        at += 4 + length;
        if length == part.len() {
            part.copy_from_slice(stream);
        } else if lz4_flex::block::decompress_into(stream, part).ok()? != part.len() {
            return None;
        }
    }
    Some(())
}

fn unshuffle(shuffled: &[u8], element: usize, out: &mut [u8]) {
    let n = out.len() / element;
    let (whole, rest) = shuffled.split_at(n * element);
    for (i, e) in out.chunks_exact_mut(element).enumerate() {
        for (k, b) in e.iter_mut().enumerate() {
            *b = whole[k * n + i];
        }
    }
    out[n * element..].copy_from_slice(rest);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of `data` with these flags and blocks of `block` bytes; streams that do not shrink are stored.
    fn frame(data: &[u8], flags: u8, element: usize, block: usize) -> Vec<u8> {
        let mut out = vec![2, 1, flags | CODEC_LZ4 << 5, element as u8];
        for n in [data.len(), block, 0] {
            out.extend((n as i32).to_le_bytes());
        }
        let blocks: Vec<&[u8]> = data.chunks(block).collect();
        out.resize(HEADER_BYTES + 4 * blocks.len(), 0);
        for (k, part) in blocks.iter().enumerate() {
            let at = out.len() as i32;
            out[HEADER_BYTES + 4 * k..][..4].copy_from_slice(&at.to_le_bytes());
            let n = part.len() / element;
            let mut bytes = part.to_vec();
            if flags & FLAG_SHUFFLED != 0 {
                (0..n * element).for_each(|i| bytes[i % element * n + i / element] = part[i]);
            }
            let split =
                flags & FLAG_NOT_SPLIT == 0 && block / element >= MIN_STREAM_BYTES && part.len() == block;
            for stream in bytes.chunks(if split { block / element } else { bytes.len() }) {
                let packed = lz4_flex::block::compress(stream);
                let kept = if packed.len() < stream.len() { &packed } else { stream };
                out.extend((kept.len() as i32).to_le_bytes());
                out.extend(kept);
            }
        }
        out
    }

    #[test]
    fn frames_of_all_flags_round_trip() {
        let data: Vec<u8> = (0..5002u32).map(|i| (i * i / 977 % 251) as u8).collect();
        for flags in [0, FLAG_SHUFFLED, FLAG_NOT_SPLIT, FLAG_SHUFFLED | FLAG_NOT_SPLIT] {
            for (element, block) in [(2, 5002), (4, 1024), (2, 512), (1, 300), (8, 96), (4, 2048)] {
                let f = frame(&data, flags, element, block);
                assert!(decode(&f, data.len()).is_ok_and(|d| d == data), "{flags} {element} {block}");
                for k in 0..64 {
                    assert!(decode(&f[..f.len() * k / 64], data.len()).is_err(), "{k}");
                }
                assert!(decode(&f, 4).is_err());
            }
        }
        let mut stored = frame(&data, FLAG_STORED, 4, 5002);
        stored.truncate(HEADER_BYTES);
        stored.extend(&data);
        assert!(decode(&stored, data.len()).is_ok_and(|d| d == data));
    }

    #[test]
    fn frames_of_other_codecs_are_refused() {
        let mut f = frame(&[7; 512], 0, 4, 512);
        f[2] = 4 << 5;
        assert!(decode(&f, 512).is_err_and(|e| e.contains("LZ4")));
    }
}
