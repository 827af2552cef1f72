//! Which shape a primitive belongs to.

/// The shapes of all primitives, counted over the scene: found in a few steps, whatever their number.
#[derive(Clone, Debug, Default)]
pub struct Owners {
    /// The first primitive of every shape, and the number of primitives.
    starts: Vec<u32>,
    /// For every 2^`shift` primitives the shape of the first of them.
    shapes: Vec<u32>,
    shift: u32,
}

/// Entries of the table, at most.
const ENTRIES: u32 = 4096;

impl Owners {
    /// From the numbers of primitives of the shapes.
    pub fn new(counts: impl Iterator<Item = u32>) -> Self {
        let mut starts = vec![0];
        let mut total = 0;
        for count in counts {
            total += count;
            starts.push(total);
        }
        let shift = (0..32).find(|&shift| total >> shift < ENTRIES).unwrap_or(31);
        let shapes = (0..=total >> shift).map(|entry| {
            let after = starts.partition_point(|&start| start <= entry << shift);
            after as u32 - 1
        });
        Self { shapes: shapes.collect(), starts, shift }
    }

    /// The first primitive of a shape.
    #[inline]
    pub fn start(&self, shape: usize) -> u32 {
        self.starts[shape]
    }

    /// The index of the shape.
    #[inline]
    pub fn of(&self, primitive: u32) -> usize {
        let mut shape = self.shapes[(primitive >> self.shift) as usize] as usize;
        while self.starts[shape + 1] <= primitive {
            shape += 1;
        }
        shape
    }
}

#[cfg(test)]
mod tests {
    use super::Owners;

    #[test]
    fn every_primitive_is_found_where_it_was_counted() {
        for counts in [vec![1, 1, 1], vec![0, 3, 0, 0, 2, 1], vec![70_000, 1, 0, 12_345, 2], vec![1; 9000]] {
            let owners = Owners::new(counts.iter().copied());
            let all = counts.iter().enumerate().flat_map(|(i, n)| std::iter::repeat_n(i, *n as usize));
            for (primitive, shape) in all.enumerate() {
                assert_eq!(owners.of(primitive as u32), shape, "{primitive} of {counts:?}");
            }
        }
    }
}
