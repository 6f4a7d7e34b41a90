//! Scenes from arrays: [`SceneBuilder`] collects surfaces, a medium, lights and cameras, and validates all of them once.

pub(crate) mod lights;
pub(crate) mod medium;
pub(crate) mod mesh;
pub(crate) mod values;

use crate::derived::topology::{self, FaceCopy};
use crate::geometry::shells::{ShellKind, Shells, WELD_TOLERANCE};
use crate::{
    BandFractions, BandSet, Bands, Camera, DEFAULT_REFLECTANCE, Diagnostic, Facet, Light, LinkLaw,
    NodeCondition, NodeLink, Plate, Scene, SceneError, SceneParts, SideEmissivity, Sides, SolveOptions,
    Surface, SurfaceEmissivity, Thermal, ThermalCondition, ThermalNetwork, ThermalNode,
};
use lights::GlassPane;
use medium::Medium;
use mesh::Mesh;
use values::BandValues;
use zonal_math::Vec3;

/// Error message for properties of sunlight that nothing needs.
const SOLAR_WITHOUT_LIGHT: &str =
    "properties for sunlight have no effect without a light in a thermal scene; add one, or leave them out";

/// Builds a [`Scene`] from arrays.
///
/// Any temperature, heat flux or heat source makes the scene thermal; every surface then needs one, and emission is refused. Lights of a thermal scene are
/// sunlight, for which surfaces and media have properties of their own; its infrared is then grey.
///
/// ```
/// use zonal_scene::{Medium, Mesh, Scene, Sun};
/// let scene = Scene::builder()
///     .surface(Mesh::room([0.0; 3], [4.0, 3.0, 2.5]).name("walls").reflectance(0.7))
///     .medium(Medium::grid([0.0; 3], [4.0, 3.0, 2.5], [8, 6, 5]).extinction(0.1).albedo(0.9))
///     .light(Sun::new([1.0, 0.0, -1.0]).irradiance(1000.0))
///     .build()?;
/// assert_eq!(scene.surfaces()[0].name, "walls");
/// # Ok::<(), zonal_scene::SceneError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    /// What needs no other part.
    parts: SceneParts,
    meshes: Vec<Mesh>,
    nodes: Vec<ThermalNode>,
    links: Vec<([String; 2], LinkLaw)>,
    panes: Vec<GlassPane>,
    medium: Option<Medium>,
    surroundings_temperature: Option<f64>,
    band_fractions: Option<BandFractions>,
}

impl Scene {
    /// Begins a scene from arrays.
    #[must_use]
    pub fn builder() -> SceneBuilder {
        SceneBuilder::default()
    }
}

impl SceneBuilder {
    /// Sets the name of the scene.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> SceneBuilder {
        self.parts.name = name.into();
        self
    }

    /// Adds a surface.
    #[must_use]
    pub fn surface(mut self, mesh: Mesh) -> SceneBuilder {
        self.meshes.push(mesh);
        self
    }

    /// Adds several surfaces.
    #[must_use]
    pub fn surfaces(mut self, meshes: impl IntoIterator<Item = Mesh>) -> SceneBuilder {
        self.meshes.extend(meshes);
        self
    }

    /// Adds a body at one temperature, to which surfaces belong by [`Mesh::node`].
    ///
    /// ```
    /// use zonal_scene::{Mesh, NodeCondition, Scene};
    /// let shield = Mesh::cuboid([0.2; 3], [0.8; 3]).name("shield").emissivity(0.1).node("shield");
    /// let hull = Mesh::room([0.0; 3], [1.0; 3]).name("hull").emissivity(0.8).temperature(300.0);
    /// let scene = Scene::builder().surface(hull).surface(shield).node("shield", NodeCondition::Power(5.0)).build()?;
    /// assert_eq!(scene.thermal().unwrap().network.as_ref().unwrap().surface_nodes, [None, Some(0)]);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    #[must_use]
    pub fn node(mut self, name: impl Into<String>, condition: NodeCondition) -> SceneBuilder {
        self.nodes.push(ThermalNode { name: name.into(), condition });
        self
    }

    /// Adds a heat path between two nodes; laws per area refer to the surfaces of the first.
    #[must_use]
    pub fn link(mut self, nodes: [&str; 2], law: LinkLaw) -> SceneBuilder {
        self.links.push((nodes.map(String::from), law));
        self
    }

    /// Adds a pane of glass.
    #[must_use]
    pub fn pane(mut self, pane: GlassPane) -> SceneBuilder {
        self.panes.push(pane);
        self
    }

    /// Sets the participating medium; vacuum without.
    #[must_use]
    pub fn medium(mut self, medium: Medium) -> SceneBuilder {
        self.medium = Some(medium);
        self
    }

    /// Adds a sun, a sky or, in a thermal scene, a planet.
    ///
    /// ```
    /// use zonal_scene::{Mesh, Planet, Scene, Sun};
    /// let plate = Mesh::rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// let scene = Scene::builder()
    ///     .surface(plate.heat_flux(0.0).emissivity(0.85).solar_absorptance(0.2))
    ///     .light(Sun::new([0.0, 0.0, -1.0]).irradiance(1361.0))
    ///     .light(Planet::new([0.0, 0.0, 1.0], 140.0).temperature(255.0).reflected_flux(400.0))
    ///     .build()?;
    /// assert_eq!(scene.bands().name(1), "solar");
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    #[must_use]
    pub fn light(mut self, light: impl Into<Light>) -> SceneBuilder {
        self.parts.lights.push(light.into());
        self
    }

    /// Sets the radiance that comes in from everywhere beyond the scene, W/(m² sr); 0 where not given.
    #[must_use]
    pub fn surroundings(mut self, radiance: impl BandValues) -> SceneBuilder {
        self.parts.surroundings.radiance = radiance.into_bands();
        self
    }

    /// Sets the temperature of black surroundings, K; cold where not given. It makes the scene thermal.
    #[must_use]
    pub fn surroundings_temperature(mut self, temperature: f64) -> SceneBuilder {
        self.surroundings_temperature = Some(temperature);
        self
    }

    /// Sets the fraction of the blackbody emissive power in each band, for thermal scenes; one grey band where not given.
    #[must_use]
    pub fn band_fractions(mut self, fractions: BandFractions) -> SceneBuilder {
        self.band_fractions = Some(fractions);
        self
    }

    /// Makes the low end of axis 0, 1 or 2, the high end, or both ends, symmetry planes: ends of the extent of the medium, or of the boundary box of a
    /// scene without one.
    ///
    /// ```
    /// use zonal_scene::{Medium, Scene};
    /// let medium = Medium::grid([0.0; 3], [1.0; 3], [4; 3]).extinction(0.5);
    /// let scene = Scene::builder().medium(medium).symmetry_planes(0, [true, false]).build()?;
    /// assert_eq!(scene.symmetry_planes()[0], [true, false]);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    ///
    /// # Panics
    /// If `axis` is above 2.
    #[must_use]
    pub fn symmetry_planes(mut self, axis: usize, [low, high]: [bool; 2]) -> SceneBuilder {
        self.parts.symmetry_planes[axis] = [low, high];
        self
    }

    /// Sets the box whose ends are symmetry planes, or a period, in a scene without a medium: its lower and upper corner, m.
    #[must_use]
    pub fn boundary_box(mut self, min: [f64; 3], max: [f64; 3]) -> SceneBuilder {
        self.parts.boundary_box = Some((Vec3::from_array(min), Vec3::from_array(max)));
        self
    }

    /// Makes the scene periodic along axis 0, 1 or 2, with the extent of the medium as its period, or that of the boundary box without a medium.
    ///
    /// # Panics
    /// If `axis` is above 2.
    #[must_use]
    pub fn periodic(mut self, axis: usize) -> SceneBuilder {
        self.parts.periodic[axis] = true;
        self
    }

    /// Adds a camera.
    #[must_use]
    pub fn camera(mut self, camera: Camera) -> SceneBuilder {
        self.parts.cameras.push(camera);
        self
    }

    /// Sets how the scene is solved: accuracy, engine, size of patches.
    #[must_use]
    pub fn options(mut self, options: SolveOptions) -> SceneBuilder {
        self.parts.options = options;
        self
    }

    /// Sets the wanted patch edge, m; a thirtieth of the scene's diagonal where not given.
    #[must_use]
    pub fn patch_size(mut self, size: f64) -> SceneBuilder {
        self.parts.options.patch_size = Some(size);
        self
    }

    /// Whether something in the scene has a temperature or a given heat.
    fn is_thermal(&self) -> bool {
        self.surroundings_temperature.is_some()
            || self.meshes.iter().any(|m| m.condition.is_some())
            || self.medium.as_ref().is_some_and(Medium::is_thermal)
    }

    /// Whether something has properties for sunlight.
    fn gives_solar(&self) -> bool {
        self.meshes.iter().any(|m| m.solar.is_some())
            || self.medium.as_ref().is_some_and(Medium::has_solar_values)
    }

    /// Validates the scene.
    ///
    /// # Errors
    /// If a value is out of range, a name is used twice, a plate has no area, or a thermal scene lacks a temperature or an emissivity. The error
    /// names the part.
    pub fn build(self) -> Result<Scene, SceneError> {
        let (thermal, gives_solar) = (self.is_thermal(), self.gives_solar());
        let mut parts = self.parts;
        let emitters = self.meshes.iter().any(|m| m.direct_light);
        if thermal && (emitters || !parts.lights.is_empty()) {
            add_sunlight(&mut parts, self.band_fractions.as_ref())?;
        } else if gives_solar {
            return Err(SceneError::new("light", SOLAR_WITHOUT_LIGHT));
        }
        let (mut conditions, mut emissivities) = (Vec::new(), Vec::new());
        let mut network = network(self.nodes, self.links)?;
        for (number, mesh) in self.meshes.into_iter().enumerate() {
            let (node, convection) = (node_of(&mesh, &network)?, mesh.convection);
            let emissivity = emissivity_of(&mesh);
            add_mesh(&mut parts, &mut conditions, number, mesh, thermal)?;
            network.surface_nodes.resize(parts.surfaces.len(), node);
            network.convection.resize(parts.surfaces.len(), convection);
            emissivities.resize(parts.surfaces.len(), emissivity);
        }
        give_node_temperatures(&mut conditions, &network);
        let bands = &parts.bands;
        parts.panes = self.panes.into_iter().enumerate().map(|(i, p)| p.into_pane(i + 1, bands)).collect();
        parts.voxel_grid = self.medium.as_ref().map(|m| m.build(bands)).transpose()?;
        if thermal {
            parts.thermal = Some(Thermal {
                cell_fractions: None,
                band_fractions: self.band_fractions.unwrap_or_else(|| default_fractions(&parts.bands)),
                surfaces: conditions,
                panes: vec![ThermalCondition::Flux(0.0); parts.panes.len()],
                surroundings: self.surroundings_temperature,
                network: (!network.is_empty()).then_some(network),
                emissivities,
            });
            give_surroundings_radiance(&mut parts);
        } else if self.band_fractions.is_some() {
            let what = "fractions of the emissive power belong to thermal scenes; give a temperature to a surface or the medium";
            return Err(SceneError::new("thermal.band_fractions", what));
        }
        Scene::new(parts)
    }
}

/// Gives the surroundings of a thermal scene the radiance of their temperature, if they have one.
fn give_surroundings_radiance(parts: &mut SceneParts) {
    if let Some(thermal) = parts.thermal.as_ref().filter(|t| t.surroundings.is_some()) {
        parts.surroundings.radiance = thermal.surroundings_radiance();
    }
}

/// Gives a thermal scene the bands of grey infrared and sunlight, and its lights their power in the latter.
fn add_sunlight(parts: &mut SceneParts, fractions: Option<&BandFractions>) -> Result<(), SceneError> {
    if fractions.is_some() {
        let what = "a thermal scene of a builder with lights is grey in the infrared; remove the band fractions, or read the scene from a file";
        return Err(SceneError::new("thermal.band_fractions", what));
    }
    parts.bands = BandSet::grey().with_solar_band()?;
    parts.lights.iter_mut().for_each(|l| lights::to_sunlight(l, &parts.bands));
    Ok(())
}

/// The band fractions of a scene without given ones: grey in the infrared.
fn default_fractions(bands: &BandSet) -> BandFractions {
    if bands.has_solar_band() {
        BandFractions::constant(Bands::from_rgb([1.0, 0.0, 0.0]))
    } else {
        BandFractions::default()
    }
}

/// Nodes and links by name.
fn network(
    nodes: Vec<ThermalNode>,
    links: Vec<([String; 2], LinkLaw)>,
) -> Result<ThermalNetwork, SceneError> {
    let mut network = ThermalNetwork { nodes, ..ThermalNetwork::default() };
    for (names, law) in links {
        let [a, b] = [index_of_node(&network, &names[0])?, index_of_node(&network, &names[1])?];
        network.links.push(NodeLink { nodes: [a, b], law });
    }
    Ok(network)
}

fn index_of_node(network: &ThermalNetwork, name: &str) -> Result<usize, SceneError> {
    let found = network.nodes.iter().position(|n| n.name == name);
    found.ok_or_else(|| {
        SceneError::new(format!("node '{name}'"), "there is no node of this name; add it to the scene")
    })
}

fn node_of(mesh: &Mesh, network: &ThermalNetwork) -> Result<Option<usize>, SceneError> {
    mesh.node.as_ref().map(|name| index_of_node(network, name)).transpose()
}

/// Gives surfaces of nodes of known temperature that temperature.
fn give_node_temperatures(conditions: &mut [ThermalCondition], network: &ThermalNetwork) {
    for (condition, node) in conditions.iter_mut().zip(&network.surface_nodes) {
        if let Some(NodeCondition::Temperature(t)) = node.map(|k| network.nodes[k].condition) {
            *condition = ThermalCondition::Temperature(t);
        }
    }
}

fn emissivity_of(mesh: &Mesh) -> SurfaceEmissivity {
    let back = mesh.back.map(|reflectance| SideEmissivity { reflectance, table: None });
    SurfaceEmissivity { table: mesh.emissivity_table.clone(), back }
}

/// Adds the surfaces of a mesh: one for each kind of shell (open, solid, enclosure) that it has, unless its sides are given.
fn add_mesh(
    parts: &mut SceneParts,
    conditions: &mut Vec<ThermalCondition>,
    number: usize,
    mesh: Mesh,
    thermal: bool,
) -> Result<(), SceneError> {
    let name = mesh.name.clone().unwrap_or_else(|| format!("surface{}", number + 1));
    if mesh.plates.is_empty() {
        return Err(SceneError::new(
            format!("surface '{name}'"),
            "the mesh has no faces; add faces or leave the surface out",
        ));
    }
    if thermal && mesh.reflectance.is_none() {
        return Err(SceneError::new(
            format!("surface '{name}'.emissivity"),
            "a surface of a thermal scene needs an emissivity",
        ));
    }
    let condition = match (mesh.condition, thermal) {
        (Some(condition), _) => Some(condition),
        (None, true) => {
            let what = "a surface of a thermal scene needs a temperature, a heat flux or a net power; a heat flux of 0 is adiabatic";
            return Err(SceneError::new(format!("surface '{name}'.temperature"), what));
        }
        (None, false) => None,
    };
    let plates = without_repeated(parts, &name, &mesh.plates);
    let shells = Shells::find(&plates, WELD_TOLERANCE);
    let mut present = ShellKind::VARIANTS.to_vec();
    present.retain(|k| (0..plates.len()).any(|i| shells.of(i) == *k));
    for &kind in &present {
        let default = if kind == ShellKind::Open { Sides::Both } else { Sides::Front };
        let sides = mesh.sides.unwrap_or(default);
        let surface = parts.surfaces.len();
        parts.surfaces.push(Surface {
            name: if present.len() > 1 { format!("{name}{}", kind.name_suffix()) } else { name.clone() },
            reflectance: with_solar(
                &parts.bands,
                mesh.reflectance.unwrap_or(DEFAULT_REFLECTANCE),
                mesh.solar,
            ),
            emission: lights::emission_of_light(mesh.emission.unwrap_or_default(), &parts.bands),
            sides,
            patch_size: mesh.patch_size,
            solid: kind == ShellKind::Solid && sides == Sides::Front,
            ..Surface::default()
        });
        conditions.extend(condition);
        if mesh.direct_light {
            parts.lights.push(Light::Emitter { name: None, surface });
        }
        let of_kind = (0..plates.len()).filter(|&i| shells.of(i) == kind);
        parts.facets.extend(of_kind.map(|i| facet(surface, plates[i])));
    }
    Ok(())
}

/// The plates of a mesh that repeat no earlier one, and a note about the others.
fn without_repeated(parts: &mut SceneParts, name: &str, plates: &[Plate]) -> Vec<Plate> {
    let numbers: Vec<usize> = (0..plates.len()).collect();
    let copies = topology::copies(plates, &numbers, &|_| 0);
    let is_repeated = |i: &usize| matches!(copies[*i], Some(FaceCopy::Repeated(_)));
    if let Some(second) = numbers.iter().copied().find(is_repeated) {
        let n = numbers.iter().filter(|i| is_repeated(i)).count();
        let text = format!(
            "{n} repeated face(s) were dropped (first: face {}); remove them from the mesh",
            second + 1
        );
        parts.notes.push(Diagnostic::note("repeated-faces", text).at(format!("surface '{name}'")));
    }
    numbers.iter().filter(|i| !is_repeated(i)).map(|i| plates[*i]).collect()
}

/// A reflectance with that of an absorptance of sunlight.
fn with_solar(bands: &BandSet, reflectance: Bands, absorptance: Option<f64>) -> Bands {
    absorptance.map_or(reflectance, |a| bands.with_solar_value(0, reflectance, 1.0 - a))
}

fn facet(surface: usize, plate: Plate) -> Facet {
    Facet { surface, plate, uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] }
}
