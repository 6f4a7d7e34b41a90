//! Lines of vertices and surfaces, in both forms.
//!
//! A surface of form `3a` lies in a plane of an origin o, an azimuth A (clockwise from +y, of the direction that the front faces) and a tilt T (0 faces
//! up, 90 degrees is vertical). A corner (a, b) of the plane is o + a u + b v with
//! u = (−cos A, sin A, 0), v = (−cos T sin A, −cos T cos A, sin T), and u × v = (sin T sin A, sin T cos A, cos T) is the normal.

use super::checks::{NumberedSurface, check_references, surface_plane};
use super::fields::LineFields;
use super::model::{View3dSurface, View3dSurfaceKind};
use crate::input::reading::error::FileFault;
use zonal_math::{Vec3, vec3};

/// Limits of emissivities in View3D, and the numbers that replace what lies beyond; the limits are a little wider.
const MIN_EMISSIVITY: f64 = 0.001;
const MAX_EMISSIVITY: f64 = 0.999;
/// Distance of an emissivity from its limits without effect.
const EMISSIVITY_TOLERANCE: f64 = 1e-5;
/// Longest name, characters.
const MAX_NAME_CHARS: usize = 256;
/// Distance of a corner from the plane relative to the radius of the surface that causes a note.
const NOTED_WARP: f64 = 3e-6;

/// Form of the surfaces of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SurfaceForm {
    /// `F 3`.
    Vertices,
    /// `F 3a`.
    Planes,
}

impl SurfaceForm {
    /// Reads an `F` line behind its letter.
    pub(super) fn read(fields: &mut LineFields<'_>) -> Result<SurfaceForm, FileFault> {
        match fields.word("form of geometry")? {
            "3" => Ok(SurfaceForm::Vertices),
            word if word.eq_ignore_ascii_case("3a") => Ok(SurfaceForm::Planes),
            word => Err(fields.fault(format!("geometry '{word}' is not read; write F 3 or F 3a"))),
        }
    }
}

/// The columns behind the geometry of a surface.
struct Attributes {
    base: usize,
    combined_with: usize,
    emissivity: f64,
    name: Option<String>,
}

/// Vertices and surfaces while they are read.
pub(super) struct SurfaceReader<'a> {
    file: &'a str,
    form: Option<SurfaceForm>,
    vertices: Vec<Vec3>,
    surfaces: Vec<NumberedSurface>,
    replaced_emissivities: usize,
    warped: usize,
    /// Number of lines of unknown letters, and the first of them.
    unknown_lines: (usize, usize),
}

impl<'a> SurfaceReader<'a> {
    pub(super) fn new(file: &'a str) -> SurfaceReader<'a> {
        SurfaceReader {
            file,
            form: None,
            vertices: Vec::new(),
            surfaces: Vec::new(),
            replaced_emissivities: 0,
            warped: 0,
            unknown_lines: (0, 0),
        }
    }

    pub(super) fn count_unknown_line(&mut self, line: usize) {
        let (count, first) = &mut self.unknown_lines;
        if *count == 0 {
            *first = line;
        }
        *count += 1;
    }

    pub(super) fn set_form(&mut self, form: SurfaceForm, fields: &LineFields<'_>) -> Result<(), FileFault> {
        let begun = !self.vertices.is_empty() || !self.surfaces.is_empty();
        if begun && self.form != Some(form) {
            return Err(fields.fault(
                "a second geometry follows the first; keep one F line above all vertices and surfaces",
            ));
        }
        self.form = Some(form);
        Ok(())
    }

    pub(super) fn form_is(&self, form: SurfaceForm) -> bool {
        self.form == Some(form)
    }

    /// Refuses lines of geometry before the form is known; counts those of vertices that the form does not have.
    pub(super) fn require_form(&mut self, fields: &LineFields<'_>) -> Result<(), FileFault> {
        if self.form.is_none() {
            return Err(
                fields.fault("the geometry is not known; write F 3 or F 3a above vertices and surfaces")
            );
        }
        self.count_unknown_line(fields.line);
        Ok(())
    }

    /// Reads a `V` line behind its letter.
    pub(super) fn read_vertex(&mut self, mut fields: LineFields<'_>) -> Result<(), FileFault> {
        let (number, wanted) = (fields.index("number of the vertex")?, self.vertices.len() + 1);
        if number != wanted {
            return Err(fields.fault(format!(
                "vertex {number} is out of sequence; number vertices from 1: {wanted} is next"
            )));
        }
        self.vertices.push(fields.vector()?);
        Ok(())
    }

    /// Reads a line of a surface behind its letter, and in form `3a` the lines of its geometry.
    pub(super) fn read_surface<'l>(
        &mut self,
        letter: &str,
        mut fields: LineFields<'l>,
        lines: &mut impl Iterator<Item = (usize, &'l str)>,
    ) -> Result<(), FileFault>
    where
        'a: 'l,
    {
        let kind = match letter.as_bytes()[0].to_ascii_uppercase() {
            b'O' => View3dSurfaceKind::Obstruction,
            b'M' => View3dSurfaceKind::Mask,
            b'N' => View3dSurfaceKind::Null,
            _ => View3dSurfaceKind::Radiating,
        };
        let Some(form) = self.form else { return self.require_form(&fields) };
        let number = self.check_sequence(&mut fields, kind)?;
        let of_surface = |e: String| format!("surface {number}: {e}");
        let (corners, attributes) = match form {
            SurfaceForm::Vertices => {
                let corners = self.corners(&mut fields)?;
                (corners, self.attributes(&mut fields, kind)?)
            }
            SurfaceForm::Planes => {
                let shape = fields.word("shape (R, T or Q)")?;
                let attributes = self.attributes(&mut fields, kind)?;
                (
                    PlaneNumbers { file: self.file, lines, fields: None, line: fields.line }
                        .corners(shape)?,
                    attributes,
                )
            }
        };
        let plane = surface_plane(&corners).map_err(|e| fields.fault(of_surface(e)))?;
        self.warped += usize::from(plane.warp > NOTED_WARP);
        let Attributes { base, combined_with, emissivity, name } = attributes;
        let name = name.unwrap_or_else(|| number.to_string());
        let surface = View3dSurface { corners, kind, base: None, combined_with: None, emissivity, name };
        self.surfaces.push(NumberedSurface { surface, line: fields.line, plane, base, combined_with });
        Ok(())
    }

    /// The number of a surface: the next, and behind an obstruction that of an obstruction.
    fn check_sequence(
        &self,
        fields: &mut LineFields<'_>,
        kind: View3dSurfaceKind,
    ) -> Result<usize, FileFault> {
        let (number, wanted) = (fields.index("number of the surface")?, self.surfaces.len() + 1);
        if number != wanted {
            return Err(fields.fault(format!(
                "surface {number} is out of sequence; number surfaces from 1: {wanted} is next"
            )));
        }
        let is_obstruction = |kind: View3dSurfaceKind| kind == View3dSurfaceKind::Obstruction;
        let behind = self.surfaces.last().is_some_and(|s| is_obstruction(s.surface.kind));
        if behind && !is_obstruction(kind) {
            return Err(fields.fault(format!(
                "surface {number} follows an obstruction; put all obstructions (O) behind the other surfaces"
            )));
        }
        Ok(number)
    }

    /// The corners by the numbers of three or four vertices; the fourth is 0 for a triangle.
    fn corners(&self, fields: &mut LineFields<'_>) -> Result<Vec<Vec3>, FileFault> {
        let mut corners = Vec::with_capacity(4);
        for k in 1..=4 {
            let number = fields.index("number of a vertex")?;
            match (number.checked_sub(1).and_then(|i| self.vertices.get(i)), k) {
                (Some(p), _) => corners.push(*p),
                (None, 4) if number == 0 => {}
                _ => {
                    return Err(fields.fault(format!(
                        "vertex {number} is none of the {} defined above; mend column v{k}",
                        self.vertices.len()
                    )));
                }
            }
        }
        Ok(corners)
    }

    /// Base, combination, emissivity and name; obstructions have none but a name where all columns are present.
    fn attributes(
        &mut self,
        fields: &mut LineFields<'_>,
        kind: View3dSurfaceKind,
    ) -> Result<Attributes, FileFault> {
        if kind == View3dSurfaceKind::Obstruction {
            let columns = (0..3).all(|_| fields.next_word().is_some());
            let name = if columns { self.name(fields)? } else { None };
            return Ok(Attributes { base: 0, combined_with: 0, emissivity: MAX_EMISSIVITY, name });
        }
        let base = fields.index("number of the base surface")?;
        let combined_with = fields.index("number of the combined surface")?;
        let given = fields.number("emissivity")?;
        let limits = MIN_EMISSIVITY - EMISSIVITY_TOLERANCE..=MAX_EMISSIVITY + EMISSIVITY_TOLERANCE;
        self.replaced_emissivities += usize::from(!limits.contains(&given));
        let emissivity = given.clamp(MIN_EMISSIVITY, MAX_EMISSIVITY);
        Ok(Attributes { base, combined_with, emissivity, name: self.name(fields)? })
    }

    fn name(&self, fields: &mut LineFields<'_>) -> Result<Option<String>, FileFault> {
        let Some(name) = fields.next_word() else { return Ok(None) };
        if name.chars().count() > MAX_NAME_CHARS {
            return Err(fields.fault(format!("a name has more than {MAX_NAME_CHARS} characters; shorten it")));
        }
        Ok(Some(name.to_string()))
    }

    /// The surfaces with the indices of bases and combinations, and notes.
    pub(super) fn finish(self) -> Result<(Vec<View3dSurface>, Vec<String>), FileFault> {
        let file = self.file;
        if !self.surfaces.iter().any(|s| s.surface.kind == View3dSurfaceKind::Radiating) {
            let message = "there is no radiating surface; write S lines behind F 3 or F 3a";
            return Err(FileFault::new(file, "", message));
        }
        check_references(file, &self.surfaces)?;
        let mut notes = Vec::new();
        let (unknown, first) = self.unknown_lines;
        let counts = [
            (
                unknown,
                format!(
                    "{file}:{first}: {unknown} lines from here begin with no letter of View3D and were ignored"
                ),
            ),
            (
                self.replaced_emissivities,
                format!(
                    "{file}: {} emissivities below 0.001 or above 0.999 were replaced by these, as View3D does",
                    self.replaced_emissivities
                ),
            ),
            (
                self.warped,
                format!("{file}: the corners of {} surfaces lie a little out of a plane", self.warped),
            ),
        ];
        notes.extend(counts.into_iter().filter(|(count, _)| *count > 0).map(|(_, text)| text));
        let resolve = |s: NumberedSurface| View3dSurface {
            base: s.base.checked_sub(1),
            combined_with: s.combined_with.checked_sub(1),
            ..s.surface
        };
        Ok((self.surfaces.into_iter().map(resolve).collect(), notes))
    }
}

/// The numbers of a surface of form `3a`, on the lines behind its first.
struct PlaneNumbers<'a, 'l, I> {
    file: &'a str,
    lines: &'l mut I,
    /// The current line.
    fields: Option<LineFields<'a>>,
    /// Number of the last line that was read.
    line: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> PlaneNumbers<'a, '_, I> {
    fn number(&mut self) -> Result<f64, FileFault> {
        loop {
            if let Some(fields) = self.fields.as_mut().filter(|f| f.has_more()) {
                return fields.number("number of the surface's plane");
            }
            let Some((line, text)) = self.lines.next() else {
                let message = "the file ends within a surface; write origin, azimuth, tilt and corners behind its first line";
                return Err(FileFault::new(self.file, self.line, message));
            };
            self.line = line;
            self.fields = Some(LineFields::new(self.file, line, text));
        }
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], FileFault> {
        let mut out = [0.0; N];
        for x in &mut out {
            *x = self.number()?;
        }
        Ok(out)
    }

    /// The corners of a shape: `R`, `T` or `Q`.
    fn corners(mut self, shape: &str) -> Result<Vec<Vec3>, FileFault> {
        let header_line = self.line;
        let [x, y, z, azimuth, tilt] = self.numbers::<5>()?;
        let in_plane: Vec<[f64; 2]> = match shape.as_bytes()[0].to_ascii_uppercase() {
            b'R' => {
                let [width, height] = self.numbers::<2>()?;
                if !(width > 0.0 && height > 0.0) {
                    let message =
                        format!("a rectangle of {width} by {height} has no area; give positive sides");
                    return Err(FileFault::new(self.file, self.line, message));
                }
                vec![[0.0, height], [0.0, 0.0], [width, 0.0], [width, height]]
            }
            b'T' => self.numbers::<6>()?.as_chunks::<2>().0.to_vec(),
            b'Q' => self.numbers::<8>()?.as_chunks::<2>().0.to_vec(),
            _ => {
                let message =
                    format!("'{shape}' is no shape; write R (rectangle), T (triangle) or Q (quadrilateral)");
                return Err(FileFault::new(self.file, header_line, message));
            }
        };
        let ((sa, ca), (st, ct)) = (sine_cosine(azimuth), sine_cosine(tilt));
        let (u, v) = (vec3(-ca, sa, 0.0), vec3(-ct * sa, -ct * ca, st));
        Ok(in_plane.iter().map(|[a, b]| vec3(x, y, z) + u * *a + v * *b).collect())
    }
}

/// Sine and cosine of an angle in degrees, exact at whole right angles.
fn sine_cosine(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        angle => angle.to_radians().sin_cos(),
    }
}
