//! Which piece of a cut plate holds a point: pieces in bins over the plate's parameters.

use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind};

/// Pieces (patches, parts of panes) by the sheet that they are cut from: one side of a facet, or a plate of a pane.
#[derive(Clone, Debug, Default)]
pub struct Sheets {
    sheets: Vec<Sheet>,
}

/// The pieces of one sheet.
#[derive(Clone, Debug, Default)]
struct Sheet {
    side: usize,
    bins: Vec<Vec<u32>>,
    all: Vec<u32>,
}

/// Parameters of `point` on the plate, moved onto it.
pub fn onto(plate: &Plate, point: Vec3) -> [f64; 2] {
    let [u, v] = plate.parameters(point).map(|x| x.clamp(0.0, 1.0));
    let over = u + v - 1.0;
    if plate.kind == PlateKind::Triangle && over > 0.0 {
        [(u - 0.5 * over).clamp(0.0, 1.0), (v - 0.5 * over).clamp(0.0, 1.0)]
    } else {
        [u, v]
    }
}

impl Sheets {
    /// Sorts `pieces`, each with its sheet, an index into `sheets`.
    pub fn new<'p>(sheets: &[Plate], pieces: impl Iterator<Item = (&'p Plate, usize)> + Clone) -> Sheets {
        let mut all = vec![Sheet::default(); sheets.len()];
        for (i, (_, sheet)) in pieces.clone().enumerate() {
            all[sheet].all.push(i as u32);
        }
        for s in &mut all {
            s.side = (s.all.len() as f64).sqrt().ceil() as usize;
            s.bins = vec![Vec::new(); s.side * s.side];
        }
        for (i, (plate, sheet)) in pieces.enumerate() {
            all[sheet].put(i as u32, plate, &sheets[sheet]);
        }
        Sheets { sheets: all }
    }

    /// The piece that holds a point with the sheet's parameters `uv` most deeply, or lies nearest; `None` where the sheet has none.
    pub fn find<'p>(
        &self,
        sheet: usize,
        uv: [f64; 2],
        point: Vec3,
        plate: impl Fn(u32) -> &'p Plate,
    ) -> Option<u32> {
        let s = self.sheets.get(sheet)?;
        if s.side == 0 {
            return None;
        }
        let bin = &s.bins[s.bin(uv[0]) * s.side + s.bin(uv[1])];
        let list = if bin.is_empty() { &s.all } else { bin };
        let mut best = (*list.first()?, f64::NEG_INFINITY);
        for &i in list {
            let d = depth(plate(i), point);
            if d > best.1 {
                best = (i, d);
            }
        }
        Some(best.0)
    }
}

/// How deep in a plate, in its parameters, a point lies; outside, minus its distance.
fn depth(plate: &Plate, point: Vec3) -> f64 {
    let [u, v] = plate.parameters(point);
    let inner = match plate.kind {
        PlateKind::Parallelogram => u.min(v).min(1.0 - u).min(1.0 - v),
        PlateKind::Triangle => u.min(v).min(1.0 - u - v),
    };
    if inner >= 0.0 {
        return inner;
    }
    let [a, b] = onto(plate, point);
    -(plate.at(a, b) - point).length()
}

impl Sheet {
    fn put(&mut self, piece: u32, plate: &Plate, sheet: &Plate) {
        let (corners, n) = plate.corners();
        let (mut lo, mut hi) = ([1.0; 2], [0.0; 2]);
        for p in corners[..n].iter().map(|c| sheet.parameters(*c)) {
            for k in 0..2 {
                lo[k] = f64::min(lo[k], p[k] - 1e-9);
                hi[k] = f64::max(hi[k], p[k] + 1e-9);
            }
        }
        for x in self.bin(lo[0])..=self.bin(hi[0]) {
            for y in self.bin(lo[1])..=self.bin(hi[1]) {
                self.bins[x * self.side + y].push(piece);
            }
        }
    }

    fn bin(&self, t: f64) -> usize {
        ((t.max(0.0) * self.side as f64) as usize).min(self.side - 1)
    }
}
