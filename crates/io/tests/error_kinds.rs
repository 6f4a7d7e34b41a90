//! The predicates of the common error tell the input, the memory limit, interruptions and files apart.

use zonal_io::{Error, input, output};
use zonal_scene::SceneError;

#[test]
fn each_error_has_one_kind() {
    let kinds = |e: Error| [e.is_input(), e.is_memory(), e.is_interrupted(), e.is_file()];
    let syntax = input::parse_scene("name = 3", None, "test.toml").unwrap_err();
    let absent = output::read_solution("no-such-folder/no-such-file.npz").unwrap_err();
    assert_eq!(kinds(syntax.into()), [true, false, false, false]);
    assert_eq!(kinds(SceneError::out_of_memory("solve", "too large").into()), [false, true, false, false]);
    assert_eq!(kinds(SceneError::interrupted().into()), [false, false, true, false]);
    assert_eq!(kinds(absent.into()), [false, false, false, true]);
}
