//! The scene in which direct light is sampled: with symmetry planes the even extension, in which shadow rays go straight where symmetry planes reflect them, with all
//! images of its suns. Lights that are left to viewers are not among its lights.

use super::baked::SunlightMode;
use super::separate_suns::separate_suns;
use std::borrow::Cow;
use zonal_scene::{EvenExtension, Light, LightGroupKind, Scene};

/// A scene with the lights that a part of it sees.
pub(super) struct LitScene<'a> {
    pub scene: Cow<'a, Scene>,
    /// The light of the solution that each light is an image of, by index.
    light_of: Vec<usize>,
    /// For each light of the solution true where its direct light is left to viewers.
    is_separate: Vec<bool>,
}

impl<'a> LitScene<'a> {
    /// The lit scene of a solved scene.
    pub(super) fn of(scene: &'a Scene, sunlight: SunlightMode) -> LitScene<'a> {
        let is_separate = separate_suns(scene, sunlight);
        match EvenExtension::of(scene).ok().flatten() {
            Some(extension) => {
                let (scene, light_of) = extension.lit_scene();
                LitScene { scene: Cow::Owned(scene), light_of, is_separate }
            }
            None => {
                let light_of = (0..scene.lights().len()).collect();
                LitScene { scene: Cow::Borrowed(scene), light_of, is_separate }
            }
        }
    }

    /// True where the scene is an even extension.
    pub(super) fn is_extended(&self) -> bool {
        matches!(self.scene, Cow::Owned(_))
    }

    /// The lights of a group and their images, without separate suns.
    pub(super) fn lights_of(&self, kind: LightGroupKind) -> impl Iterator<Item = &Light> {
        let lights = self.scene.lights().iter().zip(&self.light_of);
        lights.filter(move |(_, l)| kind.has_light(**l) && !self.is_separate[**l]).map(|x| x.0)
    }

    /// For each light of the solution true where its direct light is left to viewers.
    pub(super) fn is_separate(&self) -> &[bool] {
        &self.is_separate
    }

    /// True where the direct light of a light of the group is left to viewers.
    pub(super) fn has_separate_sun(&self, kind: LightGroupKind) -> bool {
        self.is_separate.iter().enumerate().any(|(l, separate)| *separate && kind.has_light(l))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_scene::{Medium, Mesh, Sky, Sun};

    #[test]
    fn suns_have_mirror_images_and_other_lights_have_none() {
        let build = |symmetry_planes: [bool; 2]| {
            Scene::builder()
                .surface(Mesh::rectangle([0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).name("wall"))
                .medium(Medium::grid([0.0; 3], [1.0; 3], [2; 3]).extinction(0.1))
                .symmetry_planes(0, symmetry_planes)
                .light(Sun::new([-1.0, 0.0, -1.0]).irradiance(1.0))
                .light(Sky::new(1.0))
                .build()
                .unwrap()
        };
        let (plain, mirrored) = (build([false; 2]), build([true, false]));
        let baked = |s| LitScene::of(s, SunlightMode::Baked);
        let separate = |s| LitScene::of(s, SunlightMode::Separate);
        let count = |lit: LitScene, l: usize| lit.lights_of(LightGroupKind::Light(l)).count();
        assert_eq!([count(baked(&plain), 0), count(baked(&plain), 1)], [1, 1]);
        assert_eq!([count(baked(&mirrored), 0), count(baked(&mirrored), 1)], [2, 1]);
        assert_eq!(baked(&mirrored).lights_of(LightGroupKind::All).count(), 3);
        assert_eq!(baked(&mirrored).scene.facets().len(), 2 * plain.facets().len());
        // Only suns of scenes without symmetry planes are separate.
        assert_eq!([count(separate(&plain), 0), count(separate(&plain), 1)], [0, 1]);
        assert_eq!([count(separate(&mirrored), 0), count(separate(&mirrored), 1)], [2, 1]);
        assert!(separate(&plain).has_separate_sun(LightGroupKind::All));
        assert!(!separate(&plain).has_separate_sun(LightGroupKind::Light(1)));
    }
}
