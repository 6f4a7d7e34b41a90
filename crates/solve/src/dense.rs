//! The dense engine: the exchange of every pair of zones, each computed once.
//!
//! Bands whose extinction is the same everywhere share one matrix; rows of panes differ in every band and are last, so they are
//! kept a band. Memory: 8 bytes × n(n+1)/2 a distinct band, and a byte × n(n+1)/2 for the errors.

use crate::columns::times;
use crate::operator::{Arriving, Operator};
use crate::packed::{Packed, stored};
use crate::radii::{Radii, step};
use crate::stage::{Pen, Reader};
use rayon::prelude::*;
use zonal_exchange::pair::{Counts, Exchange};
use zonal_math::Grade;
use zonal_scene::{Bands, Progress, Scene, Vault, Zones, bands};

/// Every pair of zones.
pub struct Dense {
    n: usize,
    /// Zones before the panes.
    shared: usize,
    /// One matrix a group of bands with equal extinctions, over patches and voxels.
    matrices: Vec<Packed>,
    /// The matrix of a band.
    group: [usize; 3],
    /// Rows of the panes over all zones up to and including themselves: `panes[b][k][j]`.
    panes: [Vec<Vec<f64>>; 3],
    /// d of g'_ij = d_i g_ij d_j, where closure was restored: bands that share a matrix have their own.
    scaling: Option<Vec<Bands>>,
    /// Error radii of the pairs, those of the worst band.
    radii: Radii,
    grade: Grade,
}

/// Chunks of rows of the assembly; fixed, so that sums are the same for any number of threads.
const CHUNKS: usize = 256;

/// Columns and bands that one product serves at once.
const WIDTHS: [usize; 5] = [12, 6, 3, 2, 1];

/// Groups of bands that share all their factors outside the panes.
pub fn groups(scene: &Scene, panes_between: bool) -> ([usize; 3], usize) {
    let same = |a: usize, b: usize| {
        let media =
            scene.voxmap().is_none_or(|v| (0..v.len()).all(|c| v.extinction(c)[a] == v.extinction(c)[b]));
        media && (!panes_between || scene.panes().iter().all(|p| p.extinction[a] == p.extinction[b]))
    };
    let mut group = [0; 3];
    let mut count = 1;
    for b in 1..3 {
        group[b] = match (0..b).find(|&a| same(a, b)) {
            Some(a) => group[a],
            None => {
                count += 1;
                count - 1
            }
        };
    }
    (group, count)
}

/// The first band of each group.
pub fn leads((group, count): ([usize; 3], usize)) -> Vec<usize> {
    (0..count).map(|g| group.iter().position(|&x| x == g).unwrap_or(0)).collect()
}

/// Bytes that the matrices of `zones` zones, `panes` of them panes, need with so many groups of bands.
pub fn bytes(zones: usize, panes: usize, groups: usize) -> u64 {
    let shared = stored(zones - panes) as u64 * groups as u64;
    let rows = 3 * panes as u64 * zones as u64;
    8 * (shared + rows) + stored(zones) as u64
}

/// What one chunk of rows yields beside its entries.
#[derive(Default)]
struct Chunk {
    counts: Counts,
    panes: Vec<Vec<Bands>>,
    /// Steps of the radii, row by row.
    steps: Vec<u8>,
}

impl Chunk {
    /// The chunk and its entries as a stage.
    fn kept(&self, rows: &[Vec<&mut [f64]>]) -> Vec<u8> {
        let c = &self.counts;
        let mut pen = Pen::default();
        pen.ints(&[
            c.aligned,
            c.paper,
            c.general,
            c.estimated,
            c.cut,
            c.pane,
            c.facing_away,
            c.partial,
            c.rays,
        ]);
        rows.iter().flatten().for_each(|row| pen.reals(row));
        pen.int(self.panes.len());
        self.panes.iter().for_each(|row| pen.triples(row));
        pen.raw(&self.steps);
        pen.bytes()
    }
    /// The chunk that [`Chunk::kept`] wrote, its entries put into the rows.
    fn restored(bytes: &[u8], rows: &mut [Vec<&mut [f64]>], first: usize) -> Option<Chunk> {
        let mut r = Reader::new(bytes);
        let [aligned, paper, general, estimated, cut, pane, facing_away, partial, rays] = r.ints()?[..]
        else {
            return None;
        };
        let counts = Counts { aligned, paper, general, estimated, cut, pane, facing_away, partial, rays };
        for row in rows.iter_mut().flatten() {
            let kept = r.reals().filter(|k| k.len() == row.len())?;
            row.copy_from_slice(&kept);
        }
        let panes: Option<Vec<Vec<Bands>>> = (0..r.int()?).map(|_| r.triples()).collect();
        let panes = panes?;
        // Rows of panes are the last ones, each as long as its number says.
        let offset = first + rows.len() - panes.len().min(rows.len());
        let fit =
            panes.len() <= rows.len() && panes.iter().enumerate().all(|(k, p)| p.len() == offset + k + 1);
        let steps = r.raw()?.to_vec();
        let pairs = stored(first + rows.len()) - stored(first);
        (r.at_end() && fit && steps.len() == pairs).then_some(Chunk { counts, panes, steps })
    }
}

impl Dense {
    /// Computes every pair, counted by method; every chunk of rows is a stage, `rows-…`, that `vault` may keep.
    pub fn assemble(
        exchange: &Exchange,
        zones: &Zones,
        (group, count): ([usize; 3], usize),
        vault: &dyn Vault,
        progress: &dyn Progress,
    ) -> (Dense, Counts) {
        let (n, shared) = (zones.len(), zones.pane_offset());
        let lead = leads((group, count));
        let mut matrices: Vec<Packed> = (0..count).map(|_| Packed::zeros(shared)).collect();
        let mut slots: Vec<Vec<&mut [f64]>> = (0..n).map(|_| Vec::with_capacity(count)).collect();
        for m in &mut matrices {
            for (i, row) in m.rows_mut().into_iter().enumerate() {
                slots[i].push(row);
            }
        }
        progress.begin("exchange areas", stored(n) as u64);
        let panes_of = |first: usize, rows: usize| (first + rows).saturating_sub(shared).min(rows);
        let fill = |(first, rows): (usize, &mut [Vec<&mut [f64]>])| {
            let stage = format!("rows-{first}");
            let kept = vault.load(&stage).and_then(|b| Chunk::restored(&b, rows, first));
            if let Some(chunk) = kept.filter(|c| c.panes.len() == panes_of(first, rows.len())) {
                (first..first + rows.len()).for_each(|i| progress.advance(i as u64 + 1));
                return chunk;
            }
            let mut chunk = Chunk::default();
            for (k, row) in rows.iter_mut().enumerate() {
                let i = first + k;
                let mut pane = Vec::new();
                let pairs = exchange.row(i);
                for j in 0..=i {
                    let f = exchange.pair_in(&pairs, j, &mut chunk.counts);
                    if i < shared {
                        for (r, &b) in row.iter_mut().zip(&lead) {
                            r[j] = f.value[b];
                        }
                    } else {
                        pane.push(f.value);
                    }
                    chunk.steps.push(step(f.radius.into_iter().fold(0.0, f64::max)));
                }
                if i >= shared {
                    chunk.panes.push(pane);
                }
                progress.advance(i as u64 + 1);
            }
            if vault.keeps() {
                vault.save(&stage, &chunk.kept(rows));
            }
            chunk
        };
        let chunks: Vec<Chunk> = cut(&mut slots, n).into_par_iter().with_max_len(1).map(fill).collect();
        progress.end();
        let mut counts = Counts::default();
        let mut steps = Vec::with_capacity(stored(n));
        let mut panes = [const { Vec::new() }; 3];
        // Back into the order of the rows.
        for c in chunks.into_iter().rev() {
            counts.merge(c.counts);
            steps.extend(&c.steps);
            for row in &c.panes {
                (0..3).for_each(|b| panes[b].push(row.iter().map(|x| x[b]).collect()));
            }
        }
        let grade = if counts.all_proved() { Grade::Proved } else { Grade::Estimated };
        let radii = Radii::new(n, steps);
        (Dense { n, shared, matrices, group, panes, scaling: None, radii, grade }, counts)
    }

    /// Exchange factor g_ij in band `b`, scaling included.
    pub fn factor(&self, i: usize, j: usize, b: usize) -> f64 {
        let (i, j) = if i >= j { (i, j) } else { (j, i) };
        let g = if i < self.shared {
            self.matrices[self.group[b]].get(i, j)
        } else {
            self.panes[b][i - self.shared][j]
        };
        self.scaling.as_ref().map_or(g, |d| d[i][b] * g * d[j][b])
    }

    /// Every matrix reads its entries once for as many columns and bands as it serves, a dozen at a time.
    fn apply_shared(&self, x: &[&[Bands]], out: &mut [Vec<Bands>]) {
        for (g, m) in self.matrices.iter().enumerate() {
            let bands_of = (0..3).filter(|&b| self.group[b] == g);
            let list: Vec<(usize, usize)> =
                bands_of.flat_map(|b| (0..x.len()).map(move |c| (c, b))).collect();
            let mut rest = &list[..];
            while !rest.is_empty() {
                let k = WIDTHS.into_iter().find(|&k| k <= rest.len()).unwrap_or(1);
                let (now, later) = rest.split_at(k);
                match k {
                    12 => self.block::<12>(m, x, now, out),
                    6 => self.block::<6>(m, x, now, out),
                    3 => self.block::<3>(m, x, now, out),
                    2 => self.block::<2>(m, x, now, out),
                    _ => self.block::<1>(m, x, now, out),
                }
                rest = later;
            }
        }
    }

    /// One product for `K` pairs of column and band.
    fn block<const K: usize>(
        &self,
        m: &Packed,
        x: &[&[Bands]],
        list: &[(usize, usize)],
        out: &mut [Vec<Bands>],
    ) {
        let gathered: Vec<[f64; K]> =
            (0..self.shared).map(|i| std::array::from_fn(|k| x[list[k].0][i][list[k].1])).collect();
        for (i, y) in m.apply(&gathered).iter().enumerate() {
            (0..K).for_each(|k| out[list[k].0][i][list[k].1] = y[k]);
        }
    }

    fn apply_slices(&self, columns: &[&[Bands]]) -> Vec<Vec<Bands>> {
        assert!(columns.iter().all(|s| s.len() == self.n));
        let scaled: Option<Vec<Vec<Bands>>> =
            self.scaling.as_ref().map(|d| columns.iter().map(|s| times(s, d)).collect());
        let x: Vec<&[Bands]> = match &scaled {
            Some(s) => s.iter().map(Vec::as_slice).collect(),
            None => columns.to_vec(),
        };
        let mut out = vec![vec![[0.0; 3]; self.n]; columns.len()];
        self.apply_shared(&x, &mut out);
        for (x, out) in x.iter().zip(&mut out) {
            self.apply_panes(x, out);
        }
        match &self.scaling {
            Some(d) => out.iter().map(|o| times(o, d)).collect(),
            None => out,
        }
    }

    fn apply_panes(&self, x: &[Bands], out: &mut [Bands]) {
        for b in 0..3 {
            for (k, row) in self.panes[b].iter().enumerate() {
                let i = self.shared + k;
                let mut own = row[i] * x[i][b];
                for j in 0..i {
                    own += row[j] * x[j][b];
                    out[j][b] += row[j] * x[i][b];
                }
                out[i][b] += own;
            }
        }
    }
}

/// Cuts the rows into chunks of about equal numbers of entries: (first row, rows).
fn cut<'a, 'b>(slots: &'a mut [Vec<&'b mut [f64]>], n: usize) -> Vec<(usize, &'a mut [Vec<&'b mut [f64]>])> {
    let mut rest = slots;
    let mut out = Vec::new();
    let mut first = 0;
    for c in 1..=CHUNKS {
        let end = if c == CHUNKS { n } else { (n as f64 * (c as f64 / CHUNKS as f64).sqrt()) as usize };
        if end > first {
            let (head, tail) = std::mem::take(&mut rest).split_at_mut(end - first);
            out.push((first, head));
            rest = tail;
            first = end;
        }
    }
    // The long rows first, so that what is left at the end is short.
    out.reverse();
    out
}

impl Operator for Dense {
    fn len(&self) -> usize {
        self.n
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        self.apply_slices(&[s]).pop().unwrap_or_default()
    }
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        Some(self.radii.spread(strengths))
    }
    fn arriving(&self, columns: &[Vec<Bands>]) -> Arriving {
        // Errors are put together with the defects of the rows, group by group.
        Arriving { columns: self.apply_many(columns), error: None }
    }
    fn apply_many(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        self.apply_slices(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }
    fn scale(&mut self, d: &[Bands]) {
        let old = self.scaling.take();
        self.scaling = Some(match old {
            Some(o) => o.iter().zip(d).map(|(o, d)| bands(|b| o[b] * d[b])).collect(),
            None => d.to_vec(),
        });
    }
    fn grade(&self) -> Grade {
        self.grade
    }
}
