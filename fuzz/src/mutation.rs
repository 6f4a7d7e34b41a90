//! Random changes of inputs without libFuzzer: bits, bytes, numbers of texts, parts of other seeds. The same seed gives the same inputs.

use std::path::Path;

/// A generator of pseudo-random numbers (xorshift64).
pub struct Random(pub u64);

impl Random {
    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 16) % n.max(1) as u64) as usize
    }
}

/// Texts that readers treat in their own ways.
const TOKENS: [&[u8]; 16] = [
    b"0",
    b"-1",
    b"1e400",
    b"nan",
    b"inf",
    b"4294967296",
    b"9223372036854775807",
    b"1e-300",
    b"\n",
    b" ",
    b",",
    b"\"",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
    b"<",
    b"1e8",
];

/// An input changed at one to eight places.
pub fn mutated(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut data = seeds[random.below(seeds.len())].clone();
    for _ in 0..1 + random.below(8) {
        let at = random.below(data.len() + 1);
        let end = (at + 1 + random.below(16)).min(data.len());
        match random.below(8) {
            0 if at < data.len() => data[at] ^= 1 << random.below(8),
            1 if at < data.len() => data[at] = random.below(256) as u8,
            2 => drop(data.drain(at..end)),
            3 => drop(data.splice(at..at, data[at..end].to_vec())),
            4 => drop(data.splice(at..end, TOKENS[random.below(TOKENS.len())].iter().copied())),
            5 => {
                let other = &seeds[random.below(seeds.len())];
                let from = random.below(other.len());
                let to = (from + random.below(64)).min(other.len());
                data.splice(at..end, other[from..to].iter().copied());
            }
            6 => {
                // A number of a text takes the place of another.
                let digit = data.iter().skip(at).position(u8::is_ascii_digit).map(|k| at + k);
                if let Some(start) = digit {
                    let length = data[start..].iter().take_while(|b| b.is_ascii_digit()).count();
                    let token = TOKENS[random.below(8)];
                    data.splice(start..start + length, token.iter().copied());
                }
            }
            _ => data.truncate(at.max(1)),
        }
    }
    data.truncate(1 << 14);
    data
}

/// Runs a target on changed seeds and returns the runs that panic. The variables `ZONAL_FUZZ_RUNS` and `ZONAL_FUZZ_SEED` replace the number of runs and
/// the seed; inputs that panic or take more than ten seconds are written to the folder `ZONAL_FUZZ_OUT`.
pub fn run_mutated(name: &str, target: fn(&[u8]), seeds: &[Vec<u8>], runs: usize) -> Vec<String> {
    let of = |name: &str| std::env::var(name).ok();
    let runs = of("ZONAL_FUZZ_RUNS").and_then(|n| n.parse().ok()).unwrap_or(runs);
    let seed: u64 = of("ZONAL_FUZZ_SEED").and_then(|n| n.parse().ok()).unwrap_or(1);
    let mut failed = Vec::new();
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ seed);
    for k in 0..runs {
        let data = mutated(seeds, &mut random);
        let start = std::time::Instant::now();
        let panics = std::panic::catch_unwind(|| target(&data)).is_err();
        if panics || start.elapsed().as_secs() > 10 {
            let kind = if panics { "panic" } else { "slow" };
            if let Some(folder) = of("ZONAL_FUZZ_OUT") {
                let path = Path::new(&folder).join(format!("{name}-{kind}-{seed}-{k}.bin"));
                std::fs::write(path, &data).expect("the folder of findings");
            }
            failed.extend(panics.then(|| format!("{name}: run {k} of seed {seed}")));
        }
    }
    eprintln!("{name}: {runs} runs");
    failed
}
