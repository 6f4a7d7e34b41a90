//! Samples of the long lists of cases: `cargo test` runs a sample, and all cases with the environment variable `ZONAL_TEST_CASES=all`.

/// Whether all cases are to be run: the environment variable `ZONAL_TEST_CASES` is `all`.
pub fn run_all_cases() -> bool {
    std::env::var("ZONAL_TEST_CASES").is_ok_and(|v| v == "all")
}

/// The cases at the indices `sample`, or all.
///
/// ```
/// # if !zonal_reference::test_cases::run_all_cases() {
/// assert_eq!(zonal_reference::test_cases::sampled_cases(["a", "b", "c"], &[0, 2]), ["a", "c"]);
/// # }
/// ```
pub fn sampled_cases<T>(cases: impl IntoIterator<Item = T>, sample: &[usize]) -> Vec<T> {
    let all = run_all_cases();
    cases.into_iter().enumerate().filter(|(i, _)| all || sample.contains(i)).map(|(_, case)| case).collect()
}

/// Number of random cases: `sample`, or `all`.
pub fn sampled_count(sample: u64, all: u64) -> u64 {
    if run_all_cases() { all } else { sample }
}
