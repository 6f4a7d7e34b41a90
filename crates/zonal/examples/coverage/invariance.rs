//! The same scene said otherwise: sums by name must agree within the errors that both solutions state.

use super::measure::{Of, Sum, scale, solved, sums};
use super::model::{Heat, Light, Look, Model, Motion, Part, Shape, Surface, add, times};
use std::path::Path;
use zonal::scene::Solution;
use zonal_reference::Dice;

/// Differences below this share of the largest power, or of a temperature, are rounding.
const ROUNDING: f64 = 1e-9;

/// Names of the invariances.
pub(crate) const ALL: [&str; 10] = [
    "mirrored",
    "turned by 90 degrees",
    "turned by some angle",
    "moved by a kilometre",
    "ten times as large",
    "listed in another order",
    "a surface split in two",
    "emission doubled",
    "two bands that are alike",
    "plates written as meshes",
];

/// A sum that two ways of saying a scene do not agree on, or of which one does not know its error.
#[derive(Clone, Debug)]
pub(crate) struct Broken {
    pub scene: u64,
    pub invariance: &'static str,
    pub engine: &'static str,
    pub what: String,
    /// Of the scene as it is, and of the other, brought back.
    pub values: [f64; 2],
    /// Both stated errors added up.
    pub stated: f64,
}

/// What the comparison of a scene with its other form comes to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    pub compared: usize,
    pub unknown: usize,
    pub broken: Vec<Broken>,
    pub failure: Option<String>,
}

/// The other form, with the factor of its powers and of its temperatures; none where it does not make sense.
fn other(model: &Model, k: usize, dice: &mut Dice) -> Option<(Model, [f64; 2])> {
    let motion = |rows, shift| Motion { rows, shift };
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let same = [1.0, 1.0];
    match k {
        0 => Some((model.moved(&motion([[-1.0, 0.0, 0.0], one[1], one[2]], [0.0; 3])), same)),
        1 => Some((model.moved(&motion([[0.0, -1.0, 0.0], one[0], one[2]], [0.0; 3])), same)),
        2 if model.medium.is_none() => {
            let (a, b) = (dice.direction(), dice.direction());
            let x = a.normalized();
            let z = x.cross(b).normalized();
            let y = z.cross(x);
            Some((model.moved(&motion([x.array(), y.array(), z.array()], [0.0; 3])), same))
        }
        3 => Some((model.moved(&motion(one, [1000.0, 0.0, 0.0])), same)),
        4 => Some((model.scaled(10.0), [0.01, 1.0])),
        5 => {
            let mut m = model.lowered();
            m.surfaces.reverse();
            m.panes.reverse();
            Some((m, same))
        }
        6 => split(model, dice).map(|m| (m, same)),
        7 if !model.shares.contains("weights") => Some((doubled(model), [0.5, 0.5f64.powf(0.25)])),
        8 => alike(model).map(|m| (m, same)),
        9 => Some((meshed(model), same)),
        _ => None,
    }
}

/// One plate as two, of the names X and X~.
fn split(model: &Model, dice: &mut Dice) -> Option<Model> {
    let mut m = model.lowered();
    let lamp =
        |s: &Surface| m.lights.iter().any(|l| matches!(l, Light::Emitter { surface } if *surface == s.name));
    let plates: Vec<usize> = (0..m.surfaces.len())
        .filter(|&k| matches!(m.surfaces[k].shape, Shape::Plate { .. }) && !lamp(&m.surfaces[k]))
        .collect();
    let k = *plates.get((dice.roll() * plates.len() as f64) as usize)?;
    let Shape::Plate { corner, edges: [a, b], triangle } = m.surfaces[k].shape.clone() else { return None };
    if let Heat::Power(p) = &mut m.surfaces[k].look.heat {
        *p *= 0.5;
    }
    let half = times(a, 0.5);
    let mut second = m.surfaces[k].clone();
    second.name += "~";
    m.surfaces[k].shape = Shape::Plate { corner, edges: [half, b], triangle };
    let edges = if triangle { [half, add(b, times(a, -0.5))] } else { [half, b] };
    second.shape = Shape::Plate { corner: add(corner, half), edges, triangle };
    m.surfaces.push(second);
    Some(m)
}

fn looks(m: &mut Model, mut change: impl FnMut(&mut Look)) {
    for s in &mut m.surfaces {
        change(&mut s.look);
        if let Shape::Room { walls, .. } = &mut s.shape {
            walls.iter_mut().flatten().for_each(&mut change);
        }
    }
}

fn parts(m: &mut Model) -> impl Iterator<Item = &mut Part> {
    m.medium.iter_mut().flat_map(|x| std::iter::once(&mut x.whole).chain(&mut x.regions))
}

fn doubled(model: &Model) -> Model {
    let mut m = model.clone();
    let warmer = 2f64.powf(0.25);
    let heat = |h: &mut Heat| match h {
        Heat::Temperature(t) => *t *= warmer,
        Heat::Flux(q) | Heat::Power(q) => *q *= 2.0,
    };
    looks(&mut m, |l| {
        l.emission = times(l.emission, 2.0);
        heat(&mut l.heat);
    });
    parts(&mut m).for_each(|p| {
        (p.emission, p.source) = (times(p.emission, 2.0), times(p.source, 2.0));
        heat(&mut p.heat);
    });
    for p in &mut m.panes {
        p.emission = times(p.emission, 2.0);
        p.temperature = p.temperature.map(|t| t * warmer);
    }
    for l in &mut m.lights {
        match l {
            Light::Sun { irradiance: x, .. } | Light::Sky { radiance: x } => *x = times(*x, 2.0),
            Light::Emitter { .. } => {}
        }
    }
    m.radiance = times(m.radiance, 2.0);
    m.surroundings = m.surroundings.map(|t| t * warmer);
    m
}

/// Heat of one band shared by two; light of one band, beside which the last becomes another.
fn alike(model: &Model) -> Option<Model> {
    let mut m = model.clone();
    if m.thermal {
        if !m.shares.is_empty() {
            return None;
        }
        m.shares = "shares = [0.5, 0.5, 0.0]".into();
        return Some(m);
    }
    if !m.features.contains(&"one band") {
        return None;
    }
    looks(&mut m, |l| l.reflectance[2] *= 0.7);
    Some(m)
}

/// Plates and boxes as OBJ files.
fn meshed(model: &Model) -> Model {
    let mut m = model.lowered();
    let lamps: Vec<String> = (m.lights.iter())
        .filter_map(|l| if let Light::Emitter { surface } = l { Some(surface.clone()) } else { None })
        .collect();
    for s in m.surfaces.iter_mut().filter(|s| !lamps.contains(&s.name)) {
        if let Shape::Plate { corner, edges: [a, b], triangle: false } = s.shape
            && !s.look.both
        {
            let quad = [corner, add(corner, a), add(add(corner, a), b), add(corner, b)];
            s.shape = Shape::Mesh { quads: vec![quad] };
        }
    }
    m
}

/// Compares a solution with that of the scene said otherwise, drawn by `dice`.
pub(crate) fn check(
    model: &Model,
    scene: u64,
    (words, engine, basis): (&'static str, &str, &str),
    own: &Solution,
    dice: &mut Dice,
    folder: &Path,
) -> (&'static str, Outcome) {
    let mut out = Outcome::default();
    let (name, (other, [watt, kelvin])) = loop {
        let k = (dice.roll() * ALL.len() as f64) as usize;
        if let Some(other) = other(model, k, dice) {
            break (ALL[k], other);
        }
    };
    let turned = match solved(&other, engine, basis, folder) {
        Ok(Some(s)) => s,
        Ok(None) => return (name, out),
        Err(e) => {
            out.failure = Some(format!("{name}, {engine}: {e}"));
            return (name, out);
        }
    };
    let (mine, theirs) = (sums(own), sums(&turned));
    let largest = scale(&mine);
    for a in &mine {
        let same = |s: &&Sum| s.what == a.what;
        let Some(b) = theirs.iter().find(same) else {
            out.failure = Some(format!("{name}: the other scene has no {}", a.what));
            continue;
        };
        let (factor, slack) = match a.of {
            Of::Temperature(_) => (kelvin, a.value),
            _ => (watt, largest),
        };
        if name == "two bands that are alike"
            && matches!(a.of, Of::Surface(_, 2) | Of::Medium(2) | Of::Panes(2) | Of::Escaped(2))
        {
            continue;
        }
        let mut values = [a.value, factor * b.value];
        let mut stated = a.stated + factor * b.stated;
        // A surface that was split has two rows there.
        let at = a.what.split(", band").next().unwrap_or(&a.what);
        let more = a.what.replacen(at, &format!("{at}~"), 1);
        if let Some(c) = theirs.iter().find(|s| s.what == more) {
            if matches!(a.of, Of::Temperature(_)) {
                continue;
            }
            values[1] += factor * c.value;
            stated += factor * c.stated;
        }
        out.compared += 1;
        let difference = (values[0] - values[1]).abs();
        if !stated.is_finite() {
            out.unknown += 1;
        } else if difference.is_nan() || difference > stated + ROUNDING * slack.abs() {
            out.broken.push(Broken {
                scene,
                invariance: name,
                engine: words,
                what: a.what.clone(),
                values,
                stated,
            });
        }
    }
    (name, out)
}
