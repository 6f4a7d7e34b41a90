//! The end of ranks that are stopped: where a rank dies, mpirun stops the others by a signal, and the lowest of them on its machine prints one line.

use crate::placement::machine;
use std::thread::sleep;
use std::time::Duration;
use zonal_solve::distribution::Communicator;

/// Exit code of a stopped rank.
const STOPPED_CODE: i32 = 130;
/// Time between the line and the end of its rank, in which ranks of higher number see that it runs.
const END_DELAY: Duration = Duration::from_millis(300);

/// True for a process that runs; one that died is there until its parent asks for its end. False where the system does not tell.
fn runs(id: u32) -> bool {
    // The state stands behind the name of the process, which is in brackets.
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    let state = stat.rsplit_once(')').and_then(|(_, rest)| rest.trim_start().chars().next());
    state.is_some_and(|state| !matches!(state, 'Z' | 'X'))
}

/// Prints one line where this rank is stopped, and ends it. `hint` says how the solve goes on.
pub(crate) fn report_stops(communicator: &dyn Communicator, hint: String) {
    let own = std::process::id();
    let machine = machine();
    let all = communicator.all_gather(format!("{own} {machine}").into_bytes());
    let of_lower_rank = |text: &Vec<u8>| {
        let text = String::from_utf8_lossy(text);
        let (id, place) = text.split_once(' ')?;
        (place == machine).then(|| id.parse::<u32>().ok()).flatten()
    };
    let lower: Vec<u32> = all[..communicator.rank()].iter().filter_map(of_lower_rank).collect();
    let handler = move || {
        if !lower.iter().any(|id| runs(*id)) {
            eprintln!("error: the solve was stopped, by a signal or because a rank died; {hint}");
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
        assert!(runs(std::process::id()));
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let id = child.id();
        let ended = (0..200).any(|_| {
            sleep(Duration::from_millis(10));
            !runs(id)
        });
        assert!(ended);
        child.wait().unwrap();
        assert!(!runs(id));
    }
}
