//! The scene in which direct light is sampled: with mirrors the even extension, in which shadow rays go straight where mirrors reflect them, with all
//! images of its suns.

use std::borrow::Cow;
use zonal_scene::{EvenExtension, Light, LightGroupKind, Scene};

/// A scene with the lights that a part of it sees.
pub(super) struct LitScene<'a> {
    pub scene: Cow<'a, Scene>,
    /// The light of the solution that each light is an image of, by index.
    light_of: Vec<usize>,
}

impl<'a> LitScene<'a> {
    /// The lit scene of a solved scene.
    pub(super) fn of(scene: &'a Scene) -> LitScene<'a> {
        match EvenExtension::of(scene).ok().flatten() {
            Some(extension) => {
                let (scene, light_of) = extension.lit_scene();
                LitScene { scene: Cow::Owned(scene), light_of }
            }
            None => LitScene { scene: Cow::Borrowed(scene), light_of: (0..scene.lights().len()).collect() },
        }
    }

    /// The lights of a group and their images.
    pub(super) fn lights_of(&self, kind: LightGroupKind) -> impl Iterator<Item = &Light> {
        let lights = self.scene.lights().iter().zip(&self.light_of);
        lights.filter(move |(_, l)| kind.has_light(**l)).map(|x| x.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_scene::{Medium, Mesh, Sky, Sun};

    #[test]
    fn suns_have_mirror_images_and_other_lights_have_none() {
        let build = |mirrors: [bool; 2]| {
            Scene::builder()
                .surface(Mesh::rectangle([0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).name("wall"))
                .medium(Medium::grid([0.0; 3], [1.0; 3], [2; 3]).extinction(0.1))
                .mirrors(0, mirrors)
                .light(Sun::new([-1.0, 0.0, -1.0]).irradiance(1.0))
                .light(Sky::new(1.0))
                .build()
                .unwrap()
        };
        let (plain, mirrored) = (build([false; 2]), build([true, false]));
        let count = |s: &Scene, l: usize| LitScene::of(s).lights_of(LightGroupKind::Light(l)).count();
        assert_eq!([count(&plain, 0), count(&plain, 1)], [1, 1]);
        assert_eq!([count(&mirrored, 0), count(&mirrored, 1)], [2, 1]);
        assert_eq!(LitScene::of(&mirrored).lights_of(LightGroupKind::All).count(), 3);
        assert_eq!(LitScene::of(&mirrored).scene.facets().len(), 2 * plain.facets().len());
    }
}
