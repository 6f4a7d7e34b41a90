//! Surfaces made of convex polygons: concave or bent faces in parts, unions of surfaces, surfaces within others.
//!
//! Each surface is the union of some polygons. A surface within another one's plane (a window in a wall) is cut out of it:
//! the difference of two convex polygons in one plane is a set of convex polygons, found by cutting along the edges of the inner one.

use crate::{ViewFactorSettings, ViewFactors};
use zonal_exchange::polygon::visible::ConvexPolygon;
use zonal_math::Vec3;
use zonal_scene::{CheckpointStore, Progress, SceneError};

/// Surfaces and obstructions of a computation.
#[derive(Clone, Debug, Default)]
pub struct FacetSet {
    polygons: Vec<ConvexPolygon>,
    /// Surface of each polygon.
    surface: Vec<u32>,
    surfaces: usize,
    obstructions: Vec<ConvexPolygon>,
}

impl FacetSet {
    /// A set without surfaces.
    pub fn new() -> FacetSet {
        FacetSet::default()
    }

    /// Number of surfaces.
    pub fn len(&self) -> usize {
        self.surfaces
    }

    /// True without surfaces.
    pub fn is_empty(&self) -> bool {
        self.surfaces == 0
    }

    /// Adds a surface of one polygon with these corners, counter-clockwise from its front. A polygon that is not flat and convex becomes a fan of
    /// triangles around its first corner. Returns false if it has no area: its row is empty.
    pub fn add_surface(&mut self, corners: &[Vec3]) -> bool {
        let parts = convex_parts(corners);
        let any = !parts.is_empty();
        self.add_parts(parts);
        any
    }

    /// Adds a surface that is the union of polygons.
    pub fn add_parts(&mut self, parts: Vec<ConvexPolygon>) {
        self.surface.extend(parts.iter().map(|_| self.surfaces as u32));
        self.polygons.extend(parts);
        self.surfaces += 1;
    }

    /// Adds the back of every surface as a surface of its own, in the order of the fronts.
    pub fn add_backs(&mut self) {
        let fronts = self.surfaces as u32;
        for k in 0..self.polygons.len() {
            let corners = self.polygons[k].corners().iter().rev().copied().collect();
            if let Some(back) = ConvexPolygon::new(corners) {
                self.polygons.push(back);
                self.surface.push(self.surface[k] + fronts);
            }
        }
        self.surfaces *= 2;
    }

    /// Adds a polygon that hides from both sides. Returns false if it has no area.
    pub fn add_obstruction(&mut self, corners: &[Vec3]) -> bool {
        let parts = convex_parts(corners);
        let any = !parts.is_empty();
        self.obstructions.extend(parts);
        any
    }

    /// Numbers on which all stages of a computation depend, for the key of its checkpoints: the settings, then the counts of surfaces, polygons and
    /// obstructions, and for each polygon its surface (−1 of an obstruction), the number of its corners, and their coordinates in metres.
    ///
    /// Closing and the memory limit change no stage.
    pub fn checkpoint_numbers(&self, settings: &ViewFactorSettings) -> impl Iterator<Item = f64> + '_ {
        let counts = [self.surfaces, self.polygons.len(), self.obstructions.len()].map(|n| n as f64);
        let surfaces = self.surface.iter().map(|s| f64::from(*s)).zip(&self.polygons);
        let obstructions = self.obstructions.iter().map(|p| (-1.0, p));
        let of_polygon = |(surface, p): (f64, &'_ ConvexPolygon)| {
            let corners: Vec<f64> = p.corners().iter().flat_map(|c| c.array()).collect();
            [surface, p.corners().len() as f64].into_iter().chain(corners)
        };
        settings
            .checkpoint_numbers()
            .into_iter()
            .chain(counts)
            .chain(surfaces.chain(obstructions).flat_map(of_polygon))
    }

    /// The view factors of the surfaces.
    ///
    /// # Errors
    /// As [`ViewFactors::compute`].
    pub fn compute(
        &self,
        settings: &ViewFactorSettings,
        progress: &dyn Progress,
        checkpoints: &dyn CheckpointStore,
    ) -> Result<ViewFactors, SceneError> {
        let (polygons, obstructions) = (self.polygons.as_slice(), self.obstructions.as_slice());
        if !polygons.is_empty()
            && let Some(f) = ViewFactors::by_strings(
                polygons,
                &self.surface,
                self.surfaces,
                obstructions,
                settings,
                progress,
            )?
        {
            return Ok(f);
        }
        let f = ViewFactors::compute(polygons, obstructions, settings, progress, checkpoints)?;
        let single = self.surfaces == self.polygons.len()
            && self.surface.iter().enumerate().all(|(k, s)| k == *s as usize);
        Ok(if single { f } else { f.combined(&self.surface, self.surfaces) })
    }
}

/// Convex parts of a polygon: itself, or the triangles of its fan that have an area.
pub fn convex_parts(corners: &[Vec3]) -> Vec<ConvexPolygon> {
    if let Some(p) = ConvexPolygon::new(corners.to_vec()) {
        return vec![p];
    }
    let triangle = |k: usize| ConvexPolygon::new(vec![corners[0], corners[k - 1], corners[k]]);
    (2..corners.len()).filter_map(triangle).collect()
}

/// The parts of `whole` outside `inner`, a convex polygon in the same plane with either orientation.
pub fn without(whole: Vec<ConvexPolygon>, inner: &ConvexPolygon) -> Vec<ConvexPolygon> {
    whole.into_iter().flat_map(|p| difference(p, inner)).collect()
}

fn difference(whole: ConvexPolygon, inner: &ConvexPolygon) -> Vec<ConvexPolygon> {
    let c = inner.corners();
    let mut rest = whole;
    let mut parts = Vec::new();
    for k in 0..c.len() {
        let outward = (c[(k + 1) % c.len()] - c[k]).cross(inner.normal()).normalized();
        let (inside, outside) = cut(&rest, c[k], outward);
        parts.extend(outside);
        match inside {
            Some(inside) => rest = inside,
            None => return parts,
        }
    }
    parts
}

/// The parts behind and in front of a plane.
fn cut(p: &ConvexPolygon, at: Vec3, normal: Vec3) -> (Option<ConvexPolygon>, Option<ConvexPolygon>) {
    let c = p.corners();
    let (mut behind, mut front) = (Vec::new(), Vec::new());
    for (k, a) in c.iter().enumerate() {
        let b = c[(k + 1) % c.len()];
        let (h, g) = (normal.dot(*a - at), normal.dot(b - at));
        if h <= 0.0 {
            behind.push(*a);
        }
        if h >= 0.0 {
            front.push(*a);
        }
        if h * g < 0.0 {
            let x = *a + (b - *a) * (h / (h - g));
            behind.push(x);
            front.push(x);
        }
    }
    (ConvexPolygon::new(behind), ConvexPolygon::new(front))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    fn rectangle(x: [f64; 2], y: [f64; 2]) -> Vec<Vec3> {
        [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| vec3(x[i], y[j], 0.0)).to_vec()
    }

    #[test]
    fn a_wall_without_its_window_has_the_rest_of_the_area() {
        let wall = convex_parts(&rectangle([0.0, 4.0], [0.0, 3.0]));
        for (x, y, area) in
            [([1.0, 2.0], [1.0, 2.0], 11.0), ([3.0, 5.0], [1.0, 2.0], 11.0), ([5.0, 6.0], [0.0, 1.0], 12.0)]
        {
            for reversed in [false, true] {
                let mut c = rectangle(x, y);
                if reversed {
                    c.reverse();
                }
                let rest = without(wall.clone(), &ConvexPolygon::new(c).expect("a window"));
                let sum: f64 = rest.iter().map(ConvexPolygon::area).sum();
                assert!((sum - area).abs() < 1e-12, "{sum} {area}");
            }
        }
    }

    #[test]
    fn checkpoint_numbers_tell_sets_and_settings_apart() {
        let square = rectangle([0.0, 1.0], [0.0, 1.0]);
        let settings = ViewFactorSettings::default();
        let numbers = |parts: &[usize], obstructions: usize, settings: &ViewFactorSettings| {
            let mut set = FacetSet::new();
            parts
                .iter()
                .for_each(|n| set.add_parts(vec![ConvexPolygon::new(square.clone()).expect("a square"); *n]));
            (0..obstructions).for_each(|_| assert!(set.add_obstruction(&square)));
            set.checkpoint_numbers(settings).collect::<Vec<f64>>()
        };
        let closed = ViewFactorSettings { surroundings: crate::Openness::Closed, ..settings.clone() };
        let fine = ViewFactorSettings { tolerance: 1e-4, ..settings.clone() };
        let street = ViewFactorSettings { periods: [Some(1.0), None], ..settings.clone() };
        let all = [
            numbers(&[1, 1], 0, &settings),
            numbers(&[2], 0, &settings),
            numbers(&[1], 1, &settings),
            numbers(&[1, 1, 0], 0, &settings),
            numbers(&[1, 1], 0, &closed),
            numbers(&[1, 1], 0, &fine),
            numbers(&[1, 1], 0, &street),
        ];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a != b), "{i}");
        }
        // Closing uses the stages of other settings.
        let kept = ViewFactorSettings { closure: crate::RowClosing::Keep, ..settings.clone() };
        assert_eq!(numbers(&[1, 1], 0, &kept), all[0]);
    }

    #[test]
    fn bent_faces_become_triangles_and_lines_have_no_part() {
        let mut bent = rectangle([0.0, 1.0], [0.0, 1.0]);
        bent[2].z = 0.1;
        assert_eq!(convex_parts(&bent).len(), 2);
        let mut set = FacetSet::new();
        assert!(set.add_surface(&bent));
        assert!(!set.add_surface(&[Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(2.0, 0.0, 0.0)]));
        assert_eq!(set.len(), 2);
    }
}
