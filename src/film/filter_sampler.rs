//! Filters sampled instead of splatted: every camera sample belongs to one pixel, and its place is drawn from
//! that pixel's filter (Ernst, Stamminger & Greiner 2006).

use super::filter::Profile;

/// Bins to a pixel; pixel borders fall on bin borders.
pub(super) const BINS: i32 = 32;

/// A table to sample one axis of a filter in proportion to its absolute value.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    profile: Profile,
    /// Half the number of bins.
    half: i32,
    /// Running sums of |f| over the bins, from −radius, to sample.
    absolute: Vec<f64>,
    /// Running sums of f over the bins, from −radius, to normalise.
    signed: Vec<f64>,
    /// For as many equal parts of ∫|f| as there are bins, the bin in which each begins, about.
    guide: Vec<u32>,
    /// f within each bin.
    pieces: Vec<Piece>,
    /// Where numbers lead to within each bin.
    bends: Vec<Bend>,
}

impl FilterSampler {
    /// Tables from which to sample a filter.
    pub fn new(profile: Profile) -> Self {
        let half = (profile.radius() * BINS as f64).ceil() as i32;
        let (mut absolute, mut signed) = (vec![0.0], vec![0.0]);
        let (mut a, mut s) = (0.0, 0.0);
        for bin in -half..half {
            let integral = |g: &dyn Fn(f64) -> f64| {
                let (lo, hi) = (bin as f64 / BINS as f64, (bin + 1) as f64 / BINS as f64);
                crate::math::quadrature::integrate_from_kink(lo, hi, g)
            };
            a += integral(&|x| profile.eval(x).abs());
            s += integral(&|x| profile.eval(x));
            absolute.push(a);
            signed.push(s);
        }
        let bins = 2 * half as usize;
        let begin = |part: usize| absolute.partition_point(|&c| c <= part as f64 / bins as f64 * a);
        let guide = (0..bins).map(|part| begin(part).saturating_sub(1) as u32).collect();
        let pieces = (-half..half).map(|bin| Piece::new(profile, bin)).collect();
        let bend = |(bin, sums): (i32, &[f64])| Bend::new(profile, bin, sums[1] - sums[0]);
        let bends = (-half..half).zip(absolute.windows(2)).map(bend).collect();
        Self { profile, half, absolute, signed, guide, pieces, bends }
    }

    /// The filter that is sampled.
    pub fn profile(&self) -> Profile {
        self.profile
    }

    /// Whether on a film of so many pixels in a row the weights of a pixel's samples nearly cancel, so that
    /// no mean can be made of them.
    pub fn cancels(&self, count: u32) -> bool {
        const NOTHING: f64 = 1.0 / 1024.0;
        // More pixels on either side change nothing.
        let count = count.min(2 * self.profile.radius().ceil() as u32 + 1);
        self.profile != Profile::Box
            && (0..count).any(|before| {
                let (first, last) = self.bins(before, count - 1 - before);
                let sum = |of: &[f64]| of[last] - of[first];
                sum(&self.signed).abs() < NOTHING * sum(&self.absolute)
            })
    }

    /// A place on the axis, relative to the pixel's centre, and its weight: f / (pdf ∫f).
    ///
    /// `before` and `after` are how many further pixels the film has on each side: as in Mitsuba the filter
    /// ends at the film, and the pixel is the average over what is left of it.
    #[inline]
    pub fn sample(&self, u: f64, before: u32, after: u32) -> (f64, f64) {
        if self.profile == Profile::Box {
            return (u - 0.5, 1.0);
        }
        let (first, last) = self.bins(before, after);
        let (lo, hi) = (self.absolute[first], self.absolute[last]);
        let target = lo + u * (hi - lo);
        let bin = self.bin_at(target, first, last);
        let width = self.absolute[bin + 1] - self.absolute[bin];
        let (within, stretch) = self.bends[bin].at(((target - self.absolute[bin]) / width).clamp(0.0, 1.0));
        let x = (bin as f64 + within - self.half as f64) / BINS as f64;
        let value = self.pieces[bin].eval(within).unwrap_or_else(|| self.profile.eval(x)) * stretch;
        // 1/pdf = (hi − lo)·stretch/(BINS·width).
        (x, value * (hi - lo) / (BINS as f64 * width * (self.signed[last] - self.signed[first])))
    }

    /// The bin among `first..last` that a value of ∫|f| falls into: the first after which there is more.
    #[inline(always)]
    fn bin_at(&self, target: f64, first: usize, last: usize) -> usize {
        let parts = self.guide.len();
        let part = (target / self.absolute[parts] * parts as f64) as usize;
        let mut bin = (self.guide[part.min(parts - 1)] as usize).clamp(first, last - 1);
        while bin > first && self.absolute[bin] > target {
            bin -= 1;
        }
        while bin + 1 < last && self.absolute[bin + 1] <= target {
            bin += 1;
        }
        bin
    }

    /// The range of bins that is left to a pixel with so many others before and after it: the first, and the
    /// one after the last.
    #[inline]
    fn bins(&self, before: u32, after: u32) -> (usize, usize) {
        let bin_at = |pixels: u32| (pixels.min(1 << 16) as i32 * BINS + BINS / 2).min(self.half);
        ((self.half - bin_at(before)) as usize, (self.half + bin_at(after)) as usize)
    }

    /// ∫f over what is left to a pixel with so many others before and after it.
    pub fn integral(&self, before: u32, after: u32) -> f64 {
        let (first, last) = self.bins(before, after);
        self.signed[last] - self.signed[first]
    }

    /// The inverse of [`Self::sample`]: one of `count` pixels in a row, the first of which begins at 0, for
    /// light that falls on `x`; and its weight f/∫f over the probability of the choice, which is in
    /// proportion to that of |f|/∫f. `limits` gives how many pixels the film has before and after one.
    pub fn pixel_at(
        &self,
        x: f64,
        u: f64,
        count: u32,
        limits: impl Fn(u32) -> (u32, u32),
    ) -> Option<(u32, f64)> {
        let radius = self.profile.radius();
        let first = (x - 0.5 - radius).ceil().max(0.0) as u32;
        let end = ((x + 0.5 + radius).floor().max(0.0) as u32).min(count);
        if self.profile == Profile::Box {
            return (x >= 0.0 && x < f64::from(count)).then_some((x as u32, 1.0));
        }
        let value = |pixel: u32| {
            let (before, after) = limits(pixel);
            let offset = x - 0.5 - f64::from(pixel);
            if offset < -f64::from(before) - 0.5 || offset >= f64::from(after) + 0.5 {
                return 0.0;
            }
            self.profile.eval(offset) / self.integral(before, after)
        };
        let total: f64 = (first..end).map(|pixel| value(pixel).abs()).sum();
        let mut rest = u * total;
        let mut last = None;
        for (pixel, value) in
            (first..end).map(|pixel| (pixel, value(pixel))).filter(|(_, value)| *value != 0.0)
        {
            last = Some((pixel, total.copysign(value)));
            if rest < value.abs() {
                break;
            }
            rest -= value.abs();
        }
        last
    }
}

/// The way from a number in [0, 1] to a place in a bin, as a fraction of it: the cubic that begins and ends as steeply
/// as places in proportion to |f| do. So weights are nearly the same all over the bin, and it is left at neither end.
#[derive(Clone, Copy, Debug)]
struct Bend([f64; 3]);

impl Bend {
    /// For a bin with this share of ∫|f|.
    fn new(profile: Profile, bin: i32, share: f64) -> Self {
        let mean = share * f64::from(BINS);
        // Up to a slope of 3 at either end it never turns back (Fritsch & Carlson 1980).
        let slope = |at: i32| (mean / profile.eval(f64::from(at) / f64::from(BINS)).abs()).min(3.0);
        match [slope(bin), slope(bin + 1)] {
            [a, b] if (a + b).is_finite() => Self([a, 3.0 - 2.0 * a - b, a + b - 2.0]),
            _ => Self([1.0, 0.0, 0.0]),
        }
    }

    /// The place of a number, and the derivative.
    #[inline(always)]
    fn at(&self, u: f64) -> (f64, f64) {
        let Self([a, b, c]) = *self;
        ((u * (a + u * (b + u * c))).min(1.0), a + u * (2.0 * b + u * (3.0 * c)))
    }
}

/// A filter within a bin as a polynomial, which costs a tenth of an exponential function; through five
/// Chebyshev points, in Newton's form.
#[derive(Clone, Copy, Debug)]
struct Piece(Option<[f64; NODES.len()]>);

/// ½ − ½ cos((2k + 1)π/10).
const NODES: [f64; 5] =
    [0.024_471_741_852_423_2, 0.206_107_373_853_763_5, 0.5, 0.793_892_626_146_236_5, 0.975_528_258_147_576_8];

impl Piece {
    /// Largest error of a piece, relative to the filter's value in the middle of its pixel: far less than
    /// `f32` resolves.
    const TOLERANCE: f64 = 1e-9;

    /// No polynomial where none comes near enough, as at the foot of a filter that ends within the bin.
    fn new(profile: Profile, bin: i32) -> Self {
        let f = |t: f64| profile.eval((f64::from(bin) + t) / f64::from(BINS));
        // Divided differences, in place.
        let mut c = NODES.map(f);
        for order in 1..NODES.len() {
            for i in (order..NODES.len()).rev() {
                c[i] = (c[i] - c[i - 1]) / (NODES[i] - NODES[i - order]);
            }
        }
        let most = Self::TOLERANCE * profile.eval(0.0).abs();
        const CHECKS: u32 = 64;
        let mut places = (0..=CHECKS).map(|i| f64::from(i) / f64::from(CHECKS));
        let near = places.all(|t| (Self(Some(c)).eval(t).unwrap_or(f64::NAN) - f(t)).abs() <= most);
        Self(near.then_some(c))
    }

    /// The filter's value at a fraction `t` of the bin.
    #[inline(always)]
    fn eval(&self, t: f64) -> Option<f64> {
        let [c0, c1, c2, c3, c4] = self.0?;
        let [t0, t1, t2, t3, _] = NODES;
        Some((((c4 * (t - t3) + c3) * (t - t2) + c2) * (t - t1) + c1) * (t - t0) + c0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::filter::ALL;
    use super::*;

    #[test]
    fn weights_average_one_and_moments_are_those_of_the_filter() {
        for profile in ALL {
            let sampler = FilterSampler::new(profile);
            for (before, after) in [(100, 100), (0, 100), (1, 0), (0, 0)] {
                let (lo, hi) = (-(before as f64) - 0.5, after as f64 + 0.5);
                let (lo, hi) = (lo.max(-profile.radius()), hi.min(profile.radius()));
                let steps = 200_000;
                let (mut norm, mut first) = (0.0, 0.0);
                for i in 0..steps {
                    let x = lo + (hi - lo) * (i as f64 + 0.5) / steps as f64;
                    norm += profile.eval(x);
                    first += profile.eval(x) * x;
                }
                let n = 100_000;
                let (mut weight, mut moment) = (0.0, 0.0);
                for i in 0..n {
                    let (x, w) = sampler.sample((i as f64 + 0.5) / n as f64, before, after);
                    assert!(x >= lo - 1e-12 && x <= hi + 1e-12, "{profile:?} {x}");
                    weight += w / n as f64;
                    moment += w * x / n as f64;
                }
                assert!((weight - 1.0).abs() < 1e-4, "{profile:?} {before} {after} {weight}");
                assert!((moment - first / norm).abs() < 1e-4, "{profile:?} {before} {after}");
            }
        }
    }

    #[test]
    fn light_is_spread_as_pixels_gather_it() {
        for profile in ALL {
            let sampler = FilterSampler::new(profile);
            for border in [false, true] {
                let limits = |p: u32| if border { (100, 100) } else { (p, 4 - p) };
                for place in [0.01, 0.49, 2.5, 3.2, 4.99] {
                    const N: u32 = 100_000;
                    let mut found = [0.0; 5];
                    for i in 0..N {
                        let u = (f64::from(i) + 0.5) / f64::from(N);
                        if let Some((pixel, weight)) = sampler.pixel_at(place, u, 5, limits) {
                            found[pixel as usize] += weight / f64::from(N);
                        }
                    }
                    for (pixel, found) in found.into_iter().enumerate() {
                        let (before, after) = limits(pixel as u32);
                        let offset = place - 0.5 - pixel as f64;
                        let steps = 20_000;
                        let (lo, hi) = (
                            (-f64::from(before) - 0.5).max(-profile.radius()),
                            (f64::from(after) + 0.5).min(profile.radius()),
                        );
                        let norm: f64 = (0..steps)
                            .map(|i| profile.eval(lo + (hi - lo) * (f64::from(i) + 0.5) / f64::from(steps)))
                            .sum();
                        let expected = profile.eval(offset) * f64::from(steps) / (norm * (hi - lo));
                        // The choice is resolved to 1/N of weights below 3; the midpoint rule to better.
                        assert!(
                            (found - expected).abs() < 1e-4,
                            "{profile:?} {place} {pixel}: {found} for {expected}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn weights_are_those_of_the_profile() {
        for profile in
            [ALL.as_slice(), &[Profile::Tent { radius: 0.77 }, Profile::Gaussian { deviation: 0.03 }]]
                .concat()
        {
            let sampler = FilterSampler::new(profile);
            let norm = sampler.signed[sampler.guide.len()];
            for i in 0..10_000 {
                const STEP: f64 = 1e-7;
                let u = (f64::from(i) + 0.5) / 10_000.0;
                let (x, weight) = sampler.sample(u, 100, 100);
                if profile == Profile::Box {
                    assert_eq!((x, weight), (u - 0.5, 1.0));
                    continue;
                }
                let [before, after] = [-STEP, STEP].map(|step| sampler.sample(u + step, 100, 100).0);
                let bin = |x: f64| (x * f64::from(BINS)).floor();
                if bin(before) == bin(after) {
                    // 1/pdf = ∂x/∂u.
                    let expected = profile.eval(x) * (after - before) / (2.0 * STEP * norm);
                    assert!((weight - expected).abs() <= 1e-5, "{profile:?} {x}: {weight} for {expected}");
                }
            }
        }
    }

    /// Where a filter is nowhere negative all samples count alike, but for those at its foot.
    #[test]
    fn an_even_light_has_no_noise() {
        for (profile, most) in ALL.into_iter().zip([0.0, 0.015, 0.003, 1.0, 1.0, 1.0]) {
            let sampler = FilterSampler::new(profile);
            let weights = (0..10_000).map(|i| sampler.sample((f64::from(i) + 0.5) / 10_000.0, 100, 100).1);
            let variance = weights.map(|weight| (weight - 1.0) * (weight - 1.0)).sum::<f64>() / 10_000.0;
            assert!(variance.sqrt() <= most, "{profile:?} {}", variance.sqrt());
        }
    }

    #[test]
    fn a_filter_that_cancels_at_the_border_is_found() {
        let cancels = |profile: Profile| (1..20).any(|count| FilterSampler::new(profile).cancels(count));
        assert!(!ALL.into_iter().any(cancels));
        // The integral over a film of one pixel is linear in B, and 0 between 0 and 10.
        let narrow = |b: f64| FilterSampler::new(Profile::Mitchell { b, c: 1.0 / 3.0 });
        let sum = |b: f64| {
            let sampler = narrow(b);
            let (first, last) = sampler.bins(0, 0);
            sampler.signed[last] - sampler.signed[first]
        };
        let b = sum(0.0) / (sum(0.0) - sum(1.0));
        assert!((0.0..10.0).contains(&b) && narrow(b).cancels(1) && !narrow(0.0).cancels(1), "{b}");
    }

    #[test]
    fn common_filters_are_polynomials_almost_everywhere() {
        for profile in ALL.into_iter().filter(|profile| *profile != Profile::Box) {
            let pieces = FilterSampler::new(profile).pieces;
            let missing = pieces.iter().filter(|piece| piece.0.is_none()).count();
            assert!(missing <= 2, "{profile:?} {missing} of {}", pieces.len());
        }
    }
}
