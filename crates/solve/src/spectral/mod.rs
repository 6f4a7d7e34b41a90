//! The spectral engine: every exchange area of a box enclosure, each to a proven tolerance, in memory that grows as the zones do.
//!
//! In a box on a regular grid with one extinction κ, the exchange factor of two zones depends on their offset alone: the exchange of all
//! zones is a convolution, and Fourier's transform makes it a product. With n zones one application costs n log n operations, where pairs cost n²:
//! 115³ voxels and their walls have 2.7·10¹² exchange areas.
//!
//! | module | what |
//! |---|---|
//! | [`basis`] | radiosity that varies inside a zone: components, and which kernels they have with each other |
//! | [`enclosure`] | where the engine applies, and why not |
//! | [`grid`] | cells, lengths, memory |
//! | [`even`] | transforms of even sequences: kernels to real spectra |
//! | [`kernels`] | tables by offset, their spectra |
//! | [`volume`] | voxels with voxels and walls |
//! | [`walls`] | walls with walls |
//!
//! **Zones too thick.** Radiosity that is constant in a voxel lets light through it too easily where κℓ is not small: the diffusion of a thick medium
//! is not that of its zones. With slopes ([`Variation::Linear`]) it is, in slabs of any thickness, and the error falls by more than one
//! order in ℓ; beside edges where walls of different radiosity meet, light still falls off within a mean free path, which voxels have to follow. The unknowns are the zones' own, then the slopes of the patches along their first axis, along their second, then those of
//! the voxels along x, y, z; whoever asks for the zones alone gets them, with slopes of zero.
//!
//! **Error.** Every factor has a proven relative radius ([`kernels::TOLERANCE`]), with all images of periodic axes; with slopes, an estimated one
//! ([`kernels::LINEAR_TOLERANCE`]). What a level field misses of closure in the worst row, of zones or of slopes, is measured and counts as a share of all that arrives.
//! Transforms round: what arrives is off by about ε √log₂N times the root mean square over all zones, which is large only against zones that
//! next to nothing reaches. The grade of the whole is therefore estimated.

pub mod basis;
pub mod enclosure;
pub mod even;
pub mod grid;
pub mod kernels;
pub mod volume;
pub mod walls;

use crate::columns::{times, total};
use crate::operator::{Arriving, Operator, extend_to_slopes};
use basis::Variation;
use enclosure::{Enclosure, OPENING};
use grid::Grid;
use kernels::Kernels;
use rayon::prelude::*;
use volume::Volume;
use walls::{Faces, Walls};
use zonal_exchange::aligned::lattice::Tally;
use zonal_exchange::pair::{strength, target};
use zonal_math::Grade;
use zonal_scene::{Bands, Progress, Zones, bands};

/// Relative error of a transform there and back, in units of ε √log₂N.
const ROUNDING: f64 = 4.0;

/// The exchange of a box enclosure.
pub struct Spectral {
    enclosure: Enclosure,
    /// Patches, which come before the voxels.
    patches: usize,
    variation: Variation,
    volume: Volume,
    walls: Walls,
    /// One set a distinct extinction.
    kernels: Vec<Kernels>,
    /// The set of a band.
    group: [usize; 3],
    /// d of g'_ij = d_i g_ij d_j, where closure was restored.
    scaling: Option<Vec<Bands>>,
    /// What the rows of a level field miss at most, relative to A and 4V, twice.
    defect: Bands,
}

impl Spectral {
    /// Computes the tables of an enclosure with so many patches.
    pub fn new(
        enclosure: Enclosure,
        patches: usize,
        variation: Variation,
        progress: &dyn Progress,
    ) -> Spectral {
        let (group, kappa) = enclosure.groups();
        let grid = enclosure.grid;
        progress.begin("exchange areas by offset", kappa.len() as u64);
        let kernels = kappa
            .iter()
            .map(|&kappa| {
                let k = Kernels::new(&grid, kappa, variation);
                progress.advance(1);
                k
            })
            .collect();
        progress.end();
        let (volume, walls) = (Volume::new(grid, variation), Walls::new(grid, variation));
        Spectral {
            enclosure,
            patches,
            variation,
            volume,
            walls,
            kernels,
            group,
            scaling: None,
            defect: [0.0; 3],
        }
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.enclosure.grid
    }

    /// The kernels, one set a distinct extinction.
    pub fn kernels(&self) -> &[Kernels] {
        &self.kernels
    }

    /// What the tables hold, and by which methods.
    pub fn counts(&self) -> Vec<(String, u64)> {
        let all: Vec<_> = self.kernels.iter().flat_map(|k| &k.tally).collect();
        let sum = |of: fn(&Tally) -> usize| all.iter().map(|(_, t)| of(t) as u64).sum::<u64>();
        let n = self.zones() as u64;
        let slopes = (self.len() - self.zones()) as u64;
        [
            ("pairs", n * (n + 1) / 2),
            ("slopes of radiosity", slopes),
            ("offsets in tables", sum(Tally::total)),
            ("offsets by series of moments", sum(|t| t.moments)),
            ("offsets by Gauss rules", sum(|t| t.gauss)),
            ("offsets by pyramid coordinates", sum(|t| t.pyramid)),
            ("offsets in closed form", sum(|t| t.closed)),
            ("offsets by sums of Gaussians", sum(|t| t.gaussians)),
        ]
        .into_iter()
        .filter(|x| x.1 > 0)
        .map(|(what, n)| (what.to_string(), n))
        .collect()
    }

    /// Bytes that the engine holds for a grid with so many distinct extinctions.
    pub fn bytes(grid: &Grid, extinctions: usize, variation: Variation) -> u64 {
        // While spectra are made, two of their stages are there at a time; of slopes, the tables of all kernels.
        let tables = match variation {
            Variation::Constant => 0,
            Variation::Linear => {
                8 * variation.volume().densities.len() as u64
                    * grid.distances().iter().map(|n| *n as u64).product::<u64>()
            }
        };
        let making = 8 * grid.halves().iter().map(|h| *h as u64).product::<u64>() * 2 + tables;
        let vectors = 2 * 8 * (variation.voxel() * grid.count()) as u64;
        grid.spectra_bytes(variation) * extinctions as u64
            + (grid.work_bytes(variation) + vectors).max(making)
    }

    /// Number of zones; [`Operator::len`] counts their slopes too.
    pub fn zones(&self) -> usize {
        self.patches + self.grid().count()
    }

    /// Where component `q` of the patches begins in a vector of unknowns.
    fn of_patches(&self, q: usize) -> usize {
        if q == 0 { 0 } else { self.zones() + (q - 1) * self.patches }
    }

    /// Where component `p` of the voxels begins.
    fn of_voxels(&self, p: usize) -> usize {
        match p {
            0 => self.patches,
            _ => self.zones() + (self.variation.patch() - 1) * self.patches + (p - 1) * self.grid().count(),
        }
    }

    /// The component, place in its wall's values and unknown of every patch of a wall.
    fn placed<'a>(&'a self, zones: &'a [u32]) -> impl Iterator<Item = (usize, usize)> + 'a {
        (0..self.variation.patch()).flat_map(move |q| {
            let all = zones.iter().enumerate().filter(|(_, z)| **z != OPENING);
            all.map(move |(i, z)| (q * zones.len() + i, self.of_patches(q) + *z as usize))
        })
    }

    /// What arrives through the openings, for a radiosity of one there: the factors of the surroundings, m² and m³.
    pub fn openings(&self) -> Vec<Bands> {
        let mut out = vec![[0.0; 3]; self.len()];
        let mut faces = self.walls.zeros();
        for (face, zones) in faces.iter_mut().flatten().zip(self.enclosure.faces.iter().flatten()) {
            face.iter_mut().zip(zones).for_each(|(x, z)| *x = f64::from(u8::from(*z == OPENING)));
        }
        let nothing = vec![0.0; self.variation.voxel() * self.grid().count()];
        let mut voxels = nothing.clone();
        for g in 0..self.kernels.len() {
            let met = self.exchange(g, &nothing, &faces, &mut voxels);
            let of = (0..3).filter(|&b| self.group[b] == g).collect::<Vec<_>>();
            self.scatter(&voxels, &met, &mut out, &of);
        }
        // Transforms round to a little more or less than nothing.
        out[..self.zones()].iter_mut().flatten().for_each(|x| *x = x.max(0.0));
        out
    }

    /// Measures the tables by a level field, of which A or 4V arrives at every zone and nothing at slopes, with what comes through the `openings`
    /// (by unknown, empty where there are none): what the worst row misses, twice, is added to the errors from now on.
    pub fn measure(&mut self, zones: &Zones, openings: &[Bands]) {
        const TWICE: f64 = 2.0;
        let mut level: Vec<Bands> = (0..self.zones()).map(|i| strength(zones, i)).collect();
        level.resize(self.len(), [0.0; 3]);
        let (rows, slopes) = (self.apply(&level), self.slopes());
        let off = |i: usize| {
            let zone = if i < self.zones() { i } else { slopes[i - self.zones()] as usize };
            let (whole, open) = (target(zones, zone), openings.get(i).copied().unwrap_or_default());
            let want = if i < self.zones() { whole } else { 0.0 };
            bands(|b| ((rows[i][b] + open[b] - want) / whole).abs())
        };
        let worst = |x: Bands, y: Bands| bands(|b| if y[b] <= x[b] { x[b] } else { y[b] });
        let found = (0..rows.len()).into_par_iter().map(off).reduce(|| [0.0; 3], worst);
        self.defect = found.map(|d| if d.is_finite() { TWICE * d } else { f64::INFINITY });
    }

    /// The walls of a vector over the unknowns; openings send nothing.
    fn faces(&self, at: impl Fn(usize) -> f64) -> Faces {
        let mut faces = self.walls.zeros();
        for (face, zones) in faces.iter_mut().flatten().zip(self.enclosure.faces.iter().flatten()) {
            self.placed(zones).for_each(|(i, unknown)| face[i] = at(unknown));
        }
        faces
    }

    /// Puts voxels and walls into some bands of a vector over the unknowns.
    fn scatter<const N: usize>(&self, voxels: &[f64], faces: &Faces, out: &mut [[f64; N]], of: &[usize]) {
        for (face, zones) in faces.iter().flatten().zip(self.enclosure.faces.iter().flatten()) {
            for (i, unknown) in self.placed(zones) {
                of.iter().for_each(|&b| out[unknown][b] = face[i]);
            }
        }
        for (p, voxels) in voxels.chunks(self.grid().count()).enumerate() {
            let all = out[self.of_voxels(p)..].par_iter_mut().zip(voxels);
            all.for_each(|(o, x)| of.iter().for_each(|&b| o[b] = *x));
        }
    }

    /// What arrives at the voxels, written to `met`, and at the walls, of strengths in one band.
    fn exchange(&self, group: usize, voxels: &[f64], faces: &Faces, met: &mut [f64]) -> Faces {
        let k = &self.kernels[group];
        let mut walls = self.walls.zeros();
        let spectra = self.walls.spectra(faces);
        let mut found = self.volume.apply(k, voxels, &spectra, met);
        self.walls.opposite(k, &spectra, &mut found);
        self.walls.add(found, &mut walls);
        self.walls.adjacent(k, faces, &mut walls);
        walls
    }

    /// The strengths of the voxels by component and cell.
    fn voxels(&self, own: &mut [f64], at: impl Fn(usize) -> f64 + Sync) {
        let count = self.grid().count();
        own.par_chunks_mut(count).enumerate().for_each(|(p, own)| {
            let first = self.of_voxels(p);
            own.par_iter_mut().enumerate().for_each(|(i, x)| *x = at(first + i));
        });
    }

    fn product(&self, s: &[Bands]) -> Vec<Bands> {
        assert_eq!(s.len(), self.len(), "a strength for every zone");
        let mut out = vec![[0.0; 3]; s.len()];
        let mut own = vec![0.0; self.variation.voxel() * self.grid().count()];
        let mut met = own.clone();
        let mut done = [false; 3];
        for b in 0..3 {
            if done[b] {
                continue;
            }
            // Bands of one extinction with the same strengths are one.
            let same = |c: &usize| {
                *c == b
                    || (self.group[*c] == self.group[b]
                        && s.par_iter().all(|x| x[*c].to_bits() == x[b].to_bits()))
            };
            let of: Vec<usize> = (b..3).filter(|c| !done[*c]).filter(same).collect();
            of.iter().for_each(|&c| done[c] = true);
            self.voxels(&mut own, |i| s[i][b]);
            let walls = self.exchange(self.group[b], &own, &self.faces(|i| s[i][b]), &mut met);
            self.scatter(&met, &walls, &mut out, &of);
        }
        out
    }

    /// Error of what arrives: the radii of the factors, and the rounding of the transforms.
    fn spread(&self, arriving: &[Bands]) -> Vec<Bands> {
        let n = arriving.len().max(1) as f64;
        let square = |x: &[Bands]| crate::columns::sum(x.len(), |i| x[i].map(|x| x * x));
        let rms = square(arriving).map(|x| (x / n).sqrt());
        let length: usize = self.grid().lengths().iter().product();
        let rounding = ROUNDING * f64::EPSILON * (length as f64).log2().max(1.0).sqrt();
        let radius = bands(|b| self.kernels[self.group[b]].radius + self.defect[b]);
        arriving.par_iter().map(|p| bands(|b| radius[b] * p[b].abs() + rounding * rms[b])).collect()
    }
}

impl Operator for Spectral {
    fn len(&self) -> usize {
        self.patches * self.variation.patch() + self.grid().count() * self.variation.voxel()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        if s.len() < self.len() {
            let mut all = s.to_vec();
            all.resize(self.len(), [0.0; 3]);
            let mut out = self.apply(&all);
            out.truncate(s.len());
            return out;
        }
        match &self.scaling {
            Some(d) => times(&self.product(&times(s, d)), d),
            None => self.product(s),
        }
    }
    fn one_band(&self) -> bool {
        self.kernels.len() == 1 && self.scaling.is_none()
    }
    fn apply_band(&self, s: &[[f64; 1]]) -> Vec<[f64; 1]> {
        let mut out = vec![[0.0]; s.len()];
        let faces = self.faces(|i| s[i][0]);
        // The constant alone stands as it is wanted, and needs no copies.
        match self.variation {
            Variation::Constant => {
                let met = &mut out.as_flattened_mut()[self.patches..];
                let walls = self.exchange(0, &s.as_flattened()[self.patches..], &faces, met);
                self.scatter(&[], &walls, &mut out, &[0]);
            }
            Variation::Linear => {
                let mut own = vec![0.0; self.variation.voxel() * self.grid().count()];
                let mut met = own.clone();
                self.voxels(&mut own, |i| s[i][0]);
                let walls = self.exchange(0, &own, &faces, &mut met);
                self.scatter(&met, &walls, &mut out, &[0]);
            }
        }
        out
    }
    fn slopes(&self) -> Vec<u32> {
        let patches = (1..self.variation.patch()).flat_map(|_| 0..self.patches);
        let voxels = (1..self.variation.voxel()).flat_map(|_| self.patches..self.zones());
        patches.chain(voxels).map(|i| i as u32).collect()
    }
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        Some(self.spread(&self.apply(strengths)))
    }
    fn arriving(&self, columns: &[Vec<Bands>]) -> Arriving {
        let found = self.apply_many(columns);
        let error = self.spread(&total(self.len(), &found));
        Arriving { columns: found, error: Some(error) }
    }
    fn scale(&mut self, d: &[Bands]) {
        let mut d = d.to_vec();
        extend_to_slopes(&mut d, &self.slopes());
        self.scaling = Some(match self.scaling.take() {
            Some(old) => times(&old, &d),
            None => d,
        });
    }
    fn grade(&self) -> Grade {
        Grade::Estimated
    }
}
