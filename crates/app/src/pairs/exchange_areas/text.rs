//! Exchange areas as text: a table of pairs, and MatrixMarket files.

use std::path::{Path, PathBuf};
use zonal_io::output::{self, FileError, PairColumn};
use zonal_solve::areas::exchange_areas::ExchangeAreas;

/// Writes a line for each pair of zones that exchange.
pub(super) fn write_csv(path: &Path, areas: &ExchangeAreas) -> Result<Vec<PathBuf>, FileError> {
    let mut columns = vec![
        PairColumn { name: "direct_m2", values: &areas.direct.areas },
        PairColumn { name: "direct_error_m2", values: &areas.direct.radii },
    ];
    if let Some(total) = &areas.total {
        columns.push(PairColumn { name: "total_m2", values: &total.areas });
        columns.push(PairColumn { name: "total_error_m2", values: &total.radii });
    }
    output::write_pairs_csv(path, &areas.names, &areas.name_of_zone, &columns)?;
    Ok(vec![path.to_path_buf()])
}

/// Writes the total areas, or the direct ones where there are no others, and their error radii beside them; one file for each band where bands differ.
pub(super) fn write_mtx(path: &Path, areas: &ExchangeAreas) -> Result<Vec<PathBuf>, FileError> {
    let n = areas.zone_count();
    let matrices = areas.total.as_ref().unwrap_or(&areas.direct);
    let mut written = Vec::new();
    for band in 0..areas.matrices {
        let of_band = if areas.matrices > 1 { format!("band{band}.") } else { String::new() };
        let pairs = band * n * n..(band + 1) * n * n;
        for (kind, values) in [("", &matrices.areas), ("error.", &matrices.radii)] {
            let file = path.with_extension(format!("{of_band}{kind}mtx"));
            let comments = comments(areas, !kind.is_empty(), band);
            output::write_matrix_market(&file, &comments, n, &values[pairs.clone()])?;
            written.push(file);
        }
    }
    Ok(written)
}

/// The lines of the header.
fn comments(areas: &ExchangeAreas, radii: bool, band: usize) -> Vec<String> {
    let is_total = areas.total.is_some();
    let [values, of_radii] = if is_total {
        [
            "Total exchange areas T_ij, all reflections and scattering included: zone i gives zone j the net power T_ij sigma (T_i^4 - T_j^4).",
            "Error radii of total exchange areas T_ij.",
        ]
    } else {
        [
            "Direct exchange areas F_ij, without reflection and scattering: F_ij B_j is the power from zone j that arrives at zone i.",
            "Error radii of direct exchange areas F_ij.",
        ]
    };
    let what = if radii { of_radii } else { values };
    let mut out = vec![
        what.to_string(),
        "Unit: m2. Symmetric: the lower half is listed; pairs that are not listed exchange nothing.".into(),
    ];
    if areas.matrices > 1 {
        out.push(format!("Band {band} of {}.", areas.matrices));
    }
    let sums = if is_total {
        "emissivity x area, or 4 kappa_a V of a volume"
    } else {
        "area, or 4 kappa V of a volume"
    };
    out.push(format!("Row sums of a closed scene: {sums}. The rows of an open scene fall short by the exchange with the surroundings."));
    if is_total && !radii {
        out.push("Net power q = D E - T E - S E_s with E = sigma T^4: the diagonal matrix D holds the row sums of a CLOSED scene also where the scene is open, S = D - row sums of T, E_s of the surroundings.".into());
    }
    out.push("Zones are counted from 1: patches, then voxel zones, then pane zones. Their names:".into());
    // Runs of zones of one name.
    let mut from = 0;
    let of = &areas.name_of_zone;
    for i in 1..=of.len() {
        if i == of.len() || of[i] != of[from] {
            out.push(format!("  {} to {i}: {}", from + 1, areas.names[of[from]]));
            from = i;
        }
    }
    out
}
