//! The end of ranks that are stopped: where a rank dies, mpirun stops the others by a signal, and the first of them on its machine prints one line.

use std::thread::sleep;
use std::time::Duration;

/// Exit code of a stopped rank.
const STOPPED_CODE: i32 = 130;
/// Time between the line and the end of its rank, in which later ranks see that it runs.
const END_DELAY: Duration = Duration::from_millis(300);

/// A process: its name, whether it runs (one that died is there until its parent asks for its end), and its parent.
struct Process {
    name: String,
    runs: bool,
    parent: u32,
}

/// The process of a number; `None` if there is none, or where the system does not tell.
fn process(id: u32) -> Option<Process> {
    // The state and the parent stand behind the name, which is in brackets.
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let (head, rest) = stat.rsplit_once(')')?;
    let mut fields = rest.split_whitespace();
    let runs = !matches!(fields.next()?, "Z" | "X");
    Some(Process { name: head.split_once('(')?.1.to_string(), runs, parent: fields.next()?.parse().ok()? })
}

/// True if no process of this name and of the same parent that started before this one still runs.
fn is_first_of_siblings() -> bool {
    let own = std::process::id();
    let Some(me) = process(own) else { return true };
    let numbers = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = numbers.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    let is_earlier =
        |id: u32| process(id).is_some_and(|p| p.runs && p.parent == me.parent && p.name == me.name);
    !numbers.filter(|id| *id < own).any(is_earlier)
}

/// Prints one line where this rank is stopped, and ends it. `hint` says how the solve goes on.
pub(crate) fn report_stops(hint: String) {
    let handler = move || {
        if is_first_of_siblings() {
            eprintln!("error: the command was stopped, by a signal or because a rank died; {hint}");
        }
        sleep(END_DELAY);
        std::process::exit(STOPPED_CODE);
    };
    // Without a handler a stopped rank ends silently.
    let _ = ctrlc::set_handler(handler);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn a_process_that_died_does_not_run() {
        let runs = |id: u32| process(id).is_some_and(|p| p.runs);
        assert!(runs(std::process::id()));
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let id = child.id();
        assert!(process(id).is_none_or(|p| p.parent == std::process::id()));
        let ended = (0..200).any(|_| {
            sleep(Duration::from_millis(10));
            !runs(id)
        });
        assert!(ended);
        child.wait().unwrap();
        assert!(!runs(id));
    }
}
