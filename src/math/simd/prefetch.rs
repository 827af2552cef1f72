//! Prefetching of memory.

/// Prefetches an element into the cache where the processor can; nothing but time depends on it.
#[inline(always)]
pub fn prefetch<T>(items: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(item) = items.get(index) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let start = std::ptr::from_ref(item).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(LINE) {
            // A prefetch reads nothing, and the address lies in the element.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line * LINE)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, index);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_not_fetched() {
        let items = [[1u64; 40], [2; 40]];
        (0..4).for_each(|i| prefetch(&items, i));
        (0..4).for_each(|i| prefetch(&items[..0], i));
        assert_eq!(items, [[1; 40], [2; 40]]);
    }
}
