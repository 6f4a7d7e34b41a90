//! Repair of checksums and lengths of mutated containers, so that mutations reach the code behind the container checks.

/// CRC-32 of zip and PNG.
fn crc(parts: &[&[u8]]) -> u32 {
    let mut crc = !0u32;
    for byte in parts.iter().flat_map(|p| p.iter()) {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = crc >> 1 ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    !crc
}

/// The little-endian 16-bit number at `at`.
fn read_u16(bytes: &[u8], at: usize) -> Option<usize> {
    let b: [u8; 2] = bytes.get(at..at + 2)?.try_into().ok()?;
    Some(u16::from_le_bytes(b) as usize)
}

/// The positions of a pattern.
fn find_all(bytes: &[u8], pattern: &[u8]) -> Vec<usize> {
    (0..bytes.len().saturating_sub(pattern.len() - 1)).filter(|i| bytes[*i..].starts_with(pattern)).collect()
}

/// Rewrites a zip of stored entries: an entry reaches from its local header to the next, regardless of its stated length. Byte arrays
/// (`|u1`) get the shape of their data. `None` where there is no entry.
pub fn repair_zip(bytes: &[u8]) -> Option<Vec<u8>> {
    let end = find_all(bytes, b"PK\x01\x02").first().copied().unwrap_or(bytes.len());
    let mut starts = find_all(&bytes[..end], b"PK\x03\x04");
    starts.push(end);
    let (mut out, mut directory, mut count) = (Vec::new(), Vec::new(), 0u16);
    for pair in starts.windows(2) {
        let entry = &bytes[pair[0]..pair[1]];
        let (Some(name), Some(extra)) = (read_u16(entry, 26), read_u16(entry, 28)) else { continue };
        let (Some(name), Some(data)) = (entry.get(30..30 + name), entry.get(30 + name + extra..)) else {
            continue;
        };
        let data = with_actual_shape(data);
        let mut common = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        common.extend(crc(&[&data]).to_le_bytes());
        common.extend((data.len() as u32).to_le_bytes());
        common.extend((data.len() as u32).to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        directory.extend(b"PK\x01\x02\x14\0");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend((out.len() as u32).to_le_bytes());
        directory.extend(name);
        out.extend(b"PK\x03\x04");
        out.extend(&common);
        out.extend(name);
        out.extend(&data);
        count = count.checked_add(1)?;
    }
    if count == 0 {
        return None;
    }
    let start = out.len() as u32;
    out.extend(&directory);
    out.extend(b"PK\x05\x06\0\0\0\0");
    out.extend([count, count].map(u16::to_le_bytes).as_flattened());
    out.extend((directory.len() as u32).to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0, 0]);
    Some(out)
}

/// An npy array of bytes with the shape of its data; any other entry unchanged.
fn with_actual_shape(data: &[u8]) -> Vec<u8> {
    let header = read_u16(data, 8).filter(|_| data.starts_with(b"\x93NUMPY\x01"));
    let Some(rest) = header.and_then(|n| data.get(10 + n..)) else { return data.to_vec() };
    if !find_all(&data[..data.len() - rest.len()], b"'|u1'").is_empty() {
        let mut text = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({},), }}", rest.len());
        while (10 + text.len() + 1) % 64 != 0 {
            text.push(' ');
        }
        text.push('\n');
        let length = (text.len() as u16).to_le_bytes();
        return [b"\x93NUMPY\x01\0", &length[..], text.as_bytes(), rest].concat();
    }
    data.to_vec()
}

/// A PNG with the checksums of its chunks corrected.
pub fn repair_png(bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let mut at = 8;
    while let Some(length) = out.get(at..at + 4) {
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let Some(end) = at.checked_add(8).and_then(|n| n.checked_add(length)).filter(|e| e + 4 <= out.len())
        else {
            break;
        };
        let sum = crc(&[&out[at + 4..end]]);
        out[end..end + 4].copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
    out
}
