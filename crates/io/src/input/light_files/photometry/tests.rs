use super::*;
use crate::files::FilesInMemory;
use std::f64::consts::TAU;

fn read(name: &str, text: &str) -> Result<LuminousTable, String> {
    let files = FilesInMemory::from([(name.into(), text.as_bytes().to_vec())]);
    read_luminaire(FileSource::memory(&files), Path::new(name)).map_err(|e| e.to_string())
}

/// Intensity, cd, at γ and C, degrees, of a luminaire that hangs straight down.
fn candelas(t: &LuminousTable, gamma: f64, c: f64) -> f64 {
    let down = zonal_math::vec3(0.0, 0.0, -1.0);
    let d = zonal_scene::IntensityDistribution::table(t.table.clone(), down, 0.0);
    let (across, along) = gamma.to_radians().sin_cos();
    let (sin, cos) = c.to_radians().sin_cos();
    t.peak * d.relative(zonal_math::vec3(across * cos, across * sin, -along))
}

fn near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-6 * wanted.abs() + 1e-9, "{found} where {wanted} was expected");
}

const IES: &str = "IESNA:LM-63-2002\n[TEST] 1\n[MANUFAC] none\nTILT=NONE\n1 1000 2 3 3 1 2 0 0 0\n0.9 1 30\n0 45 90\n\
    0 45 90\n100 80 10\n100, 60, 20\n100 40\n30\n";

#[test]
fn quadrants_of_type_c_have_their_factors() {
    let t = read("lamp.ies", IES).unwrap();
    for (gamma, c, listed) in
        [(0.0, 0.0, 100.0), (45.0, 0.0, 80.0), (45.0, 90.0, 40.0), (90.0, 135.0, 20.0), (45.0, 202.5, 70.0)]
    {
        near(candelas(&t, gamma, c), listed * 1.8);
    }
    near(candelas(&t, 120.0, 0.0), 0.0);
    // The second factor counts in files of 1991 and 1986 only.
    let old = IES.replace("IESNA:LM-63-2002", "IESNA91").replace("0.9 1 30", "0.9 0.5 30");
    near(candelas(&read("a.IES", &old).unwrap(), 0.0, 0.0), 90.0);
    let first = old.replace("IESNA91\n", "");
    near(candelas(&read("a.ies", &first).unwrap(), 0.0, 0.0), 90.0);
    let newest = old.replace("IESNA91", "IES:LM-63-2019").replace("0.9 0.5", "0.9 1.00001");
    near(candelas(&read("a.ies", &newest).unwrap(), 0.0, 0.0), 180.0);
    // Factors of tilted lamps stand apart; absolute photometry has the same intensities.
    let tilted = IES.replace("TILT=NONE", "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8").replace("1 1000", "1 -1");
    let mut tilted = read("a.ies", &tilted).unwrap();
    assert_eq!(tilted.tilt.take().map(|t| t.at(45.0)), Some(Ok(0.9)));
    assert_eq!(tilted, t);
}

#[test]
fn ranges_of_planes_have_their_symmetry() {
    let with = |planes: &str, values: &str| {
        let n = planes.split(' ').count();
        let text = IES
            .replace("3 3 1 2", &format!("3 {n} 1 2"))
            .split("0 45 90\n0 45 90")
            .next()
            .unwrap()
            .to_string();
        read("a.ies", &format!("{text}0 45 90\n{planes}\n{values}\n"))
    };
    let t = with("0", "9 8 7").unwrap();
    near(candelas(&t, 45.0, 217.0), 8.0 * 1.8);
    let t = with("0 90 180", "9 8 7 9 5 4 9 3 2").unwrap();
    near(candelas(&t, 45.0, 270.0), 5.0 * 1.8);
    near(candelas(&t, 45.0, 180.0), 3.0 * 1.8);
    let t = with("90 180 270", "9 8 7 9 5 4 9 3 2").unwrap();
    near(candelas(&t, 45.0, 0.0), 5.0 * 1.8);
    near(candelas(&t, 45.0, 270.0), 3.0 * 1.8);
    let t = with("0 90 180 270 360", "9 8 7 9 5 4 9 3 2 9 1 6 9 8 7").unwrap();
    near(candelas(&t, 45.0, 270.0), 1.8);
    near(candelas(&t, 45.0, 315.0), 4.5 * 1.8);
    assert!(with("0 30 60", "9 8 7 9 5 4 9 3 2").unwrap_err().contains("0 to 90, 180 or 360"));
}

#[test]
fn tables_of_type_a_and_b_are_turned_to_type_c() {
    let angles = "-90 -45 0 45 90\n-90 -45 0 45 90\n";
    // H by H the values at V; 100 at H = 45, V = 0, 50 at H = 0, V = 45.
    let values = "0 0 0 0 0\n0 0 0 0 0\n0 0 80 50 0\n0 0 100 0 0\n0 0 0 0 0\n";
    for kind in [2, 3] {
        let text = format!("IESNA91\nTILT=NONE\n1 -1 1 5 5 {kind} 2 0 0 0\n1 1 30\n{angles}{values}");
        let t = read("flood.ies", &text).unwrap();
        near(candelas(&t, 0.0, 0.0), 80.0);
        near(candelas(&t, 45.0, 0.0), 50.0);
        near(candelas(&t, 45.0, 270.0), 100.0);
        near(candelas(&t, 45.0, 90.0), 0.0);
        near(candelas(&t, 135.0, 270.0), 0.0);
    }
    let text = "IESNA91\nTILT=NONE\n1 -1 1 2 2 2 2 0 0 0\n1 1 30\n0 90\n0 90\n1 1 1 1\n";
    assert!(read("flood.ies", text).unwrap_err().contains("begin below 0"));
}

/// An EULUMDAT file with four C-planes and three angles γ.
fn eulumdat(symmetry: usize, intensities: &str) -> String {
    let mut lines = vec![
        "Maker".to_string(),
        "1".into(),
        symmetry.to_string(),
        "4".into(),
        "90".into(),
        "3".into(),
        "45".into(),
    ];
    lines.extend(["report", "name", "number", "file", "date"].map(String::from));
    lines.extend((13..=21).map(|_| "100".to_string()));
    lines.extend(["50", "80", "1,0", "0", "1"].map(String::from));
    lines.extend(["1", "LED", "2000", "3000", "80", "20"].map(String::from));
    lines.extend((0..10).map(|_| "0.5".to_string()));
    lines.extend(["0", "90", "180", "270", "0", "45", "90"].map(String::from));
    lines.extend(intensities.split(' ').map(|x| x.replace('.', ",")));
    lines.join("\r\n")
}

#[test]
fn eulumdat_has_intensities_for_1000_lumens_in_all_symmetries() {
    // Intensities at γ = 45° of the planes 0, 90, 180 and 270, times 2 for 2000 lm.
    for (symmetry, text, at_45) in [
        (0, "9 1 0 9 2 0 9 3 0 9 4.5 0", [1.0, 2.0, 3.0, 4.5]),
        (1, "9 1.5 0", [1.5, 1.5, 1.5, 1.5]),
        (2, "9 1 0 9 2 0 9 3 0", [1.0, 2.0, 3.0, 2.0]),
        (3, "9 1 0 9 2 0 9 3 0", [2.0, 3.0, 2.0, 1.0]),
        (4, "9 1 0 9 2 0", [1.0, 2.0, 1.0, 2.0]),
    ] {
        let t = read("lamp.ldt", &eulumdat(symmetry, text)).unwrap();
        near(candelas(&t, 0.0, 0.0), 18.0);
        for (k, wanted) in at_45.into_iter().enumerate() {
            near(candelas(&t, 45.0, 90.0 * k as f64), 2.0 * wanted);
        }
    }
}

#[test]
fn power_of_a_cosine_distribution_is_pi_times_its_peak() {
    let gammas: Vec<String> = (0..=180).map(|k| format!("{}", 0.5 * k as f64)).collect();
    let values: Vec<String> =
        (0..=180).map(|k| format!("{:.9}", 1000.0 * (0.5 * k as f64).to_radians().cos().max(0.0))).collect();
    let text = format!(
        "IESNA91\nTILT=NONE\n1 -1 1 181 1 1 2 0 0 0\n1 1 30\n{}\n0\n{}\n",
        gammas.join(" "),
        values.join(" ")
    );
    let t = read("lambert.ies", &text).unwrap();
    let d = zonal_scene::IntensityDistribution::table(t.table, zonal_math::vec3(0.0, 0.0, -1.0), 0.0);
    let lumens = t.peak * d.solid_angle_integral();
    assert!((lumens / (0.5 * TAU * 1000.0) - 1.0).abs() < 2e-5, "{lumens}");
}

#[test]
fn wrong_files_are_refused_with_line_and_remedy() {
    for (name, text, part) in [
        ("a.txt", IES.to_string(), "give a file .ies or .ldt"),
        ("a.ies", "no labels".to_string(), "no line TILT="),
        (
            "a.ies",
            IES.replace("TILT=NONE", "TILT=OTHER.TLT"),
            "a.ies:4: TILT=OTHER.TLT refers to another file",
        ),
        (
            "a.ies",
            IES.replace("3 3 1 2", "3 1e9 1 2"),
            "a.ies:5: the number of horizontal angles is 1000000000",
        ),
        ("a.ies", IES.replace("3 3 1 2", "9999 9999 1 2"), "the file ends before"),
        ("a.ies", IES.replace("3 3 1 2", "3 3 7 2"), "the photometric type is 7"),
        ("a.ies", IES.replace("100 80", "100 x"), "'x' stands where an intensity belongs"),
        ("a.ies", IES.replace("100 80", "100 NaN"), "'NaN' stands where an intensity belongs"),
        ("a.ies", IES.replace("100 80", "100 -80"), "no finite number from 0"),
        ("a.ies", IES.replace("0.9 1 30", "0 1 30"), "give factors above 0"),
        ("a.ldt", eulumdat(0, "9 1 0"), "the file ends before an intensity"),
        ("a.ldt", eulumdat(7, "9 1 0"), "a.ldt:3: the symmetry is 7"),
        ("a.ldt", eulumdat(1, "9 x 0"), "'x' stands where an intensity belongs"),
        ("a.ldt", eulumdat(1, "0 0 0"), "no positive number"),
        ("a.ldt", String::new(), "the file ends before the symmetry"),
    ] {
        let found = read(name, &text).unwrap_err();
        assert!(found.contains(part), "{found} where '{part}' was expected");
    }
}

#[test]
fn altered_files_do_not_panic() {
    let texts = [("a.ies", IES.to_string()), ("a.ldt", eulumdat(4, "9 1 0 9 2 0"))];
    for (name, text) in &texts {
        for k in 0..text.len() {
            for other in ["-", "9", " ", "\n", "e", "."] {
                let mut altered = text.clone();
                altered.replace_range(k..k + 1, other);
                let _ = read(name, &altered);
            }
            let _ = read(name, &text[..k]);
        }
    }
}
