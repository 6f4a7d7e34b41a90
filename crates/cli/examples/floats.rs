//! `floats PICTURE.exr OUT.npy`: converts a picture to an array [height, width, 3] of linear values, for tests in other languages.

use std::path::Path;
use zonal_io::output::{read_exr, write_array};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, to] = &arguments[..] else {
        return Err("usage: floats PICTURE.exr OUT.npy".into());
    };
    let picture = read_exr(Path::new(from))?;
    let values: Vec<f64> = picture.pixels.iter().flatten().map(|x| *x as f64).collect();
    write_array(Path::new(to), &[picture.height, picture.width, 3], &values)?;
    Ok(())
}
