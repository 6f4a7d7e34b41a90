//! A room and lights of its scenes. The unit tests of the library take this file too.

/// A room; TOLERANCE and OMIT stand for the tolerance and the walls that are left out.
pub(crate) const ROOM: &str = "name = \"room\"\n[solve]\ntolerance = TOLERANCE\npatch_size = 0.25\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\nomit = [OMIT]\nreflectance = 0.5\n";
/// A lamp below the ceiling.
pub(crate) const LAMP: &str = "[[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.6, 0.7, 1.95], edge1 = [0, 0.6, 0], edge2 = [0.8, 0, 0] }\n\
    emission = 10\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n";
/// A sun from above.
pub(crate) const SUN: &str =
    "[[light]]\nkind = \"sun\"\ndirection = [0.3, 0.2, -1]\nirradiance = 100\nangular_diameter = 2\n";
/// A uniform sky.
pub(crate) const SKY: &str = "[[light]]\nkind = \"sky\"\nradiance = 1\n";

/// A lid with a square hole of 12 cm.
pub(crate) fn lid() -> String {
    let part = |name: &str, x: f64, y: f64, dx: f64, dy: f64| {
        format!(
            "[[surface]]\nname = \"{name}\"\nrectangle = {{ origin = [{x}, {y}, 2], edge1 = [{dx}, 0, 0], edge2 = [0, {dy}, 0] }}\nsides = \"both\"\n"
        )
    };
    [part("a", 0.0, 0.0, 0.9, 2.0), part("b", 1.02, 0.0, 0.98, 2.0)].concat()
        + &[part("c", 0.9, 0.0, 0.12, 0.9), part("d", 0.9, 1.02, 0.12, 0.98)].concat()
}
