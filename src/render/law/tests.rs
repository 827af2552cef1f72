use super::*;
use crate::film::{Accumulators, Window};
use crate::render::quality::Correlation;
use rand_pcg::{Pcg32, rand_core::Rng};

/// The history of a square film whose pixels have such samples.
fn history(
    edge: u32,
    correlation: Correlation,
    samples: Range<u64>,
    mut sample: impl FnMut(u64, usize) -> f64,
) -> History {
    let window = Window { x: 0, y: 0, width: edge, height: edge };
    let mut history = History::new(window, correlation, samples.start).until(samples.end);
    let mut sums = Accumulators::new(edge, edge, 1);
    for number in samples {
        for (i, pixel) in sums.all_mut().iter_mut().enumerate() {
            pixel.add(number, sample(number, i));
        }
        history.note(number + 1, window, sums.all());
    }
    history
}

const STRATIFIED: Known = Known { stratified: true, correlation: 1.0 };

fn uniform(rng: &mut Pcg32) -> f64 {
    f64::from(rng.next_u32()) / 4294967296.0
}

#[test]
fn of_independent_samples_it_is_the_scatter_of_their_mean() {
    let mut rng = Pcg32::new(0, 1);
    for (samples, degrees) in [(0..8, 1.0), (0..16, 3.0), (0..100, 3.0), (4..200, 1.0), (64..128, 3.0)] {
        let history = history(32, Correlation::NONE, samples.clone(), |_, _| uniform(&mut rng));
        let law =
            Law::of(&history, &samples, Known { stratified: false, ..STRATIFIED }).expect("there are enough");
        let count = (samples.end - samples.start) as f64;
        // 1024 pixels of variance 1/12.
        let ratio = law.variance(&samples) * count * 12.0 / 1024.0;
        let deviation = law.uncertainty.sqrt();
        assert!((ratio - 1.0).abs() < 4.0 * deviation, "{samples:?}: {ratio} {deviation}");
        assert_eq!([law.gain, law.loss, law.gain_deviation], [2.0, 2.0, 0.0]);
        // From one difference of each pixel, or three.
        let expected = 2.0 / 1024.0 / degrees;
        assert!((law.uncertainty / expected - 1.0).abs() < 0.4, "{samples:?}: {law:?} {expected}");
        assert!((law.variance(&(0..4096)) / law.variance(&(0..1024)) - 0.25).abs() < 1e-12);
        // Of what might be stratified no more is told, and the gain is hardly ever seen above two.
        let looked = Law::of(&history, &samples, STRATIFIED).expect("there are enough");
        assert!(looked.gain < 2.2 && looked.loss <= 4.0, "{looked:?}");
        assert!(looked.variance(&samples) > 0.8 * law.variance(&samples), "{law:?} {looked:?}");
    }
}

/// Sample i of a pixel lies in a cell of its own of any 2ᵏ that begin at a multiple: a scrambled sequence of van der
/// Corput's.
fn stratified(number: u64, scramble: &[u32], u: f64) -> f64 {
    let mut place = 0u32;
    for bit in 0..8 {
        let digit = (number >> bit) as u32 & 1;
        // One random bit for each prefix of digits.
        place = place << 1 | digit ^ scramble[((1 << bit) | (number as u32 & ((1 << bit) - 1))) as usize];
    }
    (f64::from(place) + u) / 256.0
}

#[test]
fn what_stratification_gains_is_known() {
    let mut rng = Pcg32::new(0, 1);
    // A step somewhere has a variance as n⁻², a parabola as n⁻³.
    let step = |x: f64, at: f64| f64::from(x < at);
    let parabola = |x: f64, _: f64| x * x;
    let functions: [(&dyn Fn(f64, f64) -> f64, _); 2] = [(&step, 2.5..4.5), (&parabola, 6.0..8.01)];
    for (f, gains) in functions {
        const EDGE: u32 = 48;
        let mut seen = vec![];
        for run in 0..12 {
            let scrambles: Vec<Vec<u32>> =
                (0..EDGE * EDGE).map(|_| (0..512).map(|_| rng.next_u32() & 1).collect()).collect();
            let mut total = 0.0;
            let history = history(EDGE, Correlation::NONE, 0..64, |number, i| {
                let at = (i as f64 * 0.618).fract();
                let value = f(stratified(number, &scrambles[i], uniform(&mut rng)), at);
                total += value;
                value
            });
            let law = Law::of(&history, &(0..64), STRATIFIED).expect("there are enough");
            assert!(gains.contains(&law.gain), "{run}: {}", law.gain);
            seen.push((total / 64.0, law.variance(&(0..64)), law.variance(&(0..65))));
        }
        let mean = seen.iter().map(|(total, _, _)| total).sum::<f64>() / 12.0;
        let scatter = seen.iter().map(|(total, _, _)| (total - mean) * (total - mean)).sum::<f64>() / 11.0;
        let told = seen.iter().map(|(_, v, _)| v).sum::<f64>() / 12.0;
        // The scatter's square is uncertain by √(2/11), two fifths.
        assert!((0.4..3.5).contains(&(told / scatter)), "{told} {scatter}");
        // A sample more than a power of two spoils the mean rather than mending it.
        assert!(seen.iter().all(|(_, whole, more)| more > whole));
    }
}

/// One square holds nearly all noise: nothing is read from its few differences.
#[test]
fn heavy_tails_are_no_stratification() {
    let mut rng = Pcg32::new(0, 1);
    for _ in 0..50 {
        let history = history(16, Correlation::NONE, 0..64, |_, i| {
            if i == 77 && uniform(&mut rng) < 0.1 { 1e4 * uniform(&mut rng) } else { uniform(&mut rng) }
        });
        let law = Law::of(&history, &(0..64), STRATIFIED).expect("there are enough");
        assert!(law.gain == 2.0 && law.uncertainty > 0.35, "{law:?}");
    }
}

/// Errors that all pixels share are seen in the image's mean alone.
#[test]
fn what_all_squares_share_comes_to_it() {
    let mut rng = Pcg32::new(0, 1);
    let spread = Correlation { edge: 1, gain: 1.5 };
    let (mut of, runs) = ([0.0; 2], 40);
    for _ in 0..runs {
        for (shared, sum) in [0.0, 1.0].into_iter().zip(&mut of) {
            let (mut number_of, mut all) = (u64::MAX, 0.0);
            let history = history(16, spread, 0..128, |number, _| {
                if number != number_of {
                    (number_of, all) = (number, shared * uniform(&mut rng));
                }
                all + uniform(&mut rng)
            });
            let law = Law::of(&history, &(0..128), Known { stratified: true, correlation: 1.5 })
                .expect("there are enough");
            *sum += law.variance(&(0..128)) * 128.0 * 12.0 / f64::from(runs);
        }
    }
    // 256 pixels alone, times what they are said to have in common; and 256² besides.
    assert!((of[0] / (1.5 * 256.0) - 1.0).abs() < 0.1, "{of:?}");
    assert!((of[1] / (256.0 * 257.0) - 1.0).abs() < 0.2, "{of:?}");
}

#[test]
fn pieces_of_a_sequence_are_worse_than_the_whole() {
    let of = Law { samples: 64, of_sum: 1.0, gain: 3.0, loss: 5.0, gain_deviation: 0.1, uncertainty: 0.01 };
    let expected = [
        (0..64, 1.0),
        (0..256, 1.0 / 9.0),
        (0..16, 25.0),
        (0..96, 4.0 / 9.0 + 5.0 / 9.0),
        (64..128, 1.0),
        (0..192, 4.0 / 9.0 / 3.0 + 1.0 / 9.0 / 3.0 * 5.0),
        (0..24, 25.0 * (4.0 / 9.0 + 5.0 / 9.0)),
        // 16 and 64, each after a multiple of itself.
        (48..128, 25.0 / 25.0 + 16.0 / 25.0),
    ];
    for (samples, variance) in expected {
        assert!(
            (of.variance(&samples) / variance - 1.0).abs() < 1e-12,
            "{samples:?}: {}",
            of.variance(&samples)
        );
    }
    assert_eq!(of.uncertainty_after(64), 0.01);
    assert!((of.uncertainty_after(200) - 0.05).abs() < 1e-12);
}

#[test]
fn few_samples_tell_nothing_and_no_noise_is_none() {
    let none = history(4, Correlation::NONE, 0..4, |_, _| 1.0);
    assert_eq!(Law::of(&none, &(0..4), STRATIFIED), None);
    assert_eq!(Law::of(&none, &(0..0), STRATIFIED), None);
    let even = history(4, Correlation::NONE, 0..64, |_, _| 1.0);
    let law = Law::of(&even, &(0..64), STRATIFIED).expect("there are enough");
    assert_eq!((law.variance(&(0..64)), law.uncertainty_after(4096)), (0.0, 0.0));
    let lost =
        history(4, Correlation::NONE, 0..64, |number, i| if (number, i) == (9, 2) { f64::NAN } else { 1.0 });
    assert!(Law::of(&lost, &(0..64), STRATIFIED).is_some_and(|law| law.variance(&(0..64)).is_nan()));
}
