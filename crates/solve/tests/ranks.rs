//! Solutions of several processes, which are threads here.

use crate::common::thread_ranks::on_ranks;
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::{Bands, NoProgress, ZoneValues};
use zonal_solve::SolveSettings;
use zonal_solve::distribution::{Communicator, SingleProcess};

const ROOM: &str = "name = \"room\"\n[solve]\ntolerance = 0.1\npatch_size = 0.4\nengine = \"ENGINE\"\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\nomit = [\"z1\"]\nreflectance = 0.5\n\
    [[surface]]\nname = \"block\"\nbox = { min = [0.7, 0.6, 0], max = [1.3, 1.4, 0.9], rotate_z_degrees = 20 }\nreflectance = 0.6\n\
    [[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.6, 0.7, 1.95], edge1 = [0, 0.6, 0], edge2 = [0.8, 0, 0] }\nemission = 10\n\
    [[pane]]\nname = \"glass\"\npolygon = [[0.2, 0.1, 1.6], [1.6, 0.1, 1.6], [1.6, 1.6, 1.6], [0.2, 1.6, 1.6]]\n\
    thickness = 0.01\nextinction = [20, 40, 80]\nalbedo = 0.1\n\
    [medium]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\ncells = [5, 5, 5]\nextinction = 0.4\nalbedo = 0.5\n\
    [surroundings]\nname = \"sky\"\nradiance = 2\n\
    [[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n\
    [[light]]\nkind = \"sun\"\ndirection = [0.3, 0.2, -1]\nirradiance = 100\nangular_diameter = 2\n";

const BOX: &str = "name = \"box\"\n[solve]\ntolerance = 0.01\nengine = \"spectral\"\npatch_rule = \"voxels\"\nBASIS\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [1.7, 0.9, 1.1] }\nomit = [\"x1\"]\nreflectance = [0.5, 0.4, 0.5]\n\
    faces.z1 = { emission = [10, 20, 10] }\n\
    [[surface]]\nname = \"lamp\"\nrectangle = { origin = [1.7, 0, 0], edge1 = [0, 0, 1.1], edge2 = [0, 0.9, 0] }\nemission = 3\n\
    [[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n\
    [surroundings]\nradiance = 2\n\
    [medium]\nmin = [0, 0, 0]\nmax = [1.7, 0.9, 1.1]\ncells = [17, 9, 11]\nextinction = [0.5, 0.5, 0.8]\nalbedo = 0.7\n";
const STACK: &str = "name = \"stack\"\n[solve]\nengine = \"spectral\"\npatch_rule = \"voxels\"\n[boundary]\ny = \"periodic\"\n\
    [[surface]]\nname = \"ends\"\nroom = { min = [0, 0, 0], max = [1.2, 1, 0.8] }\nomit = [\"y0\", \"y1\", \"z1\"]\n\
    reflectance = 0.5\nfaces.x0 = { emission = 10 }\n\
    [surroundings]\nradiance = 2\n\
    [medium]\nmin = [0, 0, 0]\nmax = [1.2, 1, 0.8]\ncells = [12, 5, 8]\nextinction = 2\nalbedo = 0.7\n";

/// Everything of a solution, to the bit.
fn solved(text: &str, communicator: &dyn Communicator) -> String {
    let scene = zonal_io::input::parse_scene(text, None, "room").unwrap();
    let settings = SolveSettings { communicator, ..SolveSettings::new(1 << 30, &NoProgress) };
    let solution = zonal_solve::solve_with_settings(scene, &settings).unwrap();
    let collect = |own: &[Bands]| {
        zonal_solve::pipeline::zone_division::collect(&solution, communicator, own).into_owned()
    };
    let f = &solution.fields;
    let lists = zonal_scene::Fields::LISTS.map(|list| collect((list.of)(f)));
    let mut out = format!("{:?} {lists:?}", solution.report);
    for group in &solution.groups {
        for values in [&group.incident, &group.direct, &group.error, &group.direct_error] {
            match values {
                ZoneValues::Double(list) => out += &format!("{:?}", collect(list)),
                ZoneValues::Single(list) => out += &format!("{list:?}"),
            }
        }
        out += &format!("{:?} {:?} {:?}", group.energy, group.status, group.residual);
    }
    out
}

// Guards (determinism): solutions do not depend on the number of processes.
#[test]
fn solutions_do_not_depend_on_the_number_of_ranks() {
    let scenes = [
        ("rays", ROOM.replace("ENGINE", "rays")),
        ("dense", ROOM.replace("ENGINE", "dense")),
        ("spectral", BOX.replace("BASIS", "zone_basis = \"constant\"")),
        ("linear", BOX.replace("BASIS", "zone_basis = \"linear\"")),
        ("periodic", STACK.to_string()),
    ];
    let cases: Vec<(&(&str, String), usize)> =
        scenes.iter().flat_map(|scene| [2, 3, 7].map(|size| (scene, size))).collect();
    for ((name, text), size) in sampled_cases(cases, &[1, 3, 6, 8, 11, 13]) {
        let alone = solved(text, &SingleProcess);
        // The first rank collects divided fields.
        let found = on_ranks(size, |c| solved(text, c)).swap_remove(0);
        if let Some(at) = found.bytes().zip(alone.bytes()).position(|(x, y)| x != y) {
            let near = at.saturating_sub(200)..(at + 60).min(found.len().min(alone.len()));
            panic!("{name} on {size} ranks differs: {:?} {:?}", found.get(near.clone()), alone.get(near));
        }
        assert_eq!(found.len(), alone.len(), "{name} on {size} ranks");
    }
}
