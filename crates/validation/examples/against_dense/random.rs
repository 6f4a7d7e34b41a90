//! Random scenes: a room with boxes, plates and triangles at random places and smoke of random density; the same for the same seed.

use std::fmt::Write as _;
use std::path::Path;
use zonal_io::output;
use zonal_math::{Vec3, vec3};

/// Cells of the density along an edge.
const SMOKE_CELLS: usize = 12;
/// Cubes among which the density is smooth, along an edge.
const LUMP_CUBES: usize = 5;
/// Number of objects.
const OBJECTS: usize = 8;
/// Largest number of attempts to place an object.
const MAX_PLACEMENTS_PER_OBJECT: usize = 200;
/// Least distance between two objects, and from the walls, m.
const MIN_GAP: f64 = 0.08;

/// Random numbers that a seed determines (splitmix64).
struct UniformSequence(u64);

impl UniformSequence {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
    fn bands(&mut self, low: f64, high: f64) -> [f64; 3] {
        [0; 3].map(|_| self.between(low, high))
    }
    fn point(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        vec3(self.between(low.x, high.x), self.between(low.y, high.y), self.between(low.z, high.z))
    }
}

/// Bounding box of an object.
#[derive(Clone, Copy)]
struct PlacedBox {
    low: Vec3,
    high: Vec3,
}

impl PlacedBox {
    fn apart(&self, other: &PlacedBox) -> bool {
        let (a, b) = (self, other);
        let clear = |al: f64, ah: f64, bl: f64, bh: f64| ah + MIN_GAP < bl || bh + MIN_GAP < al;
        clear(a.low.x, a.high.x, b.low.x, b.high.x)
            || clear(a.low.y, a.high.y, b.low.y, b.high.y)
            || clear(a.low.z, a.high.z, b.low.z, b.high.z)
    }
}

/// Places in the room that keep apart.
fn places(random: &mut UniformSequence, room: Vec3) -> Vec<PlacedBox> {
    let mut out: Vec<PlacedBox> = Vec::new();
    for _ in 0..OBJECTS * MAX_PLACEMENTS_PER_OBJECT {
        let size = random.point(vec3(0.3, 0.3, 0.3), vec3(0.8, 0.8, 0.8));
        let low = random.point(Vec3::splat(MIN_GAP), room - size - Vec3::splat(MIN_GAP));
        let place = PlacedBox { low, high: low + size };
        if out.iter().all(|p| p.apart(&place)) {
            out.push(place);
        }
        if out.len() == OBJECTS {
            break;
        }
    }
    out
}

/// A box turned about the vertical, a plate or a triangle inside of a place.
fn object(random: &mut UniformSequence, k: usize, p: &PlacedBox) -> String {
    let (name, rho) = (format!("object {k}"), random.bands(0.1, 0.8));
    let shape = match k % 3 {
        0 => {
            // Turned by any angle, it stays inside: the diagonal of its base is the place's shorter edge.
            let (size, middle) = (p.high - p.low, (p.low + p.high) * 0.5);
            let half = 0.5 * size.x.min(size.y) * std::f64::consts::FRAC_1_SQRT_2;
            let (a, b) = (vec3(half, half, 0.5 * size.z), random.between(0.0, 90.0));
            format!(
                "box = {{ min = {:?}, max = {:?}, rotate_z_degrees = {b} }}",
                (middle - a).array(),
                (middle + a).array()
            )
        }
        1 => {
            // From a corner of the place along two edges that lean.
            let size = p.high - p.low;
            let (s, t) = (random.between(0.0, 0.5), random.between(0.0, 0.5));
            let (u, v) = (vec3(size.x, 0.0, s * size.z), vec3(0.0, size.y, t * size.z));
            format!(
                "rectangle = {{ origin = {:?}, edge1 = {:?}, edge2 = {:?} }}\nsides = \"both\"",
                p.low.array(),
                u.array(),
                v.array()
            )
        }
        _ => {
            let corner = [0; 3].map(|_| random.point(p.low, p.high).array());
            format!("triangle = {{ corners = {corner:?} }}\nsides = \"both\"")
        }
    };
    format!("[[surface]]\nname = \"{name}\"\n{shape}\nreflectance = {rho:?}\n")
}

/// A density that varies by a factor of some thirty, smoothly and everywhere.
fn density(random: &mut UniformSequence) -> Vec<f64> {
    let lumps: Vec<f64> = (0..LUMP_CUBES.pow(3)).map(|_| random.between(-1.7, 1.7)).collect();
    let at = |i: usize, axis: usize| {
        let k = [i / (SMOKE_CELLS * SMOKE_CELLS), i / SMOKE_CELLS % SMOKE_CELLS, i % SMOKE_CELLS][axis];
        let x = (k as f64 + 0.5) / SMOKE_CELLS as f64 * (LUMP_CUBES - 1) as f64;
        ((x as usize).min(LUMP_CUBES - 2), x - x.floor())
    };
    let value = |i: usize| {
        let mut sum = 0.0;
        for corner in 0..8 {
            let (mut index, mut weight) = (0, 1.0);
            for axis in 0..3 {
                let (cell, part) = at(i, axis);
                let up = corner >> axis & 1;
                index = index * LUMP_CUBES + cell + up;
                weight *= if up == 1 { part } else { 1.0 - part };
            }
            sum += weight * lumps[index];
        }
        f64::exp(sum)
    };
    (0..SMOKE_CELLS.pow(3)).map(value).collect()
}

/// The scene of a seed as text, with its density written to a file; `n` cells along the longest edge.
pub(crate) fn scene(seed: u64, n: usize, file: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let mut random = UniformSequence(seed.wrapping_mul(0x2545_F491_4F6C_DD1D));
    let room = random.point(vec3(2.6, 2.2, 1.8), vec3(3.0, 2.6, 2.2));
    let cells = room.array().map(|e| (e / 3.0 * n as f64).round().max(1.0) as usize);
    let mut t = format!(
        "name = \"random{seed}\"\n[solve]\npatch_size = {}\n[[surface]]\nname = \"room\"\nroom = {{ min = [0, 0, 0], max = {:?} }}\nreflectance = {:?}\nfaces.{} = {{ emission = {:?} }}\n",
        3.0 / n as f64,
        room.array(),
        random.bands(0.3, 0.8),
        ["x0", "x1", "y0", "y1"][(4.0 * random.next()) as usize % 4],
        random.bands(0.5, 1.0),
    );
    // A lamp below the ceiling, off its patches' edges.
    let corner = random.point(vec3(0.4, 0.4, 0.0), vec3(room.x - 0.9, room.y - 0.9, 0.0));
    let _ = write!(
        t,
        "[[surface]]\nname = \"lamp\"\nrectangle = {{ origin = {:?}, edge1 = [0, 0.5, 0], edge2 = [0.5, 0, 0] }}\nreflectance = 0.3\nemission = {:?}\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n",
        vec3(corner.x, corner.y, room.z - 0.04).array(),
        random.bands(3.0, 6.0)
    );
    let places = places(&mut random, room - vec3(0.0, 0.0, 0.1));
    for (k, p) in places.iter().enumerate() {
        t += &object(&mut random, k, p);
    }
    output::write_array(file, &[SMOKE_CELLS; 3], &density(&mut random))?;
    let _ = write!(
        t,
        "[medium]\nmin = [0, 0, 0]\nmax = {:?}\ncells = {cells:?}\n[[medium.region]]\ndensity = {{ file = {:?}, min = [0, 0, 0], max = {:?}, scale = {:?} }}\nalbedo = {:?}\n",
        room.array(),
        file.display().to_string(),
        room.array(),
        random.bands(0.2, 0.6),
        random.bands(0.5, 0.95)
    );
    Ok(t)
}
