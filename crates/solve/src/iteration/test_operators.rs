//! Operators and a checkpoint store for the tests of the iterations.

use crate::engines::dense::packed_symmetric::PackedSymmetric;
use crate::operator::ExchangeOperator;
use std::collections::HashMap;
use std::sync::Mutex;
use zonal_scene::{Bands, CheckpointStore};

/// An operator with packed symmetric factors.
pub(super) struct PackedOperator(PackedSymmetric, usize);
impl ExchangeOperator for PackedOperator {
    fn len(&self) -> usize {
        self.1
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        let columns: Vec<[f64; 3]> = s.iter().map(|x| x.to_rgb()).collect();
        self.0.apply(&columns).into_iter().map(Bands::from_rgb).collect()
    }
    fn scale(&mut self, _: &[Bands]) {}
}

/// Two facing walls of area 1 that exchange with each other only: s_1 = s⁰_1 + ρ s_2, s_2 = s⁰_2 + ρ s_1.
pub(super) fn two_walls() -> PackedOperator {
    let mut m = PackedSymmetric::zeros(2);
    m.rows_mut()[1][0] = 1.0;
    PackedOperator(m, 2)
}

/// 40 zones of about equal area with almost equal exchange, and their row sums.
pub(super) fn forty_zones() -> (PackedOperator, Vec<f64>) {
    let mut m = PackedSymmetric::zeros(40);
    for (i, row) in m.rows_mut().into_iter().enumerate() {
        row.iter_mut().enumerate().for_each(|(j, x)| *x = 1.0 / (40.0 + (i * j % 7) as f64));
    }
    let rows = m.apply(&[[1.0]; 40]).iter().map(|r| r[0]).collect();
    (PackedOperator(m, 40), rows)
}

/// A checkpoint store in memory.
#[derive(Default)]
pub(super) struct MemoryStore(Mutex<HashMap<String, Vec<u8>>>);
impl CheckpointStore for MemoryStore {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap().get(stage).cloned()
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        self.0.lock().unwrap().insert(stage.into(), bytes.to_vec());
    }
}
