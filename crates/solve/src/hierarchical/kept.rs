//! Views as stages that a vault keeps.
//!
//! Where a ray ends depends on the scene's geometry, extinctions and lights alone, so views serve a scene with other reflectances and
//! another albedo too. They are cut into stages of about [`STAGE`] bytes, `views-P-V-KIND-NUMBER` with P rays of a patch and V of a
//! volume zone, so that a kill loses no more than one of them. A stage: zones met (u32), what rays count (f32, three a ray, or none),
//! and for each block of zones the steps from which its rays go on.

use super::onward::{BLOCK, Step, step_of};
use super::shooter::NOWHERE;
use crate::stage::{Pen, Reader};

/// Bytes of a stage, about: some seconds of work.
const STAGE: usize = 64 << 20;
/// Bytes of a ray in it at most, steps left out.
const RAY: usize = 16;

/// Blocks of zones with so many rays each that make a stage.
pub(super) fn blocks(each: usize) -> usize {
    (STAGE / (RAY * BLOCK * each.max(1))).max(1)
}

/// The name of stage `number` of the patches (kind 0) or volume zones (kind 1).
pub(super) fn name(each: [usize; 2], kind: usize, number: usize) -> String {
    format!("views-{}-{}-{kind}-{number}", each[0], each[1])
}

/// A stage: zones met and what the rays count, with the steps of every block.
pub(super) fn stage(met: &[u32], worth: &[[f32; 3]], steps: &[Vec<Step>]) -> Vec<u8> {
    let mut pen = Pen::default();
    pen.words(met.len(), met.iter().copied());
    pen.words(3 * worth.len(), worth.as_flattened().iter().map(|w| w.to_bits()));
    pen.int(steps.len());
    for block in steps {
        pen.words(Step::WORDS * block.len(), block.iter().flat_map(Step::words));
    }
    pen.bytes()
}

/// Puts the stage that [`stage`] wrote where it came from; the steps of the blocks, whose rays are `rays` each but in the last. `None`
/// for anything else, and what was put is then to be computed. `patches` of all `zones` are patches.
pub(super) fn restored(
    bytes: &[u8],
    met: &mut [u32],
    worth: &mut [[f32; 3]],
    rays: usize,
    (patches, zones): (usize, usize),
) -> Option<Vec<Vec<Step>>> {
    let mut r = Reader::new(bytes);
    let ends = r.words().filter(|w| w.len() == met.len())?;
    let counts = r.words().filter(|w| w.len() == 3 * worth.len())?;
    let number = r.int().filter(|n| *n == met.len().div_ceil(rays))?;
    let steps: Option<Vec<Vec<Step>>> = (0..number)
        .map(|_| {
            let words = r.words()?;
            let (whole, rest) = words.as_chunks();
            rest.is_empty().then(|| whole.iter().map(|w| Step::of(w.map(u32::from_le_bytes))).collect())
        })
        .collect();
    let steps = steps.filter(|_| r.at_end())?;
    met.iter_mut().zip(ends).for_each(|(m, w)| *m = u32::from_le_bytes(*w));
    let flat = worth.as_flattened_mut();
    flat.iter_mut().zip(counts).for_each(|(m, w)| *m = f32::from_bits(u32::from_le_bytes(*w)));
    let blocks = met.chunks(rays).zip(&steps);
    let sound = |(met, steps): (&[u32], &Vec<Step>)| {
        // Steps lead on to later ones: nothing goes round.
        let leads = |to: u32, after: usize| match step_of(to) {
            Some(s) => (after..steps.len()).contains(&s),
            None => to >= NOWHERE || (to as usize) < zones,
        };
        met.iter().all(|m| leads(*m, 0))
            && steps.iter().enumerate().all(|(k, s)| s.is_on(patches) && leads(s.next(), k + 1))
    };
    blocks.into_iter().all(sound).then_some(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_comes_back_and_nothing_else_does() {
        let step = |zone, next| Step::of([zone, next, 7, 1, 2, 3, 4, 5, 6]);
        // Three rays a block; five rays, one of which goes on twice.
        let first = 1 << 31;
        let met = [2, first, NOWHERE, 0, 9];
        let worth = [0.1, 0.2, 0.3, 0.4, 0.5].map(|w: f32| [w, -0.0, 1.0]);
        let steps = vec![vec![step(0, first | 1), step(1, 9)], Vec::new()];
        let bytes = stage(&met, &worth, &steps);
        let read = |bytes: &[u8], zones: usize| {
            let (mut m, mut w) = ([0; 5], [[0.0; 3]; 5]);
            restored(bytes, &mut m, &mut w, 3, (2, zones)).map(|s| (m, w, stage(&m, &w, &s)))
        };
        let (m, w, again) = read(&bytes, 10).unwrap();
        assert!(m == met && w == worth && again == bytes);
        assert!(w.iter().all(|w| w[1].to_bits() == (-0.0f32).to_bits()));
        assert!(read(&bytes, 9).is_none(), "a zone that is not there");
        assert!((0..bytes.len()).all(|cut| read(&bytes[..cut], 10).is_none()));
        let round = stage(&met, &worth, &[vec![step(0, first), step(1, 9)], Vec::new()]);
        assert!(read(&round, 10).is_none(), "a step that leads to itself");
        let lost = stage(&met, &worth, &[vec![step(0, first | 2), step(1, 9)], Vec::new()]);
        assert!(read(&lost, 10).is_none(), "a step that is not there");
        let odd = stage(&met, &worth, &[vec![step(2, 3), step(1, 9)], Vec::new()]);
        assert!(read(&odd, 10).is_none(), "a step that is on no patch");
        let single = (&mut [0; 5], &mut [[0.0; 3]; 4]);
        assert!(restored(&bytes, single.0, single.1, 3, (2, 10)).is_none());
    }
}
