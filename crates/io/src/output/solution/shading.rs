//! Vertex normals and normal maps in a solution file: shading of pictures.
//!
//! | array | contents |
//! |---|---|
//! | `shading_facet` | facets with vertex normals, ascending |
//! | `shading_normal` | their unit normals at four corners, single precision; the fourth of a triangle is the third |
//! | `normal_map_surface`, `normal_map_texture`, `normal_map_scale` | normal maps by surface, ascending |
//!
//! Arrays without content are left out.

use crate::output::error::FileError;
use crate::output::npz::reader::NpzReader;
use crate::output::npz::writer::{ArraySink, ArrayWriter};
use std::io;
use zonal_scene::{CornerNormals, NormalMap, ShadingNormals};

/// Writes the normals.
pub(super) fn write_shading<S: ArraySink>(
    npz: &mut ArrayWriter<S>,
    shading: &ShadingNormals,
) -> io::Result<()> {
    let n = shading.facets().len();
    if n > 0 {
        let (facets, corners): (Vec<usize>, Vec<&CornerNormals>) = shading.facets().unzip();
        npz.ints("shading_facet", n, |i| facets[i])?;
        npz.singles("shading_normal", &[n, 4, 3], |i| corners[i / 12][i / 3 % 4][i % 3])?;
    }
    if !shading.maps.is_empty() {
        let (maps, n) = (&shading.maps, shading.maps.len());
        npz.ints("normal_map_surface", n, |i| maps[i].surface)?;
        npz.ints("normal_map_texture", n, |i| maps[i].texture)?;
        npz.reals("normal_map_scale", n, |i| maps[i].scale)?;
    }
    Ok(())
}

/// Reads the normals of `facets` facets; the constructor of the scene checks them.
pub(super) fn read_shading(
    npz: &mut NpzReader<'_>,
    facets: usize,
    surfaces: usize,
    textures: usize,
) -> Result<ShadingNormals, FileError> {
    let mut out = ShadingNormals::default();
    if npz.has("shading_facet") {
        let list = npz.ints("shading_facet", None, facets)?;
        let (shape, normals) = npz.numbers("shading_normal")?;
        if shape != [list.len(), 4, 3] {
            return Err(npz.error("shading_normal", format!("has shape {shape:?}; solve the scene again")));
        }
        let of =
            |k: usize| std::array::from_fn(|c| std::array::from_fn(|x| normals[12 * k + 3 * c + x] as f32));
        list.into_iter().enumerate().for_each(|(k, facet)| out.push_checked(facet as u32, of(k)));
    }
    if npz.has("normal_map_surface") {
        let surface = npz.ints("normal_map_surface", None, surfaces)?;
        let texture = npz.ints("normal_map_texture", Some(surface.len()), textures)?;
        let scale = npz.reals("normal_map_scale", surface.len())?;
        let map = |k: usize| NormalMap { surface: surface[k], texture: texture[k], scale: scale[k] };
        out.maps = (0..surface.len()).map(map).collect();
    }
    Ok(out)
}
