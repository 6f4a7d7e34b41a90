//! Heat transfer with closed forms: shields, collectors, satellites, fins, convection, insulation, a cavity.
//!
//! ```text
//! collector           α G = ε σ (T⁴ − T_sky⁴) + h (T − T_air) + q
//! body below a lamp   α E F = ε σ (T⁴ − T_sky⁴)                              F of coaxial squares, T_lamp = T_sky
//! plate in orbit      α (S + M_r sin²β) + ε M sin²β = 2 ε σ T⁴                    β half the angle of the planet's disc
//! box in sunlight     α S Σ A_i cos⁺θ_i = ε A σ T⁴
//! shields             Q = A₁ σ (T₁⁴ − T₂⁴)/R,   R = 1/ε₁ + Σ (A₁/A_s)(1/ε_in + 1/ε_out − 1) + (A₁/A₂)(1/ε₂ − 1)
//! radiating fin       k δ T'' = 2 ε σ T⁴,   T' = −√(4 ε σ (T⁵ − T_tip⁵)/(5 k δ)),   T'(L) = 0
//! insulation          α S A_s = 6 ε A σ T⁴ + 6 ε* A σ (T⁴ − T_tank⁴)
//! ```
//!
//! (Concentric convex bodies with uniform radiosities, with the areas of their facets.)

use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use std::f64::consts::PI;
use zonal_math::{Vec3, vec3};
use zonal_report::Failure;
use zonal_scene::thermal::{STEFAN_BOLTZMANN, blackbody_emissive_power, blackbody_temperature};
use zonal_scene::{HeatRow, Mesh, NodeCondition, NodeResult, Scene, Solution};

/// Part of a value that rounding and the residual of the solver may take beside the stated error.
const ROUNDING: f64 = 1e-8;

/// The cases.
pub(crate) const CASES: [ValidationCase; 8] = [
    case(
        "shields",
        "spheres with a shield between them, three emissivities",
        "Concentric spheres of 80 triangles with a shield whose sides differ (0.3 inside, 0.1 outside; a node), 600 K within 300 K. Closed form with the areas of the facets; faceting, the difference from \
         round spheres, is informational. Limit: the stated error of the exchange.",
        shields,
    ),
    case(
        "collector",
        "flat-plate collector: stagnation, useful heat, losses by convection, a lamp",
        "A selective plate (α 0.95, ε 0.1) in 800 W/m² below a sky of 280 K, with and without air; and a body (α 0.4, ε 0.1) of one temperature below a coaxial lamp of 5 kW. Limit: the stated error.",
        collector,
    ),
    case(
        "orbit",
        "plate in low orbit with albedo and infrared of the planet",
        "A plate of one temperature (α 0.2, ε 0.85; a node) faces the sun; a planet of 140° that emits as 255 K and reflects 400 W/m² fills the other side. Limit: the stated error.",
        orbit,
    ),
    case(
        "satellite",
        "isothermal box in sunlight",
        "A box of one temperature (a node) with an inclined sun on three of its faces; and the same box with six faces of their own temperatures. Limit: the stated error.",
        satellite,
    ),
    case(
        "fin",
        "radiating fin: conduction along a chain of nodes",
        "A plate at 500 K along one edge radiates from both sides into cold space. Temperatures of a chain of nodes against its equations solved alone, limit: the stated error; heat of 16 and 32 nodes extrapolated to the \
         differential equation, limit 0.1 %.",
        fin,
    ),
    case(
        "convection",
        "convection to equilibrium with radiation",
        "A convex body of given power in a black room, cooled by air of another temperature. Limit: the stated error.",
        convection,
    ),
    case(
        "insulation",
        "multilayer insulation of a cold tank in sunlight",
        "A box in sunlight around a tank at 90 K behind insulation of effective emissivity 0.02: temperature of the skin, and heat to the tank. Limit: the stated error.",
        insulation,
    ),
    case(
        "hohlraum",
        "cavity of one temperature with walls of any emissivity",
        "Walls of emissivity 0.1 to 0.9 and a hot gas, all at 800 K: every irradiance is σT⁴ and every net flux 0; a body of unknown temperature inside has that of the walls. Limit: the stated error.",
        hohlraum,
    ),
];

const fn case(
    name: &'static str,
    title: &'static str,
    about: &'static str,
    run: fn(&CaseContext) -> Result<CaseOutcome, Failure>,
) -> ValidationCase {
    ValidationCase {
        name,
        group: "Heat transfer with closed forms",
        title,
        about,
        quick: true,
        needs: None,
        run,
    }
}

/// Temperature (K) or power (W) with its stated error.
type Stated = [f64; 2];

fn check(out: &mut CaseOutcome, quantity: &str, [ours, error]: Stated, exact: f64) {
    out.error(
        format!("{quantity}: {ours:.3}, exactly {exact:.3}, stated ± {error:.2e}"),
        ours - exact,
        error + ROUNDING * exact.abs().max(1.0),
    );
}

/// The row of a name.
fn row<'a>(s: &'a Solution, name: &str) -> Result<&'a HeatRow, Failure> {
    let mut rows = s.report.heat.iter().flat_map(|h| &h.rows);
    rows.find(|r| r.name == name).ok_or_else(|| Failure::new(format!("there is no part {name}")))
}

/// Temperature and net power of a part, each with its exchange error.
fn part(s: &Solution, name: &str) -> Result<[Stated; 2], Failure> {
    let r = row(s, name)?;
    let kelvin = [r.temperature, r.temperature_error].map(|x| x.unwrap_or(f64::NAN));
    Ok([kelvin, [r.power, r.power_error]])
}

fn node<'a>(s: &'a Solution, name: &str) -> Result<&'a NodeResult, Failure> {
    let mut nodes = s.report.heat.iter().flat_map(|h| &h.nodes);
    nodes.find(|n| n.name == name).ok_or_else(|| Failure::new(format!("there is no node {name}")))
}

/// The root of an increasing function between two values.
fn root([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// A sphere of 80 triangles: an icosahedron divided once. Its corners lie on the sphere; normals point outward.
fn sphere(radius: f64) -> Vec<[Vec3; 3]> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let mut corners = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        corners.extend([vec3(0.0, a, b), vec3(a, b, 0.0), vec3(b, 0.0, a)]);
    }
    // The faces join corners whose distance is that of neighbours, 2.
    let near = |a: Vec3, b: Vec3| ((a - b).length() - 2.0).abs() < 1e-9;
    let mut faces = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners.iter().skip(j + 1).filter(|c| near(a, b) && near(b, **c) && near(**c, a)) {
                let outward = (b - a).cross(c - a).dot(a) > 0.0;
                faces.push(if outward { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    let unit = |p: Vec3| p.normalized();
    let divided = faces.iter().flat_map(|[a, b, c]| {
        let [a, b, c] = [unit(*a), unit(*b), unit(*c)];
        let [ab, bc, ca] = [unit(a + b), unit(b + c), unit(c + a)];
        [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    });
    divided.map(|f| f.map(|p| p * radius)).collect()
}

/// The area of triangles, m².
fn area(faces: &[[Vec3; 3]]) -> f64 {
    faces.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum()
}

/// A surface of triangles, turned inward or not.
fn surface(faces: &[[Vec3; 3]], name: &str, inward: bool) -> Result<Mesh, Failure> {
    let vertices: Vec<[f64; 3]> = faces.iter().flatten().map(|p| p.array()).collect();
    let order = |k: usize| if inward { [3 * k, 3 * k + 2, 3 * k + 1] } else { [3 * k, 3 * k + 1, 3 * k + 2] };
    let indices: Vec<[usize; 3]> = (0..faces.len()).map(order).collect();
    Ok(Mesh::from_arrays(&vertices, &indices)?.name(name))
}

fn shields(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let radii = [0.3, 0.6, 0.601, 1.0];
    let emissivities = [0.8, 0.3, 0.1, 0.6];
    let faces = radii.map(sphere);
    let scene = Scene::builder()
        .name("shields")
        .surface(surface(&faces[0], "inner", false)?.emissivity(emissivities[0]).temperature(600.0))
        .surface(surface(&faces[1], "shield-inside", true)?.emissivity(emissivities[1]).node("shield"))
        .surface(surface(&faces[2], "shield-outside", false)?.emissivity(emissivities[2]).node("shield"))
        .surface(surface(&faces[3], "outer", true)?.emissivity(emissivities[3]).temperature(300.0))
        .node("shield", NodeCondition::Power(0.0))
        .patch_size(1.0)
        .build()?;
    let s = bench.solve_scene(scene)?;
    let power = blackbody_emissive_power(600.0) - blackbody_emissive_power(300.0);
    // Resistances of the gaps, 1/m².
    let gap =
        |a: [f64; 4], k: usize| 1.0 / (emissivities[k] * a[k]) + (1.0 / emissivities[k + 1] - 1.0) / a[k + 1];
    let heat = |a: [f64; 4]| power / (gap(a, 0) + gap(a, 2));
    let flat = faces.each_ref().map(|f| area(f));
    let round = radii.map(|r| 4.0 * PI * r * r);
    let [_, net] = part(&s, "inner")?;
    check(&mut out, "heat of the inner sphere, W", net, heat(flat));
    let [_, net] = part(&s, "outer")?;
    check(&mut out, "heat of the outer sphere, W", net, -heat(flat));
    let kelvin = |a: [f64; 4]| blackbody_temperature(blackbody_emissive_power(600.0) - heat(a) * gap(a, 0));
    let [found, _] = part(&s, "shield-outside")?;
    check(&mut out, "temperature of the shield, K", found, kelvin(flat));
    out.informational("heat of round spheres, W", heat(round), heat(flat));
    Ok(out)
}

/// A square metre of selective plate in sunlight.
fn plate(bench: &CaseContext, name: &str, properties: &str) -> Result<Solution, Failure> {
    let text = format!(
        "mode = \"thermal\"\n[solve]\npatch_size = 0.25\n[[surface]]\nname = \"plate\"\nrectangle = {{ origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }}\nemissivity = 0.1\nsolar_absorptance = 0.95\n{properties}\n[[light]]\nkind = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 800\n[surroundings]\ntemperature = 280\n"
    );
    bench.solve(name, &text)
}

fn collector(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let (absorbed, emissivity, sky) = (0.95 * 800.0, 0.1, blackbody_emissive_power(280.0));
    let s = plate(bench, "collector-stagnation", "heat_flux = 0")?;
    let exact = blackbody_temperature(absorbed / emissivity + sky);
    check(&mut out, "stagnation, K", part(&s, "plate")?[0], exact);
    let s = plate(bench, "collector-heat", "temperature = 350")?;
    let useful = emissivity * (blackbody_emissive_power(350.0) - sky) - absorbed;
    check(&mut out, "net power at 350 K, W", part(&s, "plate")?[1], useful);
    let air = "heat_flux = -300\nheat_transfer_coefficient = 6\nambient_temperature = 290";
    let s = plate(bench, "collector-air", air)?;
    let exact = root([200.0, 800.0], |t| {
        emissivity * (blackbody_emissive_power(t) - sky) + 6.0 * (t - 290.0) + 300.0 - absorbed
    });
    check(&mut out, "with 300 W/m² drawn and air, K", part(&s, "plate")?[0], exact);
    below_lamp(bench, &mut out)?;
    Ok(out)
}

/// A body of one temperature below a lamp of the temperature of the sky, coaxial unit squares at distance 1.
fn below_lamp(bench: &CaseContext, out: &mut CaseOutcome) -> Result<(), Failure> {
    let (emission, sky, root) = (5000.0, blackbody_emissive_power(280.0), 2f64.sqrt());
    let text = format!(
        "mode = \"thermal\"\n[solve]\npatch_size = 0.25\n[[node]]\nname = \"body\"\n[[surface]]\nname = \"body\"\nrectangle = {{ origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }}\nnode = \"body\"\nemissivity = 0.1\nsolar_absorptance = 0.4\n[[surface]]\nname = \"lamp\"\nrectangle = {{ origin = [0, 0, 1], edge1 = [0, 1, 0], edge2 = [1, 0, 0] }}\ntemperature = 280\nemissivity = 1\nemission = {emission:?}\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n[surroundings]\ntemperature = 280\n"
    );
    let s = bench.solve("collector-lamp", &text)?;
    let factor = (2.0 / PI) * ((4.0 / 3f64).sqrt().ln() + 2.0 * root * (1.0 / root).atan() - 0.5 * PI);
    let exact = blackbody_temperature(0.4 * emission * factor / 0.1 + sky);
    check(out, "below a lamp, K", part(&s, "body")?[0], exact);
    let light = s.report.heat.as_ref().map_or(f64::NAN, |h| h.emitters);
    check(out, "light of the lamp, W", [light, 0.0], emission);
    Ok(())
}

fn orbit(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let text = "mode = \"thermal\"\n[solve]\npatch_size = 0.25\n[[node]]\nname = \"plate\"\n[[surface]]\nname = \"plate\"\nrectangle = { origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }\nsides = \"both\"\nnode = \"plate\"\nemissivity = 0.85\nsolar_absorptance = 0.2\n[[light]]\nkind = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 1361\n[[light]]\nkind = \"planet\"\nname = \"earth\"\ndirection = [0, 0, 1]\nangular_diameter = 140\ntemperature = 255\nreflected_flux = 400\n";
    let s = bench.solve("orbit", text)?;
    let seen = 70f64.to_radians().sin().powi(2);
    let absorbed = 0.2 * (1361.0 + 400.0 * seen) + 0.85 * blackbody_emissive_power(255.0) * seen;
    check(&mut out, "temperature, K", part(&s, "plate")?[0], blackbody_temperature(absorbed / (2.0 * 0.85)));
    let found = row(&s, "plate")?;
    let sunlight = 0.2 * (1361.0 + 400.0 * seen);
    out.informational("absorbed sunlight, W", sunlight, found.absorbed_sunlight.unwrap_or(f64::NAN));
    Ok(out)
}

/// A unit box of absorptance 0.9 and emissivity 0.5 in sunlight of 1000 W/m² along (−1, −2, −2)/3.
fn sunlit_box(bench: &CaseContext, name: &str, head: &str, condition: &str) -> Result<Solution, Failure> {
    let own =
        ["x0", "x1", "y0", "y1", "z0", "z1"].map(|f| format!("faces.{f} = {{ {condition} }}\n")).concat();
    let text = format!(
        "mode = \"thermal\"\n[solve]\npatch_size = 0.25\n{head}\n[[surface]]\nname = \"box\"\nbox = {{ min = [0, 0, 0], max = [1, 1, 1] }}\nemissivity = 0.5\nsolar_absorptance = 0.9\n{own}[[light]]\nkind = \"sun\"\ndirection = [-1, -2, -2]\nirradiance = 1000\n"
    );
    bench.solve(name, &text)
}

fn satellite(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let s = sunlit_box(bench, "satellite", "[[node]]\nname = \"body\"", "node = \"body\"")?;
    let body = node(&s, "body")?;
    let exact = blackbody_temperature(0.9 * 1000.0 * (5.0 / 3.0) / (6.0 * 0.5));
    check(&mut out, "one temperature, K", [body.temperature, body.temperature_error], exact);
    let s = sunlit_box(bench, "satellite-faces", "", "heat_flux = 0")?;
    for (face, cos) in [("x1", 1.0 / 3.0), ("y1", 2.0 / 3.0), ("z1", 2.0 / 3.0)] {
        let exact = blackbody_temperature(0.9 * 1000.0 * cos / 0.5);
        check(&mut out, &format!("face {face} alone, K"), part(&s, &format!("box.{face}"))?[0], exact);
    }
    Ok(out)
}

/// Conductivity times thickness of the fin, W/K; its emissivity, length in m, and the temperature of its base, K.
const FIN: [f64; 4] = [0.4, 0.8, 0.5, 500.0];

/// Heat and tip temperature of a fin of `n` nodes by the solver, with the temperatures of its nodes.
fn fin_of_nodes(bench: &CaseContext, n: usize) -> Result<(f64, Vec<Stated>), Failure> {
    let [conductance, emissivity, length, base] = FIN;
    let step = length / n as f64;
    let mut text = format!(
        "mode = \"thermal\"\n[solve]\npatch_size = 1\n[[node]]\nname = \"base\"\ntemperature = {base}\n"
    );
    for k in 0..n {
        let (to, between) =
            if k == 0 { ("base".to_string(), 0.5 * step) } else { (format!("n{}", k - 1), step) };
        let link = conductance / between;
        text +=
            &format!("[[node]]\nname = \"n{k}\"\nlinks = [{{ to = \"{to}\", conductance = {link:?} }}]\n");
    }
    for k in 0..n {
        let (x, from) = (step, k as f64 * step);
        text += &format!(
            "[[surface]]\nname = \"s{k}\"\nrectangle = {{ origin = [{from:?}, 0, 0], edge1 = [{x:?}, 0, 0], edge2 = [0, 1, 0] }}\nsides = \"both\"\nnode = \"n{k}\"\nemissivity = {emissivity}\n"
        );
    }
    let s = bench.solve(&format!("fin-{n}"), &text)?;
    let nodes = (0..n).map(|k| node(&s, &format!("n{k}")).map(|x| [x.temperature, x.temperature_error]));
    Ok((node(&s, "base")?.conducted, nodes.collect::<Result<_, _>>()?))
}

/// The temperatures of a chain of `n` nodes: the tip is found such that the base has its temperature.
fn chain(n: usize) -> Vec<f64> {
    let [conductance, emissivity, length, base] = FIN;
    let step = length / n as f64;
    let emitted = |t: f64| 2.0 * emissivity * step * blackbody_emissive_power(t);
    let along = |tip: f64| {
        let (mut t, mut heat) = (vec![tip], emitted(tip));
        for _ in 1..n {
            let next = t[t.len() - 1] + heat * step / conductance;
            heat += emitted(next);
            t.push(next);
        }
        let at_base = t[n - 1] + heat * 0.5 * step / conductance;
        (t, at_base)
    };
    let tip = root([1.0, base], |tip| along(tip).1 - base);
    let mut t = along(tip).0;
    t.reverse();
    t
}

/// Heat at the base of the fin by its differential equation, W for a metre of width.
fn fin_heat() -> f64 {
    let [conductance, emissivity, length, base] = FIN;
    let factor = 4.0 * emissivity * STEFAN_BOLTZMANN / (5.0 * conductance);
    // x(T_base) of a tip T by the substitution T = T_tip + (T_base − T_tip) u², which is regular at the tip.
    let reach = |tip: f64| {
        let points = 2000;
        let slope = |u: f64| {
            let t = tip + (base - tip) * u * u;
            // (T⁵ − T_tip⁵)/(T − T_tip)
            let quotient: f64 = (0..5).map(|k| t.powi(k) * tip.powi(4 - k)).sum();
            2.0 * ((base - tip) / (factor * quotient)).sqrt()
        };
        (0..points).map(|k| slope((k as f64 + 0.5) / points as f64)).sum::<f64>() / points as f64
    };
    let tip = root([1.0, base], |tip| length - reach(tip));
    conductance * (factor * (base.powi(5) - tip.powi(5))).sqrt()
}

fn fin(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let mut heats = Vec::new();
    for n in [16, 32] {
        let (heat, nodes) = fin_of_nodes(bench, n)?;
        heats.push(heat);
        let exact = chain(n);
        for k in [0, n / 2, n - 1] {
            check(&mut out, &format!("{n} nodes: temperature of node {k}, K"), nodes[k], exact[k]);
        }
    }
    let extrapolated = heats[1] + (heats[1] - heats[0]) / 3.0;
    let exact = fin_heat();
    out.check("heat at the base, extrapolated, W", exact, extrapolated, AcceptanceLimit::Relative(1e-3));
    Ok(out)
}

fn convection(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let (emissivity, coefficient, air, flux, wall) = (0.7, 12.0, 350.0, 400.0, 300.0);
    let text = format!(
        "mode = \"thermal\"\n[solve]\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = {{ min = [0, 0, 0], max = [1, 1, 1] }}\nemissivity = 1\ntemperature = {wall}\n[[surface]]\nname = \"body\"\nbox = {{ min = [0.3, 0.3, 0.2], max = [0.6, 0.7, 0.7] }}\nemissivity = {emissivity}\nheat_flux = {flux}\nheat_transfer_coefficient = {coefficient}\nambient_temperature = {air}\n"
    );
    let s = bench.solve("convection", &text)?;
    let exact = root([200.0, 900.0], |t| {
        emissivity * (blackbody_emissive_power(t) - blackbody_emissive_power(wall)) + coefficient * (t - air)
            - flux
    });
    let [found, net] = part(&s, "body")?;
    check(&mut out, "temperature of the body, K", found, exact);
    let area = 2.0 * (0.3 * 0.4 + 0.4 * 0.5 + 0.5 * 0.3);
    check(&mut out, "radiated power, W", net, area * (flux - coefficient * (exact - air)));
    Ok(out)
}

fn insulation(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let head = "[[node]]\nname = \"tank\"\ntemperature = 90\n[[node]]\nname = \"skin\"\nlinks = [{ to = \"tank\", effective_emissivity = 0.02 }]";
    let s = sunlit_box(bench, "insulation", head, "node = \"skin\"")?;
    let (skin, tank) = (node(&s, "skin")?, node(&s, "tank")?);
    let cold = blackbody_emissive_power(90.0);
    let e = (0.9 * 1000.0 * (5.0 / 3.0) + 6.0 * 0.02 * cold) / (6.0 * (0.5 + 0.02));
    check(
        &mut out,
        "temperature of the skin, K",
        [skin.temperature, skin.temperature_error],
        blackbody_temperature(e),
    );
    // dQ = 4 ε* A σ T³ dT
    let slope = 4.0 * 6.0 * 0.02 * STEFAN_BOLTZMANN * skin.temperature.powi(3);
    let heat = [-tank.conducted, slope * skin.temperature_error];
    check(&mut out, "heat to the tank, W", heat, 6.0 * 0.02 * (e - cold));
    Ok(out)
}

fn hohlraum(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let text = "mode = \"thermal\"\n[solve]\npatch_size = 0.34\n[[node]]\nname = \"body\"\n[[surface]]\nname = \"cavity\"\nroom = { min = [0, 0, 0], max = [1, 1, 1] }\nemissivity = 0.5\ntemperature = 800\nfaces.x0 = { emissivity = 0.1 }\nfaces.z1 = { emissivity = 0.9 }\n[[surface]]\nname = \"body\"\nbox = { min = [0.4, 0.3, 0.2], max = [0.7, 0.6, 0.5] }\nnode = \"body\"\nemissivity = 0.3\n[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [3, 3, 3]\nextinction = 0.8\nalbedo = 0.3\ntemperature = 800\n";
    let s = bench.solve("hohlraum", text)?;
    let black = blackbody_emissive_power(800.0);
    let body = node(&s, "body")?;
    check(&mut out, "temperature of the body, K", [body.temperature, body.temperature_error], 800.0);
    for name in ["cavity.x0", "cavity.z1", "medium"] {
        check(&mut out, &format!("net power of {name}, W"), part(&s, name)?[1], 0.0);
    }
    let offs = (0..s.zones.voxel_offset())
        .map(|i| ((s.fields.incident[i].first() - black).abs(), s.fields.total_error(i).first()));
    let worst = offs.max_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1))).unwrap_or((f64::NAN, 0.0));
    check(&mut out, "worst irradiance, W/m²", [black + worst.0, worst.1], black);
    Ok(out)
}
