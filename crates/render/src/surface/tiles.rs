//! Patches and pane pieces as tiles of the plates from which they are cut, and fields on them.
//!
//! The sheets of patches are the sides of the facets (`FacetSide`); the sheets of panes are their plates in order.

use super::patch_field::{PatchField, PlateTile};
use zonal_scene::{Bands, PaneZone, Patch, Solution};
use zonal_transport::Transport;
use zonal_transport::patch_locator::{facet_sides, pane_plates, side_of_patch};

/// A field on the patches; `values` has one entry per zone.
pub(crate) fn patch_field<'a>(
    s: &Solution,
    transport: &'a Transport<'a>,
    values: &[Bands],
) -> PatchField<'a> {
    let tiles = patch_tiles(s);
    let values = values[..tiles.len()].to_vec();
    PatchField::new(tiles, values, &facet_sides(&s.scene), Some(transport))
}

/// The patches as tiles.
pub(crate) fn patch_tiles(s: &Solution) -> Vec<PlateTile> {
    let shading = s.scene.shading();
    let tile = |p: &Patch| PlateTile {
        plate: p.plate,
        normal: p.normal,
        sheet: side_of_patch(&s.scene, p),
        is_curved: !shading.is_empty() && shading.of_facet(p.facet).is_some(),
    };
    s.zones.patches.iter().map(tile).collect()
}

/// B of the panes, direct light included, and the index of each pane's first plate.
pub(crate) fn pane_field(s: &Solution) -> (PatchField<'static>, Vec<usize>) {
    let (first, sheets, of) = pane_plates(&s.scene, &s.zones);
    let tiles = pane_tiles(s, &of);
    let values = s.fields.radiosity[s.zones.pane_offset()..].to_vec();
    (PatchField::new(tiles, values, &sheets, None), first)
}

/// The pieces of panes as tiles; `sheets` has the plate of each piece.
pub(crate) fn pane_tiles(s: &Solution, sheets: &[usize]) -> Vec<PlateTile> {
    let tile = |(z, &sheet): (&PaneZone, &usize)| PlateTile {
        plate: z.plate,
        normal: z.normal,
        sheet,
        is_curved: false,
    };
    s.zones.panes.iter().zip(sheets).map(tile).collect()
}
