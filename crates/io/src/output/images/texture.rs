//! A texture as the bytes of an 8-bit sRGB PNG, for pages and meshes with embedded images.

use super::png::encode_png;
use zonal_scene::Texture;

/// The PNG of a texture, values above 1 clipped. A texture larger than `max_side` pixels is halved, four pixels in one, until it fits;
/// `None` without pixels.
pub fn encode_texture_png(texture: &Texture, max_side: usize) -> Option<Vec<u8>> {
    let (mut width, mut height, mut pixels) = (texture.width, texture.height, texture.pixels.clone());
    while width.max(height) > max_side.max(1) {
        pixels = halve(&pixels, width, height);
        (width, height) = (width.div_ceil(2), height.div_ceil(2));
    }
    encode_png(width, height, &pixels)
}

/// Means over squares of four pixels, fewer at an odd edge.
fn halve(pixels: &[[f32; 3]], width: usize, height: usize) -> Vec<[f32; 3]> {
    let mean = |x: usize, y: usize| {
        let (xs, ys) = (2 * x..(2 * x + 2).min(width), 2 * y..(2 * y + 2).min(height));
        let n = (xs.len() * ys.len()) as f32;
        let mut sum = [0.0; 3];
        for p in ys.flat_map(|y| xs.clone().map(move |x| pixels[y * width + x])) {
            sum = [0, 1, 2].map(|b| sum[b] + p[b] / n);
        }
        sum
    };
    (0..height.div_ceil(2))
        .flat_map(|y| (0..width.div_ceil(2)).map(move |x| (x, y)))
        .map(|(x, y)| mean(x, y))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::tone::encode_srgb;
    use super::*;

    #[test]
    fn large_textures_are_halved_and_keep_their_mean() {
        let pixels: Vec<[f32; 3]> =
            (0..15).map(|i| [i as f32 / 15.0, 0.25, if i % 2 == 0 { 1.0 } else { 0.0 }]).collect();
        let texture = Texture { width: 5, height: 3, pixels };
        let size = |side| {
            let bytes = encode_texture_png(&texture, side).unwrap();
            let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
            let mut out = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut out).unwrap();
            (reader.info().width, reader.info().height, out[1])
        };
        let quarter = (255.0 * encode_srgb(0.25)).round() as u8;
        assert_eq!(size(8), (5, 3, quarter));
        assert_eq!(size(4), (3, 2, quarter));
        assert_eq!(size(1), (1, 1, quarter));
    }
}
