//! Exchange of walls with walls, and the transforms along walls.
//!
//! Opposite walls: a two-dimensional convolution. Adjacent walls across axes a and b, with an edge along c: transforms along c, and for each
//! frequency a matrix Q(i_a, i_b) between the patches of the second wall at i_a cells from the first wall and those of the first wall at i_b cells from
//! the second. High walls follow by reversal R of an index, with the four columns (low, high, R low, R high) on the right of Q and of its transpose.
//! Slopes of the radiosity along the reversed index change their sign.
//!
//! ```text
//!     low_a  += Qᵀ low_b   + R Qᵀ high_b        high_a += Qᵀ R low_b + R Qᵀ R high_b        and the same with Q for b from a.
//! ```
//!
//! **Cost** for n² patches a wall and a constant basis: 280 n² log₂2n operations for transforms across walls; 32 n³ operations and 8 n³ B for each
//! pair of axes with adjacent walls, since each number of Q serves four complex columns on both sides.

use super::frequency_product::WallSpectra;
use super::line_exchange::{ZERO, times_i, times_minus_i};
use super::wall_sums::{BoxWall, walls};
use crate::device::basis::patch_axis;
use crate::device::grid::OTHER_AXES;
use crate::device::spectra::{GridSpectra, KernelSet, SpectrumHalf};
use crate::device::{GridPart, WallValues};
use crate::distribution::Blocks;
use crate::distribution::part_of;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;
use zonal_fourier::Complex64;
use zonal_fourier::{ComplexToReal, Fft, Planner, RealToComplex};
use zonal_math::parallel;
use zonal_math::simd::{self, LANES, complex_bytes, complex_bytes_mut};

/// Plans of the transforms along walls.
pub(super) struct WallConvolution<'a> {
    part: GridPart<'a>,
    forward: [Arc<dyn Fft<f64>>; 3],
    back: [Arc<dyn Fft<f64>>; 3],
    real: [Arc<dyn RealToComplex<f64>>; 3],
    unreal: [Arc<dyn ComplexToReal<f64>>; 3],
}

/// An edge as one of its two walls sees it.
#[derive(Clone, Copy)]
struct WallEdge {
    /// The axis that the wall stands across.
    a: usize,
    /// The axis along the edge.
    c: usize,
}

/// A component of the walls across axis `a`, transformed along the edge axis `c`.
#[derive(Clone, Copy)]
struct EdgeComponent {
    a: usize,
    c: usize,
    /// Number of the component.
    q: usize,
}

impl EdgeComponent {
    /// True for a slope along the edge, whose spectrum is multiplied by i.
    fn is_slope_along_edge(self) -> bool {
        patch_axis(self.a, self.q) == Some(self.c)
    }
}

/// Operations of the transforms of a number of a wall, and of the product of a number of opposite walls.
const TRANSFORM_OPERATIONS: usize = 40;
const OPPOSITE_OPERATIONS: usize = 8;

/// Real columns that one product of a matrix of adjacent walls serves: four complex ones.
type ReversedColumns = [f64; LANES];

impl<'a> WallConvolution<'a> {
    /// Plans for the part of a process.
    pub(super) fn new(part: GridPart<'a>) -> WallConvolution<'a> {
        let n = part.grid.lengths();
        let mut plans = Planner::default();
        WallConvolution {
            forward: n.map(|n| plans.forward(n)),
            back: n.map(|n| plans.inverse(n)),
            real: n.map(|n| plans.real_forward(n)),
            unreal: n.map(|n| plans.real_inverse(n)),
            part,
        }
    }

    /// About the operations of the transforms of a component of a wall.
    fn wall_operations(&self) -> usize {
        let [x, y, z] = self.part.grid.lengths();
        TRANSFORM_OPERATIONS * (x * y).max(y * z).max(x * z)
    }

    /// Number of stored frequencies along the second direction of a wall: half of them along z.
    fn stored_frequencies(&self, a: usize) -> usize {
        if a == 2 { self.part.grid.lengths()[1] } else { self.part.grid.halves()[2] }
    }

    /// The spectra of both walls across each axis; each rank transforms some walls.
    pub(super) fn spectra(&self, faces: &WallValues) -> [Option<WallSpectra>; 3] {
        let list = walls(&self.part.grid);
        let one = |w: usize| {
            let BoxWall { axis: a, side } = list[w];
            let mut out = Vec::new();
            for (q, face) in faces[a][side].chunks(self.part.grid.patches(a)).enumerate() {
                let mut spectrum = self.spectrum(a, face);
                if q > 0 {
                    times_i(&mut spectrum);
                }
                if q == 0 { out = spectrum } else { out.append(&mut spectrum) }
            }
            out
        };
        let length = |w: usize| self.part.order.patch_components() * self.spectrum_length(list[w].axis);
        let blocks = Blocks::new(self.part.slabs.communicator, list.len(), 1);
        let mut made = blocks.map_lists(self.part.slabs.communicator, length, one).into_iter();
        let mut out = [const { None }; 3];
        for a in self.part.grid.walled() {
            out[a] = made.next().zip(made.next()).map(|(low, high)| [low, high]);
        }
        out
    }

    /// Numbers of the spectrum of a component of a wall across `a`.
    fn spectrum_length(&self, a: usize) -> usize {
        self.stored_frequencies(a) * self.part.grid.lengths()[OTHER_AXES[a][0]]
    }

    /// The spectrum of one wall by `[f_c][f_b]`.
    fn spectrum(&self, a: usize, face: &[f64]) -> Vec<Complex64> {
        let ([b, c], n, l) = (OTHER_AXES[a], self.part.grid.cells, self.part.grid.lengths());
        let kept = self.stored_frequencies(a);
        let mut rows = vec![ZERO; n[b] * l[c]];
        for (row, cells) in rows.chunks_mut(l[c]).zip(face.chunks(n[c])) {
            row.iter_mut().zip(cells).for_each(|(r, x)| r.re = *x);
        }
        self.forward[c].process(&mut rows);
        let mut out = vec![ZERO; kept * l[b]];
        for (f, line) in out.chunks_mut(l[b]).enumerate() {
            (0..n[b]).for_each(|i| line[i] = rows[i * l[c] + f]);
        }
        self.forward[b].process(&mut out);
        out
    }

    /// The incident power of all walls: from the voxels, given as half sums of which twice the real part counts, of the walls that this rank completes
    /// (`from_voxels`); from opposite walls of spectra `sent`, and from adjacent walls.
    pub(super) fn incident(
        &self,
        k: &GridSpectra,
        faces: &WallValues,
        sent: &[Option<WallSpectra>; 3],
        from_voxels: Vec<(BoxWall, Vec<Complex64>)>,
    ) -> WallValues {
        let communicator = self.part.slabs.communicator;
        let one = |(wall, mut spectra): (BoxWall, Vec<Complex64>)| {
            let a = wall.axis;
            self.add_opposite(k, wall, sent, &mut spectra);
            let size = self.spectrum_length(a);
            let mut face = vec![0.0; self.part.order.patch_components() * self.part.grid.patches(a)];
            let parts = spectra.chunks_mut(size).zip(face.chunks_mut(self.part.grid.patches(a)));
            for (q, (spectrum, face)) in parts.enumerate() {
                if q > 0 {
                    times_minus_i(spectrum);
                }
                self.inverse_spectrum(a, spectrum, face);
            }
            face
        };
        let least = parallel::least_items(self.wall_operations());
        let own: Vec<Vec<f64>> = from_voxels.into_par_iter().with_min_len(least).map(one).collect();
        let list = walls(&self.part.grid);
        let length = |w: usize| self.part.order.patch_components() * self.part.grid.patches(list[w].axis);
        let all = Blocks::new(communicator, list.len(), 1).gather_lists(communicator, length, own);
        let mut walls = self.part.zero_walls();
        list.iter().zip(all).for_each(|(wall, face)| walls[wall.axis][wall.side] = face);
        self.add_adjacent(k, faces, &mut walls);
        walls
    }

    /// Transforms the spectrum of one wall back and adds it to its values.
    fn inverse_spectrum(&self, a: usize, spectrum: &mut [Complex64], face: &mut [f64]) {
        let ([b, c], n, l) = (OTHER_AXES[a], self.part.grid.cells, self.part.grid.lengths());
        self.back[b].process(spectrum);
        let mut rows = vec![ZERO; n[b] * l[c]];
        for (f, line) in spectrum.chunks(l[b]).enumerate() {
            (0..n[b]).for_each(|i| rows[i * l[c] + f] = line[i]);
        }
        self.back[c].process(&mut rows);
        for (row, cells) in rows.chunks(l[c]).zip(face.chunks_mut(n[c])) {
            cells.iter_mut().zip(row).for_each(|(x, r)| *x += 2.0 * r.re);
        }
    }

    /// Adds the radiation of the opposite wall to the spectra of a wall.
    fn add_opposite(
        &self,
        k: &GridSpectra,
        wall: BoxWall,
        sent: &[Option<WallSpectra>; 3],
        met: &mut [Complex64],
    ) {
        let BoxWall { axis: a, side } = wall;
        let Some(sent) = &sent[a] else { return };
        let [b, c] = OTHER_AXES[a];
        let (lb, hb, lc) =
            (self.part.grid.lengths()[b], self.part.grid.halves()[b], self.part.grid.lengths()[c]);
        let size = self.spectrum_length(a);
        for term in &k.opposite[a].terms {
            let array = &k.opposite[a].arrays[term.array];
            let from = sent[1 - side][term.q * size..(term.q + 1) * size].par_chunks(lb);
            let to = met[term.p * size..(term.p + 1) * size].par_chunks_mut(lb);
            to.zip(from).enumerate().with_min_len(parallel::least_items(OPPOSITE_OPERATIONS * lb)).for_each(
                |(f, (met, sent))| {
                    // Across z all frequencies are stored, with half of their weight; else half of them.
                    let weight = if a == 2 || f == 0 || 2 * f == lc { 0.5 } else { 1.0 };
                    let weight = weight * array.sign(c, SpectrumHalf::of(f, lc));
                    let kernel = &array.data[f.min(lc - f) * hb..(f.min(lc - f) + 1) * hb];
                    for (i, (m, s)) in met.iter_mut().zip(sent).enumerate() {
                        let sign = array.sign(b, SpectrumHalf::of(i, lb));
                        *m += s * (weight * sign * kernel[i.min(lb - i)]);
                    }
                },
            );
        }
    }

    /// The edges with their two walls each, in the order of the pairs of axes.
    fn edges(&self) -> Vec<WallEdge> {
        let of_pair = |[a, b]: [usize; 2]| [a, b].map(|across| WallEdge { a: across, c: 3 - a - b });
        self.part.grid.corners().flat_map(of_pair).collect()
    }

    /// Numbers of one frequency of a component along an edge: both sides of a wall across `a`.
    fn edge_line(&self, edge: WallEdge) -> usize {
        2 * self.part.grid.cells[3 - edge.a - edge.c]
    }

    /// Adds the exchange of adjacent walls. Each rank transforms some walls along their edges, and multiplies some frequencies.
    fn add_adjacent(&self, k: &GridSpectra, sent: &WallValues, met: &mut WallValues) {
        let (communicator, edges) = (self.part.slabs.communicator, self.edges());
        let (rank, ranks) = (self.part.slabs.rank(), self.part.slabs.ranks());
        let own: Vec<usize> = (rank..edges.len()).step_by(ranks).collect();
        let parts = self.part.order.patch_components();
        let components = |e: usize| (0..parts).map(move |q| (e, q));
        // Transform along the edges; slopes along them are multiplied by i.
        let one = |&(e, q): &(usize, usize)| {
            let WallEdge { a, c } = edges[e];
            self.along(EdgeComponent { a, c, q }, &sent[a])
        };
        let list: Vec<(usize, usize)> = own.iter().flat_map(|&e| components(e)).collect();
        let operations = self.wall_operations();
        let spectra: Vec<Vec<Complex64>> = parallel::collect_short(list.len(), operations, |k| one(&list[k]));
        // Bring the own frequencies of all walls here, multiply, and bring the products back.
        let from = self.to_frequencies(&edges, spectra);
        let to = self.adjacent_products(k, &edges, &from);
        let spectra = self.to_walls(&edges, to);
        let one = |k: usize| {
            let WallEdge { a, c } = edges[own[k]];
            let spectra = &spectra[k * parts..(k + 1) * parts];
            let size = parts * self.part.grid.patches(a);
            let mut faces = [(); 2].map(|()| vec![0.0; size]);
            for (q, spectra) in spectra.iter().enumerate() {
                self.inverse_along(EdgeComponent { a, c, q }, spectra, &mut faces);
            }
            faces.concat()
        };
        let added: Vec<Vec<f64>> = parallel::collect_short(own.len(), parts * operations, one);
        let length = |e: usize| 2 * parts * self.part.grid.patches(edges[e].a);
        let all = Blocks::new(communicator, edges.len(), 1).gather_lists(communicator, length, added);
        for (&WallEdge { a, .. }, added) in edges.iter().zip(&all) {
            for (face, added) in met[a].iter_mut().zip(added.chunks(parts * self.part.grid.patches(a))) {
                face.iter_mut().zip(added).for_each(|(x, y)| *x += y);
            }
        }
    }

    /// The own frequencies of the walls of all edges by edge and component, from all frequencies of the walls that this rank has transformed.
    fn to_frequencies(&self, edges: &[WallEdge], spectra: Vec<Vec<Complex64>>) -> Vec<Vec<Complex64>> {
        let (ranks, parts) = (self.part.slabs.ranks(), self.part.order.patch_components());
        if ranks == 1 {
            return spectra;
        }
        let own = (self.part.slabs.rank()..edges.len()).step_by(ranks).flat_map(|e| vec![e; parts]);
        let own: Vec<usize> = own.collect();
        let message = |rank: usize| {
            let mut bytes = Vec::new();
            for (&e, list) in own.iter().zip(&spectra) {
                bytes.extend_from_slice(complex_bytes(&list[self.edge_part(edges[e], rank)]));
            }
            bytes
        };
        let received = self.part.slabs.communicator.all_to_all((0..ranks).map(message).collect());
        let mut read: Vec<&[u8]> = received.iter().map(Vec::as_slice).collect();
        let list = (0..edges.len()).flat_map(|e| vec![e; parts]);
        let take = |e: usize| {
            let mut part = vec![ZERO; self.edge_part(edges[e], self.part.slabs.rank()).len()];
            let (bytes, rest) = read[e % ranks].split_at(16 * part.len());
            read[e % ranks] = rest;
            complex_bytes_mut(&mut part).copy_from_slice(bytes);
            part
        };
        list.map(take).collect()
    }

    /// The opposite way of [`WallConvolution::to_frequencies`].
    fn to_walls(&self, edges: &[WallEdge], products: Vec<Vec<Complex64>>) -> Vec<Vec<Complex64>> {
        let (ranks, parts) = (self.part.slabs.ranks(), self.part.order.patch_components());
        if ranks == 1 {
            return products;
        }
        let mut messages = vec![Vec::new(); ranks];
        for (i, product) in products.iter().enumerate() {
            messages[i / parts % ranks].extend_from_slice(complex_bytes(product));
        }
        let received = self.part.slabs.communicator.all_to_all(messages);
        let mut read: Vec<&[u8]> = received.iter().map(Vec::as_slice).collect();
        let own = (self.part.slabs.rank()..edges.len()).step_by(ranks).flat_map(|e| vec![e; parts]);
        let take = |e: usize| {
            let frequencies = self.part.grid.halves()[edges[e].c];
            let mut whole = vec![ZERO; self.edge_line(edges[e]) * frequencies];
            for rank in 0..ranks {
                let part = &mut whole[self.edge_part(edges[e], rank)];
                let (bytes, rest) = read[rank].split_at(16 * part.len());
                read[rank] = rest;
                complex_bytes_mut(part).copy_from_slice(bytes);
            }
            whole
        };
        own.map(take).collect()
    }

    /// The numbers of the frequencies of a rank along an edge.
    fn edge_part(&self, edge: WallEdge, rank: usize) -> Range<usize> {
        let (line, f) = (self.edge_line(edge), self.part.grid.halves()[edge.c]);
        let own = part_of(f, rank, self.part.slabs.ranks());
        own.start * line..own.end * line
    }

    /// The radiation of adjacent walls on each other at the own frequencies, by edge and component as `from`.
    fn adjacent_products(
        &self,
        k: &GridSpectra,
        edges: &[WallEdge],
        from: &[Vec<Complex64>],
    ) -> Vec<Vec<Complex64>> {
        let parts = self.part.order.patch_components();
        let mut to: Vec<Vec<Complex64>> = from.iter().map(|list| vec![ZERO; list.len()]).collect();
        for (i, pair) in self.part.grid.corners().enumerate() {
            let of = [2 * i, 2 * i + 1];
            let line = of.map(|e| self.edge_line(edges[e]));
            let from = of.map(|e| &from[e * parts..(e + 1) * parts]);
            let set = &k.adjacent[pair[0] + pair[1] - 1];
            let product = |f| simd::run(AdjacentWallProduct { set, pair, line, frequency: f, from });
            let operations = set.terms.len() * line[0] * line[1] * LANES;
            let products = parallel::collect_short(from[0][0].len() / line[0], operations, product);
            for (f, product) in products.iter().enumerate() {
                for w in [0, 1] {
                    let lists = to[of[w] * parts..].iter_mut().zip(product[w].chunks(line[w]));
                    lists.for_each(|(to, own)| to[f * line[w]..(f + 1) * line[w]].copy_from_slice(own));
                }
            }
        }
        to
    }

    /// A component of the walls transformed along the edge, by `[f][side][i]`, times i where it is a slope along the edge.
    fn along(&self, part: EdgeComponent, faces: &[Vec<f64>; 2]) -> Vec<Complex64> {
        let EdgeComponent { a, c, q } = part;
        let first = q * self.part.grid.patches(a);
        let (n, l, h) = (self.part.grid.cells, self.part.grid.lengths()[c], self.part.grid.halves()[c]);
        let i = 3 - a - c;
        let [step_i, step_c] = if i < c { [n[c], 1] } else { [1, n[i]] };
        let mut out = vec![ZERO; 2 * n[i] * h];
        let (mut line, mut spectrum) = (vec![0.0; l], vec![ZERO; h]);
        let mut scratch = self.real[c].make_scratch_vec();
        for (side, face) in faces.iter().enumerate() {
            for k in 0..n[i] {
                line.fill(0.0);
                (0..n[c]).for_each(|j| line[j] = face[first + k * step_i + j * step_c]);
                let done = self.real[c].process_with_scratch(&mut line, &mut spectrum, &mut scratch);
                assert!(done.is_ok(), "buffers of the plan's lengths");
                (0..h).for_each(|f| out[(f * 2 + side) * n[i] + k] = spectrum[f]);
            }
        }
        if part.is_slope_along_edge() {
            times_i(&mut out);
        }
        out
    }

    /// Transforms `spectra` of [`WallConvolution::along`] back and adds them to the walls.
    fn inverse_along(&self, part: EdgeComponent, spectra: &[Complex64], faces: &mut [Vec<f64>; 2]) {
        let EdgeComponent { a, c, q } = part;
        let slope = part.is_slope_along_edge();
        let first = q * self.part.grid.patches(a);
        let (n, l, h) = (self.part.grid.cells, self.part.grid.lengths()[c], self.part.grid.halves()[c]);
        let i = 3 - a - c;
        let [step_i, step_c] = if i < c { [n[c], 1] } else { [1, n[i]] };
        let (mut line, mut spectrum) = (vec![0.0; l], vec![ZERO; h]);
        let mut scratch = self.unreal[c].make_scratch_vec();
        for (side, face) in faces.iter_mut().enumerate() {
            for k in 0..n[i] {
                (0..h).for_each(|f| spectrum[f] = spectra[(f * 2 + side) * n[i] + k]);
                if slope {
                    times_minus_i(&mut spectrum);
                }
                spectrum[0].im = 0.0;
                if l.is_multiple_of(2) {
                    spectrum[h - 1].im = 0.0;
                }
                let done = self.unreal[c].process_with_scratch(&mut spectrum, &mut line, &mut scratch);
                assert!(done.is_ok(), "buffers of the plan's lengths");
                (0..n[c]).for_each(|j| face[first + k * step_i + j * step_c] += line[j]);
            }
        }
    }
}

/// One frequency of the walls across two axes that are adjacent to each other.
struct AdjacentWallProduct<'a> {
    /// Kernels by `[f][i_a][i_b]`.
    set: &'a KernelSet,
    /// The axes of the normals.
    pair: [usize; 2],
    /// Numbers of one frequency of a component: both sides of each.
    line: [usize; 2],
    frequency: usize,
    /// The components of each by `[f][side][i]`.
    from: [&'a [Vec<Complex64>]; 2],
}

impl simd::SimdKernel for AdjacentWallProduct<'_> {
    /// Incident power of each by `[component][side][i]`.
    type Output = [Vec<Complex64>; 2];
    #[inline(always)]
    fn evaluate(self) -> Self::Output {
        let (set, [nb, na]) = (self.set, self.line.map(|n| n / 2));
        let (of_a, of_b) = (self.reversed_columns(0), self.reversed_columns(1));
        let (mut sum_a, mut sum_b) = (vec![[0.0; LANES]; of_a.len()], vec![[0.0; LANES]; of_b.len()]);
        for term in &set.terms {
            let (of_a, of_b) = (&of_a[term.p * nb..][..nb], &of_b[term.q * na..][..na]);
            let (sum_a, sum_b) = (&mut sum_a[term.p * nb..][..nb], &mut sum_b[term.q * na..][..na]);
            let kernel = &set.arrays[term.array].data[self.frequency * na * nb..][..na * nb];
            for i in 0..na {
                let row = &kernel[i * nb..(i + 1) * nb];
                let (x, mut own) = (of_b[i], [0.0; LANES]);
                for j in 0..nb {
                    for l in 0..LANES {
                        sum_a[j][l] += row[j] * x[l];
                        own[l] += row[j] * of_a[j][l];
                    }
                }
                for l in 0..LANES {
                    sum_b[i][l] += own[l];
                }
            }
        }
        [self.unreversed(0, &sum_a), self.unreversed(1, &sum_b)]
    }
}

impl AdjacentWallProduct<'_> {
    /// The sign of a component under reversal: slopes along the reversed index change theirs.
    #[inline(always)]
    fn sign(&self, w: usize, component: usize) -> f64 {
        if patch_axis(self.pair[w], component) == Some(self.pair[1 - w]) { -1.0 } else { 1.0 }
    }

    /// (low, high, R low, R high) by `[component][i]`.
    #[inline(always)]
    fn reversed_columns(&self, w: usize) -> Vec<ReversedColumns> {
        let (line, n) = (self.line[w], self.line[w] / 2);
        let mut out = vec![[0.0; LANES]; self.from[w].len() * n];
        for (q, values) in self.from[w].iter().enumerate() {
            let (values, sign) = (&values[self.frequency * line..][..line], self.sign(w, q));
            for i in 0..n {
                let [low, high] = [values[i], values[n + i]];
                let [back_low, back_high] = [values[n - 1 - i] * sign, values[line - 1 - i] * sign];
                out[q * n + i] =
                    [low.re, low.im, high.re, high.im, back_low.re, back_low.im, back_high.re, back_high.im];
            }
        }
        out
    }

    /// Both sides by `[component][side][i]`, from the products with all four columns.
    #[inline(always)]
    fn unreversed(&self, w: usize, sums: &[ReversedColumns]) -> Vec<Complex64> {
        let (line, n) = (self.line[w], self.line[w] / 2);
        let mut out = vec![ZERO; 2 * sums.len()];
        for (q, (out, sums)) in out.chunks_exact_mut(line).zip(sums.chunks_exact(n)).enumerate() {
            let sign = self.sign(w, q);
            for i in 0..n {
                let (own, back) = (&sums[i], &sums[n - 1 - i]);
                out[i] = Complex64::new(own[0] + sign * back[2], own[1] + sign * back[3]);
                out[n + i] = Complex64::new(own[4] + sign * back[6], own[5] + sign * back[7]);
            }
        }
        out
    }
}
