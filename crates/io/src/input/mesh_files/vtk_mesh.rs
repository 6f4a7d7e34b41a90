//! Points and cells of a VTK file as faces of a mesh, in the order of the cells: triangles, quadrilaterals, pixels and polygons.

use crate::files::FileSource;
use crate::input::mesh::model::{MeshData, MeshFace, MeshMaterial};
use crate::input::mesh::polygon::{PolygonCorner, push_polygon};
use crate::input::reading::error::FileFault;
use crate::input::vtk::{MAX_VTK_FILE_BYTES, VtkFile, VtkKind};
use std::path::Path;
use zonal_math::Vec3;

/// Largest number of corners of a polygon; it bounds the cost of ear clipping.
const MAX_POLYGON_CORNERS: usize = 1024;

/// Numbers of VTK for the types of cells that are faces.
const TRIANGLE: usize = 5;
const POLYGON: usize = 7;
const PIXEL: usize = 8;
const QUADRILATERAL: usize = 9;

/// The message about offsets of cells.
const WRONG_OFFSETS: &str = "its offsets do not fit its corners; save the file again";
/// Largest whole number of an index.
const MAX_INDEX: f64 = 1e15;

/// A whole number from 0; `None` for any other value.
fn whole(x: f64) -> Option<usize> {
    ((0.0..MAX_INDEX).contains(&x) && x.fract() == 0.0).then_some(x as usize)
}

/// Reads a .vtu or .vtp as a mesh of one material, `default`.
pub(crate) fn read_mesh_file(files: FileSource<'_>, path: &Path, file: &str) -> Result<MeshData, FileFault> {
    let bytes = files.read(path, MAX_VTK_FILE_BYTES).map_err(|e| FileFault::new(file, "", e))?;
    let vtk = VtkFile::parse(file, &bytes)?;
    vtk.mesh()
}

impl VtkFile<'_> {
    /// The faces of all cells.
    fn mesh(&self) -> Result<MeshData, FileFault> {
        let fault = |cell: usize, message: String| FileFault::new(self.file, format!("cell {cell}"), message);
        let section = if self.kind == VtkKind::PolyData { "Polys" } else { "Cells" };
        if self.other_cells > 0 {
            let message = format!(
                "{} cells are points, lines or strips; save polygons alone (ParaView: Extract Surface, Triangulate)",
                self.other_cells
            );
            return Err(FileFault::new(self.file, "", message));
        }
        if self.cells == 0 {
            return Err(FileFault::new(self.file, "", "this mesh has no cells; save it again"));
        }
        let points = self.array("Points", "", 3, self.points)?;
        let ends = self.array(section, "offsets", 1, self.cells)?;
        let count = ends.last().map_or(Some(0), |end| whole(*end));
        let count = count.ok_or_else(|| fault(self.cells - 1, WRONG_OFFSETS.into()))?;
        let corners = self.array(section, "connectivity", 1, count)?;
        let types = match self.kind {
            VtkKind::PolyData => Vec::new(),
            VtkKind::UnstructuredGrid => self.array(section, "types", 1, self.cells)?,
        };
        let mut mesh = MeshData { materials: vec![MeshMaterial::named("default")], ..MeshData::default() };
        let (mut from, mut crossed) = (0, 0);
        for (cell, end) in ends.iter().enumerate() {
            let kind = types.get(cell).map_or(Some(POLYGON), |kind| whole(*kind)).unwrap_or(usize::MAX);
            let end = whole(*end).filter(|end| *end >= from);
            let Some((end, list)) = end.and_then(|end| Some((end, corners.get(from..end)?))) else {
                return Err(fault(cell, WRONG_OFFSETS.into()));
            };
            from = end;
            let polygon = self.polygon(list, kind, &points).map_err(|e| fault(cell, e))?;
            let template = MeshFace::template(0, mesh.face_count);
            crossed += usize::from(!push_polygon(&mut mesh.faces, &template, &polygon));
            mesh.face_count += 1;
        }
        if crossed > 0 {
            mesh.notes
                .push(format!("{}: {crossed} polygons cross themselves and were cut as fans", self.file));
        }
        Ok(mesh)
    }

    /// The corners of a cell in their order around it.
    fn polygon(&self, list: &[f64], kind: usize, points: &[f64]) -> Result<Vec<PolygonCorner>, String> {
        let fits = match kind {
            TRIANGLE => list.len() == 3,
            PIXEL | QUADRILATERAL => list.len() == 4,
            POLYGON => (3..=MAX_POLYGON_CORNERS).contains(&list.len()),
            other => {
                return Err(format!(
                    "it has VTK's type {other}, which is no face; save the surface alone (ParaView: Extract Surface)"
                ));
            }
        };
        if !fits {
            return Err(format!(
                "it has {} corners, which its type {kind} does not have; save the file again",
                list.len()
            ));
        }
        let corner = |k: &f64| {
            let index = whole(*k).filter(|index| *index < self.points);
            let p = index.and_then(|index| points.get(3 * index..3 * index + 3));
            let p = p.ok_or_else(|| {
                format!("its corner {k} is none of the {} points; save the file again", self.points)
            })?;
            let p = Vec3::from_array([p[0], p[1], p[2]]);
            if p.is_finite() {
                Ok((p, [0.0; 2]))
            } else {
                Err(format!("its corner {k} is not a finite number; mend the file"))
            }
        };
        let mut out: Vec<PolygonCorner> = list.iter().map(corner).collect::<Result<_, _>>()?;
        if kind == PIXEL {
            out.swap(2, 3);
        }
        Ok(out)
    }
}
