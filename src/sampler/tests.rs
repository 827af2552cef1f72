//! Tests of the numbers: uniform, independent, and each for one use.

use super::*;

/// Kolmogorov–Smirnov distance from uniform, in units of 1/√n.
fn distance(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let gaps =
        values.iter().enumerate().map(|(i, v)| (v - i as f64 / n).abs().max((v - (i + 1) as f64 / n).abs()));
    gaps.fold(0.0, f64::max) * n.sqrt()
}

#[test]
fn every_dimension_is_uniform_over_samples_and_over_pixels() {
    for kind in [SamplerKind::Independent, SamplerKind::Sobol] {
        for dimension in 0..8 {
            for block in [0, 1, 7] {
                let value = |pixel, sample| Sampler::new(kind, 1, pixel, sample).block(block).one(dimension);
                // Exceeded once in 10⁷.
                assert!(
                    distance((0..4096).map(|s| value((3, 5), s)).collect()) < 2.9,
                    "{kind:?} {dimension}"
                );
                assert!(distance((0..4096).map(|p| value((p % 64, p / 64), 0)).collect()) < 2.9, "{kind:?}");
            }
        }
    }
}

#[test]
fn dimensions_of_different_vertices_are_independent_within_a_pixel() {
    const CELLS: usize = 16;
    let samples = 1 << 16;
    for kind in [SamplerKind::Independent, SamplerKind::Sobol] {
        for (pixel, (one, other)) in
            (0..8).flat_map(|x| [(0, 1), (1, 2), (1, 9)].map(|blocks| ((x, 7), blocks)))
        {
            let mut counts = [[[0.0; CELLS]; CELLS]; 8];
            for sample in 0..samples {
                let sampler = Sampler::new(kind, 0, pixel, sample);
                let [a, b] = [one, other].map(|block| sampler.block(block));
                for (dimension, counts) in counts.iter_mut().enumerate() {
                    let [i, j] = [a, b].map(|u| (u.one(dimension) * CELLS as f64) as usize);
                    counts[i][j] += 1.0;
                }
            }
            let expected = f64::from(samples) / (CELLS * CELLS) as f64;
            for (dimension, counts) in counts.iter().enumerate() {
                let of_cell = |count: &f64| (count - expected) * (count - expected) / expected;
                let χ2: f64 = counts.as_flattened().iter().map(of_cell).sum();
                // Of 255 degrees of freedom: exceeded once in 10⁷ by any of them.
                assert!(χ2 < 430.0, "{kind:?} {pixel:?} {one} {other} {dimension}: {χ2}");
            }
        }
    }
}

#[test]
fn emitter_samples_of_all_camera_samples_are_one_net() {
    for count in [2, 4] {
        let mut cells = std::collections::BTreeSet::new();
        for (sample, which) in (0..64 / count).flat_map(|sample| (0..count).map(move |i| (sample, i))) {
            let sampler = Sampler::new(SamplerKind::Sobol, 1, (3, 5), sample);
            let p = sampler.emitter_samples(2, 0, count, 1).of(which as usize).pair(0) * 8.0;
            cells.insert((p.x as u32, p.y as u32));
        }
        assert_eq!(cells.len(), 64, "{count}");
    }
    // Nor does the sequence end where 32 bits do.
    let last = Sampler::new(SamplerKind::Sobol, 1, (3, 5), u32::MAX);
    let first = Sampler::new(SamplerKind::Sobol, 1, (3, 5), u32::MAX - 2);
    let numbers = |sampler: Sampler, which: u32| {
        sampler.emitter_samples(0, which / 8 * 8, 1024, PAIRS).of(which as usize % 8).words()
    };
    assert_ne!(numbers(last, 0), numbers(first, 0));
    let at = |sample| Sampler::new(SamplerKind::Sobol, 1, (3, 5), sample);
    assert_ne!(numbers(at(0), 7), numbers(at(1 << 22), 7));
    // Those that are made together are those that are made alone, however many pairs of them.
    for which in 0..8 {
        let (together, alone) =
            (at(9).emitter_samples(3, 0, 11, 1), at(9).emitter_samples(3, which, 11, PAIRS));
        assert_eq!(together.of(which as usize).pair(0), alone.of(0).pair(0));
    }
}

#[test]
fn seeds_pixels_and_samples_do_not_share_numbers() {
    let all = |kind| {
        let mut seen = std::collections::BTreeSet::new();
        for (seed, x, y, sample) in [(0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)] {
            let block = Sampler::new(kind, seed, (x, y), sample).block(3);
            seen.extend(block.words());
        }
        seen.len()
    };
    assert_eq!((all(SamplerKind::Independent), all(SamplerKind::Sobol)), (40, 40));
}

#[test]
fn no_two_pixels_of_a_large_film_are_alike() {
    for seed in 0..3 {
        let key = |i: u32| Sampler::new(SamplerKind::Sobol, seed, (i % 3840, i / 3840), 0).key;
        let mut keys: Vec<u32> = (0..3840 * 2160).map(key).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), 3840 * 2160, "{seed}");
    }
}

/// Keys have 32 bits, so some pixels of two images of this size share theirs, but no rows of them.
#[test]
fn pixels_of_two_seeds_are_alike_here_and_there() {
    let size = 1u32 << 10;
    let keys = |seed| {
        let key = move |i: u32| (Sampler::new(SamplerKind::Sobol, seed, (i % size, i / size), 0).key, i);
        (0..size * size).map(key).collect::<std::collections::BTreeMap<_, _>>()
    };
    let all: Vec<_> = (0..4).map(keys).collect();
    for (a, b) in [(0, 1), (0, 2), (1, 2), (2, 3)] {
        let shared = all[a].keys().filter(|key| all[b].contains_key(*key)).count();
        // 256 are expected; so far from it once in 10⁹.
        assert!((160..=352).contains(&shared), "{a} {b}: {shared}");
    }
}

/// Numbers of light paths exceed 32 bits after some thousand samples of a pixel.
#[test]
fn light_paths_do_not_repeat_after_four_billions() {
    for kind in [SamplerKind::Independent, SamplerKind::Sobol] {
        let source = RandomSource { kind, seed: 1 };
        let first = |number: u64| source.light_path(number).block(blocks::START);
        let all = [5, 5 + (1 << 32), 5 + (2 << 32)].map(|number| format!("{:?}", first(number)));
        assert!(all[0] != all[1] && all[1] != all[2] && all[0] != all[2], "{all:?}");
    }
}
