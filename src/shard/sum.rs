//! Adds up what has the same key.

/// Sorts items by key; items of one key become one, to which `add` adds the others.
pub(super) fn sum_by_key<T, K: Ord>(items: &mut Vec<T>, key: impl Fn(&T) -> K, add: impl Fn(&mut T, &T)) {
    items.sort_unstable_by_key(&key);
    items.dedup_by(|next, kept| {
        let same = key(next) == key(kept);
        if same {
            add(kept, next);
        }
        same
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_item_a_key_is_left_with_the_sum() {
        let mut items = vec![(3, 1), (1, 10), (3, 2), (2, 100), (3, 4)];
        sum_by_key(&mut items, |item| item.0, |kept, next| kept.1 += next.1);
        assert_eq!(items, [(1, 10), (2, 100), (3, 7)]);
    }
}
