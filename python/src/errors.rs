//! Errors of the library as exceptions of the package, with file, place and key.
//!
//! The exceptions take `(message, file, place, key)`; the remedy is the part of the message after its first semicolon.

use pyo3::PyErr;
use zonal_io::input::InputError;
use zonal_io::output::FileError;
use zonal_report::Failure;
use zonal_scene::{SceneError, SceneErrorKind};

mod classes {
    pyo3::import_exception!(zonal.errors, InputError);
    pyo3::import_exception!(zonal.errors, FileError);
    pyo3::import_exception!(zonal.errors, MemoryLimitError);
    pyo3::import_exception!(zonal.errors, Interrupted);
}

/// Where a document comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DocumentOrigin {
    /// A file; lines and columns mean something.
    File,
    /// Written by the package from a document in memory; keys alone say where an error is.
    Memory,
}

/// The exception of an error in a scene.
pub(crate) fn of_input(e: &InputError, origin: DocumentOrigin) -> PyErr {
    let key = (!e.key().is_empty()).then(|| e.key().to_string());
    let array = array_message(e.message()).filter(|_| origin == DocumentOrigin::Memory);
    // An array stands in place of a file: its key is the argument itself.
    let key =
        key.map(|k| k.strip_suffix(".file").filter(|_| array.is_some()).map_or(k.clone(), str::to_string));
    match origin {
        DocumentOrigin::File => {
            let place = e.line_and_column().map(|(line, column)| format!("{line}:{column}"));
            classes::InputError::new_err((e.to_string(), Some(e.file().to_string()), place, key))
        }
        DocumentOrigin::Memory => {
            let text = array.unwrap_or(e.message());
            let message = match &key {
                Some(key) => format!("{key}: {text}"),
                None => text.to_string(),
            };
            classes::InputError::new_err((message, None::<String>, key.clone(), key))
        }
    }
}

/// The message about an array or a mesh in memory, without the folder that its name seems to be in; none about files.
fn array_message(message: &str) -> Option<&str> {
    let name = message.split(": ").next().unwrap_or(message);
    let folder = name.rfind(['/', '\\']).map_or(0, |k| k + 1);
    ["array ", "mesh "].iter().any(|kind| name[folder..].starts_with(kind)).then(|| &message[folder..])
}

/// The exception of an error of a solve or of its settings.
pub(crate) fn of_scene(e: &SceneError) -> PyErr {
    let arguments = (e.to_string(), None::<String>, Some(e.key().to_string()), Some(e.key().to_string()));
    match e.kind() {
        SceneErrorKind::Memory => classes::MemoryLimitError::new_err(arguments),
        SceneErrorKind::Interrupted => classes::Interrupted::new_err(arguments),
        _ => classes::InputError::new_err(arguments),
    }
}

/// The exception of a file that cannot be read or written.
pub(crate) fn of_file(e: &FileError) -> PyErr {
    let place = (!e.entry().is_empty()).then(|| e.entry().to_string());
    classes::FileError::new_err((e.to_string(), Some(e.path().display().to_string()), place.clone(), place))
}

/// The exception of an error of the application crate.
pub(crate) fn of_app(e: &zonal_app::Error) -> PyErr {
    match e {
        zonal_app::Error::Scene(e) => of_scene(e),
        zonal_app::Error::Input(e) => of_input(e, DocumentOrigin::File),
        zonal_app::Error::File(e) => of_file(e),
        zonal_app::Error::Refused(e) => of_failure(e),
    }
}

/// The exception of a refused option.
pub(crate) fn of_failure(e: &Failure) -> PyErr {
    refused(e.to_string())
}

/// The exception of a wrong argument; the message states the defect and, after a semicolon, the remedy.
pub(crate) fn refused(message: impl Into<String>) -> PyErr {
    classes::InputError::new_err((message.into(), None::<String>, None::<String>, None::<String>))
}
