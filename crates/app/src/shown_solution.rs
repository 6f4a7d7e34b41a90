//! Which solutions an output can show, and the bands that it shows as red, green and blue.

use std::path::Path;
use zonal_report::Failure;
use zonal_scene::Solution;

/// Bands that an output shows as red, green and blue.
const BANDS_SHOWN: usize = 3;

/// Reads a solution of light for outputs that show three bands as red, green and blue, and one reflectance for each surface. Of more bands, which are no
/// colours, it returns the three from band number `first` on.
///
/// # Errors
/// As [`read_light_solution`], for reflectances by face, and if `first` is not the first band of three.
pub fn read_uniform_light_solution(path: &Path, first: usize) -> Result<Solution, Failure> {
    let solution = with_shown_bands(zonal_io::output::read_solution(path)?, first)?;
    check_uniform_light(path, &solution)?;
    Ok(solution)
}

/// The three bands of a solution from band number `first` on.
///
/// # Errors
/// If `first` is not the first band of three.
pub fn with_shown_bands(mut solution: Solution, first: usize) -> Result<Solution, Failure> {
    let (count, block) = (solution.scene.bands().count(), first / BANDS_SHOWN);
    if !first.is_multiple_of(BANDS_SHOWN) || first >= count {
        let last = BANDS_SHOWN * ((count - 1) / BANDS_SHOWN);
        let message = format!(
            "--first-band {first}: the solution has {count} bands; give a multiple of {BANDS_SHOWN} up to {last}"
        );
        return Err(Failure::new(message));
    }
    if block > 0 {
        solution = solution.further_blocks.swap_remove(block - 1);
    }
    solution.further_blocks.clear();
    Ok(solution)
}

/// Refuses solutions for outputs that show one reflectance for each surface; `path` names the solution in messages.
///
/// # Errors
/// For solutions in thermal mode, and for reflectances by face.
pub fn check_uniform_light(path: &Path, solution: &Solution) -> Result<(), Failure> {
    check_light(path, solution)?;
    if solution.scene.faces().values.iter().all(|v| v.reflectance.is_none()) {
        return Ok(());
    }
    Err(Failure::in_file(
        path,
        "this solution has reflectances by face, and this output shows one for each surface; draw it with zonal render, or export it as .vtu",
    ))
}

/// The bands that stand for red, green and blue where a solution has other bands; `None` where it has colours or one band.
pub fn shown_bands(solution: &Solution) -> Option<String> {
    let bands = solution.scene.bands();
    if bands.is_rgb() || bands.count() == 1 {
        return None;
    }
    let names: Vec<String> = solution.scene.window().map(|b| bands.name(b)).collect();
    Some(format!("of {} bands, {} stand for red, green and blue", bands.count(), names.join(", ")))
}

/// Reads a solution of light.
///
/// # Errors
/// If the file is not a solution, or a solution in thermal mode, which has temperatures in place of light.
pub fn read_light_solution(path: &Path) -> Result<Solution, Failure> {
    let solution = zonal_io::output::read_solution(path)?;
    check_light(path, &solution)?;
    Ok(solution)
}

fn check_light(path: &Path, solution: &Solution) -> Result<(), Failure> {
    if solution.scene.thermal().is_none() {
        return Ok(());
    }
    Err(Failure::in_file(
        path,
        "this is a solution of mode = \"thermal\", which has temperatures in place of light; draw it with zonal render --show temperature, or export it as .vtu (walls), .vti (medium) or .csv",
    ))
}

/// Reads a solution of light that pictures show: its bands are colours or have wavelengths.
///
/// # Errors
/// As [`read_light_solution`], and if the bands have neither colours nor wavelengths.
pub fn read_picture_solution(path: &Path) -> Result<Solution, Failure> {
    let solution = zonal_io::output::read_solution(path)?;
    check_picture(path, &solution)?;
    Ok(solution)
}

/// Refuses solutions that pictures of light do not show; `path` names the solution in messages.
///
/// # Errors
/// As [`read_picture_solution`].
pub fn check_picture(path: &Path, solution: &Solution) -> Result<(), Failure> {
    check_light(path, solution)?;
    if shows_light(solution) {
        return Ok(());
    }
    let message = format!(
        "this solution has {} bands, which are no red, green and blue; export it as .csv, .vtu or .vti, or show irradiance or radiosity",
        solution.scene.bands().count()
    );
    Err(Failure::in_file(path, message))
}

/// True for light in bands that are colours or have wavelengths.
pub(crate) fn shows_light(solution: &Solution) -> bool {
    let bands = solution.scene.bands();
    let has_colours = bands.wavelengths().is_some() || bands.is_rgb() || bands.count() == 1;
    solution.scene.thermal().is_none() && has_colours
}
