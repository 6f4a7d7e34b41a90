//! Small OpenVDB files made on the spot: one leaf of 8³ voxels at (0, 0, 0), one active tile of 8³ at (8, 0, 0).

use std::io::Write;

/// What a test may change.
pub(crate) struct Vdb {
    pub version: u32,
    pub kind: &'static str,
    /// 1 zip, 2 active values only, 4 Blosc.
    pub flags: u32,
    pub class: &'static str,
    pub map: (&'static str, Vec<f64>),
    pub background: f32,
    pub tile: f32,
    /// 512 values, x slowest; those above −1000 are active.
    pub leaf: Vec<f32>,
    /// The code of what is not active.
    pub code: u8,
}

impl Default for Vdb {
    fn default() -> Vdb {
        Vdb {
            version: 222,
            kind: "Tree_float_5_4_3",
            flags: 2,
            class: "fog volume",
            map: ("UniformScaleMap", [0.5; 15].to_vec()),
            background: 0.0,
            tile: 2.0,
            leaf: (0..512).map(|i| if i % 3 == 0 { -1000.0 } else { (i % 7) as f32 }).collect(),
            code: 0,
        }
    }
}

fn text(out: &mut Vec<u8>, s: &str) {
    out.extend((s.len() as u32).to_le_bytes());
    out.extend(s.bytes());
}

fn mask(out: &mut Vec<u8>, bits: usize, set: impl Fn(usize) -> bool) {
    out.extend((0..bits / 8).map(|b| (0..8).fold(0u8, |m, i| m | u8::from(set(8 * b + i)) << i)));
}

impl Vdb {
    /// Σ of the active values, each counted once a voxel.
    pub(crate) fn sum(&self) -> f64 {
        self.leaf.iter().filter(|v| **v > -1000.0).map(|v| f64::from(*v)).sum::<f64>()
            + 512.0 * f64::from(self.tile)
    }
    /// Values with what packs them.
    fn values(&self, out: &mut Vec<u8>, values: &[f32]) {
        let half = self.kind.ends_with("_HalfFloat");
        let double = self.kind.contains("double");
        if half && values.is_empty() {
            return;
        }
        let raw: Vec<u8> = values
            .iter()
            .flat_map(|v| match (half, double) {
                (true, _) => half_bits(*v).to_le_bytes().to_vec(),
                (_, true) => f64::from(*v).to_le_bytes().to_vec(),
                _ => v.to_le_bytes().to_vec(),
            })
            .collect();
        let packed = match self.flags & 5 {
            0 => {
                out.extend(raw);
                return;
            }
            1 => {
                let mut z = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                z.write_all(&raw).unwrap();
                z.finish().unwrap()
            }
            _ => {
                // One block, not split, not shuffled.
                let lz4 = lz4_flex::block::compress(&raw);
                let mut f = vec![2, 1, 16 | 1 << 5, 4];
                for n in [raw.len(), raw.len(), 24 + lz4.len(), 20, lz4.len()] {
                    f.extend((n as i32).to_le_bytes());
                }
                f.extend(lz4);
                f
            }
        };
        if packed.len() < raw.len() {
            out.extend((packed.len() as i64).to_le_bytes());
            out.extend(packed);
        } else {
            out.extend((-(raw.len() as i64)).to_le_bytes());
            out.extend(raw);
        }
    }
    fn wide(&self, out: &mut Vec<u8>, v: f32) {
        match self.kind.contains("double") {
            true => out.extend(f64::from(v).to_le_bytes()),
            false => out.extend(v.to_le_bytes()),
        }
    }
    /// A node's values, those of them that are active in `on`.
    fn node(&self, out: &mut Vec<u8>, all: &[f32], on: impl Fn(usize) -> bool) {
        out.push(self.code);
        if matches!(self.code, 2 | 4 | 5) {
            self.wide(out, 9.0);
        }
        if self.code == 5 {
            self.wide(out, 8.0);
        }
        if matches!(self.code, 3..=5) {
            mask(out, all.len(), |i| i % 2 == 0);
        }
        let partial = self.flags & 2 != 0 && self.code != 6;
        let kept: Vec<f32> =
            all.iter().enumerate().filter(|(i, _)| !partial || on(*i)).map(|(_, v)| *v).collect();
        self.values(out, &kept);
    }
    /// The file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut out = vec![0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];
        for n in [self.version, 1, 1] {
            out.extend(n.to_le_bytes());
        }
        out.push(1);
        out.extend([b'0'; 36]);
        out.extend(0u32.to_le_bytes());
        out.extend(1u32.to_le_bytes());
        text(&mut out, "density");
        text(&mut out, self.kind);
        text(&mut out, "");
        let table = out.len();
        out.extend([0; 24]);
        let start = out.len();
        out.extend(self.flags.to_le_bytes());
        out.extend(1u32.to_le_bytes());
        text(&mut out, "class");
        text(&mut out, "string");
        text(&mut out, self.class);
        text(&mut out, self.map.0);
        self.map.1.iter().for_each(|x| out.extend(x.to_le_bytes()));
        out.extend(1u32.to_le_bytes());
        self.wide(&mut out, self.background);
        for n in [0u32, 1, 0, 0, 0] {
            out.extend(n.to_le_bytes());
        }
        let none = |_: usize| false;
        mask(&mut out, 1 << 15, |i| i == 0);
        mask(&mut out, 1 << 15, none);
        self.node(&mut out, &vec![0.0; 1 << 15], none);
        mask(&mut out, 1 << 12, |i| i == 0);
        // (8, 0, 0) is child 16 · 16.
        let tile = |i: usize| i == 256;
        mask(&mut out, 1 << 12, tile);
        let mut tiles = vec![self.background; 1 << 12];
        tiles[256] = self.tile;
        self.node(&mut out, &tiles, tile);
        let active = |i: usize| self.leaf[i] > -1000.0;
        mask(&mut out, 512, active);
        let leaves = out.len();
        mask(&mut out, 512, active);
        self.node(&mut out, &self.leaf, active);
        for (k, n) in [start, leaves, out.len()].into_iter().enumerate() {
            out[table + 8 * k..][..8].copy_from_slice(&(n as i64).to_le_bytes());
        }
        out
    }
}

/// A half float of a small whole number or a half of one.
fn half_bits(v: f32) -> u16 {
    if v == 0.0 {
        return 0;
    }
    let bits = v.to_bits();
    ((bits >> 16 & 0x8000) | (((bits >> 23 & 255) + 15 - 127) << 10) | (bits >> 13 & 1023)) as u16
}
