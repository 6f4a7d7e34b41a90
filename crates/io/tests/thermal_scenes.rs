//! Thermal mode in scene files: what is read, what arrays give, and what is refused.

use crate::support;

use support::{Folder, NpyOrder, f32s, npy};
use zonal_io::input::parse_scene;
use zonal_scene::{BandFractions, Bands, Scene, ThermalCondition};

fn read(text: &str) -> Scene {
    parse_scene(text, None, "test.toml").unwrap_or_else(|e| panic!("{e}"))
}

const ROOM: &str = "mode = 'thermal'\n[[surface]]\nname = 'r'\nroom = { min = [0,0,0], max = [1,1,1] }\n";
const GLASS: &str = "mode = 'thermal'\n[[surface]]\nname = 'm'\nmesh = { file = 'a.obj' }\ntemperature = 900\nemissivity = 0.7\n";
const MEDIUM: &str = "[medium]\nmin = [0,0,0]\nmax = [2,1,1]\ncells = [2,1,1]\n";

#[test]
fn thermal_conditions_of_surfaces_and_media_are_read() {
    let s = read(&format!(
        "{ROOM}temperature = 300\nemissivity = 0.8\nfaces.x0 = {{ temperature = 500, reflectance = 0.25 }}\nfaces.x1 = {{ heat_flux = 0, emissivity = 0 }}\n"
    ));
    let t = s.thermal().unwrap();
    // A face has a look of its own; what it knows takes the place of what the room knows.
    assert_eq!(t.surfaces[0], ThermalCondition::Temperature(500.0));
    assert_eq!(t.surfaces[1], ThermalCondition::Flux(0.0));
    assert_eq!(t.surfaces[2], ThermalCondition::Temperature(300.0));
    let rho = |k: usize| s.surfaces()[k].reflectance.first();
    assert!((rho(0) - 0.25).abs() < 1e-15 && rho(1) == 1.0 && (rho(2) - 0.2).abs() < 1e-15);
    let optics = |keys: &str| {
        let s = read(&format!("mode = 'thermal'\n{MEDIUM}heat_source = 7\n{keys}\n"));
        let m = s.voxel_grid().unwrap();
        assert_eq!(m.heat(1), Some(ThermalCondition::Flux(7.0)));
        (m.extinction(0).to_rgb()[1], m.albedo(0).to_rgb()[1])
    };
    assert_eq!(optics("absorption = 0.5"), (0.5, 0.0));
    assert_eq!(optics("absorption = 0.5\nalbedo = 0.75"), (2.0, 0.75));
    assert_eq!(optics("absorption = 0.5\nextinction = 2"), (2.0, 0.75));
    assert_eq!(optics("absorption = 0.5\nextinction = 2\nalbedo = 0.75"), (2.0, 0.75));
    let s = read(&format!(
        "mode = 'thermal'\nsurroundings.temperature = 290\n{MEDIUM}extinction = 1\ntemperature = 900\n[[medium.region]]\nbox = {{ min = [1,0,0], max = [2,1,1] }}\nheat_source = -2\n"
    ));
    let m = s.voxel_grid().unwrap();
    assert_eq!(
        (m.heat(0), m.heat(1)),
        (Some(ThermalCondition::Temperature(900.0)), Some(ThermalCondition::Flux(-2.0)))
    );
    let sent = s.surroundings().radiosity().first() / (5.670374419184429e-8 * 290f64.powi(4));
    assert!((sent - 1.0).abs() < 1e-14);
}

#[test]
fn band_fractions_are_read() {
    let of = |keys: &str| {
        let text =
            format!("mode = 'thermal'\n[thermal]\n{keys}\n{MEDIUM}extinction = 1\ntemperature = 900\n");
        read(&text).thermal().unwrap().band_fractions.clone()
    };
    assert_eq!(
        of("band_fractions = [0.2, 0.3, 0.5]"),
        BandFractions::constant(Bands::from_rgb([0.2, 0.3, 0.5]))
    );
    let rest = of("weights = [[0.5, -1e-4], 'rest', [0.1, 0, 1e-8]]\nrange = [300, 2000]");
    for t in [300.0, 900.0, 2000.0] {
        assert!((rest.grey_gas_weights(t).iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!((rest.grey_gas_weights(t).first() - (0.5 - 1e-4 * t)).abs() < 1e-14);
    }
    let smith = "weights = [[6.508e-1,-5.551e-4,3.029e-7,-5.353e-11], [-0.2504e-1,6.112e-4,-3.882e-7,6.528e-11], [2.718e-1,-3.118e-4,1.221e-7,-1.612e-11]]\nrange = [600, 2400]\nallow_partial = true";
    let a = of(smith).grey_gas_weights(1500.0);
    assert!(a.iter().all(|a| *a > 0.0) && a.iter().sum::<f64>() < 1.0);
}

#[test]
fn voxel_arrays_are_averaged_over_cells() {
    let four = |values: [f32; 4]| npy("<f4", NpyOrder::C, "(4, 1, 1)", &f32s(&values));
    let folder = Folder::new()
        .with("t.npy", four([300.0, 500.0, 900.0, 900.0]))
        .with("q.npy", four([1.0, 3.0, 0.0, 8.0]))
        .with("o.npy", four([0.2, 0.4, 1.0, 0.5]));
    // Two values per cell: means over the volume, of T⁴ and of the rest.
    let s = folder.scene(&format!(
        "mode = 'thermal'\n{MEDIUM}extinction = 1\nalbedo = {{ file = 'o.npy' }}\ntemperature = {{ file = 't.npy' }}\n"
    ));
    let m = s.voxel_grid().unwrap();
    let mean = (0.5f64 * (300f64.powi(4) + 500f64.powi(4))).powf(0.25);
    let Some(ThermalCondition::Temperature(t)) = m.heat(0) else { panic!("{:?}", m.heat(0)) };
    assert!((t - mean).abs() < 1e-9 && m.heat(1) == Some(ThermalCondition::Temperature(900.0)));
    assert!((m.albedo(0).to_rgb()[2] - 0.3).abs() < 1e-7 && (m.albedo(1).to_rgb()[2] - 0.75).abs() < 1e-7);
    assert_eq!(m.extinction(0), Bands::ONE);
    // In a region's box, turned up; the rest stays as it was.
    let s = folder.scene(&format!(
        "mode = 'thermal'\n{MEDIUM}extinction = 1\ntemperature = 400\n[[medium.region]]\nbox = {{ min = [1,0,0], max = [2,1,1] }}\nheat_source = {{ file = 'q.npy', scale = 10 }}\n"
    ));
    let m = s.voxel_grid().unwrap();
    assert_eq!(
        (m.heat(0), m.heat(1)),
        (Some(ThermalCondition::Temperature(400.0)), Some(ThermalCondition::Flux(30.0)))
    );
    // Arrays of their own place, without a shape; light mode knows albedo and emission.
    let s = folder.scene(&format!(
        "{MEDIUM}extinction = 1\nemission = {{ file = 'q.npy', scale = [1, 2, 0] }}\n[[medium.region]]\nalbedo = {{ file = 'o.npy', min = [0,0,0], max = [1,1,1] }}\n"
    ));
    let m = s.voxel_grid().unwrap();
    assert_eq!(
        (m.emission(0), m.emission(1)),
        (Bands::from_rgb([2.0, 4.0, 0.0]), Bands::from_rgb([4.0, 8.0, 0.0]))
    );
    assert!((m.albedo(0).first() - 0.525).abs() < 1e-7 && m.albedo(1) == Bands::ZERO);
}

/// A scene text and what its refusal must contain.
type RefusedScene<'a> = (&'a str, &'a [&'a str]);

/// Invalid scenes; ROOM, MEDIUM and MESH stand for the texts above.
const INVALID: &[RefusedScene<'static>] = &[
    (
        "ROOMtemperature = 0\nemissivity = 1",
        &["test.toml:5:15: ", "surface 'r'.temperature", "0 K is out of range", "above 0"],
    ),
    ("ROOMtemperature = -40\nemissivity = 1", &["-40 K is out of range"]),
    (
        "ROOMtemperature = 300\nheat_flux = 3\nemissivity = 1",
        &["test.toml:6:13:", "more than one of", "keep"],
    ),
    ("ROOMnet_power = 30\nheat_flux = 3\nemissivity = 1", &["more than one of"]),
    ("ROOMemissivity = 1", &["test.toml:", "surface 'r.x0'.temperature", "heat_flux = 0 is adiabatic"]),
    ("ROOMtemperature = 300", &["surface 'r.x0'.emissivity: this key is missing", "emissivity = 0.9"]),
    ("ROOMtemperature = 300\nemissivity = 0.5\nreflectance = 0.6", &["test.toml:6:14:", "at odds"]),
    ("ROOMtemperature = 300\nemissivity = 1.5", &["emissivity", "from 0 to 1"]),
    ("ROOMheat_flux = 5\nemissivity = 0", &["r.x0'.heat_flux", "emissivity 0 can give no power"]),
    ("ROOMnet_power = 5\nemissivity = 0", &["r.x0'.net_power", "emissivity 0"]),
    (
        "ROOMtemperature = 300\nemissivity = [0.1, 0.2, 0.3]",
        &["emissivity", "the bands differ", "band_fractions"],
    ),
    (
        "ROOMtemperature = 300\nemissivity = 1\nemission = 3",
        &["test.toml:7:12:", "emission", "mode = \"light\""],
    ),
    (
        "[[surface]]\nroom={min=[0,0,0],max=[1,1,1]}\ntemperature = 300",
        &["test.toml:3:15:", "mode = \"thermal\""],
    ),
    ("[[surface]]\nroom={min=[0,0,0],max=[1,1,1]}\nheat_flux = 3", &["mode = \"thermal\""]),
    ("MEDIUMextinction = 1\nheat_source = 3", &["medium.heat_source", "mode = \"thermal\""]),
    (
        "surroundings.temperature = 300\nMEDIUMextinction = 1",
        &["surroundings.temperature", "mode = \"thermal\""],
    ),
    ("mode = 'warm'\nMEDIUMextinction = 1", &["test.toml:1:8: mode: 'warm' is not known", "light, thermal"]),
    ("[thermal]\nband_fractions = [0.5,0.5,0]\nMEDIUMextinction = 1", &["thermal: ", "mode = \"thermal\""]),
    (
        "ROOMtemperature = 300\nemissivity = 1\n[[light]]\nkind='emitter'\nsurface='r.x0'",
        &["surface 'r.x0' does not emit"],
    ),
    (
        "ROOMtemperature = 300\nemissivity = 1\nemission = 3\n[[light]]\nkind='emitter'\nsurface='r.x0'",
        &["surface 'r.x1'.emission", "kind \"emitter\""],
    ),
    (
        "ROOMtemperature = 300\nemissivity = 1\nemission = [1, 2]\n[[light]]\nkind='emitter'\nsurface='r.x0'",
        &["emission", "sunlight has one band"],
    ),
    (
        "ROOMtemperature = 300\nemissivity = 1\nfaces.x0.emission = 3\n[[light]]\nkind='emitter'\nsurface='r.x0'\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\nextinction=1\ntemperature=300\nemission=2",
        &["medium.emission", "mode = \"light\""],
    ),
    (
        "ROOMtemperature = 300\nemissivity = 1\n[[light]]\nkind='sun'\ndirection=[0,0,-1]\nirradiance=[1, 2, 3]",
        &["irradiance", "give a number"],
    ),
    ("ROOMtemperature = 300\nemissivity = 1\nsolar_absorptance = 0.2", &["solar_absorptance", "no sunlight"]),
    (
        "ROOMtemperature = 300\nemissivity = 1\n[[light]]\nkind='planet'\ndirection=[0,0,-1]\nangular_diameter=90",
        &["light 'light1'", "sends nothing"],
    ),
    (
        "bands = 3\nROOMtemperature = 300\nemissivity = 1\n[[light]]\nkind='sky'\nradiance=1",
        &["3 bands and sunlight", "band_fractions"],
    ),
    (
        "mode = 'thermal'\nsurroundings.radiance = 3\nMEDIUMextinction = 1\ntemperature = 300",
        &["surroundings.radiance", "mode = \"light\""],
    ),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1",
        &["nothing is known of the medium in cell (0, 0, 0)", "heat_source"],
    ),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1\ntemperature = 300\nheat_source = 4",
        &["more than one of temperature, heat_source"],
    ),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1\nsource = 3\ntemperature = 300",
        &["medium.source", "mode = \"light\""],
    ),
    ("mode = 'thermal'\nMEDIUMextinction = 0\nheat_source = 4", &["medium.heat_source", "absorbs"]),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1\nalbedo = 1\nheat_source = 4",
        &["medium.heat_source", "absorbs"],
    ),
    (
        "mode = 'thermal'\nMEDIUMextinction = [1, 2, 3]\ntemperature = 300",
        &["medium.extinction", "the bands differ"],
    ),
    (
        "mode = 'thermal'\nMEDIUMabsorption = 3\nextinction = 2\ntemperature = 300",
        &["exceeds the extinction"],
    ),
    ("mode = 'thermal'\nMEDIUMabsorption = 1\nextinction = 2\nalbedo = 0.3\ntemperature = 300", &["at odds"]),
    (
        "mode = 'thermal'\nMEDIUMabsorption = 1\nalbedo = 1\ntemperature = 300",
        &["does not determine the extinction"],
    ),
    (
        "mode = 'thermal'\n[thermal]\nband_fractions = [0.5, 0.2, 0.2]\nMEDIUMextinction = 1\ntemperature = 300",
        &["thermal.band_fractions", "sum to 0.9"],
    ),
    (
        "mode = 'thermal'\n[thermal]\nweights = [[1], [0], [0]]\nMEDIUMextinction = 1\ntemperature = 300",
        &["thermal.range", "missing"],
    ),
    (
        "mode = 'thermal'\n[thermal]\nweights = [[1], [0], [0]]\nrange = [900, 300]\n[surroundings]\ntemperature = 302\nMEDIUMextinction = 1\ntemperature = 300",
        &["thermal.range", "[900, 300]", "the lower first"],
    ),
    (
        "mode = 'thermal'\n[thermal]\nweights = [[1], [0]]\nrange = [300, 900]\nMEDIUMextinction = 1\ntemperature = 300",
        &["three lists"],
    ),
    (
        "mode = 'thermal'\n[thermal]\nweights = ['rest', 'rest', [0]]\nrange = [300, 900]\nMEDIUMextinction = 1\ntemperature = 300",
        &["two bands are the rest"],
    ),
    (
        "mode = 'thermal'\n[thermal]\nweights = [[1, -1e-3], 'rest', [0]]\nrange = [300, 1900]\nMEDIUMextinction = 1\ntemperature = 300",
        &["thermal.weights", "band 0 is -0."],
    ),
    (
        "mode = 'thermal'\n[thermal]\nband_fractions = [1, 0, 0]\nrange = [300, 900]\nMEDIUMextinction = 1\ntemperature = 300",
        &["hold everywhere"],
    ),
    (
        "mode = 'thermal'\n[solve]\nscattering_orders = 3\nMEDIUMextinction = 1\ntemperature = 300",
        &["solve.scattering_orders", "thermal"],
    ),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1\ntemperature = { file = 'zero.npy' }",
        &["temperature", "in cell (1, 0, 0) 0 K"],
    ),
    ("MEDIUMextinction = 1\nalbedo = { file = 'hot.npy' }", &["albedo must lie between 0 and 1"]),
    ("MEDIUMextinction = 1\nalbedo = { file = 'none.npy' }", &["medium.albedo.file", "none.npy"]),
    (
        "mode = 'thermal'\n[[pane]]\npolygon=[[0,0,0],[1,0,0],[1,1,0]]\nthickness=0.01\nextinction=3\nheat_source = 4",
        &["heat_source", "a pane has a temperature"],
    ),
    // Powers without measure.
    (
        "ROOMheat_flux = 1e300\nemissivity = 1",
        &["test.toml:5:13:", "r'.heat_flux", "1e300 is out of range", "1e18"],
    ),
    ("ROOMnet_power = -1e19\nemissivity = 1", &["net_power", "-1e19 is out of range"]),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1\nheat_source = 2e18",
        &["medium.heat_source: 2e18 is out of range"],
    ),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1\nheat_source = { file = 'hot.npy', scale = 1e300 }",
        &["medium.heat_source", "e302 is out of range"],
    ),
    (
        "mode = 'thermal'\nMEDIUMextinction = 1\nheat_source = { file = 'cold.npy' }",
        &["cold.npy", "-3 is no heat source; give finite values from 0"],
    ),
    // What can emit in no band gives no power.
    (
        "mode = 'thermal'\n[thermal]\nband_fractions = [0, 0, 1]\nMEDIUMextinction = [1, 4, 0]\nheat_source = 4",
        &["medium.heat_source", "in cell (0, 0, 0)", "no band that has a fraction"],
    ),
    (
        "mode = 'thermal'\n[thermal]\nweights = [[0.3, 1e-4], 'rest', [0]]\nrange = [300, 900]\nMEDIUMextinction = [1, 1, 4]\nalbedo = [1, 1, 0]\nheat_source = 4",
        &["medium.heat_source", "no band that has a fraction"],
    ),
    (
        "ROOMheat_flux = 9\nemissivity = [0, 1, 0]\n[thermal]\nband_fractions = [0.5, 0, 0.5]",
        &["r.x0'.heat_flux", "fraction"],
    ),
    // Glass knows nothing of surfaces.
    (
        "MESHmaterials.'a'.pane = { thickness = 0.1, extinction = 3 }\nmaterials.'a'.temperature = 500",
        &[
            "test.toml:8:29:",
            "materials.a.temperature",
            "is a pane",
            "put temperature into materials.\"a\".pane",
        ],
    ),
    (
        "MESHmaterials.'a' = { pane = { thickness = 0.1, extinction = 3 }, net_power = 5 }",
        &["materials.a.net_power", "put temperature into"],
    ),
    (
        "MESHmaterials.'a' = { pane = { thickness = 0.1, extinction = 3 }, emissivity = 0.5 }",
        &["materials.a.emissivity", "has no emissivity; remove"],
    ),
    (
        "MESHmaterials.'a' = { region = true, pane = { extinction = 3 }, heat_flux = 0 }\nMEDIUMextinction = 1\nheat_source = 0",
        &["materials.a.heat_flux", "fills the medium", "heat_source into"],
    ),
];

#[test]
fn invalid_thermal_scenes_are_refused() {
    let two = |values: [f32; 2]| npy("<f4", NpyOrder::C, "(2, 1, 1)", &f32s(&values));
    let folder = Folder::new().with("zero.npy", two([300.0, 0.0])).with("hot.npy", two([300.0, 900.0]));
    let folder = folder
        .with("cold.npy", two([-3.0, 1.0]))
        .with("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
    let mut wrong = String::new();
    for (text, wanted) in INVALID {
        let text = text.replace("ROOM", ROOM).replace("MEDIUM", MEDIUM).replace("MESH", GLASS);
        let message = folder.refusal(&text);
        for w in wanted.iter().filter(|w| !message.contains(**w)) {
            wrong += &format!("'{w}' is not in:\n{message}\nfor\n{text}\n\n");
        }
        if !message.contains([';', '?', '(']) || message.contains('\n') {
            wrong += &format!("no mend, or several lines:\n{message}\n\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Zero power needs no share, great powers up to the limit are taken, and glass has its temperature among its own keys.
#[test]
fn limiting_cases_are_read() {
    read(&format!(
        "mode = 'thermal'\n[thermal]\nband_fractions = [0, 0, 1]\n{MEDIUM}extinction = [1, 4, 0]\nheat_source = 0\n"
    ));
    read(&format!("mode = 'thermal'\n{MEDIUM}extinction = 1\nheat_source = -1e18\n"));
    let folder = Folder::new().with("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
    let s = folder.scene(&format!(
        "{GLASS}materials.a.pane = {{ thickness = 0.1, extinction = 3, temperature = 500 }}\n"
    ));
    assert_eq!(s.thermal().unwrap().panes, [ThermalCondition::Temperature(500.0)]);
}

/// A room with a body, whose table ends with `surface`, after the tables `nodes`.
fn with_network(nodes: &str, surface: &str) -> Result<zonal_scene::Scene, String> {
    let text = format!(
        "mode = \"thermal\"\n{nodes}\n[[surface]]\nroom = {{ min = [0,0,0], max = [1,1,1] }}\ntemperature = 300\nemissivity = 1\n[[surface]]\nname = \"body\"\nbox = {{ min = [0.4,0.4,0.4], max = [0.6,0.6,0.6] }}\nemissivity = 0.5\n{surface}"
    );
    zonal_io::input::parse_scene(&text, None, "t.toml").map_err(|e| e.to_string())
}

#[test]
fn nodes_and_convection_are_read() {
    use zonal_scene::{Convection, LinkLaw, NodeCondition, ThermalCondition};
    let nodes = "[[node]]\nname = \"a\"\nnet_power = 5\nlinks = [{ to = \"b\", conductance = 2 }, { to = \"b\", effective_emissivity = 0.1 }]\n[[node]]\nname = \"b\"\ntemperature = 400";
    let scene = with_network(
        nodes,
        "node = \"a\"\nheat_transfer_coefficient = 3\nambient_temperature = 290\nfaces.z1 = { temperature = 500 }\nfaces.z0 = { node = \"b\" }",
    )
    .unwrap();
    let thermal = scene.thermal().unwrap();
    let network = thermal.network.as_ref().unwrap();
    // Faces without keys of their own are one surface.
    let of = |name: &str| scene.surfaces().iter().position(|s| s.name == name).unwrap();
    assert_eq!(network.nodes[0].condition, NodeCondition::Power(5.0));
    let laws: Vec<LinkLaw> = network.links.iter().map(|l| l.law).collect();
    assert_eq!(laws, [LinkLaw::Conductance(2.0), LinkLaw::EffectiveEmissivity(0.1)]);
    assert_eq!(network.surface_nodes[of("body")], Some(0));
    assert_eq!((network.surface_nodes[of("body.z0")], network.surface_nodes[0]), (Some(1), None));
    assert_eq!(thermal.surfaces[of("body.z0")], ThermalCondition::Temperature(400.0));
    assert_eq!(network.convection[of("body")], Some(Convection { coefficient: 3.0, ambient: 290.0 }));
    assert!(with_network("", "heat_flux = 0").unwrap().thermal().unwrap().network.is_none());
}

#[test]
fn wrong_nodes_are_refused() {
    let a = "[[node]]\nname = \"a\"";
    for (nodes, surface, message) in [
        ("", "node = \"a\"", "there is no node 'a'; add [[node]]"),
        (a, "node = \"b\"", "the nodes are: a"),
        (a, "node = \"a\"\ntemperature = 300", "remove temperature, heat_flux and net_power, or the node"),
        (a, "heat_flux = 0", "no surface and no link refers to this node"),
        (a, "heat_flux = 0\nambient_temperature = 300", "give both"),
        (
            a,
            "temperature = 300\nheat_transfer_coefficient = 1\nambient_temperature = 300",
            "convection does not change",
        ),
        (
            "[[node]]\nname = \"a\"\nlinks = [{ to = \"a\", conductance = 1 }]",
            "node = \"a\"",
            "no link to itself",
        ),
        ("[[node]]\nname = \"a\"\ntemperature = 300\nnet_power = 1", "node = \"a\"", "both given"),
        (
            "[[node]]\nname = \"a\"\n[[node]]\nname = \"b\"\nlinks = [{ to = \"a\" }]",
            "node = \"a\"",
            "a link has one law",
        ),
        (
            "[[node]]\nname = \"a\"\n[[node]]\nname = \"b\"\nlinks = [{ to = \"a\", conductance_per_area = 1 }]",
            "node = \"a\"",
            "no surface, hence no area",
        ),
        ("[[node]]\nname = \"a\"\n[[node]]\nname = \"a\"", "node = \"a\"", "given twice"),
    ] {
        let error = with_network(nodes, surface).unwrap_err();
        assert!(error.starts_with("t.toml") && error.contains(message), "{error}");
    }
    let light = "[[node]]\nname = 'a'\n[[surface]]\nroom = { min = [0,0,0], max = [1,1,1] }";
    let error = zonal_io::input::parse_scene(light, None, "t.toml").unwrap_err().to_string();
    assert!(error.contains("nodes belong to thermal mode"), "{error}");
}

#[test]
fn emissivities_by_temperature_and_side_are_read() {
    let s = read(&format!(
        "{ROOM}temperature = 300\nemissivity = 1\n[[surface]]\nname = 's'\nrectangle = {{ origin = [0.2,0.2,0.5], edge1 = [0.5,0,0], edge2 = [0,0.5,0] }}\nsides = 'both'\nheat_flux = 0\nemissivity = {{ temperatures = [300, 500], values = [0.1, 0.3] }}\nback = {{ emissivity = 0.9 }}\n"
    ));
    let own = &s.thermal().unwrap().emissivities[6];
    assert_eq!(own.table.as_ref().unwrap().points(), [[300.0, 0.1], [500.0, 0.3]]);
    let back = own.back.as_ref().unwrap();
    assert!((back.reflectance - 0.1).abs().all(|d| d < 1e-15) && back.table.is_none());
    // The middle of the table stands for it.
    assert!((s.surfaces()[6].reflectance - 0.8).abs().all(|d| d < 1e-15));
    // From a file; at a given temperature its value there stands for it.
    let f = Folder::new().with("e.csv", "T,steel,brass\n300,0.1,0.02\n500,0.3,0.04\n");
    let of_file = |keys: &str| {
        let text = format!("{ROOM}temperature = 400\nemissivity = {{ by_temperature = 'e.csv'{keys} }}\n");
        1.0 - f.scene(&text).surfaces()[0].reflectance.first()
    };
    assert!((of_file("") - 0.2).abs() < 1e-15 && (of_file(", column = 'brass'") - 0.03).abs() < 1e-15);
}

#[test]
fn wrong_emissivities_by_temperature_are_refused() {
    let f = Folder::new().with("e.csv", "T,e\n300,0.1\n500,1.3\n");
    let sheet =
        "[[surface]]\nname = 's'\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\n";
    let table = "emissivity = { temperatures = [300, 500], values = [0.1, 0.3] }";
    for (text, words) in [
        (format!("{sheet}{table}\n"), "belongs to thermal mode"),
        (
            format!(
                "{ROOM}temperature = 300\nemissivity = {{ temperatures = [300, 500], values = [0.1] }}\n"
            ),
            "give one for each",
        ),
        (
            format!(
                "{ROOM}temperature = 300\nemissivity = {{ temperatures = [500, 300], values = [0.1, 0.2] }}\n"
            ),
            "ascending",
        ),
        (
            format!("{ROOM}temperature = 300\nemissivity = {{ temperatures = [300], values = [1.2] }}\n"),
            "from 0 to 1",
        ),
        (format!("{ROOM}temperature = 300\nemissivity = {{ temperatures = [300] }}\n"), "values"),
        (
            format!("{ROOM}temperature = 300\nemissivity = {{ by_temperature = 'e.csv' }}\n"),
            "1.3 as an emissivity",
        ),
        (
            format!("{ROOM}temperature = 300\nemissivity = {{ by_temperature = 'e.csv', values = [1] }}\n"),
            "keep one of them",
        ),
        (format!("{ROOM}temperature = 300\nreflectance = 0.1\n{table}\n"), "keep one of them"),
    ] {
        let message = f.refusal(&text);
        assert!(message.contains(words), "'{words}' is not in:\n{message}\nfor\n{text}");
    }
}

#[test]
fn wrong_emissivities_of_backs_and_in_sunlight_are_refused() {
    let f = Folder::new();
    let sheet =
        "[[surface]]\nname = 's'\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\n";
    let table = "emissivity = { temperatures = [300, 500], values = [0.1, 0.3] }";
    for (text, words) in [
        (
            format!("{ROOM}temperature = 300\nemissivity = 1\nback = {{ emissivity = 0.5 }}\n"),
            "sides = \"both\"",
        ),
        (
            format!(
                "mode = 'thermal'\n{sheet}sides = 'both'\ntemperature = 300\nemissivity = 1\nback = {{}}\n"
            ),
            "emissivity",
        ),
        (format!("{sheet}sides = 'both'\nback = {{ emissivity = 0.5 }}\n"), "thermal mode"),
        (
            format!(
                "mode = 'thermal'\n{sheet}sides = 'both'\ntemperature = 300\n{table}\n[[light]]\nkind = 'sun'\ndirection = [0,0,-1]\nirradiance = 800\n"
            ),
            "solar_absorptance",
        ),
    ] {
        let message = f.refusal(&text);
        assert!(message.contains(words), "'{words}' is not in:\n{message}\nfor\n{text}");
    }
}
