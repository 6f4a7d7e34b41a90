//! Laws that hold for every scene: on random boxes, through the exchange areas alone and through whole solves.

use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::measures::WallMeans;
use crate::validate::richardson::ResolutionSequence;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, ZoneShape, factor};
use zonal_math::low_discrepancy::hash_to_unit;
use zonal_math::{Vec3, vec3};
use zonal_render::{RenderOptions, render};
use zonal_report::Failure;
use zonal_scene::{Band, Bands};

/// The cases.
pub(crate) const CASES: [ValidationCase; 3] = [
    ValidationCase {
        name: "laws-areas",
        group: "Laws",
        title: "exchange areas of random pairs",
        about: "Closure (ΣF = 4κV), reciprocity to the bit, scaling, the 48 symmetries of the axes, additivity when a zone is cut in eight, monotonicity in κ, bounds 0 ≤ F ≤ min(A), the thin and the thick limit; \
            on random boxes asked to 10⁻¹².",
        quick: true,
        needs: None,
        run: areas,
    },
    ValidationCase {
        name: "laws-solves",
        group: "Laws",
        title: "whole solves of random scenes",
        about: "An isothermal enclosure has no net flux, whatever extinction, albedo, emissivity and mesh; energy is kept; radiosities are positive and the solver meets its residual; the number of threads changes no bit; \
            a varying extinction that is constant is the uniform medium; a picture inside an enclosure of one temperature has one radiance, E/π.",
        quick: true,
        needs: None,
        run: solves,
    },
    ValidationCase {
        name: "thick-limit",
        group: "Laws",
        title: "a thick slab in radiative equilibrium: diffusion",
        about: "Ψ → (4/3)/(τ + 1.42089), 1.42089 twice Hopf's constant: the neglected terms fall as e^−τ. τ = 50, extrapolated, limit 10⁻⁴ relative.",
        quick: true,
        needs: None,
        run: thick,
    },
];

/// Deterministic numbers in (0, 1).
struct UniformSequence(u64);

impl UniformSequence {
    fn next(&mut self) -> f64 {
        self.0 += 1;
        hash_to_unit(self.0)
    }
    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next()
    }
    fn vector(&mut self, a: f64, b: f64) -> Vec3 {
        vec3(self.between(a, b), self.between(a, b), self.between(a, b))
    }
}

const REQUESTED_TOLERANCE: f64 = 1e-12;

fn value(a: &Cuboid, b: &Cuboid, kappa: f64) -> f64 {
    geometric_factor(a, b, kappa, REQUESTED_TOLERANCE).bounded.value
}

/// Image of a box under a signed permutation of the axes.
fn turned(c: &Cuboid, order: [usize; 3], sign: [f64; 3]) -> Cuboid {
    let map = |v: Vec3| vec3(sign[0] * v[order[0]], sign[1] * v[order[1]], sign[2] * v[order[2]]);
    let (p, q) = (map(c.lo), map(c.hi));
    let ends = |k: usize| (p[k].min(q[k]), p[k].max(q[k]));
    let [x, y, z] = [ends(0), ends(1), ends(2)];
    Cuboid { lo: vec3(x.0, y.0, z.0), hi: vec3(x.1, y.1, z.1), normal: None }
}

/// Largest violation of each law over random pairs.
#[derive(Default)]
struct AreaViolations {
    closure: f64,
    /// Pairs whose two orders differ in a bit.
    reciprocity: f64,
    scaling: f64,
    symmetries: f64,
    additivity: f64,
}

fn areas(_: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let mut random = UniformSequence(1);
    let mut v = AreaViolations::default();
    for _ in 0..12 {
        v.add_random_pair(&mut random);
    }
    out.error("closure of twelve boxes, ΣF/(4κV) − 1", v.closure, REQUESTED_TOLERANCE);
    out.error("pairs whose two orders differ in a bit", v.reciprocity, 0.0);
    out.error("scaling, relative", v.scaling, 4.0 * REQUESTED_TOLERANCE);
    out.error("48 symmetries, relative", v.symmetries, 4.0 * REQUESTED_TOLERANCE);
    out.error("eight parts against the whole, relative", v.additivity, 4.0 * REQUESTED_TOLERANCE);
    limits(&mut out);
    Ok(out)
}

impl AreaViolations {
    /// Draws a box of gas and another voxel, and tests every law on them.
    fn add_random_pair(&mut self, random: &mut UniformSequence) {
        let size = random.vector(0.3, 2.0);
        let kappa = 10f64.powf(random.between(-2.0, 1.0));
        let gas = Cuboid::voxel(Vec3::ZERO, size);
        let volume = size.x * size.y * size.z;
        let sum = kappa * kappa * value(&gas, &gas, kappa)
            + gas.walls().iter().map(|w| kappa * value(&gas, w, kappa)).sum::<f64>();
        self.closure = self.closure.max((sum / (4.0 * kappa * volume) - 1.0).abs());

        let lo = random.vector(-3.0, 3.0) + vec3(4.0, 0.0, 0.0);
        let other = Cuboid::voxel(lo, lo + random.vector(0.3, 2.0));
        let f = value(&gas, &other, kappa);
        let demand = AccuracyRequest::relative(REQUESTED_TOLERANCE);
        let of = |a: &Cuboid, b: &Cuboid| {
            factor(&ZoneShape::Box(*a), &ZoneShape::Box(*b), kappa, demand).bounded.value
        };
        if of(&gas, &other).to_bits() != of(&other, &gas).to_bits() {
            self.reciprocity += 1.0;
        }
        let scale = random.between(0.1, 10.0);
        let by = |c: &Cuboid| Cuboid { lo: c.lo * scale, hi: c.hi * scale, normal: None };
        let scaled = value(&by(&gas), &by(&other), kappa / scale);
        self.scaling = self.scaling.max((scaled / (scale.powi(4) * f) - 1.0).abs());
        self.add_symmetries(&gas, &other, kappa, f);
        let half = size * 0.5;
        let eighths: f64 = (0..8)
            .map(|k| {
                let at = |i: usize| if k >> i & 1 == 1 { half[i] } else { 0.0 };
                let lo = vec3(at(0), at(1), at(2));
                value(&Cuboid::voxel(lo, lo + half), &other, kappa)
            })
            .sum();
        self.additivity = self.additivity.max((eighths / f - 1.0).abs());
    }

    /// The 48 signed permutations of the axes.
    fn add_symmetries(&mut self, gas: &Cuboid, other: &Cuboid, kappa: f64, f: f64) {
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            for signs in 0..8 {
                let sign = [0, 1, 2].map(|k| if signs >> k & 1 == 1 { -1.0 } else { 1.0 });
                let image = value(&turned(gas, order, sign), &turned(other, order, sign), kappa);
                self.symmetries = self.symmetries.max((image / f - 1.0).abs());
            }
        }
    }
}

fn limits(out: &mut CaseOutcome) {
    let gas = Cuboid::voxel(Vec3::ZERO, Vec3::splat(1.0));
    let walls = gas.walls();
    let opposite = |k: f64| value(&walls[0], &walls[1], k);
    let steps: Vec<f64> = (0..200).map(|i| opposite(0.05 * i as f64)).collect();
    let rising = steps.windows(2).filter(|w| w[1] >= w[0]).count();
    out.error("steps of κ at which ss of opposite walls does not fall", rising as f64, 0.0);
    let mut random = UniformSequence(1000);
    let mut beyond = 0.0;
    for _ in 0..40 {
        let (a, b) = (random.vector(0.1, 2.0), random.vector(0.1, 2.0));
        let floor = Cuboid::patch(Vec3::ZERO, vec3(a.x, a.y, 0.0), 2, 1);
        let lid = Cuboid::patch(vec3(a.z, b.z, b.x), vec3(a.z + b.y, b.z + a.x, b.x), 2, -1);
        let f = value(&floor, &lid, 0.0);
        if !(0.0..=floor.measure().min(lid.measure())).contains(&f) {
            beyond += 1.0;
        }
    }
    out.error("pairs of plates outside 0 ≤ F ≤ min(A)", beyond, 0.0);
    let gs = |k: f64| k * value(&gas, &walls[0], k);
    out.check(
        "thin limit: gs/(4κV/6), κ = 10⁻⁸",
        1.0,
        gs(1e-8) / (4e-8 / 6.0),
        AcceptanceLimit::Absolute(1e-7),
    );
    // A wall sees a thick medium but along its edges: 1 − gs = (4 edges × ∫ of what passes the side) ∝ 1/κ.
    let rest = |k: f64| (1.0 - gs(k)) * k;
    out.check(
        "thick limit: (1 − gs) κ, κ = 400 and 200",
        rest(200.0),
        rest(400.0),
        AcceptanceLimit::Relative(5e-3),
    );
}

fn random_room(random: &mut UniformSequence, engine: &str, isothermal: bool) -> BoxScene {
    let size = [random.between(0.5, 2.0), random.between(0.5, 2.0), random.between(0.5, 2.0)];
    let cells = [0; 3].map(|_| 2 + (4.0 * random.next()) as usize);
    let kappa = 10f64.powf(random.between(-1.0, 0.7));
    let emission = if isothermal { "emission = 1\n" } else { "" };
    let mut room = BoxScene::new(size, cells, kappa)
        .medium(&format!("{emission}albedo = {:?}", random.next()))
        .solve(&format!("engine = \"{engine}\""));
    for face in 0..6 {
        let rho = 0.9 * random.next();
        let hot = if isothermal { 1.0 - rho } else { f64::from(u8::from(face == 0)) };
        room = room.wall(face, rho, hot);
    }
    room
}

fn solves(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let mut random = UniformSequence(5000);
    for engine in ["dense", "spectral"] {
        let (mut even, mut kept, mut residual) = (0.0f64, 0.0f64, 0.0f64);
        let mut dark = 0usize;
        for k in 0..6 {
            let name = format!("law-isothermal-{engine}-{k}");
            let s = bench.solve(&name, &random_room(&mut random, engine, true).text(&name))?;
            even = s.fields.radiosity.iter().fold(even, |m, b| m.max((b.first() - 1.0).abs()));
            let name = format!("law-hot-wall-{engine}-{k}");
            let s = bench.solve(&name, &random_room(&mut random, engine, false).text(&name))?;
            kept = kept.max(s.report.energy.residual.first().abs());
            dark += s.fields.incident.iter().filter(|h| h.first() <= 0.0).count();
            residual = residual.max(s.report.residuals[Band::first()].last().copied().unwrap_or(f64::NAN));
        }
        out.error(format!("isothermal enclosures, {engine}: largest |B − 1|"), even, 1e-10);
        out.error(format!("one hot wall, {engine}: energy left over, relative"), kept, 1e-10);
        out.error(format!("one hot wall, {engine}: zones that nothing reaches"), dark as f64, 0.0);
        out.error(format!("one hot wall, {engine}: residual"), residual, 1e-10);
    }
    let room = random_room(&mut UniformSequence(77), "dense", false);
    threads(bench, &mut out, &room)?;
    constant_map(bench, &mut out)?;
    enclosure(bench, &mut out)?;
    Ok(out)
}

fn threads(bench: &CaseContext, out: &mut CaseOutcome, room: &BoxScene) -> Result<(), Failure> {
    let solved = |n: usize| -> Result<Vec<Bands>, Failure> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build();
        let pool = pool.map_err(|e| Failure::new(format!("{n} threads: {e}")))?;
        Ok(pool.install(|| bench.solve("law-threads", &room.text("law-threads")))?.fields.radiosity)
    };
    let one = solved(1)?;
    let mut differ = 0;
    for n in [2, 5] {
        let bits = |v: &[Bands]| v.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        differ += usize::from(bits(&solved(n)?) != bits(&one));
    }
    out.error("solves with 2 and 5 threads that differ from one thread's in a bit", differ as f64, 0.0);
    Ok(())
}

/// An extinction that an array says, the same but for one cell by a millionth, against the uniform medium.
fn constant_map(bench: &CaseContext, out: &mut CaseOutcome) -> Result<(), Failure> {
    let n = 5;
    let room = |kappa| BoxScene::new([1.0; 3], [n; 3], kappa).wall(0, 0.3, 1.0).solve("engine = \"dense\"");
    let uniform = bench.solve("law-uniform", &room(1.0).medium("albedo = 0.5").text("law-uniform"))?;
    let mut kappa = vec![1.0; n * n * n];
    kappa[0] += 1e-6;
    let file = bench.array("law-constant", &[n; 3], &kappa)?;
    let region = format!(
        "[[medium.region]]\ndensity = {{ file = \"{file}\", min = [0, 0, 0], max = [1, 1, 1] }}\nalbedo = 0.5"
    );
    let varying = bench.solve("law-constant", &room(0.0).medium(&region).text("law-constant"))?;
    let pairs = varying.fields.incident.iter().zip(&uniform.fields.incident);
    let d = crate::validate::measures::rms(pairs.map(|(a, b)| a.first() / b.first() - 1.0));
    out.error("a constant array against the uniform medium: RMS of the relative difference", d, 2e-3);
    Ok(())
}

fn enclosure(bench: &CaseContext, out: &mut CaseOutcome) -> Result<(), Failure> {
    let text = random_room(&mut UniformSequence(99), "dense", true).text("law-picture");
    let camera =
        "\n[[camera]]\nname = \"inside\"\norigin = [0.2, 0.2, 0.2]\ntarget = [0.4, 0.45, 0.35]\nfov = 80\n";
    let s = bench.solve("law-picture", &(text + camera))?;
    let Some(camera) = s.scene.cameras().first() else { return Err(Failure::new("law-picture: no camera")) };
    let options = RenderOptions { width: 32, height: 24, samples: 4, ..RenderOptions::default() };
    let image = render(&s, camera, &options, bench.progress);
    let worst =
        image.pixels.iter().fold(0.0f64, |m, p| m.max((f64::from(p[0]) * std::f64::consts::PI - 1.0).abs()));
    out.error("picture in an enclosure of one temperature: largest |πL/E − 1|", worst, 1e-4);
    // One hot wall in a vacuum, seen perpendicularly: the mean radiance is W/π of the wall.
    let text = BoxScene::new([1.0; 3], [8; 3], 1e-9).wall(0, 0.5, 1.0).wall(1, 0.5, 0.0).text("law-wall")
        + "\n[[camera]]\nname = \"wall\"\norigin = [0.5, 0.5, 0.5]\ntarget = [1, 0.5, 0.5]\nfov = 90\n";
    let s = bench.solve("law-wall", &text)?;
    let Some(camera) = s.scene.cameras().first() else { return Err(Failure::new("law-wall: no camera")) };
    let options = RenderOptions { width: 64, height: 64, samples: 4, ..RenderOptions::default() };
    let image = render(&s, camera, &options, bench.progress);
    let mean = image.pixels.iter().map(|p| f64::from(p[0])).sum::<f64>() / image.pixels.len() as f64;
    let wall = WallMeans::of(&s, "x1").radiosity / std::f64::consts::PI;
    out.check(
        "picture of a flat wall: mean radiance, W/(m² sr)",
        wall,
        mean,
        AcceptanceLimit::Relative(5e-3),
    );
    Ok(())
}

/// Ψ of a thick slab between black plates.
pub(crate) fn diffusion(tau: f64) -> f64 {
    const TEMPERATURE_JUMP: f64 = 1.420_892;
    4.0 / 3.0 / (tau + TEMPERATURE_JUMP)
}

fn thick(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    const OPTICAL_THICKNESS: f64 = 50.0;
    let mut out = CaseOutcome::default();
    let mut steps = Vec::new();
    for n in [100, 200, 400, 800] {
        let name = format!("thick-limit-{n}");
        let room = BoxScene::layer(OPTICAL_THICKNESS, n)
            .medium("albedo = 1")
            .wall(4, 0.0, 1.0)
            .solve(&format!("engine = \"spectral\"\nmax_iterations = 3000\n{}", super::cube::CONSTANT_BASIS));
        let s = bench.solve(&name, &room.text(&name))?;
        steps.push((n as f64, WallMeans::of(&s, "z0").net()));
    }
    let exact = diffusion(OPTICAL_THICKNESS);
    let sequence = ResolutionSequence::new("Ψ, τ = 50", steps, Some((exact, 0.0)));
    out.check("Ψ, τ = 50, extrapolated", exact, sequence.value(), AcceptanceLimit::Relative(1e-4));
    out.sequences.push(sequence);
    Ok(out)
}
