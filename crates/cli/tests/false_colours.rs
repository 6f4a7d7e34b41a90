//! `zonal render --show`: pixels of an .exr against a search over all zones, colours of a .png against the scale, refused options.

use crate::support;

use support::{Folder, Parser, Program, refused, solution};
use zonal_app::pictures::srgb_bytes;
use zonal_io::output::{ColourMap, NO_VALUE_COLOUR, read_solution};
use zonal_math::Vec3;
use zonal_scene::{Camera, Plate, PlateKind, Solution};

/// A room with five temperatures and an adiabatic mirror without one, a warmer cube, and a vertical pane.
const HEATED_ROOM: &str = "mode = 'thermal'
[solve]
patch_size = 0.5
tolerance = 0.05
discretization_error = false
[[surface]]
name = 'room'
room = { min = [0, 0, 0], max = [1, 1, 1] }
temperature = 500
emissivity = 0.8
faces.x0 = { temperature = 900 }
faces.y0 = { temperature = 300 }
faces.z0 = { heat_flux = 0, emissivity = 0 }
faces.y1 = { heat_flux = 2000 }
[[surface]]
name = 'cube'
box = { min = [0.1, 0.55, 0.2], max = [0.4, 0.85, 0.5], rotate_z_degrees = 30 }
temperature = 1000
emissivity = 0.9
[[pane]]
name = 'glass'
polygon = [[0.2, 0.05, 0.3], [0.6, 0.25, 0.3], [0.6, 0.25, 0.8], [0.2, 0.05, 0.8]]
thickness = 0.02
extinction = 20
";
const CAMERA: &str = "[[camera]]
name = 'door'
origin = [0.95, 0.9, 0.62]
target = [0.1, 0.3, 0.4]
fov = 85
";

fn solved_heated_room() -> Folder {
    let f = Folder::new();
    f.put("warm.toml", format!("{HEATED_ROOM}{CAMERA}"));
    f.done(&["solve", "warm.toml", "-o", "warm.npz"]);
    f
}

/// A field of an EXR file, row 0 on top.
struct ExrField {
    size: (usize, usize),
    values: Vec<f32>,
    /// Quantity and unit.
    comments: String,
}

fn exr_field(f: &Folder, name: &str) -> ExrField {
    let image = exr::prelude::read_first_flat_layer_from_file(f.path().join(name)).unwrap();
    let layer = image.layer_data;
    let channels = &layer.channel_data.list;
    assert_eq!(channels.iter().map(|c| c.name.to_string()).collect::<Vec<_>>(), ["Y"]);
    let comments = layer.attributes.comments.as_ref().unwrap().to_string();
    let values = channels[0].sample_data.values_as_f32().collect();
    ExrField { size: (layer.size.width(), layer.size.height()), values, comments }
}

fn values(f: &Folder, name: &str) -> Vec<f32> {
    exr_field(f, name).values
}

/// Pixels of a PNG.
struct DecodedPng {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
}

impl DecodedPng {
    fn read(f: &Folder, name: &str) -> DecodedPng {
        let mut reader = png::Decoder::new(std::io::Cursor::new(f.get(name))).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        DecodedPng { width: info.width as usize, height: info.height as usize, bytes }
    }
    fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.bytes[3 * (y * self.width + x)..][..3].try_into().unwrap()
    }
    fn count(&self, colour: [u8; 3]) -> usize {
        self.bytes.chunks(3).filter(|p| **p == colour).count()
    }
}

/// Distance to the intersection of a ray and a plate, m.
fn plate_distance(plate: &Plate, origin: Vec3, dir: Vec3) -> Option<f64> {
    let normal = plate.normal();
    let t = (plate.origin - origin).dot(normal) / dir.dot(normal);
    let [u, v] = plate.parameters(origin + dir * t);
    let inside = match plate.kind {
        PlateKind::Parallelogram => u <= 1.0 && v <= 1.0,
        PlateKind::Triangle => u + v <= 1.0,
    };
    (t > 1e-9 && inside && u >= 0.0 && v >= 0.0).then_some(t)
}

/// Distance and index of all zones on a ray, nearest first, by a search over all zones.
fn zones_on_ray(s: &Solution, origin: Vec3, dir: Vec3, panes: bool) -> Vec<(f64, usize)> {
    let patch = |(i, p): (usize, &zonal_scene::Patch)| {
        (p.normal.dot(dir) < 0.0).then(|| plate_distance(&p.plate, origin, dir).map(|t| (t, i))).flatten()
    };
    let mut out: Vec<_> = s.zones.patches.iter().enumerate().filter_map(patch).collect();
    if panes {
        let first = s.zones.pane_offset();
        let pane = |(i, z): (usize, &zonal_scene::PaneZone)| {
            Some((plate_distance(&z.plate, origin, dir)?, first + i))
        };
        out.extend(s.zones.panes.iter().enumerate().filter_map(pane));
    }
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    out
}

/// The direction of the ray through the centre of a pixel.
fn pixel_ray(c: &Camera, (w, h): (usize, usize), x: usize, y: usize) -> Vec3 {
    let f = (c.target - c.origin).normalized();
    let right = f.cross(c.up).normalized();
    let half = (0.5 * c.fov.to_radians()).tan();
    let (x, y) = ((2 * x + 1) as f64 / w as f64 - 1.0, 1.0 - (2 * y + 1) as f64 / h as f64);
    (f + right * (x * half) + right.cross(f) * (y * half * h as f64 / w as f64)).normalized()
}

/// Function from a zone to its value.
type ZoneValue<'a> = &'a dyn Fn(usize) -> f64;

// Guards (pictures): a pixel of a false-colour picture has the value of the first zone on its ray.
#[test]
fn pixels_have_the_value_of_the_first_zone_on_their_ray() {
    let f = solved_heated_room();
    let s = read_solution(f.path().join("warm.npz")).unwrap();
    let heat = s.fields.heat.as_ref().unwrap();
    assert!(heat.temperature.iter().any(|t| t.is_nan()));
    let size = (97, 64);
    let door = s.scene.cameras()[0].clone();
    let (low, high) = s.scene.bounds();
    let overview = Camera::overview(low, high, size.0 as f64 / size.1 as f64);
    let panes = s.zones.pane_offset();
    let net = |i: usize| heat.net[i] * if i < panes { 1.0 } else { s.zones.panes[i - panes].thickness };
    let light = |i: usize| s.fields.incident[i].to_rgb()[0] + s.fields.direct_light(i).to_rgb()[0];
    let fields: [(&str, bool, &str, ZoneValue); 4] = [
        ("temperature", true, "K", &|i| heat.temperature[i]),
        ("net-flux", true, "W/m2", &net),
        ("radiosity", false, "W/m2", &|i| s.fields.radiosity[i].to_rgb()[0]),
        ("irradiance", false, "W/m2", &light),
    ];
    for camera in [&door, &overview] {
        for (field, with_panes, unit, value) in fields {
            let args = ["--size", "97x64", "--camera", &camera.name, "-o", "a.exr"];
            f.done(&[&["render", "warm.npz", "--show", field], args.as_slice()].concat());
            let picture = exr_field(&f, "a.exr");
            assert_eq!((picture.size, picture.comments), (size, format!("{field} [{unit}]")));
            let (mut pane_pixels, mut empty_pixels) = (0, 0);
            for (i, got) in picture.values.iter().enumerate() {
                let dir = pixel_ray(camera, size, i % size.0, i / size.0);
                let list = zones_on_ray(&s, camera.origin, dir, with_panes);
                let Some(first) = list.first() else {
                    assert!(got.is_nan(), "{field}, pixel {i}: {got}");
                    empty_pixels += 1;
                    continue;
                };
                pane_pixels += usize::from(first.1 >= panes);
                let is_value = |expected: f32| expected == *got || expected.is_nan() && got.is_nan();
                // On a ray along an edge either side is correct.
                let close = list.iter().filter(|l| l.0 - first.0 < 1e-6);
                assert!(close.into_iter().any(|l| is_value(value(l.1) as f32)), "{field}, pixel {i}: {got}");
            }
            assert_eq!(pane_pixels > 50, with_panes);
            assert_eq!(empty_pixels > 500, camera.name == "overview");
        }
    }
}

/// Two adjacent rooms: of two sides in one plane the one that faces the camera is visible.
#[test]
fn back_to_back_walls_are_distinguished() {
    let f = Folder::new();
    let room = |name: &str, x: f64, kelvin: f64| {
        format!(
            "[[surface]]\nname = '{name}'\nroom = {{ min = [{x}, 0, 0], max = [{}, 1, 1] }}\ntemperature = {kelvin}\nemissivity = 1\n",
            x + 1.0
        )
    };
    let camera = |name: &str, x: f64| {
        format!("[[camera]]\nname = '{name}'\norigin = [{x}, 0.4, 0.45]\ntarget = [1, 0.5, 0.5]\nfov = 100\n")
    };
    let rooms =
        [room("cold", 0.0, 300.0), room("warm", 1.0, 400.0), camera("cold", 0.3), camera("warm", 1.8)];
    f.put("rooms.toml", format!("mode = 'thermal'\n[solve]\npatch_size = 0.5\n{}", rooms.concat()));
    f.done(&["solve", "rooms.toml", "-o", "rooms.npz"]);
    let seen = |camera: &str| {
        let args =
            ["render", "rooms.npz", "--show", "temperature", "--size", "60x44", "-o", "a.exr", "--camera"];
        f.done(&[&args, [camera].as_slice()].concat());
        values(&f, "a.exr")
    };
    assert!(seen("cold").iter().all(|t| *t == 300.0) && seen("warm").iter().all(|t| *t == 400.0));
    // From outside: rays pass through the backs of walls.
    let s = read_solution(f.path().join("rooms.npz")).unwrap();
    let (low, high) = s.scene.bounds();
    let overview = Camera::overview(low, high, 60.0 / 44.0);
    for (i, got) in seen("overview").iter().enumerate() {
        let list = zones_on_ray(&s, overview.origin, pixel_ray(&overview, (60, 44), i % 60, i / 60), false);
        let expected =
            list.first().map_or(f32::NAN, |l| s.fields.heat.as_ref().unwrap().temperature[l.1] as f32);
        assert!(expected == *got || expected.is_nan() && got.is_nan(), "pixel {i}: {got} for {expected}");
    }
}

const GAS: &str = "[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [4, 4, 4]
extinction = 0.5
heat_source = 1000
";

/// The heated room with gas in four by four by four cells, some cut by walls.
fn solved_room_with_gas() -> Folder {
    let f = Folder::new();
    f.put("gas.toml", format!("{HEATED_ROOM}{GAS}"));
    f.done(&["solve", "gas.toml", "-o", "gas.npz"]);
    f
}

/// Pixels of planes through the gas have the temperature of the nearest wall, pane or cut voxel.
#[test]
fn slice_shows_the_voxels_that_it_cuts() {
    let f = solved_room_with_gas();
    let s = read_solution(f.path().join("gas.npz")).unwrap();
    let (grid, heat) = (s.scene.voxel_grid().unwrap(), s.fields.heat.as_ref().unwrap());
    let size = (90, 70);
    let (low, high) = s.scene.bounds();
    let camera = Camera::overview(low, high, 90.0 / 70.0);
    // Planes inside cells, and one between two cells, which shows the upper one.
    for (slice, axis, place) in
        [("x=0.3", 0, 0.3), ("y = 0.6", 1, 0.6), ("z=0.75", 2, 0.75), ("z=0.1", 2, 0.1)]
    {
        let args = [
            "render",
            "gas.npz",
            "--show",
            "temperature",
            "--size",
            "90x70",
            "-o",
            "out/a.exr",
            "--slice",
            slice,
        ];
        f.done(&args);
        let mut voxels = 0;
        for (i, got) in values(&f, "out/a.exr").iter().enumerate() {
            let dir = pixel_ray(&camera, size, i % size.0, i / size.0);
            let t = (place - camera.origin[axis]) / dir[axis];
            let mut point = (camera.origin + dir * t).array();
            point[axis] = place;
            let cell = grid.cell_at(Vec3::from_array(point));
            let mut list = zones_on_ray(&s, camera.origin, dir, true);
            if let Some(c) = cell {
                // The cube hides cells that it cuts; of a divided cell any part is correct.
                let zones = s.zones.voxel_zones_of_cell(grid.index(c));
                list.extend(zones.map(|z| (t, s.zones.voxel_offset() + z)));
                list.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
            let Some(first) = list.first().copied() else {
                assert!(got.is_nan());
                continue;
            };
            voxels += usize::from(cell.is_some() && first.0 == t);
            let mut close =
                list.iter().filter(|l| l.0 - first.0 < 1e-6).map(|l| heat.temperature[l.1] as f32);
            assert!(close.any(|t| t == *got || t.is_nan() && got.is_nan()), "{slice}, pixel {i}: {got}");
        }
        assert!(voxels > 300, "{slice}: {voxels}");
    }
}

#[test]
fn wrong_slices_are_refused() {
    let f = solved_room_with_gas();
    let slice = |text: &str, named: &str| {
        let args = ["render", "gas.npz", "--show", "temperature", "-o", "out/x.png", "--slice", text];
        refused(&f, Program, &args, named);
    };
    for text in ["", "z", "z=", "=1", "w=1", "z=high", "z=nan", "z=inf", "1.0"] {
        slice(text, "AXIS=METRES");
    }
    slice("z=1.2", "from z=0 to z=1");
    slice("x=-0.1", "does not cut");
    refused(
        &f,
        Program,
        &["render", "gas.npz", "--show", "net-flux", "-o", "out/x.png", "--slice=z=1"],
        "--slice",
    );
    refused(&f, Parser, &["render", "gas.npz", "-o", "out/x.png", "--slice=z=1"], "--show");
    f.put("warm.toml", HEATED_ROOM);
    f.done(&["solve", "warm.toml", "-o", "warm.npz"]);
    let args = ["render", "warm.npz", "--show", "temperature", "-o", "out/x.png", "--slice=z=0.5"];
    refused(&f, Program, &args, "no medium");
}

#[test]
fn colours_agree_with_the_scale() {
    let f = solved_heated_room();
    let draw = |field: &str, more: &[&str], name: &str| {
        let args = ["render", "warm.npz", "--size", "160x120", "--show", field, "-o", name];
        f.done(&[&args, more].concat())
    };
    draw("temperature", &[], "t.exr");
    let kelvin = values(&f, "t.exr");
    let interior = |x: usize, y: usize| {
        // The value of a pixel whose eight neighbours have the same one.
        let own = kelvin[y * 160 + x];
        let rows = (y - 1..=y + 1).map(|v| &kelvin[v * 160 + x - 1..v * 160 + x + 2]);
        rows.flatten().all(|t| *t == own || t.is_nan() && own.is_nan()).then_some(own)
    };
    let mut inside: Vec<(usize, usize, f32)> = Vec::new();
    for y in 1..119 {
        inside.extend((1..159).filter_map(|x| Some((x, y, interior(x, y)?))));
    }
    let (low, high) =
        kelvin.iter().filter(|t| !t.is_nan()).fold((f32::MAX, 0.0f32), |(a, b), t| (a.min(*t), b.max(*t)));
    assert_eq!((low, high), (300.0, 1000.0));
    // Most pixels of a value have its colour; pixels at edges of zones are blended with lines.
    let mostly = |p: &DecodedPng, is: &dyn Fn(f32) -> bool, colour: [f32; 3]| {
        let here: Vec<_> = inside.iter().filter(|i| is(i.2)).collect();
        let hit = here.iter().filter(|i| p.at(i.0, i.1) == srgb_bytes(colour)).count();
        assert!(here.len() > 100 && hit > here.len() * 4 / 5, "{hit} of {}", here.len());
    };
    let plain = ColourMap::Sequential;
    draw("temperature", &[], "t.png");
    let p = DecodedPng::read(&f, "t.png");
    assert!(p.width > 160 && p.height >= 120);
    mostly(&p, &|t| t == 300.0, plain.colour(0.0));
    mostly(&p, &|t| t == 1000.0, plain.colour(1.0));
    mostly(&p, &|t| t == 900.0, plain.colour(600.0 / 700.0));
    mostly(&p, &|t| t.is_nan(), NO_VALUE_COLOUR);
    // Values out of a given range have the colours of its ends.
    let report = draw("temperature", &["--range", "400,950"], "r.png");
    assert!(report.contains("from 300 to 1000 K") && report.contains("without a value"), "{report}");
    let p = DecodedPng::read(&f, "r.png");
    mostly(&p, &|t| t == 300.0, plain.colour(0.0));
    mostly(&p, &|t| t == 1000.0, plain.colour(1.0));
    mostly(&p, &|t| t == 900.0, plain.colour(500.0 / 550.0));
    draw("temperature", &["--log", "--range=100,1000"], "l.png");
    mostly(&DecodedPng::read(&f, "l.png"), &|t| t == 300.0, plain.colour(3f64.log10()));
    // Zero net flux, that of the adiabatic mirror, has the middle colour.
    draw("net-flux", &["--range", "-1e4,5e3"], "q.png");
    mostly(&DecodedPng::read(&f, "q.png"), &|t| t.is_nan(), ColourMap::Diverging.colour(0.5));
    draw("net-flux", &[], "q.png");
    assert!(DecodedPng::read(&f, "q.png").count(srgb_bytes(ColourMap::Diverging.colour(0.5))) > 100);
}

#[test]
fn false_colours_are_identical_for_any_number_of_threads() {
    let f = solved_heated_room();
    let draw = |field: &str, more: &[&str], name: &str| {
        let args = ["render", "warm.npz", "--size", "160x120", "--show", field, "-o", name];
        f.done(&[&args, more].concat())
    };
    for (ending, field) in [("png", "temperature"), ("png", "net-flux"), ("exr", "radiosity")] {
        let (one, three) = (format!("one.{ending}"), format!("three.{ending}"));
        draw(field, &["--threads", "1"], &one);
        draw(field, &["--threads", "3"], &three);
        assert!(f.get(&one) == f.get(&three), "{field}");
    }
}

/// The default camera of a scene without cameras sees the whole scene from an upper corner.
#[test]
fn scene_without_camera_has_overview() {
    let f = Folder::new();
    f.put("warm.toml", HEATED_ROOM);
    let report = f.done(&["solve", "warm.toml", "-o", "warm.npz"]);
    assert!(report.contains("next: zonal render warm.npz --show temperature -o walls.png"), "{report}");
    let json: serde_json::Value = serde_json::from_str(&f.done(&[
        "render",
        "warm.npz",
        "--show",
        "temperature",
        "-o",
        "out/a.png",
        "--size",
        "80x60",
        "--json",
    ]))
    .unwrap();
    assert_eq!((&json["camera"], &json["unit"]), (&"overview".into(), &"K".into()));
    assert_eq!(json["range"], json["visible_range"]);
    assert_eq!((json["width"].as_u64(), json["height"].as_u64()), (Some(80), Some(60)));
    assert!(json["without_value"].as_u64().unwrap() > 50 && json["out_of_range"] == 0);
    f.done(&["render", "warm.npz", "--show", "irradiance", "--camera", "overview", "-o", "out/b.png"]);
    refused(
        &f,
        Program,
        &["render", "warm.npz", "--show", "temperature", "--camera", "door", "-o", "out/x.png"],
        "overview",
    );
}

#[test]
fn light_has_radiosity_and_irradiance() {
    let f = Folder::new();
    f.put("room.npz", solution());
    f.done(&["render", "room.npz", "--show", "radiosity", "--size", "32x24", "-o", "out/b.exr"]);
    f.done(&["render", "room.npz", "--show", "irradiance", "--log", "--size", "32x24", "-o", "out/h.png"]);
    let s = read_solution(f.path().join("room.npz")).unwrap();
    let mean = |i: usize| (s.fields.radiosity[i].iter().sum::<f64>() / 3.0) as f32;
    let b = values(&f, "out/b.exr");
    assert!(b.iter().all(|b| (0..s.zones.voxel_offset()).any(|i| (mean(i) / b - 1.0).abs() < 1e-6)));
}

#[test]
fn inapplicable_options_are_refused() {
    let f = solved_heated_room();
    f.put("room.npz", solution());
    let show = |run: &str, by, field: &str, output: &str, more: &[&str], named: &str| {
        let args = ["render", run, "--show", field, "-o", output];
        refused(&f, by, &[&args, more].concat(), named);
    };
    for field in ["temperature", "net-flux"] {
        show("room.npz", Program, field, "out/x.png", &[], "thermal");
        show("room.npz", Program, field, "out/x.exr", &[], field);
    }
    for range in
        ["", "400", "400,", ",", "a,b", "5,4", "4,4", "nan,1", "0,inf", "-inf,3", "1,2,3", "-1.7e308,1.7e308"]
    {
        show("warm.npz", Program, "temperature", "out/x.png", &[&format!("--range={range}")], "--range");
    }
    for more in [
        ["--stops=1"].as_slice(),
        &["--contrast=1.2"],
        &["--bloom=0.1"],
        &["--gather=16"],
        &["--samples=9"],
        &["--aperture=0.1"],
        &["--focus=2"],
        &["--animate=a.toml"],
    ] {
        show("warm.npz", Program, "temperature", "out/x.png", more, more[0].split('=').next().unwrap());
    }
    show("warm.npz", Program, "net-flux", "out/x.png", &["--log"], "--log");
    show("warm.npz", Program, "temperature", "out/x.png", &["--log", "--range=0,4"], "--range");
    show("warm.npz", Program, "temperature", "out/x.exr", &["--range=1,4"], "--range");
    show("warm.npz", Program, "temperature", "out/x.exr", &["--log"], "--log");
    show("warm.npz", Program, "temperature", "out/x.png", &["--size=0x4"], "--size");
    show("warm.npz", Program, "temperature", "out/x.png", &["--size=16385x1"], "16384");
    show("warm.npz", Program, "temperature", "out/x.png", &["--camera=window"], "--camera");
    show("warm.npz", Program, "temperature", "out/x.jpg", &[], ".png");
    show("none.npz", Program, "temperature", "out/x.png", &[], "none.npz");
    show("warm.npz", Parser, "warmth", "out/x.png", &[], "--show");
    for flag in ["--range=1,2", "--log"] {
        refused(&f, Parser, &["render", "room.npz", "-o", "out/x.png", flag], "--show");
    }
    // The camera sees no zone.
    f.put(
        "away.toml",
        format!("{HEATED_ROOM}[[camera]]\nname = 'out'\norigin = [9, 9, 9]\ntarget = [19, 19, 19]\n"),
    );
    f.done(&["solve", "away.toml", "-o", "away.npz"]);
    show("away.npz", Program, "temperature", "out/x.png", &[], "--camera");
}
