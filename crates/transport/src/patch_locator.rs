//! Point location: the piece of a subdivided plate that holds a point.
//!
//! Each base plate (one side of a facet, or a plate of a pane) has a grid of bins over its parameters (u, v); a bin lists the pieces
//! (patches, parts of panes) that overlap it. In a piece the point has the parameters M (u − u₀, v − v₀); each piece stores these
//! six numbers. Bins are about as large as the mean piece, so a long plate has more bins along its length. A query tests the few
//! pieces of one bin.

use zonal_math::Vec3;
use zonal_scene::{PaneZone, Patch, Plate, PlateKind, Scene, Zones};

/// Locates points among the pieces (patches, parts of panes) of base plates.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::Plate;
/// use zonal_transport::patch_locator::PatchLocator;
///
/// let base = Plate::parallelogram(Vec3::ZERO, vec3(2.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// let half = |x: f64| Plate::parallelogram(vec3(x, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// let pieces = [half(0.0), half(1.0)];
/// let locator = PatchLocator::new(&[base], pieces.iter().map(|p| (p, 0)));
/// assert_eq!(locator.locate(0, [0.25, 0.5]), Some(0));
/// assert_eq!(locator.locate(0, [0.75, 0.5]), Some(1));
/// ```
#[derive(Clone, Debug, Default)]
pub struct PatchLocator {
    base_plates: Vec<BasePlateBins>,
    /// First entry of every bin of all base plates, and the number of entries.
    bins: Vec<u32>,
    /// Pieces and their indices, bin by bin.
    entries: Vec<(PieceMap, u32)>,
}

/// The bins of one base plate.
#[derive(Clone, Copy, Debug, Default)]
struct BasePlateBins {
    /// Number of bins along both parameters; 0 without pieces.
    counts: [u32; 2],
    /// Index of the first bin.
    first: u32,
}

/// The map from the parameters of the base plate to those of a piece.
#[derive(Clone, Copy, Debug)]
struct PieceMap {
    at: [f32; 2],
    rows: [[f32; 2]; 2],
    kind: PlateKind,
}

/// A side of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FacetSide {
    /// The side of the normal.
    Front,
    /// The side opposite to the normal.
    Back,
}

impl FacetSide {
    /// The front where `front` holds, otherwise the back.
    pub(crate) fn front_if(front: bool) -> FacetSide {
        if front { FacetSide::Front } else { FacetSide::Back }
    }

    /// Number of this side of a facet: 2k is the front of facet k, 2k + 1 its back.
    pub fn of_facet(self, facet: usize) -> usize {
        2 * facet + usize::from(self == FacetSide::Back)
    }
}

/// The plates of the sides of all facets.
pub fn facet_sides(scene: &Scene) -> Vec<Plate> {
    scene.facets().iter().flat_map(|f| [f.plate, f.plate]).collect()
}

/// The side of a facet on which a patch lies.
pub fn side_of_patch(scene: &Scene, patch: &Patch) -> usize {
    let is_back = patch.normal.dot(scene.facets()[patch.facet].plate.normal()) < 0.0;
    FacetSide::front_if(!is_back).of_facet(patch.facet)
}

/// A locator of the patches on the sides of all facets.
pub fn facet_side_locator(scene: &Scene, zones: &Zones) -> PatchLocator {
    let pieces = zones.patches.iter().map(|p| (&p.plate, side_of_patch(scene, p)));
    PatchLocator::new(&facet_sides(scene), pieces)
}

/// The index of each pane's first plate among all pane plates, and a locator of the pieces of all panes.
pub fn pane_piece_locator(scene: &Scene, zones: &Zones) -> (Vec<usize>, PatchLocator) {
    let (first, plates, base_of) = pane_plates(scene, zones);
    let locator = PatchLocator::new(&plates, zones.panes.iter().map(|z| &z.plate).zip(base_of));
    (first, locator)
}

/// The index of each pane's first plate among all pane plates, the plates of all panes, and the plate from which each piece is cut.
pub fn pane_plates(scene: &Scene, zones: &Zones) -> (Vec<usize>, Vec<Plate>, Vec<usize>) {
    let (mut first, mut plates) = (Vec::new(), Vec::new());
    for pane in scene.panes() {
        first.push(plates.len());
        plates.extend(pane.plates.iter().copied());
    }
    let mut last = 0usize;
    let base_of = zones.panes.iter().map(|z| {
        let own = &scene.panes()[z.pane].plates;
        last = plate_of_piece(own, z, last.saturating_sub(first[z.pane])) + first[z.pane];
        last
    });
    let base_of = base_of.collect();
    (first, plates, base_of)
}

/// Distance of a piece's centre from its plate over the diameter of the piece, up to which the plate holds it.
const ON_PLATE_SHARE: f64 = 1e-7;

/// The plate from which a piece of a pane is cut: one near number `start` that holds its centre, since pieces follow the order of plates; otherwise the
/// nearest of all.
fn plate_of_piece(plates: &[Plate], piece: &PaneZone, start: usize) -> usize {
    let centre = piece.plate.centre();
    let distance = |plate: &Plate| {
        let [u, v] = clamped_parameters(plate, centre);
        (plate.at(u, v) - centre).length()
    };
    let near = ON_PLATE_SHARE * piece.plate.diameter();
    let next = (start..plates.len()).take(2).find(|&k| distance(&plates[k]) <= near);
    let nearest = || (0..plates.len()).min_by(|&a, &b| distance(&plates[a]).total_cmp(&distance(&plates[b])));
    next.or_else(nearest).unwrap_or(0)
}

/// Parameters of `point` on the plate, clamped to the plate.
pub fn clamped_parameters(plate: &Plate, point: Vec3) -> [f64; 2] {
    let [u, v] = plate.parameters(point).map(|x| x.clamp(0.0, 1.0));
    let over = u + v - 1.0;
    if plate.kind == PlateKind::Triangle && over > 0.0 {
        [(u - 0.5 * over).clamp(0.0, 1.0), (v - 0.5 * over).clamp(0.0, 1.0)]
    } else {
        [u, v]
    }
}

impl PieceMap {
    /// Placeholder that holds no point.
    const EMPTY_PIECE: PieceMap =
        PieceMap { at: [0.0; 2], rows: [[0.0; 2]; 2], kind: PlateKind::Parallelogram };

    fn new(plate: &Plate, base: &Plate) -> PieceMap {
        let at = base.parameters(plate.origin);
        let edge = |e: Vec3| {
            let p = base.parameters(plate.origin + e);
            [p[0] - at[0], p[1] - at[1]]
        };
        let (a, b) = (edge(plate.e1), edge(plate.e2));
        let det = a[0] * b[1] - a[1] * b[0];
        let over = |x: f64| if det != 0.0 { (x / det) as f32 } else { 0.0 };
        let rows = [[over(b[1]), over(-b[0])], [over(-a[1]), over(a[0])]];
        PieceMap { at: at.map(|x| x as f32), rows, kind: plate.kind }
    }

    /// Depth of a point of the base plate in the piece, in parameters of the piece; negative outside.
    fn depth(&self, uv: [f32; 2]) -> f32 {
        let d = [uv[0] - self.at[0], uv[1] - self.at[1]];
        let [s, t] = self.rows.map(|r| r[0] * d[0] + r[1] * d[1]);
        match self.kind {
            PlateKind::Parallelogram => s.min(t).min(1.0 - s).min(1.0 - t),
            PlateKind::Triangle => s.min(t).min(1.0 - s - t),
        }
    }
}

impl BasePlateBins {
    fn bin(&self, uv: [f64; 2]) -> [u32; 2] {
        let bin = |t: f64, count: u32| ((t.max(0.0) * count as f64) as u32).min(count.saturating_sub(1));
        [bin(uv[0], self.counts[0]), bin(uv[1], self.counts[1])]
    }
    fn index(&self, x: u32, y: u32) -> usize {
        (self.first + x * self.counts[1] + y) as usize
    }
}

impl PatchLocator {
    /// Builds the bins of `pieces`, each with its base plate, an index into `base_plates`.
    pub fn new<'p>(
        base_plates: &[Plate],
        pieces: impl Iterator<Item = (&'p Plate, usize)> + Clone,
    ) -> PatchLocator {
        let (bins_of, bin_count) = bin_grids(base_plates, pieces.clone());
        let for_each_bin = |plate: &Plate, base: usize, visit: &mut dyn FnMut(usize)| {
            let (lo, hi) = parameter_range(plate, &base_plates[base]);
            let bins = bins_of[base];
            let ([x0, y0], [x1, y1]) = (bins.bin(lo), bins.bin(hi));
            for x in x0..=x1 {
                for y in y0..=y1 {
                    visit(bins.index(x, y));
                }
            }
        };
        // Count the entries of each bin, then sum the counts up to offsets.
        let mut counts = vec![0u32; bin_count as usize + 1];
        for (plate, base) in pieces.clone() {
            for_each_bin(plate, base, &mut |bin| counts[bin + 1] += 1);
        }
        for b in 0..bin_count as usize {
            counts[b + 1] += counts[b];
        }
        // Fill in the entries, in the order of the pieces.
        let mut next = counts.clone();
        let mut entries = vec![(PieceMap::EMPTY_PIECE, 0); counts[bin_count as usize] as usize];
        for (i, (plate, base)) in pieces.clone().enumerate() {
            let piece = PieceMap::new(plate, &base_plates[base]);
            for_each_bin(plate, base, &mut |bin| {
                entries[next[bin] as usize] = (piece, i as u32);
                next[bin] += 1;
            });
        }
        PatchLocator { base_plates: bins_of, bins: counts, entries }
    }

    /// The piece that holds the point of base plate `base` with parameters `uv`. Where rounding leaves a gap: the nearest piece in
    /// its own parameters, first of the bin, then of the plate. `None` where the base plate has no pieces.
    pub fn locate(&self, base: usize, uv: [f64; 2]) -> Option<u32> {
        let bins = self.base_plates.get(base)?;
        if bins.counts[0] == 0 {
            return None;
        }
        let [x, y] = bins.bin(uv);
        let bin = bins.index(x, y);
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
        best.0.or_else(|| self.nearest_of_plate(bins, uv))
    }

    /// Loads into the cache the memory that [`PatchLocator::locate`] reads for these base plates and parameters; `places` is
    /// scratch.
    pub fn prefetch(&self, points: impl Iterator<Item = (usize, [f64; 2])>, places: &mut Vec<usize>) {
        places.clear();
        places.extend(points.map(|(base, uv)| {
            let bins = &self.base_plates[base];
            let [x, y] = bins.bin(uv);
            bins.index(x, y)
        }));
        for p in places.iter_mut() {
            *p = self.bins[*p] as usize;
        }
        let read = |p: &usize| self.entries.get(*p).map_or(0, |e| e.1);
        std::hint::black_box(places.iter().map(read).fold(0, |s, i| s ^ i));
    }

    /// The nearest piece of all bins of a base plate.
    fn nearest_of_plate(&self, bins: &BasePlateBins, uv: [f64; 2]) -> Option<u32> {
        let end = bins.index(bins.counts[0] - 1, bins.counts[1] - 1) + 1;
        let list = &self.entries[self.bins[bins.first as usize] as usize..self.bins[end] as usize];
        let depth = |e: &(PieceMap, u32)| e.0.depth(uv.map(|x| x as f32));
        list.iter().max_by(|a, b| depth(a).total_cmp(&depth(b))).map(|e| e.1)
    }
}

/// The grid of bins of every base plate, and the number of all bins: bins of about the mean extent of the pieces, at most four per
/// piece.
fn bin_grids<'p>(
    base_plates: &[Plate],
    pieces: impl Iterator<Item = (&'p Plate, usize)>,
) -> (Vec<BasePlateBins>, u32) {
    let mut sums = vec![(0usize, [0.0; 2]); base_plates.len()];
    for (plate, base) in pieces {
        let (lo, hi) = parameter_range(plate, &base_plates[base]);
        sums[base].0 += 1;
        (0..2).for_each(|k| sums[base].1[k] += hi[k] - lo[k]);
    }
    let (mut grids, mut bin_count) = (Vec::with_capacity(sums.len()), 0u32);
    for (n, extent) in sums {
        let count = |e: f64| if n == 0 { 0 } else { ((n as f64 / e).ceil() as u32).clamp(1, n as u32) };
        let mut counts = extent.map(count);
        // Slivers may lead to more bins than pieces.
        while counts[0] as u64 * counts[1] as u64 > 4 * n as u64 {
            counts = counts.map(|c| c.div_ceil(2));
        }
        grids.push(BasePlateBins { counts, first: bin_count });
        bin_count += counts[0] * counts[1];
    }
    (grids, bin_count)
}

/// Lowest and highest parameters of a piece on its base plate, widened by 10⁻⁷.
fn parameter_range(plate: &Plate, base: &Plate) -> ([f64; 2], [f64; 2]) {
    let (corners, n) = plate.corners();
    let (mut lo, mut hi) = ([1.0; 2], [0.0; 2]);
    for p in corners[..n].iter().map(|c| base.parameters(*c)) {
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
    use zonal_math::{low_discrepancy, vec3};

    #[test]
    fn locate_finds_the_piece_that_holds_the_point() {
        let tall = Plate::triangle(vec3(1.0, 0.0, 2.0), vec3(20.0, 1.0, 0.0), vec3(0.0, 0.3, 0.2));
        let wide = Plate {
            kind: PlateKind::Parallelogram,
            ..Plate::triangle(Vec3::ZERO, vec3(3.0, 0.0, 1.0), vec3(0.0, 2.0, 0.0))
        };
        let base_plates = [tall, wide];
        let mut pieces = Vec::new();
        for (base, plate) in base_plates.iter().enumerate() {
            let mut list = vec![*plate];
            for _ in 0..4 {
                list = list.iter().flat_map(|p| p.quarters()).collect();
            }
            pieces.extend(list.into_iter().map(|p| (p, base)));
        }
        let index = PatchLocator::new(&base_plates, pieces.iter().map(|(p, s)| (p, *s)));
        for k in 0..2000 {
            for (base, plate) in base_plates.iter().enumerate() {
                let [u, v] = plate.warp(low_discrepancy::r2(k, [0.2, 0.6]));
                let found = index.locate(base, [u, v]).map(|i| pieces[i as usize]).expect("a piece");
                assert_eq!(found.1, base);
                let [s, t] = clamped_parameters(&found.0, plate.at(u, v));
                assert!((found.0.at(s, t) - plate.at(u, v)).length() < 1e-5);
            }
        }
        assert_eq!(
            PatchLocator::new(&base_plates, pieces[..1].iter().map(|(p, s)| (p, *s))).locate(1, [0.5, 0.5]),
            None
        );
    }
}
