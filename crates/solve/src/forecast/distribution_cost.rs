//! Expected cost of a solve that several processes share: the memory of one, and the bytes that it sends.
//!
//! | engine | a process has | sends for each product of a light group |
//! |---|---|---|
//! | spectral | 1/R of spectra and of voxels | two exchanges of spectra, 32 n₀/R N₁ (N₂/2 + 1) (R − 1)/R bytes, and spectra and values of walls |
//! | dense | 1/R of the exchange areas, all fields | one sum of rows, 24 n (R − 1) bytes |
//! | rays | 1/R of the stored rays, all fields | its zones' values, 24 n/R (R − 1) bytes |
//!
//! Messages within a machine or between machines go at some gigabytes a second; the model takes 1.1 GB/s, and knows neither the delay of single
//! messages nor the shape of a network.

use crate::engines::selection::EngineChoice;
use crate::engines::spectral::sent_bytes_of_product;
use zonal_scene::{Band, Engine, Zones};

/// Bytes a second that a process sends, as measured between two processes of one machine of 2023; networks of clusters reach as much.
const MESSAGE_BYTES_PER_SECOND: f64 = 1.1e9;

/// Bytes of a value of all bands.
const VALUE_BYTES: u64 = 24;

/// Bytes that the first of several processes sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes for each product with the exchange areas, a band and light group of the spectral engine, all bands of the others.
    pub product: u64,
    /// Bytes of the whole solve.
    pub total: u64,
}

impl Traffic {
    /// Expected traffic of `products` products, those of all light groups; none of one process.
    pub(super) fn expected(
        choice: &EngineChoice,
        zones: &Zones,
        ranks: usize,
        products: f64,
    ) -> Option<Traffic> {
        if ranks == 1 {
            return None;
        }
        let (n, others) = (zones.total() as u64, ranks as u64 - 1);
        let [product, kinds] = match (choice.engine, &choice.enclosure) {
            (Engine::Spectral, Some((enclosure, order))) => [
                sent_bytes_of_product(&enclosure.grid, *order, 0, ranks),
                enclosure.extinction_groups().1.len() as u64,
            ],
            (Engine::Dense, _) => [VALUE_BYTES * n * others, 1],
            (Engine::Rays, _) => [VALUE_BYTES * n / ranks as u64 * others, 1],
            _ => [0, 0],
        };
        // The rows of the dense engine go to the processes that keep them, factors and radii.
        let pairs = n * (n + 1) / 2;
        let rows = match choice.engine {
            Engine::Dense => 2 * 8 * Band::count() as u64 * pairs / ranks as u64 * others / ranks as u64,
            _ => 0,
        };
        let total = rows + (product as f64 * kinds as f64 * products) as u64;
        Some(Traffic { product, total })
    }

    /// Expected seconds of the messages.
    pub(super) fn seconds(self) -> f64 {
        self.total as f64 / MESSAGE_BYTES_PER_SECOND
    }
}
