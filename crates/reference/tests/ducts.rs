//! The exact factors of ducts against View3D's cross-sections and printed matrices (G. Walton, NIST), which are right to a few units of their
//! seventh digit.

#[path = "support/view3d_files.rs"]
mod view3d_files;

use view3d_files::text;
use zonal_reference::crossed_strings;

/// The walls of a cross-section (.vs2).
fn walls(text: &str) -> Vec<crossed_strings::Wall> {
    let (mut vertices, mut out) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split('!').next().unwrap_or("").split_whitespace().collect();
        match words.first().map(|w| w.to_lowercase()).as_deref() {
            Some("v") => vertices.push([2, 3].map(|k: usize| words[k].parse::<f64>().unwrap())),
            Some("s") => out.push([2, 3].map(|k: usize| vertices[words[k].parse::<usize>().unwrap() - 1])),
            Some("end") => break,
            _ => {}
        }
    }
    out
}

/// F row by row from a printed 2-D result.
fn printed_plane(text: &str) -> Vec<Vec<f64>> {
    let mut words = text.lines().skip(1).filter(|l| !l.starts_with('!')).flat_map(str::split_whitespace);
    let n: usize = words.next().unwrap().parse().unwrap();
    words.by_ref().take(2).for_each(drop);
    (0..n).map(|_| words.by_ref().skip(4).take(n).map(|w| w.parse().unwrap()).collect()).collect()
}

#[test]
fn ducts_match_published_digits() {
    // Name, largest difference, entries within one unit of the last of seven digits, of how many.
    for (name, most, good, all) in [("facet", 1.1e-7, 142, 144), ("test5", 1.2e-6, 9_500, 10_000)] {
        let (Some(input), Some(output)) =
            (text(&format!("test/2d/{name}.vs2")), text(&format!("test/2d/{name}.txt")))
        else {
            return;
        };
        let f = crossed_strings::view_factors(&walls(&input));
        for row in &f {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        }
        let printed = printed_plane(&output);
        let off: Vec<f64> =
            f.iter().flatten().zip(printed.iter().flatten()).map(|(x, y)| (x - y).abs()).collect();
        let worst = off.iter().fold(0.0f64, |s, x| x.max(s));
        let near = off.iter().filter(|x| **x <= 1e-7).count();
        println!("{name}: largest difference {worst:.2e}, {near} of {all} within 1e-7");
        assert_eq!(f.len() * f.len(), all);
        assert!(worst <= most && near >= good, "{name}: {worst:e}, {near} within a unit");
    }
}
