//! View factors of whole geometries: laws, closed forms, and rays against every facet.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Mutex;
use zonal_math::{Bounded, Grade, Vec3, vec3};
use zonal_reference::Rng;
use zonal_scene::{CheckpointStore, NoCheckpoints, NoProgress};
use zonal_view_factors::{ConvexPolygon, Openness, RowClosing, ViewFactorSettings, ViewFactors};

fn polygon(c: &[Vec3]) -> ConvexPolygon {
    ConvexPolygon::new(c.to_vec()).expect("a polygon")
}

/// Triangles of a parallelogram in n × m cells.
fn divide(out: &mut Vec<ConvexPolygon>, at: Vec3, e: Vec3, f: Vec3, [n, m]: [usize; 2]) {
    let corner = |i: usize, j: usize| at + e * (i as f64 / n as f64) + f * (j as f64 / m as f64);
    for i in 0..n {
        for j in 0..m {
            let [p, q, r, s] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            out.extend([polygon(&[p, q, r]), polygon(&[p, r, s])]);
        }
    }
}

/// The faces of a box, outwards or inwards, each in n × n cells of triangles.
fn cuboid(out: &mut Vec<ConvexPolygon>, lo: Vec3, size: Vec3, inwards: bool, n: usize) {
    for axis in 0..3 {
        for high in [false, true] {
            let unit = |k: usize| {
                let mut x = [0.0; 3];
                x[k] = size.array()[k];
                Vec3::from_array(x)
            };
            let at = if high { lo + unit(axis) } else { lo };
            let (e, f) = (unit((axis + 1) % 3), unit((axis + 2) % 3));
            let (e, f) = if high != inwards { (e, f) } else { (f, e) };
            divide(out, at, e, f, [n, n]);
        }
    }
}

fn compute(
    facets: &[ConvexPolygon],
    obstructions: &[ConvexPolygon],
    settings: &ViewFactorSettings,
) -> ViewFactors {
    ViewFactors::compute(facets, obstructions, settings, &NoProgress, &NoCheckpoints).expect("valid settings")
}

fn turned(p: &ConvexPolygon) -> ConvexPolygon {
    let (x, y, z) = (vec3(0.36, 0.48, -0.8), vec3(-0.8, 0.6, 0.0), vec3(0.48, 0.64, 0.6));
    polygon(
        &p.corners().iter().map(|c| x * c.x + y * c.y + z * c.z + vec3(3.0, -2.0, 5.0)).collect::<Vec<_>>(),
    )
}

/// A room with a block that stands on the middle cell of the floor, and one above it.
fn furnished_room() -> Vec<ConvexPolygon> {
    let (size, mut facets) = (vec3(3.0, 2.4, 2.5), Vec::new());
    cuboid(&mut facets, Vec3::ZERO, size, true, 3);
    let lo = vec3(1.0, 0.8, 0.0);
    let hi = vec3(2.0, 1.6, 0.0);
    let within = |p: &ConvexPolygon| {
        p.corners().iter().all(|c| c.z == 0.0 && c.x >= 0.99 && c.x <= 2.01 && c.y >= 0.79 && c.y <= 1.61)
    };
    facets.retain(|p| !within(p));
    let mut block = Vec::new();
    cuboid(&mut block, lo, hi - lo + vec3(0.0, 0.0, 0.9), false, 1);
    facets.extend(block.into_iter().filter(|p| !within(p)));
    cuboid(&mut facets, vec3(1.7, 1.1, 1.3), vec3(0.7, 0.9, 0.4), false, 1);
    facets
}

#[test]
fn empty_rooms_close_with_proved_radii() {
    let mut facets = Vec::new();
    cuboid(&mut facets, Vec3::ZERO, vec3(1.0, 2.0, 3.0), true, 3);
    let facets: Vec<ConvexPolygon> = facets.iter().map(turned).collect();
    let settings = ViewFactorSettings {
        tolerance: 1e-7,
        closure: RowClosing::Keep,
        surroundings: Openness::Closed,
        ..Default::default()
    };
    let f = compute(&facets, &[], &settings);
    assert_eq!(f.grade(), Grade::Proved);
    for i in 0..f.len() {
        assert!(
            f.defects()[i].abs() <= f.row_radius(i) && f.row_radius(i) < 1e-6,
            "{i}: {:e}",
            f.defects()[i]
        );
    }
}

// Guards (numbers): rows of view factors close within their radii.
#[test]
fn rows_of_a_furnished_room_close_within_their_radii() {
    let facets: Vec<ConvexPolygon> = furnished_room().iter().map(turned).collect();
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let open = ViewFactorSettings { tolerance, closure: RowClosing::Keep, ..Default::default() };
        let f = compute(&facets, &[], &open);
        for i in 0..f.len() {
            assert!(
                f.defects()[i].abs() <= f.row_radius(i),
                "{tolerance} {i}: {:e} {:e}",
                f.defects()[i],
                f.row_radius(i)
            );
            assert!(f.defects()[i].abs() <= tolerance && f.row(i).all(|(_, b)| b.value <= 1.0));
            // Nothing of the surroundings is seen from within a room.
            assert!(f.sky(i).value + f.ground(i).value <= 1e-9, "{i}: {:?}", f.sky(i));
        }
        let closed = compute(&facets, &[], &ViewFactorSettings { tolerance, ..Default::default() });
        assert!(closed.remaining_defect() < 1e-12);
        for (i, area) in closed.areas().iter().enumerate() {
            for (j, b) in closed.row(i) {
                let back = closed.row(j).find(|e| e.0 == i).expect("the reverse factor").1;
                assert!((area * b.value - closed.areas()[j] * back.value).abs() <= 1e-15 * area);
                let before = f.row(i).find(|e| e.0 == j).expect("the same factor").1;
                assert!(b.radius >= 0.999_999 * (before.radius + (b.value - before.value).abs()) - 1e-12);
            }
        }
    }
}

/// Houses of several heights on a ground with holes under them, turned off the axes.
fn street() -> Vec<ConvexPolygon> {
    let mut facets = Vec::new();
    for (i, j) in (0..3).flat_map(|i| (0..2).map(move |j| (i, j))) {
        let (x, y) = (4.0 * f64::from(i), 4.0 * f64::from(j));
        let height = [1.0, 2.5, 1.6, 3.2, 0.8, 2.0][(2 * i + j) as usize];
        let mut house = Vec::new();
        cuboid(&mut house, vec3(x + 1.0, y + 1.0, 0.0), vec3(2.0, 1.7, height), false, 2);
        house.retain(|p| p.normal().z > -0.5);
        facets.append(&mut house);
        let (xs, ys) = ([x, x + 1.0, x + 3.0, x + 4.0], [y, y + 1.0, y + 2.7, y + 4.0]);
        for (u, v) in (0..3).flat_map(|u| (0..3).map(move |v| (u, v))).filter(|c| *c != (1, 1)) {
            let edges = [vec3(xs[u + 1] - xs[u], 0.0, 0.0), vec3(0.0, ys[v + 1] - ys[v], 0.0)];
            divide(&mut facets, vec3(xs[u], ys[v], 0.0), edges[0], edges[1], [1, 1]);
        }
    }
    facets.iter().map(turned).collect()
}

#[test]
fn radii_cover_the_errors_of_a_street() {
    let facets = street();
    let computed = |tolerance: f64| {
        let settings = ViewFactorSettings { tolerance, closure: RowClosing::Keep, ..Default::default() };
        compute(&facets, &[], &settings)
    };
    let (coarse, fine) = (computed(1e-3), computed(3e-5));
    // The houses are solids, and the ground is one plate.
    assert_eq!((coarse.counts.occluders, coarse.counts.solids), (7, 6));
    let (mut pairs, mut beyond, mut largest) = (0, 0, 0.0f64);
    for i in 0..facets.len() {
        let exact: HashMap<usize, Bounded> = fine.row(i).collect();
        for (j, b) in coarse.row(i) {
            let e = exact.get(&j).copied().unwrap_or(Bounded::ZERO);
            let share = (b.value - e.value).abs() / (b.radius + e.radius + 1e-12);
            (pairs, beyond) = (pairs + 1, beyond + u32::from(share > 1.0));
            largest = largest.max(share);
        }
        for (b, e) in [(coarse.sky(i), fine.sky(i)), (coarse.ground(i), fine.ground(i))] {
            assert!((b.value - e.value).abs() <= b.radius + e.radius + 1e-12, "{i}: {b:?} {e:?}");
        }
        let defect = coarse.defects()[i].abs();
        assert!(defect <= coarse.row_radius(i) && defect < 1e-3, "{i}: {defect:e}");
    }
    // The radii are estimates: a shadow between the points of a rule may be missed.
    assert!(pairs > 15_000 && beyond == 0, "{beyond} of {pairs}, {largest}");
}

/// The facet that a ray meets first, by testing all.
fn first_hit(facets: &[ConvexPolygon], o: Vec3, d: Vec3) -> Option<usize> {
    let hit = |p: &ConvexPolygon| {
        let t = -p.height(o) / p.normal().dot(d);
        let x = o + d * t;
        let c = p.corners();
        let inside =
            (0..c.len()).all(|k| (c[(k + 1) % c.len()] - c[k]).cross(x - c[k]).dot(p.normal()) >= 0.0);
        (t > 1e-9 && inside).then_some(t)
    };
    let hits = facets.iter().enumerate().filter_map(|(k, p)| hit(p).map(|t| (t, k)));
    hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|h| h.1)
}

// Guards (numbers): view factors of many facets agree with rays against every facet.
#[test]
fn factors_agree_with_rays_against_every_facet() {
    let mut facets = furnished_room();
    // Without its ceiling and one wall, the room sees the sky and the ground.
    facets.retain(|p| p.corners().iter().any(|c| c.z < 2.5) && p.corners().iter().any(|c| c.x > 0.0));
    let facets: Vec<ConvexPolygon> = facets.iter().map(turned).collect();
    let f = compute(&facets, &[], &ViewFactorSettings { closure: RowClosing::Keep, ..Default::default() });
    let (mut rng, rays) = (Rng::new(11), 4_000);
    for i in (0..facets.len()).step_by(3) {
        let c = facets[i].corners();
        let mut counts: HashMap<Option<usize>, f64> = HashMap::new();
        let mut above = 0.0;
        for _ in 0..rays {
            let (u, v) = (rng.uniform(), rng.uniform());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let x = c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v;
            let d = rng.cosine_direction(facets[i].normal());
            let hit = first_hit(&facets, x, d);
            *counts.entry(hit).or_default() += 1.0;
            above += f64::from(u8::from(hit.is_none() && d.z > 0.0));
        }
        let check = |what: &str, ours: f64, radius: f64, hits: f64| {
            let share = hits / f64::from(rays);
            let likely = share.max(ours.min(1.0));
            let sigma = ((likely * (1.0 - likely)).max(1.0 / f64::from(rays)) / f64::from(rays)).sqrt();
            assert!(
                (ours - share).abs() <= radius + 4.5 * sigma,
                "{i} to {what}: {ours} ± {radius:e}, rays {share}"
            );
        };
        for j in 0..facets.len() {
            let ours = f.row(i).find(|e| e.0 == j).map_or((0.0, 0.0), |e| (e.1.value, e.1.radius));
            check(&j.to_string(), ours.0, ours.1, counts.get(&Some(j)).copied().unwrap_or(0.0));
        }
        let (sky, ground) = (f.sky(i), f.ground(i));
        check("sky", sky.value, sky.radius, above);
        check("ground", ground.value, ground.radius, counts.get(&None).copied().unwrap_or(0.0) - above);
    }
}

#[test]
fn an_endless_street_sees_the_sky_as_by_crossed_strings() {
    // Street of width 10 m between blocks of 8 m; blocks are 6 m wide. Periods: 16 m across, 5 m along the street.
    let (width, block, height, along) = (10.0, 6.0, 8.0, 5.0);
    let (mut facets, z) = (Vec::new(), vec3(0.0, 0.0, height));
    let y = vec3(0.0, along, 0.0);
    divide(&mut facets, Vec3::ZERO, vec3(width, 0.0, 0.0), y, [2, 1]);
    let street = facets.len();
    divide(&mut facets, vec3(width, 0.0, 0.0), z, y, [1, 1]);
    divide(&mut facets, vec3(width, 0.0, height), vec3(block, 0.0, 0.0), y, [1, 1]);
    divide(&mut facets, vec3(width + block, 0.0, 0.0), y, z, [1, 1]);
    let settings = ViewFactorSettings {
        periods: [Some(width + block), Some(along)],
        closure: RowClosing::Keep,
        ..Default::default()
    };
    let f = compute(&facets, &[], &settings);
    let group: Vec<u32> =
        (0..f.len()).map(|i| if i < street { 0 } else { 1 + ((i - street) / 2) as u32 }).collect();
    let f = f.combined(&group, 4);
    let sky = (1.0 + (height / width).powi(2)).sqrt() - height / width;
    let (ours, wall) = (f.sky(0), f.row(0).find(|e| e.0 == 1).expect("the street sees a wall").1);
    assert!((ours.value - sky).abs() <= ours.radius + 2e-3, "{ours:?} {sky}");
    assert!((wall.value - 0.5 * (1.0 - sky)).abs() <= wall.radius + 2e-3, "{wall:?} {}", 0.5 * (1.0 - sky));
    assert!((f.sky(2).value - 1.0).abs() <= 1e-9);
    for i in 0..4 {
        assert!(f.defects()[i].abs() <= f.row_radius(i), "{i}: {:e} {:e}", f.defects()[i], f.row_radius(i));
    }
}

#[test]
fn rows_of_partly_buried_facets_are_left_open() {
    // A block on a floor whose triangles reach beneath it: what is covered sees nothing.
    let mut facets = Vec::new();
    cuboid(&mut facets, Vec3::ZERO, vec3(3.0, 3.0, 3.0), true, 1);
    cuboid(&mut facets, vec3(1.0, 1.0, 0.0), vec3(1.0, 1.0, 1.0), false, 1);
    facets.retain(|p| p.normal().z > -0.5 || p.corners()[0].z > 0.0);
    let f = compute(&facets, &[], &ViewFactorSettings::default());
    let floor: Vec<usize> = (0..f.len())
        .filter(|i| facets[*i].normal().z > 0.5 && facets[*i].corners().iter().all(|c| c.z == 0.0))
        .collect();
    assert_eq!(f.open_rows(), floor);
    for i in floor {
        // One ninth of the floor is covered.
        assert!((f.defects()[i] + 1.0 / 9.0).abs() < 1e-3, "{}", f.defects()[i]);
        let sum: f64 = f.row(i).map(|e| e.1.value).sum();
        assert!((sum - 8.0 / 9.0).abs() < 2e-3, "{sum}");
    }
}

#[test]
fn obstructions_reduce_factors_and_exchange_nothing() {
    let (mut floor, mut top) = (Vec::new(), Vec::new());
    divide(&mut floor, Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), [1, 1]);
    divide(&mut top, vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), [1, 1]);
    let facets: Vec<ConvexPolygon> = floor.into_iter().chain(top).collect();
    let screen = |half: f64| {
        let c = [[-half, -half], [half, -half], [half, half], [-half, half]];
        polygon(&c.map(|[x, y]| vec3(0.5 + x, 0.5 + y, 0.5)))
    };
    let sum = |half: f64| {
        let f = compute(&facets, &[screen(half)], &ViewFactorSettings::default()).combined(&[0, 0, 1, 1], 2);
        assert_eq!(f.len(), 2);
        f.row(0).find(|e| e.0 == 1).map_or(0.0, |e| e.1.value)
    };
    let (small, large) = (sum(0.1), sum(0.3));
    assert!(large < small - 0.02 && small < 0.1998, "{small} {large}");
    assert!(sum(0.6) < 0.01);
}

/// A store in memory that counts what it loads.
#[derive(Default)]
struct InMemory(Mutex<HashMap<String, Vec<u8>>>, Mutex<usize>);

impl CheckpointStore for InMemory {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        let found = self.0.lock().expect("no panic elsewhere").get(stage).cloned();
        *self.1.lock().expect("no panic elsewhere") += usize::from(found.is_some());
        found
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        self.0.lock().expect("no panic elsewhere").insert(stage.into(), bytes.into());
    }
}

fn bits(f: &ViewFactors) -> Vec<u64> {
    let rows = (0..f.len()).flat_map(|i| {
        f.row(i).map(|(j, b)| j as u64 ^ b.value.to_bits() ^ b.radius.to_bits().rotate_left(7))
    });
    rows.chain((0..f.len()).map(|i| f.sky(i).value.to_bits() ^ f.ground(i).value.to_bits())).collect()
}

// Guards (determinism): view factors have the same bits for any number of threads and after any checkpoint.
#[test]
fn threads_and_checkpoints_leave_every_bit() {
    let facets = furnished_room();
    let settings = ViewFactorSettings::default();
    let store = InMemory::default();
    let in_pool = |threads: usize, store: &dyn CheckpointStore| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            bits(&ViewFactors::compute(&facets, &[], &settings, &NoProgress, store).expect("valid settings"))
        })
    };
    let one = in_pool(1, &NoCheckpoints);
    assert_eq!(one, in_pool(3, &store));
    // Half of the batches are lost, one is damaged.
    {
        let mut stages = store.0.lock().expect("no panic elsewhere");
        let mut names: Vec<String> = stages.keys().cloned().collect();
        names.sort();
        names.iter().step_by(2).for_each(|n| drop(stages.remove(n)));
        stages.get_mut(&names[1]).expect("a stage").push(0);
    }
    assert_eq!(one, in_pool(2, &store));
    assert!(*store.1.lock().expect("no panic elsewhere") > 10);
}

#[test]
fn invalid_settings_and_small_memory_are_refused() {
    let facets = furnished_room();
    let refused = |settings: ViewFactorSettings, facets: &[ConvexPolygon], word: &str| {
        let e =
            ViewFactors::compute(facets, &[], &settings, &NoProgress, &NoCheckpoints).expect_err("refused");
        assert!(format!("{} {}", e.key(), e.message()).contains(word), "{e:?}");
    };
    refused(ViewFactorSettings { tolerance: 0.0, ..Default::default() }, &facets, "tolerance");
    refused(ViewFactorSettings { up: 3, ..Default::default() }, &facets, "up");
    refused(ViewFactorSettings { periods: [Some(-1.0), None], ..Default::default() }, &facets, "periods");
    refused(ViewFactorSettings { memory_limit: 1_000, ..Default::default() }, &facets, "max_memory");
    refused(ViewFactorSettings::default(), &[], "facets");
}

#[test]
fn spheres_see_each_other_as_in_closed_form() {
    // Two distant spheres: F → ½ (1 − √(1 − (r/d)²)) of the far field, here r/d = 0.1, to the faceting's error.
    let sphere = |centre: Vec3| {
        let (n, m) = (12, 6);
        let at = |i: usize, j: usize| {
            let (a, b) = (2.0 * PI * (i % n) as f64 / n as f64, PI * j as f64 / m as f64);
            centre + vec3(a.cos() * b.sin(), a.sin() * b.sin(), b.cos())
        };
        let mut out = Vec::new();
        for i in 0..n {
            for j in 0..m {
                let quad = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                out.extend(ConvexPolygon::new(vec![quad[0], quad[1], quad[2]]));
                out.extend(ConvexPolygon::new(vec![quad[0], quad[2], quad[3]]));
            }
        }
        out
    };
    let mut facets = sphere(Vec3::ZERO);
    let first = facets.len();
    facets.extend(sphere(vec3(10.0, 0.0, 0.0)));
    let f = compute(&facets, &[], &ViewFactorSettings { closure: RowClosing::Keep, ..Default::default() });
    let group: Vec<u32> = (0..facets.len()).map(|i| u32::from(i >= first)).collect();
    let f = f.combined(&group, 2);
    let between = f.row(0).find(|e| e.0 == 1).expect("the spheres see each other").1.value;
    assert!((between / 0.002_506 - 1.0).abs() < 0.1, "{between}");
    assert!((f.sky(0).value + f.ground(0).value + between - 1.0).abs() < 1e-3);
    assert!((f.sky(0).value / f.ground(0).value - 1.0).abs() < 1e-3);
}
