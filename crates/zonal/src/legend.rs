//! A picture in false colours with its scale beside it: a bar, round numbers, quantity and unit.
//!
//! The picture stays as it is; the scale stands to its right on white and makes the whole wider (and higher, beside a very low
//! picture). Letters are Noto Sans Mono, drawn beforehand at four sizes by the crate of that name, of which the one that suits the height is taken.

use crate::plot::number;
use crate::scale::Scale;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use zonal_io::output::{NO_VALUE, srgb_byte};

const INK: [u8; 3] = [40, 40, 40];
const FRAME: [u8; 3] = [120, 120, 120];
const WEIGHT: FontWeight = FontWeight::Regular;

/// An 8-bit sRGB picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Three bytes a pixel, row by row, row 0 on top.
    pub bytes: Vec<u8>,
}

/// What stands beside a picture.
#[derive(Clone, Debug)]
pub struct Legend {
    /// Lines above the bar: quantity and unit.
    pub title: Vec<String>,
    /// The scale, in the unit of the title.
    pub scale: Scale,
    /// True where some of the picture has no value.
    pub has_no_value: bool,
}

/// The bytes of a linear colour.
pub fn bytes(linear: [f32; 3]) -> [u8; 3] {
    linear.map(srgb_byte)
}

impl Canvas {
    /// White.
    fn new(width: usize, height: usize) -> Canvas {
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
            self.fill(x, y, FRAME);
        }
        for (x, y) in [([x0 - 1, x0], [y0, y1]), ([x1, x1 + 1], [y0, y1])] {
            self.fill(x, y, FRAME);
        }
    }
    /// A line of text with its upper left corner there.
    fn write(&mut self, text: &str, (x, y): (usize, usize), size: RasterHeight) {
        let advance = get_raster_width(WEIGHT, size);
        for (k, c) in text.chars().enumerate() {
            let Some(letter) = get_raster(c, WEIGHT, size) else { continue };
            for (dy, row) in letter.rows().enumerate() {
                for (dx, ink) in row.iter().enumerate() {
                    self.ink(x + k * advance + dx, y + dy, *ink);
                }
            }
        }
    }
    fn ink(&mut self, x: usize, y: usize, ink: u8) {
        if x >= self.width || y >= self.height {
            return;
        }
        let i = 3 * (y * self.width + x);
        for (b, c) in self.bytes[i..i + 3].iter_mut().zip(INK) {
            let (paper, ink) = (*b as u32, ink as u32);
            *b = ((paper * (255 - ink) + c as u32 * ink + 127) / 255) as u8;
        }
    }
}

/// Lengths in pixels.
struct Layout {
    size: RasterHeight,
    /// Height of a line, and width of a letter.
    line: usize,
    letter: usize,
    /// The bar from top to bottom.
    bar: [usize; 2],
    height: usize,
}

impl Layout {
    fn new(legend: &Legend, height: usize) -> Layout {
        let size = match height {
            0..560 => RasterHeight::Size16,
            560..760 => RasterHeight::Size20,
            760..1000 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        };
        let line = size.val();
        let top = line * 3 / 4 + legend.title.len() * line * 9 / 8 + line;
        let foot = if legend.has_no_value { 3 * line } else { line };
        let height = height.max(top + 7 * line + foot);
        Layout { size, line, letter: get_raster_width(WEIGHT, size), bar: [top, height - foot], height }
    }
    fn ticks(&self, scale: &Scale) -> Vec<(usize, String)> {
        let [top, bottom] = self.bar;
        let long = (bottom - top) as f64;
        let count = (long / (3.0 * self.line as f64)).clamp(3.0, 8.0) as usize;
        let row = |v: f64| bottom - (scale.place(v).clamp(0.0, 1.0) * long).round() as usize;
        let mut out: Vec<(usize, String)> = Vec::new();
        for v in scale.ticks(count) {
            let clear = out.last().is_none_or(|(y, _)| y - row(v) >= self.line * 5 / 4);
            if clear {
                out.push((row(v), number(v, scale.log)));
            }
        }
        out
    }
}

/// The picture, row by row, with its scale.
pub fn beside(picture: &[[f32; 3]], (width, height): (usize, usize), legend: &Legend) -> Canvas {
    let l = Layout::new(legend, height);
    let ticks = l.ticks(&legend.scale);
    let (margin, bar, notch) = (l.line, l.line * 5 / 4, l.line / 3);
    let wide = |texts: &mut dyn Iterator<Item = &str>| {
        texts.map(|t| t.chars().count()).max().unwrap_or(0) * l.letter
    };
    let titles = wide(&mut legend.title.iter().map(String::as_str));
    let labels = bar + 2 * notch + wide(&mut ticks.iter().map(|t| t.1.as_str()));
    let none = if legend.has_no_value { bar + 2 * notch + NONE.len() * l.letter } else { 0 };
    let mut out = Canvas::new(width + 2 * margin + titles.max(labels).max(none), l.height);
    for (row, target) in picture.chunks(width).zip(out.bytes.chunks_mut(3 * out.width)) {
        for (c, p) in row.iter().zip(target.chunks_mut(3)) {
            p.copy_from_slice(&bytes(*c));
        }
    }
    let left = width + margin;
    for (k, text) in legend.title.iter().enumerate() {
        out.write(text, (left, l.line * 3 / 4 + k * l.line * 9 / 8), l.size);
    }
    let [top, bottom] = l.bar;
    for y in top..bottom {
        let v = legend.scale.at(1.0 - (y as f64 + 0.5 - top as f64) / (bottom - top) as f64);
        out.fill([left, left + bar], [y, y + 1], bytes(legend.scale.colour(v)));
    }
    out.frame([left, left + bar], l.bar);
    for (y, text) in &ticks {
        let y = (*y).clamp(top, bottom - 1);
        out.fill([left + bar, left + bar + notch], [y, y + 1], FRAME);
        out.write(text, (left + bar + 2 * notch, y - l.line / 2), l.size);
    }
    if legend.has_no_value {
        let at = [bottom + l.line, bottom + 2 * l.line];
        out.fill([left, left + bar], at, bytes(NO_VALUE));
        out.frame([left, left + bar], at);
        out.write(NONE, (left + bar + 2 * notch, at[0]), l.size);
    }
    out
}

/// The label of the grey.
const NONE: &str = "none";

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_io::output::ColourMap;

    fn legend(low: f64, high: f64) -> Legend {
        Legend {
            title: vec!["Temperature".into(), "K".into()],
            scale: Scale { low, high, map: ColourMap::Plain, log: false },
            has_no_value: true,
        }
    }

    /// The picture's own pixels stay, the bar ends with the ends of the map, and the low end is below.
    #[test]
    fn a_scale_stands_beside_the_picture() {
        let (w, h) = (300, 200);
        let l = legend(400.0, 1200.0);
        let picture = vec![[0.2, 0.4, 0.6]; w * h];
        let c = beside(&picture, (w, h), &l);
        assert!(c.height >= h && c.bytes.len() == 3 * c.width * c.height && c.width > w + 80);
        let at = |x: usize, y: usize| &c.bytes[3 * (y * c.width + x)..][..3];
        assert!((0..h).all(|y| (0..w).all(|x| at(x, y) == bytes([0.2, 0.4, 0.6]))));
        let layout = Layout::new(&l, h);
        let near = |a: &[u8], b: [u8; 3]| a.iter().zip(b).all(|(x, y)| x.abs_diff(y) <= 3);
        assert!(near(at(w + 20, layout.bar[0]), bytes(l.scale.colour(1200.0))));
        assert!(near(at(w + 20, layout.bar[1] - 1), bytes(l.scale.colour(400.0))));
        assert_eq!(at(w + 20, layout.bar[1] + 20), bytes(NO_VALUE));
    }

    /// Letters of every size and of the superscript are there; nothing of the text is cut off; a low picture is enough.
    #[test]
    fn all_that_is_written_is_there() {
        for h in [6, 480, 600, 800, 2000] {
            for (low, high) in [(400.0, 1200.0), (-0.00012, 0.0003), (1e5, 9e5)] {
                let mut l = legend(low, high);
                l.title = vec!["Irradiance".into(), "mean of bands".into(), "kW/m²".into()];
                let c = beside(&vec![[1.0; 3]; 8 * h], (8, h), &l);
                let edge = |x: usize| (0..c.height).all(|y| c.bytes[3 * (y * c.width + x)] == 255);
                assert!(edge(c.width - 1) && edge(c.width - 3), "{h}");
                let ticks = Layout::new(&l, h).ticks(&l.scale);
                assert!(ticks.len() >= 2, "{h}: {ticks:?}");
                let texts: std::collections::BTreeSet<&String> = ticks.iter().map(|t| &t.1).collect();
                assert_eq!(texts.len(), ticks.len(), "{ticks:?}");
                let size = Layout::new(&l, h).size;
                for c in "0123456789.-eWkKMm²/".chars() {
                    assert!(get_raster(c, WEIGHT, size).is_some(), "{c}");
                }
            }
        }
    }
}
