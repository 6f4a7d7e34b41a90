//! The alpha of a picture at any point, and whether it is the same class within a box.
//!
//! Alpha is interpolated bilinearly between the centres of the pixels, which repeat beyond the picture, and times a factor. Thresholds c₁ < … < c_n
//! divide it into classes: class k holds c_k ≤ α < c_{k+1}. Within a box of pixels every interpolated value lies between the smallest and the largest pixel,
//! so that the box has one class if all its pixels have it. Sums over rectangles (Crow, *Summed-area tables*, 1984) count the pixels of each class in a time that
//! does not depend on the size of the box.

/// Largest number of pixels of a map; larger pictures are averaged over squares of pixels.
const MAX_MAP_PIXELS: usize = 1 << 22;

/// The alpha of a picture, 0 to 255 by pixel, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AlphaMap {
    width: usize,
    height: usize,
    values: Vec<u8>,
}

impl AlphaMap {
    /// A map of `width * height` values.
    pub(crate) fn new(width: usize, height: usize, values: Vec<u8>) -> AlphaMap {
        let mut map = AlphaMap { width, height, values };
        while map.values.len() > MAX_MAP_PIXELS {
            map = map.halved();
        }
        map
    }
    /// The same alpha everywhere.
    pub(crate) fn opaque() -> AlphaMap {
        AlphaMap { width: 1, height: 1, values: vec![u8::MAX] }
    }
    /// Half as many pixels along each side, each the mean of a square.
    fn halved(&self) -> AlphaMap {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let at = |x: usize, y: usize| {
            u32::from(self.values[y.min(self.height - 1) * self.width + x.min(self.width - 1)])
        };
        let mean = |x: usize, y: usize| {
            (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1) + 2)
                / 4
        };
        let values = (0..width * height).map(|i| mean(i % width, i / width) as u8).collect();
        AlphaMap { width, height, values }
    }
    /// Pixels along u and v.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }
    /// Interpolated alpha, 0 to 1, at texture coordinates.
    pub(crate) fn at(&self, uv: [f64; 2]) -> f64 {
        self.interpolated(self.pixel_place(uv))
    }
    /// Place among the pixels of texture coordinates: pixel k has its centre at k.
    pub(crate) fn pixel_place(&self, uv: [f64; 2]) -> [f64; 2] {
        [uv[0] * self.width as f64 - 0.5, uv[1] * self.height as f64 - 0.5]
    }
    /// Interpolated alpha, 0 to 1, at a place among the pixels.
    fn interpolated(&self, place: [f64; 2]) -> f64 {
        let [x, y] = place.map(|t| if t.is_finite() { t } else { 0.0 });
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let pixel = |dx: f64, dy: f64| {
            let i = wrapped(x.floor() + dx, self.width);
            let j = wrapped(y.floor() + dy, self.height);
            f64::from(self.values[j * self.width + i]) / 255.0
        };
        let top = pixel(0.0, 0.0) * (1.0 - fx) + pixel(1.0, 0.0) * fx;
        let bottom = pixel(0.0, 1.0) * (1.0 - fx) + pixel(1.0, 1.0) * fx;
        top * (1.0 - fy) + bottom * fy
    }
}

/// The pixel of `count` repeated ones at a whole number.
fn wrapped(k: f64, count: usize) -> usize {
    (k.rem_euclid(count as f64) as usize).min(count - 1)
}

/// Alpha in classes.
pub(crate) struct AlphaClasses<'a> {
    map: &'a AlphaMap,
    factor: f64,
    thresholds: Vec<f64>,
    /// For each threshold, the number of pixels at or above it to the left of and above each pixel.
    tables: Vec<Vec<u32>>,
}

impl<'a> AlphaClasses<'a> {
    pub(crate) fn new(map: &'a AlphaMap, factor: f64, thresholds: Vec<f64>) -> AlphaClasses<'a> {
        let table = |c: &f64| {
            let row = map.width + 1;
            let mut sums = vec![0; row * (map.height + 1)];
            for y in 0..map.height {
                let mut along = 0;
                for x in 0..map.width {
                    along += u32::from(factor * f64::from(map.values[y * map.width + x]) / 255.0 >= *c);
                    sums[(y + 1) * row + x + 1] = sums[y * row + x + 1] + along;
                }
            }
            sums
        };
        let tables = thresholds.iter().map(table).collect();
        AlphaClasses { map, factor, thresholds, tables }
    }
    /// The map.
    pub(crate) fn map(&self) -> &AlphaMap {
        self.map
    }
    /// Alpha at texture coordinates.
    pub(crate) fn alpha(&self, uv: [f64; 2]) -> f64 {
        self.factor * self.map.interpolated(self.map.pixel_place(uv))
    }
    /// Threshold number `k`, from 1: the smallest alpha of class k.
    pub(crate) fn threshold(&self, k: usize) -> f64 {
        self.thresholds[k - 1]
    }
    /// The largest class.
    pub(crate) fn top(&self) -> usize {
        self.thresholds.len()
    }
    /// The class at texture coordinates.
    pub(crate) fn class(&self, uv: [f64; 2]) -> usize {
        let alpha = self.alpha(uv);
        self.thresholds.iter().take_while(|c| alpha >= **c).count()
    }
    /// The class of all points of a box of texture coordinates, if the pixels about it have one.
    pub(crate) fn uniform_class(&self, corners: &[[f64; 2]]) -> Option<usize> {
        let sizes = [self.map.width, self.map.height];
        let [columns, rows] = [0, 1].map(|k| {
            let places = corners.iter().map(|c| self.map.pixel_place(*c)[k]);
            let (lo, hi) = places.fold((f64::MAX, f64::MIN), |(lo, hi), x| (lo.min(x), hi.max(x)));
            wrapped_ranges(lo.floor(), hi.floor() + 1.0, sizes[k])
        });
        let mut pixels = 0;
        let mut above = vec![0; self.tables.len()];
        for [x0, x1] in columns.into_iter().flatten() {
            for [y0, y1] in rows.into_iter().flatten() {
                pixels += ((x1 - x0) * (y1 - y0)) as u32;
                for (table, n) in self.tables.iter().zip(&mut above) {
                    let at = |x: usize, y: usize| table[y * (self.map.width + 1) + x];
                    *n += at(x1, y1) + at(x0, y0) - at(x0, y1) - at(x1, y0);
                }
            }
        }
        let class = above.iter().take_while(|n| **n == pixels).count();
        above[class..].iter().all(|n| *n == 0).then_some(class)
    }
}

/// The pixels from `lo` to `hi`, whole numbers, of `count` repeated ones, as at most two ranges.
fn wrapped_ranges(lo: f64, hi: f64, count: usize) -> [Option<[usize; 2]>; 2] {
    let length = hi - lo + 1.0;
    if !(length.is_finite() && length < count as f64) {
        return [Some([0, count]), None];
    }
    let (first, length) = (wrapped(lo, count), length as usize);
    if first + length <= count {
        [Some([first, first + length]), None]
    } else {
        [Some([first, count]), Some([0, first + length - count])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_of_one_class_hold_no_other_value() {
        let values: Vec<u8> = (0..35u32).map(|i| (i * i * 37 % 256) as u8).collect();
        let map = AlphaMap::new(7, 5, values);
        let classes = AlphaClasses::new(&map, 0.9, vec![0.2, 0.7]);
        let mut uniform = 0;
        for k in 0..4000u32 {
            let step = |m: u32| f64::from(k * m % 997) / 997.0;
            let (at, size) = ([3.0 * step(31) - 1.0, 3.0 * step(57) - 1.0], 0.1 * step(91));
            let Some(class) = classes.uniform_class(&[at, [at[0] + size, at[1] + size]]) else { continue };
            uniform += 1;
            for i in 0..25u32 {
                let [x, y] = [i % 5, i / 5].map(|n| size * f64::from(n) / 4.0);
                assert_eq!(classes.class([at[0] + x, at[1] + y]), class);
            }
        }
        assert!(uniform > 100, "{uniform}");
        // A box beyond the picture holds all pixels.
        assert_eq!(classes.uniform_class(&[[0.0, 0.0], [3.0, 3.0]]), None);
        assert_eq!(
            AlphaClasses::new(&map, 1.0, vec![0.0]).uniform_class(&[[-9.0, 0.0], [3.0, 3.0]]),
            Some(1)
        );
    }

    #[test]
    fn large_maps_keep_their_mean() {
        let map = AlphaMap::new(3000, 3000, (0..9_000_000u32).map(|i| (i % 3000 % 200) as u8).collect());
        assert_eq!((map.width, map.height), (1500, 1500));
        let mean = map.values.iter().map(|v| f64::from(*v)).sum::<f64>() / map.values.len() as f64;
        assert!((mean - 99.5).abs() < 0.6, "{mean}");
    }
}
