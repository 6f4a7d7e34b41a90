use super::*;

/// A number in 0..1 from a counter.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*state >> 33) as f64) / (1u64 << 31) as f64
}

/// Random lines that may cross, some of them two-sided, some obstructions, over a ground.
fn lines(state: &mut u64, count: usize, period: f64) -> Vec<Line> {
    let mut made = vec![Line { a: [0.0, 0.0], b: [period, 0.0], facet: Some(0) }];
    let mut facets = 1;
    while made.len() < count {
        let a = [period * random(state), 0.1 + random(state)];
        let b = [a[0] + 0.8 * (random(state) - 0.5), 0.1 + random(state)];
        let two_sided = random(state) < 0.5;
        let facet = (random(state) < 0.8).then_some(facets);
        facets += u32::from(facet.is_some());
        made.push(Line { a, b, facet });
        if two_sided && facet.is_some() {
            made.push(Line { a: b, b: a, facet: Some(facets) });
            facets += 1;
        }
    }
    made
}

fn extrusion(lines: Vec<Line>, period: Option<f64>) -> Extrusion {
    let section = Section::new(&lines, period, 1e-10).expect("a section");
    let facets: Vec<&Line> = lines.iter().filter(|l| l.facet.is_some()).collect();
    let lengths = facets.iter().map(|l| (l.b[0] - l.a[0]).hypot(l.b[1] - l.a[1])).collect();
    let surface = (0..facets.len() as u32).collect();
    let lines = facets.into_iter().copied().collect();
    Extrusion { lines, surface, lengths, section, period: 1.0 }
}

/// The facet that a ray meets first, in images up to `columns`; None for a back, an obstruction or nothing.
fn trace(all: &[Line], period: f64, columns: i32, from: [f64; 2], d: [f64; 2]) -> Option<u32> {
    let mut first = (f64::INFINITY, None);
    for l in all {
        for n in -columns..=columns {
            let a = [l.a[0] + f64::from(n) * period, l.a[1]];
            let e = [l.b[0] - l.a[0], l.b[1] - l.a[1]];
            let det = d[0] * e[1] - d[1] * e[0];
            let c = [a[0] - from[0], a[1] - from[1]];
            let (t, s) = ((c[0] * e[1] - c[1] * e[0]) / det, (c[0] * d[1] - c[1] * d[0]) / det);
            // The front is to the left: the ray comes from there.
            let facet = l.facet.filter(|_| det > 0.0);
            let is_nearer = t < first.0 - 1e-12 || (t < first.0 + 1e-12 && facet.is_some());
            if t > 1e-9 && (0.0..=1.0).contains(&s) && is_nearer {
                first = (t.min(first.0), facet);
            }
        }
    }
    first.1
}

#[test]
fn rows_are_reciprocal_complete_and_as_traced() {
    let mut state = 7;
    for case in 0..12 {
        let period = if case % 3 == 0 { None } else { Some(0.5 + 2.0 * random(&mut state)) };
        let all = lines(&mut state, 5 + case / 2, period.unwrap_or(2.0));
        let e = extrusion(all.clone(), period);
        let columns = 8;
        let (rows, _) = e.rows_of_columns(columns, &zonal_scene::NoProgress);
        for (i, row) in rows.iter().enumerate() {
            let line = e.lines[i];
            let d = [(line.b[0] - line.a[0]) / e.lengths[i], (line.b[1] - line.a[1]) / e.lengths[i]];
            let (points, rays) = (80, 80);
            let mut traced = vec![0.0; rows.len()];
            for k in 0..points {
                let s = e.lengths[i] * (f64::from(k) + 0.5) / f64::from(points);
                let from = [line.a[0] + s * d[0], line.a[1] + s * d[1]];
                for m in 0..rays {
                    let tau = 2.0 * (f64::from(m) + 0.5) / f64::from(rays) - 1.0;
                    let h = (1.0 - tau * tau).sqrt();
                    let to = [tau * d[0] - h * d[1], tau * d[1] + h * d[0]];
                    if let Some(j) = trace(&all, period.unwrap_or(1e9), columns + 1, from, to) {
                        traced[j as usize] += e.lengths[i] / f64::from(points * rays);
                    }
                }
            }
            for j in 0..rows.len() {
                let (x, y) = (row.facets[j], rows[j].facets[i]);
                let missing = row.unresolved.iter().sum::<f64>() + rows[j].unresolved.iter().sum::<f64>();
                assert!((x - y).abs() <= missing + 1e-12, "{case}: {i} {j}: {x} {y}");
                assert!(
                    (x - traced[j]).abs() <= missing + 0.02 * e.lengths[i],
                    "{case}: {i} {j}: {x} {}",
                    traced[j]
                );
            }
            assert!(row.left_out <= 1e-9 * e.lengths[i], "{case}: {}", row.left_out);
        }
    }
}

/// Sheds over a ground, with the exact exchange of far columns in the radius: more columns stay within.
#[test]
fn more_columns_stay_within_the_radius() {
    let slope = [2.119_074_222_86, 1.826_731_750_69];
    let line = |a, b, facet| Line { a, b, facet: Some(facet) };
    let all = vec![line([0.0, 0.7], slope, 0), line(slope, [0.0, 0.7], 1), line([-1.0, 0.0], [4.5, 0.0], 2)];
    let e = extrusion(all, Some(5.5));
    let of = |columns| e.rows_of_columns(columns, &zonal_scene::NoProgress).0;
    let fine = of(64);
    for columns in [1, 4, 16] {
        let rows = of(columns);
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let (x, exact) = (e.pair(&rows, i, j), e.pair(&fine, i, j));
            assert!((x.value - exact.value).abs() <= x.radius + exact.radius, "{columns} {i} {j}");
            assert!(x.radius < 3e-2 / f64::from(columns * columns), "{columns}: {x:?}");
        }
    }
}
