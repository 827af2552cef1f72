//! Arrays in large pages, for random access.
//!
//! A ray of a large scene waits for memory, as a look at a large environment map does, and half of the wait is
//! for the page tables. Large arrays are put in pages of two megabytes where the system provides them.

use bytemuck::Pod;
use memmap2::MmapMut;
use std::fmt::{Debug, Formatter};
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

/// Fewest bytes for which large pages are requested.
const LARGE: usize = 4 << 20;

/// A fixed number of elements, all bits zero at first.
pub struct Pages<T> {
    memory: Memory<T>,
}

enum Memory<T> {
    Small(Vec<T>),
    Large(MmapMut, usize, PhantomData<T>),
}

impl<T: Pod> Pages<T> {
    pub fn zeroed(count: usize) -> Self {
        let bytes = count * size_of::<T>();
        let large = (bytes >= LARGE).then(|| MmapMut::map_anon(bytes).ok()).flatten();
        let memory = match large {
            Some(map) => {
                // A refusal costs speed only.
                #[cfg(target_os = "linux")]
                let _ = map.advise(memmap2::Advice::HugePage);
                Memory::Large(map, count, PhantomData)
            }
            None => Memory::Small(bytemuck::zeroed_vec(count)),
        };
        Self { memory }
    }
}

impl<T> Debug for Pages<T> {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        f.write_str("Pages")
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match &self.memory {
            Memory::Small(items) => items,
            Memory::Large(map, count, _) => bytemuck::cast_slice(&map[..count * size_of::<T>()]),
        }
    }
}

impl<T: Pod> DerefMut for Pages<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.memory {
            Memory::Small(items) => items,
            Memory::Large(map, count, _) => bytemuck::cast_slice_mut(&mut map[..*count * size_of::<T>()]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_hold_what_is_put_in() {
        for count in [0, 1, 1000, LARGE / 4 - 1, LARGE / 4, LARGE] {
            let mut pages = Pages::<u32>::zeroed(count);
            assert_eq!(matches!(pages.memory, Memory::Large(..)), 4 * count >= LARGE);
            assert!(pages.len() == count && pages.iter().all(|&item| item == 0));
            for (i, item) in pages.iter_mut().enumerate() {
                *item = i as u32;
            }
            assert!(pages.iter().enumerate().all(|(i, &item)| item == i as u32));
        }
    }
}
