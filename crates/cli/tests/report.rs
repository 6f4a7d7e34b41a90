//! `zonal report`: pages of light and heat with the numbers of the solution, and nothing that a browser would load or run.

use crate::support;

use support::{Folder, Parser, Program, refused};
use zonal_io::output::read_solution;

const ROOM: &str = "[solve]
patch_size = 0.5
[[surface]]
name = 'walls <script>alert(1)</script>'
room = { min = [0, 0, 0], max = [1, 1, 1] }
reflectance = 0.5
faces.z1 = { emission = 1 }
[[camera]]
name = 'door'
origin = [0.5, 0.1, 0.5]
target = [0.5, 1, 0.4]
fov = 80
";
const FURNACE: &str = "mode = 'thermal'
[solve]
patch_size = 0.5
discretization_error = true
[[surface]]
name = 'floor'
rectangle = { origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }
temperature = 900
emissivity = 0.8
[[surface]]
name = 'roof'
rectangle = { origin = [0, 0, 1], edge1 = [0, 1, 0], edge2 = [1, 0, 0] }
temperature = 500
emissivity = 0.6
";

/// The text between two marks.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let start = text.find(from).unwrap_or_else(|| panic!("no {from}")) + from.len();
    &text[start..start + text[start..].find(to).unwrap()]
}

#[test]
fn a_page_of_light_has_pictures_and_the_powers_of_the_solution() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    f.done(&["solve", "room.toml", "-o", "room.npz"]);
    let json: serde_json::Value = serde_json::from_str(&f.done(&[
        "report",
        "room.npz",
        "-o",
        "room.html",
        "--size",
        "32x24",
        "--quality",
        "draft",
        "--json",
    ]))
    .unwrap();
    let page = String::from_utf8(f.get("room.html")).unwrap();
    // A picture of light and one of irradiance; their bytes are PNG files.
    assert_eq!(json["pictures"], 2);
    assert_eq!(page.matches("src=\"data:image/png;base64,iVBORw0KGgo").count(), 2);
    assert!(page.contains("door: light") && page.contains("door: irradiance"));
    // Names are text, and nothing is loaded or run.
    assert!(!page.contains("<script") && page.contains("&lt;script&gt;"));
    assert!(!page.contains("<link") && page.contains("default-src 'none'"));
    // The ceiling of 1 m² emits 1 W.
    let emitted = between(&page, "<tr><th>emitted</th><td>", "</td>");
    assert_eq!(emitted.split(" ± ").next(), Some("1"), "{emitted}");
    let s = read_solution(f.path().join("room.npz")).unwrap();
    let absorbed = s.report.energy.absorbed_surfaces[0].1.first();
    let row = between(&page, "<tr><th>absorbed by walls", "</tr>");
    let stated: f64 = between(row, "<td>", "<").split(" ±").next().unwrap().parse().unwrap();
    assert!((stated - absorbed).abs() < 1e-3 * absorbed, "{stated} {absorbed}");
    assert!(page.contains(&s.scene_hash) && page.contains("Accuracy"));
    // The same solution gives the same bytes.
    f.done(&["report", "room.npz", "-o", "again.html", "--size", "32x24", "--quality", "draft"]);
    assert_eq!(f.get("again.html"), f.get("room.html"));
}

#[test]
fn a_page_of_heat_has_temperatures_and_fluxes_with_errors() {
    let f = Folder::new();
    f.put("furnace.toml", FURNACE);
    f.done(&["solve", "furnace.toml", "-o", "furnace.npz"]);
    f.done(&["report", "furnace.npz", "-o", "furnace.html", "--size", "48x32"]);
    let page = String::from_utf8(f.get("furnace.html")).unwrap();
    assert!(page.contains("overview: temperature") && page.contains("overview: net-flux"));
    let s = read_solution(f.path().join("furnace.npz")).unwrap();
    let floor = s.surface("floor").unwrap();
    let row = between(&page, "<tr><th>floor</th>", "</tr>");
    let cells: Vec<&str> = row.split("<td>").skip(1).map(|c| c.trim_end_matches("</td>")).collect();
    assert_eq!(&cells[..2], ["1 m²", "900"]);
    let [power, error] = [0, 1].map(|k| cells[3].split(" ± ").nth(k).unwrap().parse::<f64>().unwrap());
    let wanted = floor.total_error().unwrap();
    assert!((power - floor.net_power).abs() <= wanted, "{power} {}", floor.net_power);
    assert!((error / wanted - 1.0).abs() < 0.06, "{error} {wanted}");
    // A page without pictures.
    f.done(&["report", "furnace.npz", "-o", "plain.html", "--pictures", "0"]);
    assert!(!String::from_utf8(f.get("plain.html")).unwrap().contains("<img"));
}

#[test]
fn wrong_arguments_are_refused() {
    let f = Folder::new();
    f.put("bad.npz", "not a solution");
    refused(&f, Program, &["report", "bad.npz", "-o", "x.html"], "bad.npz");
    refused(&f, Program, &["report", "bad.npz", "-o", "x.pdf"], "x.pdf");
    refused(&f, Program, &["report", "bad.npz", "-o", "x.html", "--size", "0x3"], "--size");
    refused(&f, Parser, &["report", "bad.npz", "-o", "x.html", "--pictures", "99"], "--pictures");
}
