//! Places of the charts in the atlas.
//!
//! A chart of w × h metres with texels of edge t takes (⌈w/t⌉ + 2m) × (⌈h/t⌉ + 2m) texels with the margin m, and lies in their middle. Charts are placed the
//! tallest first, by the guillotine packer of the crate guillotiere with the best fit.

use super::charts::FlatChart;
use super::lightmap_data::{AtlasTooSmall, CHART_MARGIN, LightmapOptions};
use guillotiere::{AllocatorOptions, SimpleAtlasAllocator, size2};

/// Largest width and height of an atlas, texels.
const MAX_ATLAS_SIDE: usize = 16_384;
/// Smallest width and height that are tried.
const MIN_ATLAS_SIDE: usize = 32;
/// Factor between texels that are tried in turn.
const TEXEL_GROWTH: f64 = 1.03;
/// Columns and rows of a chart beyond which it fits into no atlas.
const MAX_CHART_TEXELS: f64 = 1e6;
/// Rounding of extents up to full texels, share of a texel.
const TEXEL_ROUNDING: f64 = 1e-6;
/// Width and height of an atlas are multiples of this, as compressed textures demand.
const SIDE_MULTIPLE: usize = 4;

/// A packed atlas.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PackedAtlas {
    /// Texels across.
    pub width: usize,
    /// Texels down.
    pub height: usize,
    /// Edge of a texel, m.
    pub texel: f64,
    /// The rectangle of each chart.
    pub places: Vec<AtlasRectangle>,
}

/// The texels of a chart, margin included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AtlasRectangle {
    /// First column and row.
    pub at: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// Coordinates in texels of the chart's corner (0, 0), from the first column and row.
    pub corner: [f64; 2],
}

impl AtlasRectangle {
    /// A chart's rectangle that is not placed yet.
    fn of_chart(chart: &FlatChart, texel: f64) -> AtlasRectangle {
        let inner = chart.extent.map(|x| (x / texel - TEXEL_ROUNDING).ceil().clamp(1.0, MAX_CHART_TEXELS));
        let corner = [0, 1].map(|k| CHART_MARGIN as f64 + 0.5 * (inner[k] - chart.extent[k] / texel));
        AtlasRectangle { at: [0; 2], size: inner.map(|n| n as usize + 2 * CHART_MARGIN), corner }
    }
    /// Coordinates of the centre of a texel of the rectangle in the chart, m.
    pub(super) fn centre(&self, texel: f64, [i, j]: [usize; 2]) -> [f64; 2] {
        [(i as f64 + 0.5 - self.corner[0]) * texel, (j as f64 + 0.5 - self.corner[1]) * texel]
    }
    /// Coordinates of a point of the chart in texels of the rectangle.
    pub(super) fn texels(&self, texel: f64, x: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.corner[k] + x[k] / texel)
    }
}

/// Packs the charts.
///
/// # Errors
/// If they do not fit.
pub(super) fn pack(charts: &[FlatChart], options: &LightmapOptions) -> Result<PackedAtlas, AtlasTooSmall> {
    let max_side = options.max_side.min(MAX_ATLAS_SIDE);
    let full = |texel: f64| {
        let of = |c: &FlatChart| AtlasRectangle::of_chart(c, texel).size.map(|n| n as f64);
        charts.iter().map(of).map(|[w, h]| w * h).sum::<f64>()
    };
    let too_small = |texel: f64| AtlasTooSmall { charts: charts.len(), max_side, texels: full(texel) };
    if let Some(texel) = options.texel {
        // The smallest square, or half of one, of a power of two.
        let sides = (0..).map(|k| MIN_ATLAS_SIDE << k).take_while(|n| *n < 2 * max_side);
        let sizes = sides.flat_map(|n| [[n, n / 2], [n, n]]).map(|s| s.map(|n| n.min(max_side)));
        let found = sizes.into_iter().find_map(|size| place(charts, texel, size));
        return found.ok_or_else(|| too_small(texel));
    }
    let area: f64 = charts.iter().map(|c| c.extent[0] * c.extent[1]).sum();
    let longest = charts.iter().map(|c| c.extent[0]).fold(0.0, f64::max);
    let mut texel = (area.sqrt() / max_side as f64).max(longest / max_side as f64);
    // With one texel a chart nothing more is gained.
    while texel > 0.0 && texel <= TEXEL_GROWTH * longest {
        if let Some(atlas) = place(charts, texel, [max_side; 2]) {
            return Ok(atlas);
        }
        texel *= TEXEL_GROWTH;
    }
    Err(too_small(longest.max(f64::MIN_POSITIVE)))
}

/// Places the charts in an atlas of at most this size, cropped to what is used; `None` where they do not fit.
fn place(charts: &[FlatChart], texel: f64, size: [usize; 2]) -> Option<PackedAtlas> {
    let mut places: Vec<AtlasRectangle> = charts.iter().map(|c| AtlasRectangle::of_chart(c, texel)).collect();
    let fits = |r: &AtlasRectangle| r.size[0] <= size[0] && r.size[1] <= size[1];
    let area: f64 = places.iter().map(|r| r.size[0] as f64 * r.size[1] as f64).sum();
    if area > size[0] as f64 * size[1] as f64 || !places.iter().all(fits) {
        return None;
    }
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse((places[i].size[1], places[i].size[0])), i));
    // One list of free rectangles, of which the best fit is taken.
    let packer =
        AllocatorOptions { alignment: size2(1, 1), small_size_threshold: 0, large_size_threshold: i32::MAX };
    let mut packer = SimpleAtlasAllocator::with_options(size2(size[0] as i32, size[1] as i32), &packer);
    let mut used = [1; 2];
    for i in order {
        let [w, h] = places[i].size;
        let found = packer.allocate(size2(w as i32, h as i32))?;
        places[i].at = [found.min.x as usize, found.min.y as usize];
        (0..2).for_each(|k| used[k] = used[k].max(places[i].at[k] + places[i].size[k]));
    }
    let [width, height] = used.map(|n| n.next_multiple_of(SIDE_MULTIPLE));
    Some(PackedAtlas { width, height, texel, places })
}
