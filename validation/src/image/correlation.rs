//! Noise that neighbouring pixels share, as one pair of images shows it: a reconstruction filter lets samples count
//! for several pixels, and their sums are noisier than independent pixels would be.

use super::pair::Pair;
use super::pixels::score;
use std::ops::Range;

/// Farthest columns and rows between pixels that share samples: filters reach two pixels to each side.
const REACH: usize = 4;

/// Least edge length in pixels of the tiles from whose mean scores are counted, so that a difference of whole regions
/// is no correlation of their noise. What is left at the end of an image belongs to its last tile.
const TILE: usize = 16;

/// Scores beyond this count as this, so that neither a firefly nor a true difference dominates.
const LARGEST: f64 = 3.0;

/// Standard errors, of one over the root of the number of pixels, beyond which a correlation is no chance.
const SIGNIFICANT: f64 = 4.0;

/// Sums over pairs of pixels within tiles, by the columns and rows between the two.
pub(super) struct Correlation {
    /// Number of pixels with a score.
    pixels: f64,
    /// Number of tiles that have any.
    tiles: f64,
    lags: [[Lag; REACH + 1]; REACH + 1],
}

/// Pairs of pixels that lie so many columns and rows apart, in whichever direction.
#[derive(Clone, Copy, Default)]
struct Lag {
    pairs: f64,
    /// Of the z-scores, less their mean over the tile.
    products: f64,
}

impl Lag {
    fn mean(&self) -> f64 {
        if self.pairs > 0.0 { self.products / self.pairs } else { 0.0 }
    }
}

impl Correlation {
    /// b being typically `ratio` times as noisy as a.
    pub fn of(pair: &Pair, ratio: Option<f64>) -> Self {
        let mut found = Self { pixels: 0.0, tiles: 0.0, lags: Default::default() };
        for (rows, columns) in
            parts(pair.height).flat_map(|rows| parts(pair.width).map(move |columns| (rows.clone(), columns)))
        {
            let clamped =
                |x: usize, y: usize| score(pair.pixel(x, y), ratio).map(|z| z.clamp(-LARGEST, LARGEST));
            let row = |y: usize| columns.clone().map(|x| clamped(x, y)).collect();
            found.add(rows.map(row).collect());
        }
        found
    }

    fn add(&mut self, mut tile: Vec<Vec<Option<f64>>>) {
        let scores = || tile.iter().flatten().flatten();
        let count = scores().count() as f64;
        let mean = scores().sum::<f64>() / count;
        tile.iter_mut().flatten().flatten().for_each(|z| *z -= mean);
        self.pixels += count;
        self.tiles += f64::from(u8::from(count > 0.0));
        let at = |x: usize, y: usize| *tile.get(y)?.get(x)?;
        for (y, x) in (0..tile.len()).flat_map(|y| (0..tile[y].len()).map(move |x| (y, x))) {
            let Some(here) = at(x, y) else { continue };
            for (down, right) in (0..=REACH).flat_map(|down| (0..=REACH).map(move |right| (down, right))) {
                let below = at(x + right, y + down);
                let above = if down > 0 && right > 0 && down <= y { at(x + right, y - down) } else { None };
                for there in [below, above].into_iter().flatten() {
                    let lag = &mut self.lags[down][right];
                    (lag.pairs, lag.products) = (lag.pairs + 1.0, lag.products + here * there);
                }
            }
        }
    }

    /// The mean correlation of neighbours in rows and columns; 0 without noise.
    pub fn of_neighbours(&self) -> f64 {
        let all = self.lags[0][0].mean();
        if all > 0.0 { 0.5 * (self.lags[0][1].mean() + self.lags[1][0].mean()) / all } else { 0.0 }
    }

    /// F, the variance of the mean of many pixels over that of independent ones: the sum of the correlations of a
    /// pixel with all K around it and itself, at least 1; and 1 if those of neighbours are not significant, or
    /// tiles too small to tell.
    ///
    /// Scores of a tile of n pixels lack their mean, whose variance is F/n of theirs. So a correlation ρ is seen as
    /// (ρ − F/n)/(1 − F/n), and the sum M of those that are seen is (F − K F/n)/(1 − F/n).
    pub fn shared_noise(&self) -> f64 {
        const K: f64 = ((2 * REACH + 1) * (2 * REACH + 1)) as f64;
        let n = self.pixels / self.tiles;
        if self.of_neighbours() * self.pixels.sqrt() <= SIGNIFICANT || n < 2.0 * K {
            return 1.0;
        }
        let all = self.lags[0][0].mean();
        let times =
            |down: usize, right: usize| f64::from([1, 2, 4][usize::from(down > 0) + usize::from(right > 0)]);
        let places = (0..=REACH).flat_map(|down| (0..=REACH).map(move |right| (down, right)));
        let seen: f64 =
            places.map(|(down, right)| times(down, right) * self.lags[down][right].mean() / all).sum();
        (seen / (1.0 - (K - seen) / n)).max(1.0)
    }
}

/// The rows or columns of tiles.
fn parts(extent: usize) -> impl Iterator<Item = Range<usize>> {
    let count = (extent / TILE).max(1);
    (0..count).map(move |part| part * TILE..if part + 1 < count { (part + 1) * TILE } else { extent })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::{Noise, filtered, grey, render};

    fn of(a: &crate::image::Image, b: &crate::image::Image) -> Correlation {
        Correlation::of(&Pair::all(a, b).0[0], None)
    }

    #[test]
    fn noise_that_a_filter_shares_is_measured() {
        for weights in [&[0.25, 0.5, 0.25][..], &[0.1, 0.2, 0.4, 0.2, 0.1]] {
            let image = |number| filtered(96, &[1.0; 96 * 96], weights, "correlation", number);
            let found = of(&image(0), &image(1)).shared_noise();
            // In either direction the square of the sum of the weights, over the sum of their squares.
            let along = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
            let expected = along * along;
            assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
        }
    }

    #[test]
    fn the_ends_of_images_belong_to_their_last_tiles() {
        const PAIRS: u64 = 32;
        for [width, height] in [[20, 20], [36, 36], [17, 64]] {
            let scene = vec![1.0; width * height];
            let image = |number| filtered(width, &scene, &[0.25, 0.5, 0.25], "ends", number);
            let factor = |pair: u64| of(&image(2 * pair), &image(2 * pair + 1)).shared_noise();
            let mean = (0..PAIRS).map(factor).sum::<f64>() / PAIRS as f64;
            assert!((mean / (64.0 / 9.0) - 1.0).abs() < 0.3, "{width} × {height}: {mean}");
        }
        assert_eq!(parts(47).collect::<Vec<_>>(), [0..16, 16..47]);
        assert!(parts(5).eq(std::iter::once(0..5)));
    }

    #[test]
    fn independent_noise_and_a_brighter_half_share_none() {
        let mut b = render(64, &[1.0; 64 * 64], Noise::Exponential, 64, "shares none", 1);
        let a = render(64, &[1.0; 64 * 64], Noise::Exponential, 64, "shares none", 0);
        assert_eq!(of(&a, &b).shared_noise(), 1.0);
        for (index, value) in b.channels[0].mean.iter_mut().enumerate() {
            *value += if index % 64 < 32 { 0.1 } else { 0.0 };
        }
        assert_eq!(of(&a, &b).shared_noise(), 1.0);
        let exact = grey(8, &[1.0; 64], 0.0);
        assert_eq!((of(&exact, &exact).of_neighbours(), of(&exact, &exact).shared_noise()), (0.0, 1.0));
    }
}
