//! The keys of cameras and camera paths.

use super::keys::{KeyGroups, KeySpec, key};

/// Keys of a camera's position and lens.
const VIEW_KEYS: &[KeySpec] = &[
    key("origin", "point", "m", "required", "position"),
    key("target", "point", "m", "required", "point in the middle of the picture"),
    key("up", "direction", "", "[0, 0, 1]", "upward direction"),
    key("fov", "number in (0, 180)", "degrees", "60", "angle of view across the picture's width"),
    key("aperture", "number from 0", "m", "0", "diameter of the lens"),
    key("focus", "number above 0", "m", "distance of the picture's middle", "distance in focus"),
];
/// `[[camera]]`.
pub(crate) const CAMERA: KeyGroups = &[&[key("name", "text", "", "camera1, …", "unique name")], VIEW_KEYS];

/// A file of cameras.
pub(crate) const CAMERA_FILE: KeyGroups = &[&[key("camera", "list of tables", "", "required", "cameras")]];
/// A camera path.
pub(crate) const CAMERA_PATH: KeyGroups = &[&[
    key("frames_per_second", "number in (0, 1000]", "1/s", "24", "frame rate"),
    key("exposure", "number above 0", "(m2 sr)/W", "automatic", "factor of the radiance"),
    key("key", "list of tables", "", "required", "key frames by ascending time"),
]];
/// `[[key]]` of a camera path.
pub(crate) const KEY_FRAME: KeyGroups = &[
    &[
        key("time", "number", "s", "required", "time"),
        key("camera", "text", "", "", "camera of the scene"),
        key(
            "stops",
            "number in [-30, 30]",
            "stops",
            "that of the key before",
            "exposure above that of all frames",
        ),
        key("lights", "table of bands", "", "those of the key before", "factors of light groups"),
    ],
    VIEW_KEYS,
];
