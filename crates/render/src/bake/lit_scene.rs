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
