//! Ranks on their machines: which share processors, and how many threads each starts.

use std::num::NonZero;
use std::thread::available_parallelism;
use zonal_report::note;
use zonal_solve::distribution::Communicator;

/// The name of this machine; empty where the system does not tell.
pub(crate) fn machine() -> String {
    std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim().to_string()
}

/// The processors that this process may use, as text; empty where the system does not tell.
fn processors() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let list = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    list.unwrap_or_default().trim().to_string()
}

/// Threads of this rank: those that were asked for, or its share of the processors that it has together with other ranks. More threads than processors are reported once.
pub(crate) fn threads(communicator: &dyn Communicator, asked: Option<u16>) -> u16 {
    let own = format!("{} {}", machine(), processors());
    let all = communicator.all_gather(own.clone().into_bytes());
    let sharing = all.iter().filter(|place| **place == own.as_bytes()).count();
    let available = available_parallelism().map_or(1, NonZero::get);
    let threads = asked.map_or(threads_of_share(available, sharing), usize::from);
    let excess = u8::from(threads * sharing > available);
    let too_many = communicator.all_gather(vec![excess]).iter().filter(|x| x.first() == Some(&1)).count();
    if communicator.rank() == 0 && too_many > 0 {
        note(&format!(
            "{too_many} of {} ranks have more threads than processors: {sharing} ranks of {threads} threads share {available} processors; start fewer ranks, or set --threads",
            communicator.size()
        ));
    }
    u16::try_from(threads).unwrap_or(u16::MAX)
}

/// Threads of one of `sharing` ranks on `available` processors.
fn threads_of_share(available: usize, sharing: usize) -> usize {
    (available / sharing.max(1)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_share_the_processors() {
        assert_eq!([1, 2, 3, 7].map(|ranks| threads_of_share(4, ranks)), [4, 2, 1, 1]);
    }

    #[test]
    fn a_single_rank_takes_all_processors() {
        let one = zonal_solve::distribution::SingleProcess;
        let available = available_parallelism().map_or(1, NonZero::get);
        assert_eq!(usize::from(threads(&one, None)), available);
        assert_eq!(threads(&one, Some(1)), 1);
    }
}
