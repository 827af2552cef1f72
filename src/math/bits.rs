//! Sets of small numbers, a bit for each.

/// The numbers in a set, in ascending order.
#[inline(always)]
pub fn numbers(mut set: u64) -> impl Iterator<Item = usize> + Clone {
    std::iter::from_fn(move || {
        let first = set.trailing_zeros();
        set &= set.wrapping_sub(1);
        (first < u64::BITS).then_some(first as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::numbers;

    #[test]
    fn numbers_come_in_order_and_once() {
        assert_eq!(numbers(0).count(), 0);
        assert_eq!(numbers(0b1010_0001).collect::<Vec<_>>(), [0, 5, 7]);
        assert_eq!(numbers(1 << 63).collect::<Vec<_>>(), [63]);
        assert!(numbers(u64::MAX).eq(0..64));
    }
}
