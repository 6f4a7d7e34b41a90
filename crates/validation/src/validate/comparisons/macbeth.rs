//! Pictures through wavelengths: the 24 patches of the Macbeth chart in sixteen bands against integrals at 5 nm.
//!
//! ```text
//!     (X, Y, Z) = Σ_λ ρ(λ) S(λ) (x̄, ȳ, z̄)(λ) / Σ_λ S(λ) ȳ(λ)
//! ```
//!
//! The chart lies below a distant light; a narrow camera above each patch gives its colour. ΔE₀₀ is the colour difference CIEDE2000 (ISO/CIE 11664-6:2014) about the white of the
//! light, with a patch of reflectance 1 as the unit of Y.

use crate::validate::case::{CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use zonal_math::{Vec3, vec3};
use zonal_render::{RenderOptions, render_each};
use zonal_report::Failure;
use zonal_scene::Camera;

/// Number of bands from 400 to 700 nm.
const BANDS: usize = 16;
/// Names of the columns of patches, in the order of the chart.
const PATCHES: [&str; 24] = [
    "dark skin",
    "light skin",
    "blue sky",
    "foliage",
    "blue flower",
    "bluish green",
    "orange",
    "purplish blue",
    "moderate red",
    "purple",
    "yellow green",
    "orange yellow",
    "blue",
    "green",
    "red",
    "yellow",
    "magenta",
    "cyan",
    "white",
    "neutral 8",
    "neutral 6.5",
    "neutral 5",
    "neutral 3.5",
    "black 2",
];
/// hc/k, nm K.
const SECOND_RADIATION_CONSTANT: f64 = 1.438_776_877e7;

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "macbeth",
    group: "Pictures through wavelengths",
    title: "Macbeth chart under D65 and 2856 K, sixteen bands",
    about: "Spectra of N. Ohta. The patches are solved in sixteen bands from 400 to 700 nm and drawn; colours against sums at 5 nm from 380 to 780 nm. Limits of ΔE₀₀: 0.5 in the mean, 1.5 at most.",
    quick: true,
    needs: None,
    run,
}];

/// The colour matching functions and the light at one wavelength, and the reflectances there.
struct Sample {
    matching: [f64; 3],
    light: f64,
    reflectances: Vec<f64>,
}

fn run(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for (name, light) in [("D65", "illuminant = \"D65\""), ("2856 K", "black_body = 2856")] {
        let samples = samples(name)?;
        let ours = drawn_colours(bench, light)?;
        let white = colour(&samples, |_| 1.0);
        let own_white = ours[PATCHES.len()][1];
        let differences = (0..PATCHES.len()).map(|k| {
            let wanted = lab(colour(&samples, |s| s.reflectances[k]), white);
            difference(lab(ours[k].map(|x| x / own_white), white), wanted)
        });
        let differences: Vec<f64> = differences.collect();
        let largest = differences.iter().fold(0.0f64, |m, d| m.max(*d));
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        let patch = differences.iter().position(|d| *d == largest).map_or("", |k| PATCHES[k]);
        out.error(format!("{name}: mean ΔE₀₀"), mean, 0.5);
        out.error(format!("{name}: largest ΔE₀₀ ({patch})"), largest, 1.5);
    }
    Ok(out)
}

/// The table with a light.
fn samples(light: &str) -> Result<Vec<Sample>, Failure> {
    let table = table!("macbeth.csv")?;
    let sample = |row: crate::validate::data::ReferenceRow| {
        let wavelength = row.number("wavelength")?;
        let planck = wavelength.powi(-5) / (SECOND_RADIATION_CONSTANT / (wavelength * 2856.0)).exp_m1();
        Ok(Sample {
            matching: [row.number("xbar")?, row.number("ybar")?, row.number("zbar")?],
            light: if light == "D65" { row.number("D65")? } else { planck },
            reflectances: PATCHES.iter().map(|p| row.number(p)).collect::<Result<_, _>>()?,
        })
    };
    table.rows().map(sample).collect()
}

/// X, Y, Z of a reflectance over Y of the light.
fn colour(samples: &[Sample], reflectance: impl Fn(&Sample) -> f64) -> [f64; 3] {
    let all: f64 = samples.iter().map(|s| s.light * s.matching[1]).sum();
    std::array::from_fn(|c| {
        samples.iter().map(|s| reflectance(s) * s.light * s.matching[c]).sum::<f64>() / all
    })
}

/// X, Y, Z of all patches, and of a white one, in a picture of the scene.
fn drawn_colours(bench: &CaseContext, light: &str) -> Result<Vec<[f64; 3]>, Failure> {
    let table = table!("macbeth.csv")?;
    let mut csv = format!("wavelength,{}\n", PATCHES.join(","));
    for row in table.rows() {
        let cells = PATCHES.iter().map(|p| row.text(p)).collect::<Result<Vec<_>, _>>()?;
        csv += &format!("{},{}\n", row.text("wavelength")?, cells.join(","));
    }
    let file = bench.text_file("macbeth.csv", &csv)?;
    let width = 300.0 / BANDS as f64;
    let bands: Vec<String> = (0..BANDS)
        .map(|b| format!("[{:?}, {:?}]", 400.0 + width * b as f64, 400.0 + width * (b + 1) as f64))
        .collect();
    let mut text = format!(
        "bands = [{}]\n[solve]\npatch_size = 1\n[[light]]\nkind = \"sun\"\ndirection = [0, 0, -1]\nirradiance = {{ {light}, total = 1000 }}\nangular_diameter = 0\n",
        bands.join(", ")
    );
    let mut cameras = Vec::new();
    for k in 0..=PATCHES.len() {
        let reflectance = match PATCHES.get(k) {
            Some(name) => format!("{{ spectrum = \"{file}\", column = \"{name}\" }}"),
            None => "1".to_string(),
        };
        let (x, y) = ((k % 6) as f64 * 1.1, (k / 6) as f64 * 1.1);
        text += &format!(
            "[[surface]]\nname = \"patch{k}\"\nrectangle = {{ origin = [{x:?}, {y:?}, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }}\nreflectance = {reflectance}\n"
        );
        let centre = vec3(x + 0.5, y + 0.5, 0.0);
        let origin = centre + vec3(0.0, 0.0, 1.0);
        cameras.push(Camera {
            up: vec3(0.0, 1.0, 0.0),
            fov: 10.0,
            ..Camera::look_at(origin.array(), centre.array())
        });
    }
    let s = bench.solve(&format!("macbeth-{}", if light.contains("D65") { "d65" } else { "2856" }), &text)?;
    let options = RenderOptions { width: 3, height: 3, samples: 1, ..RenderOptions::default() };
    let mut colours = Vec::new();
    render_each(&s, &cameras, &options, bench.progress, |_, image| {
        colours.push(xyz(image.pixels[4].map(f64::from)));
        Ok::<(), Failure>(())
    })?;
    Ok(colours)
}

/// X, Y, Z of linear sRGB (IEC 61966-2-1).
fn xyz([r, g, b]: [f64; 3]) -> [f64; 3] {
    let m = [
        vec3(0.412_390_8, 0.357_584_3, 0.180_480_8),
        vec3(0.212_639_0, 0.715_168_7, 0.072_192_3),
        vec3(0.019_330_8, 0.119_194_8, 0.950_532_2),
    ];
    m.map(|row: Vec3| row.dot(vec3(r, g, b)))
}

/// L*, a*, b* about a white.
fn lab(colour: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let f = |k: usize| {
        let t = colour[k] / white[k];
        if t > (6.0f64 / 29.0).powi(3) { t.cbrt() } else { t / (3.0 * (6.0f64 / 29.0).powi(2)) + 4.0 / 29.0 }
    };
    [116.0 * f(1) - 16.0, 500.0 * (f(0) - f(1)), 200.0 * (f(1) - f(2))]
}

/// CIEDE2000 of two colours.
fn difference([l1, a1, b1]: [f64; 3], [l2, a2, b2]: [f64; 3]) -> f64 {
    let seventh = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - seventh(0.5 * (a1.hypot(b1) + a2.hypot(b2))));
    let [(c1, h1), (c2, h2)] = [(a1, b1), (a2, b2)].map(|(a, b)| {
        let a = (1.0 + g) * a;
        (a.hypot(b), b.atan2(a).to_degrees().rem_euclid(360.0))
    });
    let is_grey = c1 * c2 == 0.0;
    let dh = match h2 - h1 {
        _ if is_grey => 0.0,
        d if d > 180.0 => d - 360.0,
        d if d < -180.0 => d + 360.0,
        d => d,
    };
    let is_across_zero = (h1 - h2).abs() > 180.0;
    let mean_hue = if is_grey {
        h1 + h2
    } else if !is_across_zero {
        0.5 * (h1 + h2)
    } else if h1 + h2 < 360.0 {
        0.5 * (h1 + h2 + 360.0)
    } else {
        0.5 * (h1 + h2 - 360.0)
    };
    let (l, c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let cosine = |factor: f64, shift: f64| (factor * mean_hue + shift).to_radians().cos();
    let t = 1.0 - 0.17 * cosine(1.0, -30.0) + 0.24 * cosine(2.0, 0.0) + 0.32 * cosine(3.0, 6.0)
        - 0.2 * cosine(4.0, -63.0);
    let rotation =
        -2.0 * seventh(c) * (60.0 * (-((mean_hue - 275.0) / 25.0).powi(2)).exp()).to_radians().sin();
    let lightness = (l - 50.0).powi(2);
    let terms = [
        (l2 - l1) / (1.0 + 0.015 * lightness / (20.0 + lightness).sqrt()),
        (c2 - c1) / (1.0 + 0.045 * c),
        2.0 * (c1 * c2).sqrt() * (0.5 * dh).to_radians().sin() / (1.0 + 0.015 * c * t),
    ];
    (terms.iter().map(|x| x * x).sum::<f64>() + rotation * terms[1] * terms[2]).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of the test data of Sharma, Wu and Dalal (2005).
    #[test]
    fn colour_differences_are_those_of_published_pairs() {
        for (one, other, wanted) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
        ] {
            assert!((difference(one, other) - wanted).abs() < 5e-5, "{}", difference(one, other));
        }
    }
}
