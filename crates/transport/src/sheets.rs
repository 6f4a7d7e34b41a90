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
    /// Bins along both parameters.
    sides: [usize; 2],
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
        // Bins as large as a piece in the mean, so that long sheets are cut along their length.
        let mut extents = vec![[0.0; 2]; sheets.len()];
        for (plate, sheet) in pieces.clone() {
            let (lo, hi) = range(plate, &sheets[sheet]);
            (0..2).for_each(|k| extents[sheet][k] += hi[k] - lo[k]);
        }
        for (s, extent) in all.iter_mut().zip(extents) {
            let n = s.all.len();
            s.sides = extent.map(|e| if n == 0 { 0 } else { ((n as f64 / e).ceil() as usize).clamp(1, n) });
            s.bins = vec![Vec::new(); s.sides[0] * s.sides[1]];
        }
        for (i, (plate, sheet)) in pieces.enumerate() {
            all[sheet].put(i as u32, plate, &sheets[sheet]);
        }
        Sheets { sheets: all }
    }

    /// The piece that holds a point with the sheet's parameters `uv`, or lies nearest; `None` where the sheet has none.
    pub fn find<'p>(
        &self,
        sheet: usize,
        uv: [f64; 2],
        point: Vec3,
        plate: impl Fn(u32) -> &'p Plate,
    ) -> Option<u32> {
        let s = self.sheets.get(sheet)?;
        if s.all.is_empty() {
            return None;
        }
        let bin = &s.bins[s.bin(0, uv[0]) * s.sides[1] + s.bin(1, uv[1])];
        let list = if bin.is_empty() { &s.all } else { bin };
        let mut best = (*list.first()?, f64::INFINITY);
        for &i in list {
            let plate = plate(i);
            let [u, v] = plate.parameters(point);
            let inner = match plate.kind {
                PlateKind::Parallelogram => u.min(v).min(1.0 - u).min(1.0 - v),
                PlateKind::Triangle => u.min(v).min(1.0 - u - v),
            };
            if inner >= 0.0 {
                return Some(i);
            }
            let [a, b] = onto(plate, point);
            let away = (plate.at(a, b) - point).length2();
            if away < best.1 {
                best = (i, away);
            }
        }
        Some(best.0)
    }
}

/// Lowest and highest parameters of a piece on its sheet, a little widened.
fn range(plate: &Plate, sheet: &Plate) -> ([f64; 2], [f64; 2]) {
    let (corners, n) = plate.corners();
    let (mut lo, mut hi) = ([1.0; 2], [0.0; 2]);
    for p in corners[..n].iter().map(|c| sheet.parameters(*c)) {
        for k in 0..2 {
            lo[k] = f64::min(lo[k], p[k] - 1e-9);
            hi[k] = f64::max(hi[k], p[k] + 1e-9);
        }
    }
    (lo, hi)
}

impl Sheet {
    fn put(&mut self, piece: u32, plate: &Plate, sheet: &Plate) {
        let (lo, hi) = range(plate, sheet);
        for x in self.bin(0, lo[0])..=self.bin(0, hi[0]) {
            for y in self.bin(1, lo[1])..=self.bin(1, hi[1]) {
                self.bins[x * self.sides[1] + y].push(piece);
            }
        }
    }

    fn bin(&self, axis: usize, t: f64) -> usize {
        ((t.max(0.0) * self.sides[axis] as f64) as usize).min(self.sides[axis] - 1)
    }
}
