//! The report as JSON, and back: shared by `--json` and by the header of solution files.
//!
//! Lists over bands have one number for each band. A number that is not finite is `null`. The fields are described once, in `format`, `heat` and
//! `notes`.

pub(crate) mod codec;
mod format;
mod heat;
pub(crate) mod notes;

use codec::{decode_at, factors};
use format::{EnergyFormat, add_unit, decode_report, encode_report};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use zonal_scene::encoding::nan_bands;
use zonal_scene::{
    BandSet, Bands, EnergyBalance, LightGroup, LightGroupKind, PerBand, Report, Solution, SolveStatus,
    printable_text,
};

/// The report of a solution as a JSON document: zones, engine, status, residuals, estimate, closure, energy (W), light groups, counts,
/// warnings, provenance.
pub fn report_json(s: &Solution) -> Value {
    codec::join_blocks(s.scene.bands(), s.blocks().map(block_json).collect()).0
}

/// The report of one block of bands, with values of bands marked.
pub(crate) fn block_json(s: &Solution) -> Value {
    let mut v = encode_report(&s.report);
    v["light_groups"] = s.groups.iter().map(encode_group).collect();
    v["scene"] = json!(s.scene.name());
    v["zones"] = json!({
        "patches": s.zones.patches.len(),
        "voxels": s.zones.voxels.total(),
        "panes": s.zones.panes.len(),
    });
    v["provenance"] = json!({
        "scene_hash": s.scene_hash,
        "scene_hash_function": "BLAKE3, 256 bits",
        "version": s.version,
        "tolerance": s.scene.options().tolerance,
        "grade": s.report.grade.name(),
    });
    if !s.scene.bands().is_rgb() {
        v["bands"] = encode_bands(s.scene.bands());
    }
    v
}

/// The bands of a scene: number, names and wavelengths.
pub(crate) fn encode_bands(bands: &BandSet) -> Value {
    let names: Vec<String> = (0..bands.count()).map(|b| bands.name(b)).collect();
    let mut v = json!({ "count": bands.count(), "names": names, "wavelengths_nm": bands.wavelengths() });
    if bands.has_solar_band() {
        v["has_solar_band"] = true.into();
    }
    v
}

/// The bands that [`encode_bands`] wrote; red, green and blue in files without them.
pub(crate) fn decode_bands(v: &Value) -> Result<BandSet, String> {
    if v.is_null() {
        return Ok(BandSet::default());
    }
    let count = v["count"].as_u64().ok_or("bands.count: a number is missing")? as usize;
    let set = match decode_at::<Option<Vec<[f64; 2]>>>("bands.wavelengths_nm", &v["wavelengths_nm"])? {
        Some(wavelengths) => BandSet::by_wavelength(wavelengths),
        None if v["has_solar_band"] == true => {
            BandSet::numbered(count.saturating_sub(1)).and_then(BandSet::with_solar_band)
        }
        None => BandSet::numbered(count),
    };
    let set = set.map_err(|e| e.to_string())?;
    if set.count() == count { Ok(set) } else { Err("bands.count: differs from the wavelengths".into()) }
}

/// The report and the light groups, without their fields, of a JSON document that [`report_json`] wrote.
pub(super) fn decode_document(v: &Value) -> Result<(Report, Vec<LightGroup>), String> {
    let groups: Vec<GroupFormat> = decode_at("report.light_groups", &v["light_groups"])?;
    let groups = groups.into_iter().map(GroupFormat::into_group).collect::<Result<_, _>>()?;
    Ok((decode_report(v)?, groups))
}

/// The format of a light group without its fields.
#[derive(Serialize, Deserialize)]
struct GroupFormat {
    #[serde(deserialize_with = "printable_text")]
    name: String,
    /// A word, and the index of a light or surface.
    of: Value,
    status: PerBand<SolveStatus>,
    #[serde(deserialize_with = "nan_bands")]
    residual: Bands,
    #[serde(deserialize_with = "factors")]
    incident_scale: Bands,
    #[serde(deserialize_with = "factors")]
    direct_scale: Bands,
    #[serde(with = "EnergyFormat")]
    energy: EnergyBalance,
}

impl GroupFormat {
    fn into_group(self) -> Result<LightGroup, String> {
        Ok(LightGroup {
            name: self.name,
            kind: decode_kind(&self.of)?,
            incident_scale: self.incident_scale,
            direct_scale: self.direct_scale,
            energy: self.energy,
            status: self.status,
            residual: self.residual,
            ..LightGroup::default()
        })
    }
}

fn encode_group(g: &LightGroup) -> Value {
    let format = GroupFormat {
        name: g.name.clone(),
        of: encode_kind(g.kind),
        status: g.status,
        residual: g.residual,
        incident_scale: g.incident_scale,
        direct_scale: g.direct_scale,
        energy: g.energy.clone(),
    };
    let mut v = serde_json::to_value(format).unwrap_or_default();
    add_unit(&mut v["energy"]);
    v
}

fn encode_kind(k: LightGroupKind) -> Value {
    match k {
        LightGroupKind::Light(l) => json!(["light", l]),
        LightGroupKind::Surface(s) => json!(["surface", s]),
        LightGroupKind::Medium => json!(["medium"]),
        LightGroupKind::Panes => json!(["panes"]),
        LightGroupKind::Surroundings => json!(["surroundings"]),
        LightGroupKind::All => json!(["all"]),
    }
}

fn decode_kind(v: &Value) -> Result<LightGroupKind, String> {
    let index = || v[1].as_u64().map(|n| n as usize).ok_or("of: a number is missing");
    match v[0].as_str() {
        Some("light") => Ok(LightGroupKind::Light(index()?)),
        Some("surface") => Ok(LightGroupKind::Surface(index()?)),
        Some("medium") => Ok(LightGroupKind::Medium),
        Some("panes") => Ok(LightGroupKind::Panes),
        Some("surroundings") => Ok(LightGroupKind::Surroundings),
        Some("all") => Ok(LightGroupKind::All),
        _ => Err("of: is not a kind of light group".into()),
    }
}
