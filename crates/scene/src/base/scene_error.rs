//! The error of scene validation.

use std::fmt;

/// An invalid scene: the key of the faulty value and a message that states the fault and a remedy.
///
/// ```
/// let error = zonal_scene::SceneError::new("camera 'front'.fov", "the field of view must lie between 0 and 180 degrees");
/// assert_eq!(error.key(), "camera 'front'.fov");
/// assert!(error.to_string().starts_with("camera 'front'.fov: the field"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    key: String,
    message: String,
    kind: SceneErrorKind,
}

/// The kind of a [`SceneError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// A value of the scene or of its options is invalid.
    Input,
    /// The solve would exceed its memory limit.
    Memory,
    /// The observer interrupted the solve.
    Interrupted,
}

impl SceneError {
    /// An error at `key` (dotted, as in the scene file); `message` states the fault and a remedy.
    pub fn new(key: impl Into<String>, message: impl Into<String>) -> SceneError {
        SceneError { key: key.into(), message: message.into(), kind: SceneErrorKind::Input }
    }
    /// An error for a solve that would exceed its memory limit.
    pub fn out_of_memory(key: impl Into<String>, message: impl Into<String>) -> SceneError {
        SceneError { kind: SceneErrorKind::Memory, ..SceneError::new(key, message) }
    }
    /// The error of a solve that its observer interrupted.
    pub fn interrupted() -> SceneError {
        let message =
            "the observer interrupted the solve; finished stages are in the checkpoint, if there is one";
        SceneError { kind: SceneErrorKind::Interrupted, ..SceneError::new("solve", message) }
    }
    /// The kind of the error.
    pub fn kind(&self) -> SceneErrorKind {
        self.kind
    }
    /// The key of the faulty value.
    pub fn key(&self) -> &str {
        &self.key
    }
    /// The fault and a remedy.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key, self.message)
    }
}

impl std::error::Error for SceneError {}

/// `Err` of a [`SceneError`].
pub(crate) fn invalid<T>(key: impl Into<String>, message: impl Into<String>) -> Result<T, SceneError> {
    Err(SceneError::new(key, message))
}
