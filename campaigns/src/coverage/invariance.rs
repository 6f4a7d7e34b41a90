//! Equivalent forms of a scene: named sums must agree within the stated errors of both solutions.

use super::measure::{EngineVariant, solved};
use super::model::{
    HeatCondition, MediumPart, ModelLight, ModelShape, ModelSurface, RigidMotion, SceneModel,
    SurfaceProperties, add, last_band, quad, times,
};
use super::quantities::{NamedSum, SumSubject, scale, sums};
use super::result::InvarianceOutcome;
use std::path::Path;
use zonal_reference::Rng;
use zonal_scene::Solution;

/// Differences below this share of the largest power, or of a temperature, are rounding.
const ROUNDING_SHARE: f64 = 1e-9;

/// Names of the invariances.
pub(super) const INVARIANCES: [&str; 10] = [
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

/// The other form, with the factor of its powers and of its temperatures; none where it does not make sense.
fn other(model: &SceneModel, k: usize, rng: &mut Rng) -> Option<(SceneModel, [f64; 2])> {
    let motion = |rows, shift| RigidMotion { rows, shift };
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let same = [1.0, 1.0];
    match k {
        0 => Some((model.moved(&motion([[-1.0, 0.0, 0.0], one[1], one[2]], [0.0; 3])), same)),
        1 => Some((model.moved(&motion([[0.0, -1.0, 0.0], one[0], one[2]], [0.0; 3])), same)),
        2 if model.medium.is_none() => {
            let (a, b) = (rng.unit_vector(), rng.unit_vector());
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
        6 => split(model, rng).map(|m| (m, same)),
        7 if !model.shares.contains("weights") => Some((doubled(model), [0.5, 0.5f64.powf(0.25)])),
        8 => alike(model).map(|m| (m, same)),
        9 => Some((meshed(model), same)),
        _ => None,
    }
}

/// One plate as two, of the names X and X~.
fn split(model: &SceneModel, rng: &mut Rng) -> Option<SceneModel> {
    let mut m = model.lowered();
    let lamp = |s: &ModelSurface| {
        m.lights.iter().any(|l| matches!(l, ModelLight::Emitter { surface } if *surface == s.name))
    };
    let plates: Vec<usize> = (0..m.surfaces.len())
        .filter(|&k| matches!(m.surfaces[k].shape, ModelShape::Plate { .. }) && !lamp(&m.surfaces[k]))
        .collect();
    let k = *plates.get((rng.uniform() * plates.len() as f64) as usize)?;
    let ModelShape::Plate { corner, edges: [a, b], triangle } = m.surfaces[k].shape.clone() else {
        return None;
    };
    if let HeatCondition::Power(p) = &mut m.surfaces[k].look.heat {
        *p *= 0.5;
    }
    let half = times(a, 0.5);
    let mut second = m.surfaces[k].clone();
    second.name += "~";
    m.surfaces[k].shape = ModelShape::Plate { corner, edges: [half, b], triangle };
    let edges = if triangle { [half, add(b, times(a, -0.5))] } else { [half, b] };
    second.shape = ModelShape::Plate { corner: add(corner, half), edges, triangle };
    m.surfaces.push(second);
    Some(m)
}

fn looks(m: &mut SceneModel, mut change: impl FnMut(&mut SurfaceProperties)) {
    for s in &mut m.surfaces {
        change(&mut s.look);
        if let ModelShape::Room { walls, .. } = &mut s.shape {
            walls.iter_mut().flatten().for_each(&mut change);
        }
    }
}

fn parts(m: &mut SceneModel) -> impl Iterator<Item = &mut MediumPart> {
    m.medium.iter_mut().flat_map(|x| std::iter::once(&mut x.whole).chain(&mut x.regions))
}

fn doubled(model: &SceneModel) -> SceneModel {
    let mut m = model.clone();
    let warmer = 2f64.powf(0.25);
    let heat = |h: &mut HeatCondition| match h {
        HeatCondition::Temperature(t) => *t *= warmer,
        HeatCondition::Flux(q) | HeatCondition::Power(q) => *q *= 2.0,
    };
    looks(&mut m, |l| {
        l.emission *= 2.0;
        heat(&mut l.heat);
    });
    parts(&mut m).for_each(|p| {
        (p.emission, p.source) = (p.emission * 2.0, p.source * 2.0);
        heat(&mut p.heat);
    });
    for p in &mut m.panes {
        p.emission *= 2.0;
        p.temperature = p.temperature.map(|t| t * warmer);
    }
    for l in &mut m.lights {
        match l {
            ModelLight::Sun { irradiance: x, .. } | ModelLight::Sky { radiance: x } => *x *= 2.0,
            ModelLight::Emitter { .. } => {}
        }
    }
    m.radiance *= 2.0;
    m.surroundings = m.surroundings.map(|t| t * warmer);
    m
}

/// Heat of one band shared by two; light of one band, beside which the last becomes another.
fn alike(model: &SceneModel) -> Option<SceneModel> {
    let mut m = model.clone();
    if m.thermal {
        if !m.shares.is_empty() {
            return None;
        }
        m.shares = "band_fractions = [0.5, 0.5, 0.0]".into();
        return Some(m);
    }
    if !m.features.contains(&"one band") {
        return None;
    }
    looks(&mut m, |l| l.reflectance[last_band()] *= 0.7);
    Some(m)
}

/// Plates and boxes as OBJ files.
fn meshed(model: &SceneModel) -> SceneModel {
    let mut m = model.lowered();
    let lamps: Vec<String> = (m.lights.iter())
        .filter_map(|l| if let ModelLight::Emitter { surface } = l { Some(surface.clone()) } else { None })
        .collect();
    for s in m.surfaces.iter_mut().filter(|s| !lamps.contains(&s.name)) {
        if let ModelShape::Plate { corner, edges, triangle: false } = s.shape
            && !s.look.both
        {
            s.shape = ModelShape::Mesh { quads: vec![quad(corner, edges)] };
        }
    }
    m
}

/// Compares a solution of a variant with that of the transformed scene, drawn by `rng`.
pub(super) fn check_invariance(
    model: &SceneModel,
    variant: &EngineVariant,
    own: &Solution,
    rng: &mut Rng,
    folder: &Path,
) -> InvarianceOutcome {
    let (name, (other, factors)) = loop {
        let k = (rng.uniform() * INVARIANCES.len() as f64) as usize;
        if let Some(other) = other(model, k, rng) {
            break (INVARIANCES[k], other);
        }
    };
    let mut out = InvarianceOutcome { name, ..InvarianceOutcome::default() };
    let turned = match solved(&other, variant, folder) {
        Ok(Some(s)) => s,
        Ok(None) => return out,
        Err(e) => {
            out.failure = Some(format!("{}: {e}", variant.name));
            return out;
        }
    };
    let (mine, theirs) = (sums(own), sums(&turned));
    let largest = scale(&mine);
    for a in &mine {
        if !theirs.iter().any(|s| s.what == a.what) {
            out.failure = Some(format!("the other scene has no {}", a.what));
            continue;
        }
        let Some(([x, y], stated)) = paired_values(name, a, &theirs, factors) else { continue };
        let slack = if a.of.is_temperature() { a.value } else { largest };
        out.compared += 1;
        let difference = (x - y).abs();
        if !stated.is_finite() {
            out.unknown += 1;
        } else if difference.is_nan() || difference > stated + ROUNDING_SHARE * slack.abs() {
            let (engine, what) = (variant.name, &a.what);
            out.broken.push(format!("{engine}: {what} = {x:.6e}, otherwise {y:.6e}, stated {stated:.1e}"));
        }
    }
    out
}

/// A sum and its counterpart of the transformed scene, brought back by the factors of power and temperature, with both stated errors added;
/// `None` where the two are not comparable.
fn paired_values(
    name: &str,
    a: &NamedSum,
    theirs: &[NamedSum],
    [watt, kelvin]: [f64; 2],
) -> Option<([f64; 2], f64)> {
    use SumSubject::{Escaped, Medium, Panes, Surface};
    let b = theirs.iter().find(|s| s.what == a.what)?;
    let factor = if a.of.is_temperature() { kelvin } else { watt };
    let in_last = matches!(a.of, Surface(_, b) | Medium(b) | Panes(b) | Escaped(b) if b == last_band());
    if name == "two bands that are alike" && in_last {
        return None;
    }
    let mut values = [a.value, factor * b.value];
    let mut stated = a.stated + factor * b.stated;
    // A surface that was split has two rows.
    let at = a.what.split(", band").next().unwrap_or(&a.what);
    let more = a.what.replacen(at, &format!("{at}~"), 1);
    if let Some(c) = theirs.iter().find(|s| s.what == more) {
        if a.of.is_temperature() {
            return None;
        }
        values[1] += factor * c.value;
        stated += factor * c.stated;
    }
    Some((values, stated))
}
