//! `albedo`, `emission`, `temperature`, `heat_source` = `{ file, … }`: a value for each voxel from a file, as densities are read.
//!
//! A cell gets the mean over the volume of what lies in it: of Ω, of E, of T⁴ and of the heat. An array without a place of its own fills
//! the box of its region, or the medium.

use super::build::Builder;
use super::density::{self, Filling};
use super::error::InputError;
use super::medium::{Grid, Matter};
use super::node::Table;
use zonal_math::Vec3;
use zonal_scene::{Bands, Known};

/// The keys that may be arrays.
const KEYS: [&str; 4] = ["albedo", "emission", "temperature", "heat_source"];

/// True where some key of the table is an array.
pub(crate) fn given(t: &Table<'_>) -> bool {
    KEYS.iter().any(|k| t.get(k).is_some_and(|n| n.is_table()))
}

/// Fills in the arrays of a table; `place` is where those lie that do not say.
pub(crate) fn read_arrays(
    t: &Table<'_>,
    grid: &mut Grid,
    place: (Vec3, Vec3),
    b: &mut Builder<'_>,
) -> Result<(), InputError> {
    for key in KEYS {
        let Some(node) = t.get(key).filter(|n| n.is_table()) else { continue };
        let matter = |v: Bands| match key {
            "albedo" => Matter { albedo: Some(v), ..Matter::default() },
            "emission" => Matter { emission: Some(v), ..Matter::default() },
            "temperature" => {
                Matter { heat: Some(Known::Temperature(v[0].sqrt().sqrt())), ..Matter::default() }
            }
            _ => Matter { heat: Some(Known::Flux(v[0])), ..Matter::default() },
        };
        let fourth = key == "temperature";
        let filling = Filling {
            of: if fourth { |x| x.powi(4) } else { |x| x },
            power: if fourth { 4 } else { 1 },
            matter: &matter,
            place: Some(place),
            word: if key == "heat_source" { "heat source" } else { key },
        };
        if density::read_density(&node, grid, &filling, b)? == 0 {
            return Err(
                node.error("this array fills no cell of the medium; move it inside, or use smaller cells")
            );
        }
    }
    Ok(())
}
