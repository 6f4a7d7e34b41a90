//! Direct light and textures that vary within zones: the rays engine reads them at the points that its samples meet.

use crate::common;

use common::{read, solve, solved, unit_room};
use zonal_reference::path_tracer::{Detector, PathTracer, TracingAccuracy};
use zonal_scene::{Bands, Scene, Solution, Texture};

/// A lamp of direct light in the middle of hazy air, in a room of 2 m.
fn lamp_in_haze(cells: usize) -> Solution {
    solve(read(&format!(
        "[solve]\nengine = \"rays\"\ntolerance = 0.02\npatch_size = 0.5\n\
         [[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [2,2,2] }}\nreflectance = 0.3\n\
         [[surface]]\nname = \"lamp\"\nrectangle = {{ origin = [0.9,0.9,1], edge1 = [0.2,0,0], edge2 = [0,0.2,0] }}\nreflectance = 0.5\nemission = 100\nsides = \"both\"\n\
         [[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n\
         [medium]\nmin = [0,0,0]\nmax = [2,2,2]\ncells = [{cells},{cells},{cells}]\nextinction = 0.5\nalbedo = 0.9\n"
    )))
}

/// Mean H of a surface without direct light, and its stated error, W/m².
fn mean_of_surface(s: &Solution, name: &str) -> [f64; 2] {
    let surface = s.scene.surfaces().iter().position(|x| x.name == name).unwrap();
    let own = s.zones.patches.iter().enumerate().filter(|(_, p)| p.surface == surface);
    let [mut area, mut value, mut error] = [0.0; 3];
    for (i, p) in own {
        area += p.area;
        value += p.area * s.fields.incident[i].first();
        error += p.area * s.fields.error[i].first();
    }
    [value / area, error / area]
}

/// In cells larger than itself a lamp has received 6 to 60 % less of the light that the air before it scatters back.
#[test]
fn lamp_in_haze_does_not_depend_on_the_cells() {
    let fine = lamp_in_haze(16);
    let [want, of_fine] = mean_of_surface(&fine, "lamp");
    for cells in [2, 5] {
        let s = lamp_in_haze(cells);
        let [found, stated] = mean_of_surface(&s, "lamp");
        assert!(
            (found - want).abs() < stated + of_fine,
            "{cells} cells: {found} ± {stated}, not {want} ± {of_fine}"
        );
        let removed = s.error_parts().iter().map(|p| p.1.zoning_removed).fold(0.0, f64::max);
        assert!(removed > 0.02, "{cells} cells: {removed}");
    }
}

/// H of the patches of a surface, traced without zones, against those of a solution: the relative L2 error, and the stated one.
fn errors_of(s: &Solution, name: &str) -> [f64; 2] {
    let surface = s.scene.surfaces().iter().position(|x| x.name == name).unwrap();
    let own: Vec<usize> =
        (0..s.zones.patches.len()).filter(|i| s.zones.patches[*i].surface == surface).collect();
    let detectors: Vec<Detector> = own.iter().map(|i| Detector::patch(&s.zones.patches[*i])).collect();
    let accuracy = TracingAccuracy { relative: 0.005, max_paths: 40_000, ..TracingAccuracy::default() };
    let traced = PathTracer::new(&s.scene).measure(&detectors, &accuracy, 3);
    let [mut square, mut stated, mut level] = [0.0; 3];
    for (i, reading) in own.into_iter().zip(&traced) {
        let want = Bands::from_fn(|b| reading.incident[b].value).first();
        square += (s.fields.incident[i].first() - want).powi(2);
        stated += s.fields.error[i].first().powi(2);
        level += want * want;
    }
    [square, stated].map(|x| (x / level).sqrt())
}

/// Behind a screen the floor is dark, and only the dark part of its patches lights the back of the screen.
#[test]
fn what_hides_the_lamp_also_hides_its_light() {
    let s = solved(&unit_room(
        "engine = \"rays\"\ntolerance = 0.02\npatch_size = 0.5",
        "reflectance = 0.2\nfaces.z0 = { reflectance = 0.8 }",
        "[[surface]]\nname = \"screen\"\nrectangle = { origin = [0.3,0,0.45], edge1 = [0.4,0,0], edge2 = [0,1,0] }\nreflectance = 0.1\nsides = \"both\"\n\
         [[light]]\nkind = \"point\"\nposition = [0.5,0.5,0.95]\nintensity = 1\n",
    ));
    let [error, stated] = errors_of(&s, "screen");
    assert!(error < 0.02 && stated < 0.025, "{error}, stated {stated}");
    let removed = s.error_parts()[0].1.zoning_removed;
    assert!(removed > 0.01, "{removed}");
}

/// A floor that is black on one half of each patch, and a wall that sees mostly one half.
#[test]
fn textures_are_read_at_points() {
    let text = unit_room(
        "engine = \"rays\"\ntolerance = 0.02\npatch_size = 1",
        "reflectance = 0\nfaces.z1 = { emission = 1 }",
        "[[surface]]\nname = \"floor\"\nrectangle = { origin = [0,0,0.001], edge1 = [1,0,0], edge2 = [0,1,0] }\nreflectance = 1\nsides = \"both\"\n",
    );
    let mut parts = read(&text).into_parts();
    let floor = parts.surfaces.iter().position(|s| s.name == "floor").unwrap();
    let pixel = |k: usize| if k % 64 < 32 { [0.0; 3] } else { [0.8; 3] };
    parts.textures.push(Texture { width: 64, height: 64, pixels: (0..64 * 64).map(pixel).collect() });
    parts.surfaces[floor].reflectance_texture = Some(parts.textures.len() - 1);
    let own = parts.facets.iter_mut().filter(|f| f.surface == floor);
    own.for_each(|f| f.uv = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let s = solve(Scene::new(parts).unwrap());
    let [error, stated] = errors_of(&s, "room.x1");
    assert!(error < 0.02 && stated < 0.025, "{error}, stated {stated}");
}

/// A room of 2 m with boxes on its floor under a lamp, by the dense engine.
fn boxes_on_a_floor(lamp: &str) -> Solution {
    let mut text = format!(
        "[solve]\nengine = \"dense\"\ntolerance = 0.01\npatch_size = 0.5\n\
         [[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [2,2,2] }}\nreflectance = 0.6\n{lamp}"
    );
    for (k, x) in [0.2, 0.8, 1.4].into_iter().enumerate() {
        text += &format!(
            "[[surface]]\nname = \"box {k}\"\nbox = {{ min = [{x},0.7,0], max = [{},1.2,0.4] }}\nreflectance = 0.5\n",
            x + 0.3
        );
    }
    solve(read(&text))
}

// Guards (numbers): the dense engine states the error of light that varies within its zones.
#[test]
fn dense_engine_states_what_its_zones_miss() {
    let lamps = [
        "[[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.8,0.8,1.9], edge1 = [0,0.4,0], edge2 = [0.4,0,0] }\nemission = 100\n",
        "[[light]]\nkind = \"point\"\nposition = [1.5,0.4,1.6]\npower = 100\n",
    ];
    for lamp in lamps {
        let s = boxes_on_a_floor(lamp);
        let zoning = s.error_parts()[0].1.zoning;
        for surface in s.scene.surfaces().iter().map(|x| &x.name).filter(|name| *name != "lamp") {
            let [error, stated] = errors_of(&s, surface);
            println!("{surface}: {error:.4} off, stated {stated:.4}, zoning {zoning:.4}");
            assert!(error < 2.0 * stated, "{surface}: {error} off, {stated} stated");
        }
        assert!(zoning > 0.01, "{zoning}");
        assert!(s.report.warnings.iter().any(|w| w.code == "tolerance"), "no warning");
    }
}

/// Where light is even, zones miss nothing.
#[test]
fn zones_of_a_furnace_miss_nothing() {
    let s = solve(read(
        "[solve]\nengine = \"dense\"\ntolerance = 0.01\npatch_size = 0.5\n\
         [[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [2,2,2] }\nreflectance = 0.5\nemission = 0.5\n\
         [[surface]]\nname = \"box\"\nbox = { min = [0.4,0.7,0.3], max = [1,1.2,0.9] }\nreflectance = 0.2\nemission = 0.8\n",
    ));
    let zoning = s.error_parts()[0].1.zoning;
    assert!(zoning < 1e-5, "{zoning}");
}

/// Shadows and beams have rays, even rooms and small tolerances exchange areas.
#[test]
fn auto_takes_rays_where_light_varies_within_zones() {
    let screen = "[[surface]]\nname = \"screen\"\nrectangle = { origin = [0.3,0.3,0.5], edge1 = [0.4,0,0], edge2 = [0,0.4,0] }\nsides = \"both\"\n";
    let lamp = "[[light]]\nkind = \"point\"\nposition = [0.5,0.5,0.9]\nintensity = 1\n";
    let haze = "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [4,4,4]\nextinction = 0.2\nalbedo = 0.5\n";
    let cases = [
        (0.05, format!("{lamp}{screen}"), "rays"),
        (5e-4, format!("{lamp}{screen}"), "dense"),
        (0.05, lamp.to_string(), "dense"),
        (0.05, format!("{lamp}{haze}"), "rays"),
        (0.05, haze.to_string(), "dense"),
    ];
    for (tolerance, rest, engine) in cases {
        let room = unit_room(
            &format!("tolerance = {tolerance}\npatch_size = 0.5"),
            "reflectance = 0.5\nfaces.z1 = { emission = 1 }",
            &rest,
        );
        assert_eq!(solved(&room).report.engine, engine, "{tolerance} {rest}");
    }
}

/// Behind dark glass that scatters, of one radiosity over its thickness, the room is too bright; the stated error contains it.
#[test]
fn glass_of_one_radiosity_states_its_error() {
    let s = solved(&unit_room(
        "engine = \"rays\"\ntolerance = 0.02\npatch_size = 0.5",
        "omit = [\"z1\"]\nreflectance = 0.3",
        "[[pane]]\nname = \"glass\"\npolygon = [[0,0,0.98], [1,0,0.98], [1,1,0.98], [0,1,0.98]]\nthickness = 0.01\nextinction = 300\nalbedo = 0.4\n\
         [[light]]\nkind = \"sun\"\ndirection = [0.3,0,-1]\nirradiance = 1000\n",
    ));
    let [error, stated] = errors_of(&s, "room.z0");
    println!("{error} off, stated {stated}");
    assert!(error > 0.02 && error < 1.5 * stated, "{error} off, stated {stated}");
}
