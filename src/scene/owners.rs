//! The shape that a primitive belongs to.

/// The shapes of all primitives, counted over the scene: a table says between which two shapes to look, which
/// are mostly one and the same.
#[derive(Clone, Debug, Default)]
pub struct Owners {
    /// The first primitive of every shape, and the number of primitives.
    starts: Vec<u32>,
    /// For every 2^`shift` primitives the shapes of the first and the last of them.
    shapes: Vec<[u32; 2]>,
    shift: u32,
}

/// Entries of the table, at most, unless there are more shapes.
const ENTRIES: usize = 4096;

impl Owners {
    /// From the numbers of primitives of the shapes.
    pub fn new(counts: impl Iterator<Item = u32>) -> Self {
        let mut starts = vec![0];
        let mut total = 0;
        for count in counts {
            total += count;
            starts.push(total);
        }
        let entries = ENTRIES.max(starts.len());
        let shift = (0..32).find(|&shift| ((total >> shift) as usize) < entries).unwrap_or(31);
        let owner = |primitive: u32| starts.partition_point(|&start| start <= primitive) as u32 - 1;
        let last = total.saturating_sub(1);
        let ends = |entry: u32| {
            let first = entry << shift;
            [first, (first | ((1 << shift) - 1)).min(last)].map(owner)
        };
        let shapes = (0..=last >> shift).map(ends).collect();
        Self { shapes, starts, shift }
    }

    /// The first primitive of a shape.
    #[inline]
    pub fn start(&self, shape: usize) -> u32 {
        self.starts[shape]
    }

    /// The index of the shape.
    #[inline]
    pub fn of(&self, primitive: u32) -> usize {
        let [first, last] = self.shapes[(primitive >> self.shift) as usize];
        if first == last { first as usize } else { self.between(first as usize, last as usize, primitive) }
    }

    /// The last of the shapes from `shape` to `last` that does not begin after the primitive.
    fn between(&self, mut shape: usize, mut last: usize, primitive: u32) -> usize {
        while shape < last {
            let middle = (shape + last).div_ceil(2);
            if self.starts[middle] <= primitive {
                shape = middle;
            } else {
                last = middle - 1;
            }
        }
        shape
    }
}

#[cfg(test)]
mod tests {
    use super::Owners;

    #[test]
    fn every_primitive_is_found_where_it_was_counted() {
        let beside = [vec![3_000_000], vec![1; 5000], vec![0; 10], vec![1; 5000]].concat();
        let few = [vec![1, 1, 1], vec![0, 3, 0, 0, 2, 1, 0], vec![70_000, 1, 0, 12_345, 2]];
        for counts in few.into_iter().chain([vec![1; 9000], beside]) {
            let owners = Owners::new(counts.iter().copied());
            let all = counts.iter().enumerate().flat_map(|(i, n)| std::iter::repeat_n(i, *n as usize));
            for (primitive, shape) in all.enumerate() {
                assert_eq!(owners.of(primitive as u32), shape, "{primitive} of {} shapes", counts.len());
            }
        }
    }
}
