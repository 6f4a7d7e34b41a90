//! Which piece of a cut plate holds a point: pieces in bins over the plate's parameters.
//!
//! A point of a sheet with parameters (u, v) has in a piece the parameters M (u − u₀, v − v₀); each piece keeps these six numbers. Bins are about
//! as large as a piece in the mean, so that long sheets are cut along their length.

use zonal_math::Vec3;
use zonal_scene::{PaneZone, Plate, PlateKind, Scene, Zones};

/// Pieces (patches, parts of panes) by the sheet that they are cut from: one side of a facet, or a plate of a pane.
#[derive(Clone, Debug, Default)]
pub struct Sheets {
    sheets: Vec<Sheet>,
    /// First entry of every bin of all sheets, and the end.
    bins: Vec<u32>,
    /// Pieces and their numbers, bin by bin: those of a bin lie together.
    entries: Vec<(Piece, u32)>,
}

/// The bins of one sheet.
#[derive(Clone, Copy, Debug, Default)]
struct Sheet {
    /// Number along both parameters; none without pieces.
    sides: [u32; 2],
    /// Its first bin.
    first: u32,
}

/// A piece in the parameters of its sheet.
#[derive(Clone, Copy, Debug)]
struct Piece {
    at: [f32; 2],
    rows: [[f32; 2]; 2],
    kind: PlateKind,
}

/// The pieces of all panes by the plates from which they are cut; and the number of each pane's first plate.
pub fn of_panes(scene: &Scene, zones: &Zones) -> (Vec<usize>, Sheets) {
    let (first, plates, of) = pane_sheets(scene, zones);
    let sheets = Sheets::new(&plates, zones.panes.iter().map(|z| &z.plate).zip(of));
    (first, sheets)
}

/// The number of each pane's first plate, the plates of all panes, and the one from which each piece is cut.
pub fn pane_sheets(scene: &Scene, zones: &Zones) -> (Vec<usize>, Vec<Plate>, Vec<usize>) {
    let (mut first, mut plates) = (Vec::new(), Vec::new());
    for pane in scene.panes() {
        first.push(plates.len());
        plates.extend(pane.plates.iter().copied());
    }
    let of = |z: &PaneZone| {
        let centre = z.plate.centre();
        let distance = |plate: &Plate| {
            let [u, v] = plate.parameters(centre);
            let outside = |x: f64| (-x).max(x - 1.0).max(0.0);
            outside(u) + outside(v) + (plate.at(u, v) - centre).length()
        };
        let own = &scene.panes()[z.pane].plates;
        let best = (0..own.len()).min_by(|&a, &b| distance(&own[a]).total_cmp(&distance(&own[b])));
        first[z.pane] + best.unwrap_or(0)
    };
    let of = zones.panes.iter().map(of).collect();
    (first, plates, of)
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

impl Piece {
    /// Holds nothing.
    const NONE: Piece = Piece { at: [0.0; 2], rows: [[0.0; 2]; 2], kind: PlateKind::Parallelogram };

    fn new(plate: &Plate, sheet: &Plate) -> Piece {
        let at = sheet.parameters(plate.origin);
        let edge = |e: Vec3| {
            let p = sheet.parameters(plate.origin + e);
            [p[0] - at[0], p[1] - at[1]]
        };
        let (a, b) = (edge(plate.e1), edge(plate.e2));
        let det = a[0] * b[1] - a[1] * b[0];
        let over = |x: f64| if det != 0.0 { (x / det) as f32 } else { 0.0 };
        let rows = [[over(b[1]), over(-b[0])], [over(-a[1]), over(a[0])]];
        Piece { at: at.map(|x| x as f32), rows, kind: plate.kind }
    }

    /// How deep in it a point of the sheet lies, in its own parameters; negative outside.
    fn depth(&self, uv: [f32; 2]) -> f32 {
        let d = [uv[0] - self.at[0], uv[1] - self.at[1]];
        let [s, t] = self.rows.map(|r| r[0] * d[0] + r[1] * d[1]);
        match self.kind {
            PlateKind::Parallelogram => s.min(t).min(1.0 - s).min(1.0 - t),
            PlateKind::Triangle => s.min(t).min(1.0 - s - t),
        }
    }
}

impl Sheet {
    fn bin(&self, uv: [f64; 2]) -> [u32; 2] {
        let one = |t: f64, side: u32| ((t.max(0.0) * side as f64) as u32).min(side.saturating_sub(1));
        [one(uv[0], self.sides[0]), one(uv[1], self.sides[1])]
    }
    fn index(&self, x: u32, y: u32) -> usize {
        (self.first + x * self.sides[1] + y) as usize
    }
}

impl Sheets {
    /// Sorts `pieces`, each with its sheet, an index into `sheets`.
    pub fn new<'p>(sheets: &[Plate], pieces: impl Iterator<Item = (&'p Plate, usize)> + Clone) -> Sheets {
        let mut sums = vec![(0usize, [0.0; 2]); sheets.len()];
        for (plate, sheet) in pieces.clone() {
            let (lo, hi) = range(plate, &sheets[sheet]);
            sums[sheet].0 += 1;
            (0..2).for_each(|k| sums[sheet].1[k] += hi[k] - lo[k]);
        }
        let mut out = Sheets::default();
        let mut bins = 0u32;
        for (n, extent) in sums {
            let side = |e: f64| if n == 0 { 0 } else { ((n as f64 / e).ceil() as u32).clamp(1, n as u32) };
            let mut sides = extent.map(side);
            // Slivers may ask for more bins than there are pieces.
            while sides[0] as u64 * sides[1] as u64 > 4 * n as u64 {
                sides = sides.map(|s| s.div_ceil(2));
            }
            out.sheets.push(Sheet { sides, first: bins });
            bins += sides[0] * sides[1];
        }
        let mut counts = vec![0u32; bins as usize + 1];
        let each = |plate: &Plate, sheet: usize, sheets_of: &[Sheet], put: &mut dyn FnMut(usize)| {
            let (lo, hi) = range(plate, &sheets[sheet]);
            let s = sheets_of[sheet];
            let ([x0, y0], [x1, y1]) = (s.bin(lo), s.bin(hi));
            for x in x0..=x1 {
                for y in y0..=y1 {
                    put(s.index(x, y));
                }
            }
        };
        for (plate, sheet) in pieces.clone() {
            each(plate, sheet, &out.sheets, &mut |bin| counts[bin + 1] += 1);
        }
        for b in 0..bins as usize {
            counts[b + 1] += counts[b];
        }
        let mut at = counts.clone();
        out.entries = vec![(Piece::NONE, 0); counts[bins as usize] as usize];
        for (i, (plate, sheet)) in pieces.clone().enumerate() {
            let (entries, piece) = (&mut out.entries, Piece::new(plate, &sheets[sheet]));
            each(plate, sheet, &out.sheets, &mut |bin| {
                entries[at[bin] as usize] = (piece, i as u32);
                at[bin] += 1;
            });
        }
        out.bins = counts;
        out
    }

    /// The piece that holds the point of a sheet with parameters `uv`, or is nearest in its own measure among those about; `None` where the
    /// sheet has none.
    pub fn find(&self, sheet: usize, uv: [f64; 2]) -> Option<u32> {
        let s = self.sheets.get(sheet)?;
        if s.sides[0] == 0 {
            return None;
        }
        let [x, y] = s.bin(uv);
        let bin = s.index(x, y);
        let list = &self.entries[self.bins[bin] as usize..self.bins[bin + 1] as usize];
        if let [(_, only)] = list {
            return Some(*only);
        }
        let (uv32, mut best) = (uv.map(|x| x as f32), (None, f32::NEG_INFINITY));
        for (piece, i) in list {
            let depth = piece.depth(uv32);
            if depth >= 0.0 {
                return Some(*i);
            }
            if depth > best.1 {
                best = (Some(*i), depth);
            }
        }
        best.0.or_else(|| self.anywhere(s, uv))
    }

    /// Reads what [`Sheets::find`] will read of these sheets and parameters, all at once; `places` is scratch.
    pub fn fetch(&self, points: impl Iterator<Item = (usize, [f64; 2])>, places: &mut Vec<usize>) {
        places.clear();
        places.extend(points.map(|(sheet, uv)| {
            let s = &self.sheets[sheet];
            let [x, y] = s.bin(uv);
            s.index(x, y)
        }));
        for p in places.iter_mut() {
            *p = self.bins[*p] as usize;
        }
        let read = |p: &usize| self.entries.get(*p).map_or(0, |e| e.1);
        std::hint::black_box(places.iter().map(read).fold(0, |s, i| s ^ i));
    }

    /// The nearest piece of all bins of a sheet.
    fn anywhere(&self, s: &Sheet, uv: [f64; 2]) -> Option<u32> {
        let last = s.index(s.sides[0] - 1, s.sides[1] - 1) + 1;
        let list = &self.entries[self.bins[s.first as usize] as usize..self.bins[last] as usize];
        let depth = |e: &(Piece, u32)| e.0.depth(uv.map(|x| x as f32));
        list.iter().max_by(|a, b| depth(a).total_cmp(&depth(b))).map(|e| e.1)
    }
}

/// Lowest and highest parameters of a piece on its sheet, a little widened.
fn range(plate: &Plate, sheet: &Plate) -> ([f64; 2], [f64; 2]) {
    let (corners, n) = plate.corners();
    let (mut lo, mut hi) = ([1.0; 2], [0.0; 2]);
    for p in corners[..n].iter().map(|c| sheet.parameters(*c)) {
        for k in 0..2 {
            lo[k] = f64::min(lo[k], p[k] - 1e-7);
            hi[k] = f64::max(hi[k], p[k] + 1e-7);
        }
    }
    (lo, hi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{sequence, vec3};

    #[test]
    fn every_point_is_found_in_the_piece_that_holds_it() {
        let tall = Plate::triangle(vec3(1.0, 0.0, 2.0), vec3(20.0, 1.0, 0.0), vec3(0.0, 0.3, 0.2));
        let wide = Plate {
            kind: PlateKind::Parallelogram,
            ..Plate::triangle(Vec3::ZERO, vec3(3.0, 0.0, 1.0), vec3(0.0, 2.0, 0.0))
        };
        let sheets = [tall, wide];
        let mut pieces = Vec::new();
        for (sheet, plate) in sheets.iter().enumerate() {
            let mut list = vec![*plate];
            for _ in 0..4 {
                list = list.iter().flat_map(|p| p.quarters()).collect();
            }
            pieces.extend(list.into_iter().map(|p| (p, sheet)));
        }
        let index = Sheets::new(&sheets, pieces.iter().map(|(p, s)| (p, *s)));
        for k in 0..2000 {
            for (sheet, plate) in sheets.iter().enumerate() {
                let [u, v] = plate.warp(sequence::r2(k, [0.2, 0.6]));
                let found = index.find(sheet, [u, v]).map(|i| pieces[i as usize]).expect("a piece");
                assert_eq!(found.1, sheet);
                let [s, t] = onto(&found.0, plate.at(u, v));
                assert!((found.0.at(s, t) - plate.at(u, v)).length() < 1e-5);
            }
        }
        assert_eq!(Sheets::new(&sheets, pieces[..1].iter().map(|(p, s)| (p, *s))).find(1, [0.5, 0.5]), None);
    }
}
