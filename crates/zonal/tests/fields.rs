//! Pictures of numbers through the command: every pixel of an .exr beside all zones asked one by one, colours of a .png at the ends of
//! the scale, and what is refused.

mod support;

use support::{Folder, Parser, Program, refused, solution};
use zonal::io::output::{ColourMap, NO_VALUE, read_exr_field, read_solution};
use zonal::legend::bytes;
use zonal::math::Vec3;
use zonal::scene::{Camera, Plate, PlateKind, Solution};

/// A room of five temperatures with a mirror that has none, a cube that is warmer, and an upright pane.
const WARM: &str = "mode = 'thermal'
[solve]
patch_size = 0.5
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

fn warm() -> Folder {
    let f = Folder::new();
    f.put("warm.toml", format!("{WARM}{CAMERA}"));
    f.done(&["solve", "warm.toml", "-o", "warm.npz"]);
    f
}

fn values(f: &Folder, name: &str) -> Vec<f32> {
    read_exr_field(&f.path().join(name)).unwrap().values
}

/// Pixels of a PNG.
struct Png {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
}

impl Png {
    fn read(f: &Folder, name: &str) -> Png {
        let mut reader = png::Decoder::new(std::io::Cursor::new(f.get(name))).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        Png { width: info.width as usize, height: info.height as usize, bytes }
    }
    fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.bytes[3 * (y * self.width + x)..][..3].try_into().unwrap()
    }
    fn has(&self, colour: [u8; 3]) -> usize {
        self.bytes.chunks(3).filter(|p| **p == colour).count()
    }
}

/// Where a ray meets a plate, m.
fn meets(plate: &Plate, origin: Vec3, dir: Vec3) -> Option<f64> {
    let normal = plate.normal();
    let t = (plate.origin - origin).dot(normal) / dir.dot(normal);
    let [u, v] = plate.parameters(origin + dir * t);
    let inside = match plate.kind {
        PlateKind::Parallelogram => u <= 1.0 && v <= 1.0,
        PlateKind::Triangle => u + v <= 1.0,
    };
    (t > 1e-9 && inside && u >= 0.0 && v >= 0.0).then_some(t)
}

/// Distance and number of all zones that a ray meets on sides that are zones, nearest first; all of them asked.
fn met(s: &Solution, origin: Vec3, dir: Vec3, panes: bool) -> Vec<(f64, usize)> {
    let patch = |(i, p): (usize, &zonal::scene::Patch)| {
        (p.normal.dot(dir) < 0.0).then(|| meets(&p.plate, origin, dir).map(|t| (t, i))).flatten()
    };
    let mut out: Vec<_> = s.zones.patches.iter().enumerate().filter_map(patch).collect();
    if panes {
        let first = s.zones.pane_offset();
        let pane =
            |(i, z): (usize, &zonal::scene::PaneZone)| Some((meets(&z.plate, origin, dir)?, first + i));
        out.extend(s.zones.panes.iter().enumerate().filter_map(pane));
    }
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    out
}

/// The ray through the middle of a pixel.
fn ray(c: &Camera, (w, h): (usize, usize), x: usize, y: usize) -> Vec3 {
    let f = (c.target - c.origin).normalized();
    let right = f.cross(c.up).normalized();
    let half = (0.5 * c.fov.to_radians()).tan();
    let (x, y) = ((2 * x + 1) as f64 / w as f64 - 1.0, 1.0 - (2 * y + 1) as f64 / h as f64);
    (f + right * (x * half) + right.cross(f) * (y * half * h as f64 / w as f64)).normalized()
}

/// The value of a zone.
type Value<'a> = &'a dyn Fn(usize) -> f64;

#[test]
fn every_pixel_has_the_value_of_the_zone_that_its_ray_meets_first() {
    let f = warm();
    let s = read_solution(&f.path().join("warm.npz")).unwrap();
    let heat = s.fields.heat.as_ref().unwrap();
    assert!(heat.temperature.iter().any(|t| t.is_nan()));
    let size = (97, 64);
    let door = s.scene.cameras()[0].clone();
    let overview = Camera::overview(s.scene.bounds(), size.0 as f64 / size.1 as f64);
    let panes = s.zones.pane_offset();
    let net = |i: usize| heat.net[i] * if i < panes { 1.0 } else { s.zones.panes[i - panes].thickness };
    let light = |i: usize| s.fields.incident[i][0] + s.fields.direct[i][0];
    let fields: [(&str, bool, &str, Value); 4] = [
        ("temperature", true, "K", &|i| heat.temperature[i]),
        ("net-flux", true, "W/m2", &net),
        ("radiosity", false, "W/m2", &|i| s.fields.radiosity[i][0]),
        ("irradiance", false, "W/m2", &light),
    ];
    for camera in [&door, &overview] {
        for (field, with_panes, unit, value) in fields {
            let args = ["--size", "97x64", "--camera", &camera.name, "-o", "a.exr"];
            f.done(&[&["render", "warm.npz", "--show", field], args.as_slice()].concat());
            let picture = read_exr_field(&f.path().join("a.exr")).unwrap();
            assert_eq!((picture.width, picture.height), size);
            assert_eq!((picture.quantity.as_str(), picture.unit.as_str()), (field, unit));
            let (mut panes_seen, mut nothing) = (0, 0);
            for (i, got) in picture.values.iter().enumerate() {
                let dir = ray(camera, size, i % size.0, i / size.0);
                let list = met(&s, camera.origin, dir, with_panes);
                let Some(first) = list.first() else {
                    assert!(got.is_nan(), "{field}, pixel {i}: {got}");
                    nothing += 1;
                    continue;
                };
                panes_seen += usize::from(first.1 >= panes);
                let same = |want: f32| want == *got || want.is_nan() && got.is_nan();
                // A ray along an edge may have either side.
                let close = list.iter().filter(|l| l.0 - first.0 < 1e-6);
                assert!(close.into_iter().any(|l| same(value(l.1) as f32)), "{field}, pixel {i}: {got}");
            }
            assert_eq!(panes_seen > 50, with_panes);
            assert_eq!(nothing > 500, camera.name == "overview");
        }
    }
}

/// Two rooms wall to wall: of two sides in one plane the one that faces the eye is seen, whichever a ray names first.
#[test]
fn walls_back_to_back_are_told_apart() {
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
    // From outside on the warm side: its backs and the cold room's wall are looked through.
    let s = read_solution(&f.path().join("rooms.npz")).unwrap();
    let overview = Camera::overview(s.scene.bounds(), 60.0 / 44.0);
    for (i, got) in seen("overview").iter().enumerate() {
        let list = met(&s, overview.origin, ray(&overview, (60, 44), i % 60, i / 60), false);
        let want = list.first().map_or(f32::NAN, |l| s.fields.heat.as_ref().unwrap().temperature[l.1] as f32);
        assert!(want == *got || want.is_nan() && got.is_nan(), "pixel {i}: {got} for {want}");
    }
}

/// A plane through a medium of four by four by four cells, some between walls.
#[test]
fn a_slice_has_the_voxels_that_it_cuts() {
    let f = Folder::new();
    let medium = "[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [4, 4, 4]
extinction = 0.5
heat_source = 1000
";
    f.put("gas.toml", format!("{WARM}{medium}"));
    f.done(&["solve", "gas.toml", "-o", "gas.npz"]);
    let s = read_solution(&f.path().join("gas.npz")).unwrap();
    let (map, heat) = (s.scene.voxmap().unwrap(), s.fields.heat.as_ref().unwrap());
    let size = (90, 70);
    let camera = Camera::overview(s.scene.bounds(), 90.0 / 70.0);
    // Planes within cells, and one between two of them, where it shows the upper.
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
            let dir = ray(&camera, size, i % size.0, i / size.0);
            let t = (place - camera.origin[axis]) / dir[axis];
            let mut point = (camera.origin + dir * t).array();
            point[axis] = place;
            let cell = map.cell_at(Vec3::from_array(point));
            let mut list = met(&s, camera.origin, dir, true);
            if let Some(c) = cell {
                // The cube's temperature hides cells that it cuts; of parted cells any part may be meant.
                let zones = s.zones.of_cell(map.index(c));
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
    f.put("warm.toml", WARM);
    f.done(&["solve", "warm.toml", "-o", "warm.npz"]);
    let args = ["render", "warm.npz", "--show", "temperature", "-o", "out/x.png", "--slice=z=0.5"];
    refused(&f, Program, &args, "no medium");
}

#[test]
fn colours_are_those_of_the_scale() {
    let f = warm();
    let draw = |field: &str, more: &[&str], name: &str| {
        let args = ["render", "warm.npz", "--size", "160x120", "--show", field, "-o", name];
        f.done(&[&args, more].concat())
    };
    draw("temperature", &[], "t.exr");
    let kelvin = values(&f, "t.exr");
    let interior = |x: usize, y: usize| {
        // A pixel and the eight around it see one value.
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
    // What the colour of one value is: most pixels of it are not at edges of zones, where lines stand.
    let mostly = |p: &Png, is: &dyn Fn(f32) -> bool, colour: [f32; 3]| {
        let here: Vec<_> = inside.iter().filter(|i| is(i.2)).collect();
        let hit = here.iter().filter(|i| p.at(i.0, i.1) == bytes(colour)).count();
        assert!(here.len() > 100 && hit > here.len() * 4 / 5, "{hit} of {}", here.len());
    };
    let plain = ColourMap::Plain;
    draw("temperature", &[], "t.png");
    let p = Png::read(&f, "t.png");
    assert!(p.width > 160 && p.height >= 120);
    mostly(&p, &|t| t == 300.0, plain.colour(0.0));
    mostly(&p, &|t| t == 1000.0, plain.colour(1.0));
    mostly(&p, &|t| t == 900.0, plain.colour(600.0 / 700.0));
    mostly(&p, &|t| t.is_nan(), NO_VALUE);
    // A range of one's own: what is beyond has the colours of the ends.
    let told = draw("temperature", &["--range", "400,950"], "r.png");
    assert!(told.contains("from 300 to 1000 K") && told.contains("without a value"), "{told}");
    let p = Png::read(&f, "r.png");
    mostly(&p, &|t| t == 300.0, plain.colour(0.0));
    mostly(&p, &|t| t == 1000.0, plain.colour(1.0));
    mostly(&p, &|t| t == 900.0, plain.colour(500.0 / 550.0));
    draw("temperature", &["--log", "--range=100,1000"], "l.png");
    mostly(&Png::read(&f, "l.png"), &|t| t == 300.0, plain.colour(3f64.log10()));
    // Net fluxes: nothing is the middle of the colours, the adiabatic mirror here.
    draw("net-flux", &["--range", "-1e4,5e3"], "q.png");
    mostly(&Png::read(&f, "q.png"), &|t| t.is_nan(), ColourMap::Signed.colour(0.5));
    draw("net-flux", &[], "q.png");
    assert!(Png::read(&f, "q.png").has(bytes(ColourMap::Signed.colour(0.5))) > 100);
    // The same bytes with any number of threads.
    for (ending, field) in [("png", "temperature"), ("png", "net-flux"), ("exr", "radiosity")] {
        let (one, three) = (format!("one.{ending}"), format!("three.{ending}"));
        draw(field, &["--threads", "1"], &one);
        draw(field, &["--threads", "3"], &three);
        assert!(f.get(&one) == f.get(&three), "{field}");
    }
}

/// Without a camera the whole is seen from a corner above, through the backs of the walls.
#[test]
fn a_scene_without_a_camera_has_an_overview() {
    let f = Folder::new();
    f.put("warm.toml", WARM);
    let told = f.done(&["solve", "warm.toml", "-o", "warm.npz"]);
    assert!(told.contains("next: zonal render warm.npz --show temperature -o walls.png"), "{told}");
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
    assert_eq!(json["range"], json["seen"]);
    assert_eq!((json["width"].as_u64(), json["height"].as_u64()), (Some(80), Some(60)));
    assert!(json["without_value"].as_u64().unwrap() > 50 && json["beyond_range"] == 0);
    f.done(&["render", "warm.npz", "--show", "irradiation", "--camera", "overview", "-o", "out/b.png"]);
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
    let s = read_solution(&f.path().join("room.npz")).unwrap();
    let mean = |i: usize| (s.fields.radiosity[i].iter().sum::<f64>() / 3.0) as f32;
    let b = values(&f, "out/b.exr");
    assert!(b.iter().all(|b| (0..s.zones.voxel_offset()).any(|i| (mean(i) / b - 1.0).abs() < 1e-6)));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let f = warm();
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
    // Nothing but backs, or nothing at all.
    f.put(
        "away.toml",
        format!("{WARM}[[camera]]\nname = 'out'\norigin = [9, 9, 9]\ntarget = [19, 19, 19]\n"),
    );
    f.done(&["solve", "away.toml", "-o", "away.npz"]);
    show("away.npz", Program, "temperature", "out/x.png", &[], "--camera");
}
