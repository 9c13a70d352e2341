//! Lists that are refilled, because engine steps must not allocate.

/// Replaces the items of a list, reusing its allocation.
pub(crate) fn refill<T>(list: &mut Vec<T>, items: impl IntoIterator<Item = T>) {
    list.clear();
    list.extend(items);
}

/// Sets a list to `count` equal items, reusing its allocation.
pub(crate) fn reset<T: Clone>(list: &mut Vec<T>, count: usize, item: T) {
    list.clear();
    list.resize(count, item);
}
