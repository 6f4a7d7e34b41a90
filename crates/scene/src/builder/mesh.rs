//! A surface from arrays: its shape and its material.

use super::values::BandValues;
use crate::{Bands, Convection, EmissivityTable, Plate, SceneError, Sides, ThermalCondition};
use zonal_math::Vec3;

/// A surface of a [`crate::SceneBuilder`]: plates of one diffuse material under one name.
///
/// Fronts are the sides from which the corners of a face run counter-clockwise. Without [`Mesh::sides`], closed parts with outward normals are
/// solids and closed parts with inward normals are enclosures, both of which exchange on their fronts; open parts exchange on both sides.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(super) name: Option<String>,
    pub(super) plates: Vec<Plate>,
    pub(super) reflectance: Option<Bands>,
    /// Absorptance of sunlight.
    pub(super) solar: Option<f64>,
    pub(super) emission: Option<Bands>,
    pub(super) sides: Option<Sides>,
    pub(super) patch_size: Option<f64>,
    pub(super) condition: Option<ThermalCondition>,
    /// Name of the node.
    pub(super) node: Option<String>,
    pub(super) convection: Option<Convection>,
    pub(super) direct_light: bool,
    /// Emissivities by temperature, and reflectance of the back.
    pub(super) emissivity_table: Option<EmissivityTable>,
    pub(super) back: Option<Bands>,
}

impl Mesh {
    /// A surface of plates.
    #[must_use]
    pub fn from_plates(plates: Vec<Plate>) -> Mesh {
        Mesh {
            name: None,
            plates,
            reflectance: None,
            solar: None,
            emission: None,
            sides: None,
            patch_size: None,
            condition: None,
            node: None,
            convection: None,
            direct_light: false,
            emissivity_table: None,
            back: None,
        }
    }

    /// A surface of triangles: `vertices` in metres, and for each face the indices of its three corners.
    ///
    /// # Errors
    /// If a face names a vertex that does not exist. Faces without area are refused by [`crate::SceneBuilder::build`].
    ///
    /// ```
    /// use zonal_scene::Mesh;
    /// let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// assert!(Mesh::from_arrays(&vertices, &[[0, 1, 2]]).is_ok());
    /// assert!(Mesh::from_arrays(&vertices, &[[0, 1, 3]]).unwrap_err().to_string().contains("vertex 3"));
    /// ```
    pub fn from_arrays(vertices: &[[f64; 3]], faces: &[[usize; 3]]) -> Result<Mesh, SceneError> {
        let plate = |(number, face): (usize, &[usize; 3])| {
            if let Some(bad) = face.iter().find(|v| **v >= vertices.len()) {
                return Err(SceneError::new(
                    "mesh.faces",
                    format!(
                        "face {number} names vertex {bad}, but there are {} vertices; indices start at 0",
                        vertices.len()
                    ),
                ));
            }
            let [a, b, c] = face.map(|v| Vec3::from_array(vertices[v]));
            Ok(Plate::triangle(a, b, c))
        };
        Ok(Mesh::from_plates(faces.iter().enumerate().map(plate).collect::<Result<_, _>>()?))
    }

    /// The parallelogram spanned by two edges at a corner, m; its front is the side of edge1 × edge2.
    #[must_use]
    pub fn rectangle(corner: [f64; 3], edge1: [f64; 3], edge2: [f64; 3]) -> Mesh {
        let [corner, edge1, edge2] = [corner, edge1, edge2].map(Vec3::from_array);
        Mesh::from_plates(vec![Plate::parallelogram(corner, edge1, edge2)])
    }

    /// The solid box between two corners, m: six walls with outward normals.
    #[must_use]
    pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Mesh {
        Mesh::from_plates(box_faces(min, max).iter().map(Plate::flipped).collect())
    }

    /// The six inner walls of a box, m, as one surface.
    #[must_use]
    pub fn room(min: [f64; 3], max: [f64; 3]) -> Mesh {
        Mesh::from_plates(box_faces(min, max).to_vec())
    }

    /// The six inner walls of a box, m, as a surface each, named `x0`, `x1`, `y0`, `y1`, `z0`, `z1` after the axis to which they are normal and
    /// the end of it.
    #[must_use]
    pub fn room_walls(min: [f64; 3], max: [f64; 3]) -> [Mesh; 6] {
        let faces = box_faces(min, max);
        let names = ["x0", "x1", "y0", "y1", "z0", "z1"];
        std::array::from_fn(|i| Mesh::from_plates(vec![faces[i]]).name(names[i]).sides(Sides::Front))
    }

    /// Sets the name, which has to be unique in the scene; without one it is `surface1`, `surface2`, ….
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Mesh {
        self.name = Some(name.into());
        self
    }

    /// The name, if it has one.
    #[must_use]
    pub fn given_name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Sets the diffuse reflectance ρ, 0 to 1; 0.5 where not given.
    #[must_use]
    pub fn reflectance(mut self, reflectance: impl BandValues) -> Mesh {
        self.reflectance = Some(reflectance.into_bands());
        self
    }

    /// Sets the emissivity 1 − ρ, 0 to 1.
    #[must_use]
    pub fn emissivity(mut self, emissivity: impl BandValues) -> Mesh {
        self.reflectance = Some(emissivity.into_bands().map(|e| 1.0 - e));
        self
    }

    /// Sets an emissivity that depends on temperature, in thermal scenes. The absorptance of sunlight is that of the middle of the table where not given.
    #[must_use]
    pub fn emissivity_by_temperature(mut self, table: EmissivityTable) -> Mesh {
        let points = table.points();
        let middle = 0.5 * (points[0][0] + points[points.len() - 1][0]);
        self.reflectance = Some(Bands::splat(1.0 - table.at(middle)));
        self.emissivity_table = Some(table);
        self
    }

    /// Sets another emissivity of the back, 0 to 1, in thermal scenes; both sides then exchange. Its absorptance of sunlight is the same number.
    #[must_use]
    pub fn back_emissivity(mut self, emissivity: impl BandValues) -> Mesh {
        self.back = Some(emissivity.into_bands().map(|e| 1.0 - e));
        self.sides = Some(Sides::Both);
        self
    }

    /// Sets the absorptance of sunlight, 0 to 1, in thermal scenes with lights; the emissivity where not given.
    #[must_use]
    pub fn solar_absorptance(mut self, absorptance: f64) -> Mesh {
        self.solar = Some(absorptance);
        self
    }

    /// Sets the emitted flux E, W/m²; in thermal scenes that of an emitter of light ([`Mesh::as_direct_light`]), in the band of sunlight.
    #[must_use]
    pub fn emission(mut self, emission: impl BandValues) -> Mesh {
        self.emission = Some(emission.into_bands());
        self
    }

    /// Treats the emission as direct light, as suits small lamps: it is gathered by shadow rays instead of the zonal exchange.
    #[must_use]
    pub fn as_direct_light(mut self) -> Mesh {
        self.direct_light = true;
        self
    }

    /// Sets the sides that exchange.
    #[must_use]
    pub fn sides(mut self, sides: Sides) -> Mesh {
        self.sides = Some(sides);
        self
    }

    /// Sets the wanted patch edge, m; the scene's where not given.
    #[must_use]
    pub fn patch_size(mut self, size: f64) -> Mesh {
        self.patch_size = Some(size);
        self
    }

    /// Sets the temperature, K. It makes the scene thermal.
    #[must_use]
    pub fn temperature(mut self, temperature: f64) -> Mesh {
        self.condition = Some(ThermalCondition::Temperature(temperature));
        self
    }

    /// Sets the net flux that leaves the surface, W/m²; 0 is adiabatic. It makes the scene thermal.
    #[must_use]
    pub fn heat_flux(mut self, flux: f64) -> Mesh {
        self.condition = Some(ThermalCondition::Flux(flux));
        self
    }

    /// Sets the net power that leaves the whole surface, W. It makes the scene thermal.
    #[must_use]
    pub fn net_power(mut self, power: f64) -> Mesh {
        self.condition = Some(ThermalCondition::Power(power));
        self
    }

    /// Gives the surface the temperature of a node ([`SceneBuilder::node`](super::SceneBuilder::node)). It makes the scene thermal.
    #[must_use]
    pub fn node(mut self, name: impl Into<String>) -> Mesh {
        self.node = Some(name.into());
        self.condition = Some(ThermalCondition::Flux(0.0));
        self
    }

    /// Sets convection: the heat transfer coefficient, W/(m² K), and the temperature of the air, K. Without a heat flux or a node the surface is
    /// adiabatic behind. It makes the scene thermal.
    #[must_use]
    pub fn convection(mut self, coefficient: f64, ambient: f64) -> Mesh {
        self.convection = Some(Convection { coefficient, ambient });
        self.condition = self.condition.or(Some(ThermalCondition::Flux(0.0)));
        self
    }
}

/// The walls of a box with inward normals, in the order x0, x1, y0, y1, z0, z1.
fn box_faces(min: [f64; 3], max: [f64; 3]) -> [Plate; 6] {
    let size: [f64; 3] = std::array::from_fn(|k| max[k] - min[k]);
    let edge = |axis: usize| {
        let mut e = [0.0; 3];
        e[axis] = size[axis];
        Vec3::from_array(e)
    };
    std::array::from_fn(|i| {
        let (axis, upper) = (i / 2, i % 2 == 1);
        let mut corner = min;
        if upper {
            corner[axis] = max[axis];
        }
        // The edges after the axis in cyclic order span the positive normal.
        let (u, v) = (edge((axis + 1) % 3), edge((axis + 2) % 3));
        let (e1, e2) = if upper { (v, u) } else { (u, v) };
        Plate::parallelogram(Vec3::from_array(corner), e1, e2)
    })
}
