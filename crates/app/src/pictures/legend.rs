//! A picture in false colours with its legend: a colour bar, tick labels, quantity and unit.
//!
//! The legend is drawn to the right of the picture on white; the pixels of the picture do not change. A picture that is lower than the legend is extended
//! downwards. The font is Noto Sans Mono, rasterized at four sizes by the crate `noto-sans-mono-bitmap`; the size follows the height of the picture.

use super::colour_scale::ColourScale;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use zonal_io::output::{NO_VALUE_COLOUR, srgb_to_byte};
use zonal_report::plot::tick_label;

/// Colour of text, sRGB.
const TEXT_COLOUR: [u8; 3] = [40, 40, 40];
/// Colour of frames and tick marks, sRGB.
const FRAME_COLOUR: [u8; 3] = [120, 120, 120];
const FONT_WEIGHT: FontWeight = FontWeight::Regular;
/// Label of the colour of zones without a value.
const NO_VALUE_LABEL: &str = "none";

/// An 8-bit sRGB picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Canvas {
    /// Pixels across.
    pub(crate) width: usize,
    /// Pixels down.
    pub(crate) height: usize,
    /// Three bytes per pixel, row by row, row 0 on top.
    pub(crate) bytes: Vec<u8>,
}

/// Content of a legend.
#[derive(Clone, Debug)]
pub(super) struct Legend {
    /// Lines above the bar: quantity and unit.
    pub(super) title: Vec<String>,
    /// The scale, in the unit of the title.
    pub(super) scale: ColourScale,
    /// True if zones without a value are visible.
    pub(super) has_no_value: bool,
}

/// The sRGB bytes of a linear colour.
pub fn srgb_bytes(linear: [f32; 3]) -> [u8; 3] {
    linear.map(srgb_to_byte)
}

impl Canvas {
    /// A white canvas.
    fn white(width: usize, height: usize) -> Canvas {
        Canvas { width, height, bytes: vec![255; 3 * width * height] }
    }
    fn fill(&mut self, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2], colour: [u8; 3]) {
        for y in y0..y1.min(self.height) {
            for x in x0..x1.min(self.width) {
                let i = 3 * (y * self.width + x);
                self.bytes[i..i + 3].copy_from_slice(&colour);
            }
        }
    }
    /// A frame of one pixel around a rectangle.
    fn frame(&mut self, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2]) {
        for (x, y) in [([x0 - 1, x1 + 1], [y0 - 1, y0]), ([x0 - 1, x1 + 1], [y1, y1 + 1])] {
            self.fill(x, y, FRAME_COLOUR);
        }
        for (x, y) in [([x0 - 1, x0], [y0, y1]), ([x1, x1 + 1], [y0, y1])] {
            self.fill(x, y, FRAME_COLOUR);
        }
    }
    /// Draws a line of text from its upper left corner.
    fn draw_text(&mut self, text: &str, corner: (usize, usize), size: RasterHeight) {
        let (x, y) = corner;
        let advance = get_raster_width(FONT_WEIGHT, size);
        for (k, c) in text.chars().enumerate() {
            let Some(letter) = get_raster(c, FONT_WEIGHT, size) else { continue };
            for (dy, row) in letter.rows().enumerate() {
                for (dx, coverage) in row.iter().enumerate() {
                    self.blend_text(x + k * advance + dx, y + dy, *coverage);
                }
            }
        }
    }
    /// Blends the text colour over a pixel.
    fn blend_text(&mut self, x: usize, y: usize, coverage: u8) {
        if x >= self.width || y >= self.height {
            return;
        }
        let i = 3 * (y * self.width + x);
        for (b, c) in self.bytes[i..i + 3].iter_mut().zip(TEXT_COLOUR) {
            let (background, coverage) = (*b as u32, coverage as u32);
            *b = ((background * (255 - coverage) + c as u32 * coverage + 127) / 255) as u8;
        }
    }
}

/// Layout of a legend, pixels.
struct LegendLayout {
    font_size: RasterHeight,
    line_height: usize,
    letter_width: usize,
    /// Top and bottom of the colour bar.
    bar: [usize; 2],
    height: usize,
}

impl LegendLayout {
    fn new(legend: &Legend, height: usize) -> LegendLayout {
        let font_size = match height {
            0..560 => RasterHeight::Size16,
            560..760 => RasterHeight::Size20,
            760..1000 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        };
        let line = font_size.val();
        let top = line * 3 / 4 + legend.title.len() * line * 9 / 8 + line;
        let foot = if legend.has_no_value { 3 * line } else { line };
        let height = height.max(top + 7 * line + foot);
        LegendLayout {
            font_size,
            line_height: line,
            letter_width: get_raster_width(FONT_WEIGHT, font_size),
            bar: [top, height - foot],
            height,
        }
    }
    /// Row and label of each tick; ticks whose labels would overlap are left out.
    fn ticks(&self, scale: &ColourScale) -> Vec<(usize, String)> {
        let [top, bottom] = self.bar;
        let length = (bottom - top) as f64;
        let count = (length / (3.0 * self.line_height as f64)).clamp(3.0, 8.0) as usize;
        let row = |v: f64| bottom - (scale.position(v).clamp(0.0, 1.0) * length).round() as usize;
        let mut out: Vec<(usize, String)> = Vec::new();
        for v in scale.ticks(count) {
            let has_space = out.last().is_none_or(|(y, _)| y - row(v) >= self.line_height * 5 / 4);
            if has_space {
                out.push((row(v), tick_label(v, scale.axis)));
            }
        }
        out
    }
}

/// A picture, row by row, with its legend to the right.
pub(super) fn beside(picture: &[[f32; 3]], size: (usize, usize), legend: &Legend) -> Canvas {
    let (width, height) = size;
    let l = LegendLayout::new(legend, height);
    let ticks = l.ticks(&legend.scale);
    // Measure the legend, and copy the picture.
    let (margin, bar, tick) = (l.line_height, l.line_height * 5 / 4, l.line_height / 3);
    let text_width = |texts: &mut dyn Iterator<Item = &str>| {
        texts.map(|t| t.chars().count()).max().unwrap_or(0) * l.letter_width
    };
    let titles = text_width(&mut legend.title.iter().map(String::as_str));
    let labels = bar + 2 * tick + text_width(&mut ticks.iter().map(|t| t.1.as_str()));
    let no_value =
        if legend.has_no_value { bar + 2 * tick + NO_VALUE_LABEL.len() * l.letter_width } else { 0 };
    let mut out = Canvas::white(width + 2 * margin + titles.max(labels).max(no_value), l.height);
    for (row, target) in picture.chunks(width).zip(out.bytes.chunks_mut(3 * out.width)) {
        for (c, p) in row.iter().zip(target.chunks_mut(3)) {
            p.copy_from_slice(&srgb_bytes(*c));
        }
    }
    // Draw the title and the colour bar with its ticks.
    let left = width + margin;
    for (k, text) in legend.title.iter().enumerate() {
        out.draw_text(text, (left, l.line_height * 3 / 4 + k * l.line_height * 9 / 8), l.font_size);
    }
    let [top, bottom] = l.bar;
    for y in top..bottom {
        let v = legend.scale.value_at(1.0 - (y as f64 + 0.5 - top as f64) / (bottom - top) as f64);
        out.fill([left, left + bar], [y, y + 1], srgb_bytes(legend.scale.colour(v)));
    }
    out.frame([left, left + bar], l.bar);
    for (y, text) in &ticks {
        let y = (*y).clamp(top, bottom - 1);
        out.fill([left + bar, left + bar + tick], [y, y + 1], FRAME_COLOUR);
        out.draw_text(text, (left + bar + 2 * tick, y - l.line_height / 2), l.font_size);
    }
    // Draw the colour of zones without a value below.
    if legend.has_no_value {
        let rows = [bottom + l.line_height, bottom + 2 * l.line_height];
        out.fill([left, left + bar], rows, srgb_bytes(NO_VALUE_COLOUR));
        out.frame([left, left + bar], rows);
        out.draw_text(NO_VALUE_LABEL, (left + bar + 2 * tick, rows[0]), l.font_size);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_io::output::ColourMap;
    use zonal_report::plot::AxisScale;

    fn legend(low: f64, high: f64) -> Legend {
        Legend {
            title: vec!["Temperature".into(), "K".into()],
            scale: ColourScale { low, high, map: ColourMap::Sequential, axis: AxisScale::Linear },
            has_no_value: true,
        }
    }

    /// The pixels of the picture are unchanged; the colour bar runs from the low end at the bottom to the high end at the top.
    #[test]
    fn legend_leaves_the_picture_unchanged() {
        let (w, h) = (300, 200);
        let l = legend(400.0, 1200.0);
        let picture = vec![[0.2, 0.4, 0.6]; w * h];
        let c = beside(&picture, (w, h), &l);
        assert!(c.height >= h && c.bytes.len() == 3 * c.width * c.height && c.width > w + 80);
        let at = |x: usize, y: usize| &c.bytes[3 * (y * c.width + x)..][..3];
        assert!((0..h).all(|y| (0..w).all(|x| at(x, y) == srgb_bytes([0.2, 0.4, 0.6]))));
        let layout = LegendLayout::new(&l, h);
        let near = |a: &[u8], b: [u8; 3]| a.iter().zip(b).all(|(x, y)| x.abs_diff(y) <= 3);
        assert!(near(at(w + 20, layout.bar[0]), srgb_bytes(l.scale.colour(1200.0))));
        assert!(near(at(w + 20, layout.bar[1] - 1), srgb_bytes(l.scale.colour(400.0))));
        assert_eq!(at(w + 20, layout.bar[1] + 20), srgb_bytes(NO_VALUE_COLOUR));
    }

    /// Every letter exists in every size, superscripts included; no text is cut off, even beside a low picture.
    #[test]
    fn legend_text_is_complete() {
        for h in [6, 480, 600, 800, 2000] {
            for (low, high) in [(400.0, 1200.0), (-0.00012, 0.0003), (1e5, 9e5)] {
                let mut l = legend(low, high);
                l.title = vec!["Irradiance".into(), "mean of bands".into(), "kW/m²".into()];
                let c = beside(&vec![[1.0; 3]; 8 * h], (8, h), &l);
                let edge = |x: usize| (0..c.height).all(|y| c.bytes[3 * (y * c.width + x)] == 255);
                assert!(edge(c.width - 1) && edge(c.width - 3), "{h}");
                let ticks = LegendLayout::new(&l, h).ticks(&l.scale);
                assert!(ticks.len() >= 2, "{h}: {ticks:?}");
                let texts: std::collections::BTreeSet<&String> = ticks.iter().map(|t| &t.1).collect();
                assert_eq!(texts.len(), ticks.len(), "{ticks:?}");
                let size = LegendLayout::new(&l, h).font_size;
                for c in "0123456789.-eWkKMm²/".chars() {
                    assert!(get_raster(c, FONT_WEIGHT, size).is_some(), "{c}");
                }
            }
        }
    }
}
