//! Seeds derived from a test's name and a number, so that nobody picks them.

use rand_pcg::{Pcg64Mcg, rand_core::Rng};

/// A seed for the test called `name`, the `number`-th of its kind: FNV-1a over the bytes of the name and the
/// number, then splitmix64's finaliser (Steele, Lea and Flood 2014), so that neighbours differ in all bits.
pub fn seed_for(name: &str, number: u64) -> u64 {
    let bytes = name.bytes().chain(number.to_le_bytes());
    let hash = bytes
        .fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    finalise(hash)
}

fn finalise(hash: u64) -> u64 {
    let hash = hash.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    hash ^ (hash >> 31)
}

/// Random numbers for simulations and checks.
pub struct Stream(Pcg64Mcg);

impl Stream {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::new((u128::from(finalise(seed)) << 64) | u128::from(seed)))
    }

    /// The stream of [`seed_for`]`(name, number)`.
    pub fn named(name: &str, number: u64) -> Self {
        Self::new(seed_for(name, number))
    }

    /// Uniform on \[0, 1), a multiple of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Exponential with mean 1.
    pub fn exponential(&mut self) -> f64 {
        -libm::log(1.0 - self.uniform())
    }

    /// Standard normal (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (2.0 * self.exponential()).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::uniformity;

    #[test]
    fn names_and_numbers_give_unrelated_seeds() {
        let mut seeds: Vec<u64> =
            (0..1000).flat_map(|n| [seed_for("chi2", n), seed_for("chi3", n)]).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 2000);
        let first: Vec<f64> = (0..2000).map(|number| Stream::named("first draw", number).uniform()).collect();
        assert!(uniformity(&first) > 1e-3);
    }

    #[test]
    fn seeds_never_change() {
        // Values computed by an implementation of the two hashes in another language.
        let known = [
            ("", 0, 0x5ba3_14b8_cfda_3b6b),
            ("chi2", 1, 0x4447_da0c_a2c9_e570),
            ("λ", u64::MAX, 0x138a_601f_d536_4223),
        ];
        for (name, number, seed) in known {
            assert_eq!(seed_for(name, number), seed, "{name} {number}");
        }
        assert_ne!(seed_for("a", 0), seed_for("", 97));
    }
}
