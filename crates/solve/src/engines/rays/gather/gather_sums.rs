//! Sums of the samples of all zones, and their checkpoint.

use super::escape_rays::EscapeRays;
use super::gather_task::GatherTask;
use super::zone_gather::{DirectReading, SampleSums};
use crate::distribution::{Blocks, Communicator, Message};
use crate::settings::stage_codec::{Decoder, Encoder};
use zonal_math::parallel;
use zonal_scene::{Bands, CheckpointStore};

/// The stage of the checkpoint.
const STAGE: &str = "state-gather";

/// What direct light at points changes, found in the first round (`point_zoning`).
pub(crate) struct PointChanges {
    /// C of every column and zone, W/m²; empty where no kind of zones reads direct light at points.
    pub columns: Vec<Vec<Bands>>,
    /// (C_A − C_B)/2 of every zone, all columns together, W/m²; empty with the same.
    pub noise: Vec<Bands>,
    /// z of every column, then of their sum: of the patches, and of the volume zones and panes, over the root of the sum of squares of their incident
    /// radiation.
    pub zoning: Vec<[Bands; 2]>,
}

impl PointChanges {
    /// Encodes the changes.
    fn encode(&self, encoder: &mut Encoder) {
        encoder.bands(self.zoning.as_flattened());
        encoder.bands(&self.noise);
        encoder.int(self.columns.len());
        self.columns.iter().for_each(|c| encoder.bands(c));
    }

    /// Decodes the changes of the zones and groups of a gather; `None` for others.
    fn decode(decoder: &mut Decoder, task: &GatherTask) -> Option<PointChanges> {
        let zoning = decoder.bands()?;
        let (zoning, rest) = zoning.as_chunks();
        let noise = decoder.bands()?;
        let columns: Vec<Vec<Bands>> = (0..decoder.int()?).map(|_| decoder.bands()).collect::<Option<_>>()?;
        let fits = |list: &Vec<Bands>| list.len() == task.zones.len();
        let complete = match columns.len() {
            0 => noise.is_empty(),
            count => count == task.groups && fits(&noise) && columns.iter().all(fits),
        };
        let complete = complete && rest.is_empty() && zoning.len() == task.groups + 1;
        complete.then(|| PointChanges { columns, noise, zoning: zoning.to_vec() })
    }

    /// z of quantity `q` for zones whose direct light is the means of zones; 0 where it is read at points.
    pub(crate) fn zoning_left(&self, q: usize, direct: [DirectReading; 2]) -> [Bands; 2] {
        std::array::from_fn(|kind| match direct[kind] {
            DirectReading::OfZones => self.zoning[q][kind],
            DirectReading::AtPoints => Bands::ZERO,
        })
    }
}

/// Sums of all zones: of each zone, half and quantity.
pub(crate) struct GatherSums {
    /// Quantities of a sample.
    pub quantities: usize,
    /// Rounds so far.
    pub round: usize,
    /// Samples of each half of every zone so far.
    pub counts: Vec<usize>,
    /// Sums of every zone, half and quantity.
    pub sums: Vec<SampleSums>,
    /// Rays that only find out whether they leave the scene.
    pub escape: EscapeRays,
    /// How the patches, and the volume zones with the panes, read direct light.
    pub direct: [DirectReading; 2],
    /// What direct light at points changes; `None` where it cannot be read.
    pub changes: Option<PointChanges>,
}

impl GatherSums {
    /// The sums of the rounds that an earlier run finished, or none.
    pub(crate) fn load(task: &GatherTask, escape: EscapeRays) -> GatherSums {
        let (n, quantities) = (task.zones.len(), task.quantities());
        let mut sums = GatherSums {
            quantities,
            round: 0,
            counts: vec![0; n],
            sums: parallel::collect(2 * n * quantities, |_| SampleSums::default()),
            escape,
            direct: [DirectReading::OfZones; 2],
            changes: None,
        };
        if let Some(bytes) = task.checkpoints.load(STAGE)
            && sums.decode(&bytes, task).is_none()
        {
            sums.round = 0;
            sums.counts.fill(0);
            sums.sums.fill(SampleSums::default());
            sums.escape.clear();
            sums.direct = [DirectReading::OfZones; 2];
            sums.changes = None;
        }
        sums
    }

    /// Reads a stage; the sums are undefined where it is damaged.
    fn decode(&mut self, bytes: &[u8], task: &GatherTask) -> Option<()> {
        let mut decoder = Decoder::new(bytes);
        self.round = decoder.int().filter(|r| *r > 0)?;
        let counts = decoder.ints()?;
        let words = decoder.words()?;
        if counts.len() != self.counts.len() || words.len() != self.sums.len() * SampleSums::ENCODED_WORDS {
            return None;
        }
        self.counts.iter_mut().zip(counts).for_each(|(own, c)| *own = c as usize);
        let sum = |w: &[[u8; 4]]| SampleSums::from_words(std::array::from_fn(|k| u32::from_le_bytes(w[k])));
        let sums = words.chunks_exact(SampleSums::ENCODED_WORDS);
        self.sums.iter_mut().zip(sums).for_each(|(own, w)| *own = sum(w));
        self.escape.decode(&mut decoder)?;
        for direct in &mut self.direct {
            *direct = DirectReading::from_number(decoder.int()?)?;
        }
        self.changes = match decoder.int()? {
            0 => None,
            _ => Some(PointChanges::decode(&mut decoder, task)?),
        };
        decoder.at_end().then_some(())
    }

    /// Sends the sums of the own zones that have more than `before` samples, and receives those of the other ranks, of `wanted` samples.
    pub(crate) fn exchange(
        &mut self,
        blocks: &Blocks,
        communicator: &dyn Communicator,
        before: &[usize],
        wanted: &[usize],
    ) {
        let (width, is_new) = (2 * self.quantities, |i: usize| wanted[i] > before[i]);
        let (mut zones, mut received, escape) = (Vec::new(), Vec::new(), &self.escape);
        let bytes_of_sums = 4 * width * SampleSums::ENCODED_WORDS;
        let put = |i: usize, out: &mut Vec<u8>| {
            if is_new(i) {
                let sums = &self.sums[width * i..width * (i + 1)];
                sums.iter().flat_map(SampleSums::words).for_each(|w| w.put(out));
                escape.put_row(i, out);
            }
        };
        let take = |i: usize, bytes: &[u8]| {
            let length = if is_new(i) { bytes_of_sums + escape.row_bytes(i) } else { 0 };
            if length > 0 {
                zones.push((i, received.len()));
                received.extend_from_slice(&bytes[..length]);
            }
            length
        };
        blocks.exchange(communicator, put, take);
        for (i, first) in zones {
            let (sums, row) = received[first..].split_at(bytes_of_sums);
            let values = sums.chunks_exact(4 * SampleSums::ENCODED_WORDS).map(<[u32; 6]>::get);
            let own = &mut self.sums[width * i..width * (i + 1)];
            own.iter_mut().zip(values).for_each(|(own, w)| *own = SampleSums::from_words(w));
            self.escape.take_row(i, row);
            self.counts[i] = wanted[i];
        }
    }

    /// Saves the sums of the rounds so far.
    pub(crate) fn save(&self, checkpoints: &dyn CheckpointStore) {
        if checkpoints.keeps() {
            let mut encoder = Encoder::default();
            encoder.int(self.round);
            encoder.ints(&self.counts.iter().map(|c| *c as u64).collect::<Vec<_>>());
            encoder.words(
                self.sums.len() * SampleSums::ENCODED_WORDS,
                self.sums.iter().flat_map(SampleSums::words),
            );
            self.escape.encode(&mut encoder);
            self.direct.iter().for_each(|d| encoder.int(d.number()));
            encoder.int(usize::from(self.changes.is_some()));
            self.changes.iter().for_each(|c| c.encode(&mut encoder));
            checkpoints.save(STAGE, &encoder.bytes());
        }
    }

    /// Removes all samples and sets the number of quantities.
    pub(crate) fn begin(&mut self, quantities: usize) {
        let words = 2 * self.counts.len() * quantities;
        (self.sums, self.quantities) = (parallel::collect(words, |_| SampleSums::default()), quantities);
        self.counts.fill(0);
        self.escape.clear();
        self.round = 0;
    }

    /// Ends the first round, whose quantities beyond `quantities` are the same with direct light at points: keeps those of each kind of zones by its reading.
    pub(crate) fn keep_readings(
        &mut self,
        kind_of: impl Fn(usize) -> usize + Sync,
        quantities: usize,
        direct: [DirectReading; 2],
    ) {
        let width = self.quantities;
        let replaced = width - quantities;
        let kept = |k: usize| {
            let (row, q) = (k / quantities, k % quantities);
            let at_points = direct[kind_of(row / 2)] == DirectReading::AtPoints && q < replaced;
            self.sums[row * width + if at_points { quantities + q } else { q }]
        };
        let sums = parallel::collect(2 * self.counts.len() * quantities, kept);
        (self.sums, self.quantities, self.direct) = (sums, quantities, direct);
    }

    fn of(&self, i: usize, half: usize, q: usize) -> &SampleSums {
        &self.sums[(2 * i + half) * self.quantities + q]
    }

    /// Mean of one half of quantity `q` of zone `i`.
    pub(crate) fn half(&self, i: usize, half: usize, q: usize) -> Bands {
        self.of(i, half, q).sum() / self.counts[i].max(1) as f64
    }

    /// Mean of both halves of quantity `q` of zone `i`.
    pub(crate) fn mean(&self, i: usize, q: usize) -> Bands {
        0.5 * (self.half(i, 0, q) + self.half(i, 1, q))
    }

    /// Variance of the samples of that quantity over their number.
    pub(crate) fn variance(&self, i: usize, q: usize) -> Bands {
        let n = 2.0 * self.counts[i].max(1) as f64;
        let (mean, squares) = (self.mean(i, q), self.of(i, 0, q).squares() + self.of(i, 1, q).squares());
        (squares / n - mean * mean).map(|v| v.max(0.0)) / n
    }
}
