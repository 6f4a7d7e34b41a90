//! The keys of cameras and camera paths.

use super::keys::{Kind, keys};
use super::kinds::{LENGTH, NUMBER, POINT, POSITIVE, TABLES, TEXT, VECTOR, limited, shown};
use zonal_math::Vec3;

/// Angle of view across the picture's width.
const ANGLE_OF_VIEW: Kind<f64> = Kind::new("number in (0, 180)", |n| {
    limited(n, |x| x > 0.0 && x < 180.0, "degrees above 0 and below 180")
})
.in_unit("degrees");
/// Diameter of the lens.
const APERTURE: Kind<f64> =
    Kind::new("number from 0", |n| limited(n, |x| x >= 0.0, "the lens's diameter in metres, from 0"))
        .in_unit("m");
const FRAME_RATE: Kind<f64> = Kind::new("number in (0, 1000]", |n| {
    limited(n, |x| x > 0.0 && x <= 1000.0, "frames a second above 0 and up to 1000")
})
.in_unit("1/s");
const STOPS: Kind<f64> =
    Kind::new("number in [-30, 30]", |n| limited(n, |x| x.abs() <= 30.0, "stops from -30 to 30"))
        .in_unit("stops");

keys! {
    /// Position and lens of a camera.
    VIEW: View = [View] {
        origin: Vec3 = POINT, "required", "position", "[x, y, z]";
        target: Vec3 = POINT, "required", "point in the middle of the picture", "[x, y, z]";
        up: Vec3 = VECTOR, "[0, 0, 1]", "upward direction";
        fov: f64 = ANGLE_OF_VIEW, "60", "angle of view across the picture's width";
        aperture: f64 = APERTURE, "0", "diameter of the lens";
        focus: f64 = LENGTH, "distance of the picture's middle", "distance in focus";
    }
    /// `[[camera]]`.
    CAMERA: Camera = [Camera, View] {
        name: String = TEXT, "camera1, …", "unique name";
    }
    /// A file of cameras.
    CAMERA_FILE: CameraFile = [CameraFile] {
        camera: () = TABLES, "required", "cameras";
    }
    /// A camera path.
    CAMERA_PATH: CameraPath = [CameraPath] {
        frames_per_second: f64 = FRAME_RATE, "24", "frame rate";
        exposure: f64 = POSITIVE.in_unit("(m2 sr)/W"), "automatic", "factor of the radiance";
        key: () = TABLES, "required", "key frames by ascending time";
    }
    /// `[[key]]` of a camera path.
    KEY_FRAME: KeyFrame = [KeyFrame, View] {
        time: f64 = NUMBER.in_unit("s"), "required", "time", "2.5, in seconds";
        camera: () = shown("text", ""), "", "camera of the scene";
        stops: f64 = STOPS, "that of the key before", "exposure above that of all frames";
        lights: () = shown("table of bands", ""), "those of the key before", "factors of light groups";
    }
}
