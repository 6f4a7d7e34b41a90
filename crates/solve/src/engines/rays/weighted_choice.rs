//! Choice of one of several items by their weights.

/// The item at the part `left` of the sum of the weights; the last of positive weight where rounding leaves none.
#[inline]
pub(crate) fn choose<T>(items: impl Iterator<Item = (T, f64)>, mut left: f64) -> Option<T> {
    let mut chosen = None;
    for (item, weight) in items.filter(|(_, weight)| *weight > 0.0) {
        chosen = Some(item);
        left -= weight;
        if left < 0.0 {
            break;
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::choose;

    #[test]
    fn items_are_chosen_in_proportion_to_their_weights() {
        let at = |left: f64| choose([("a", 1.0), ("none", 0.0), ("b", 3.0)].into_iter(), left);
        assert_eq!(
            [0.0, 0.9, 1.0, 3.9, 4.0].map(at),
            [Some("a"), Some("a"), Some("b"), Some("b"), Some("b")]
        );
        assert_eq!(choose([("none", 0.0)].into_iter(), 0.0), None);
    }
}
