//! Tile level: *where* two images differ.

use serde::Serialize;

use super::{
    Settings,
    correlation::Correlation,
    mean::{NoiseOf, Side, Sums},
    pair::Pair,
};
use crate::statistics::{Interval, Verdict, Welch, power::more_samples, sidak};

/// The comparison of one tile of one channel.
#[derive(Clone, Debug, Serialize)]
pub struct Tile {
    pub channel: String,
    /// Column in the grid of tiles.
    pub column: usize,
    /// Row in the grid of tiles.
    pub row: usize,
    /// Column of the first pixel.
    pub x: usize,
    /// Row of the first pixel.
    pub y: usize,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// (mean_b − mean_a) relative to the larger of the tile's and the whole image's mean, so that no
    /// invisible accuracy is required of a dark tile.
    pub difference: f64,
    /// Standard error of `difference`.
    pub standard_error: f64,
    /// Welch's signed statistic.
    pub z: f64,
    pub p_value: f64,
    pub verdict: Verdict,
}

impl std::fmt::Display for Tile {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(
            formatter,
            "tile ({}, {}) channel {} (pixels {}..{} × {}..{}): {:+.3} % ± {:.3} % of the mean of both, z = {:.1}",
            self.column,
            self.row,
            self.channel,
            self.x,
            self.x + self.width,
            self.y,
            self.y + self.height,
            100.0 * self.difference,
            100.0 * self.standard_error,
            self.z
        )
    }
}

/// The comparison of all tiles of all channels.
#[derive(Clone, Debug, Serialize)]
pub struct TileComparison {
    pub columns: usize,
    pub rows: usize,
    /// Number of tested tiles × channels: those with at least one pixel of known variance.
    pub tested: usize,
    /// The significance level of each test, corrected for their number.
    pub level: f64,
    pub smallest_p_value: f64,
    pub verdict: Verdict,
    /// The tile with the smallest p-value.
    pub worst: Option<Tile>,
    /// Every tile that differs, most significant first.
    pub different: Vec<Tile>,
    /// Factor by which more samples would decide the noisiest tile, if one is inconclusive.
    pub more_samples: Option<f64>,
}

/// A tile of one channel before its test: place and sums.
struct Raw {
    column: usize,
    row: usize,
    width: usize,
    height: usize,
    sums: Sums,
}

fn cut(pair: &Pair, size: usize) -> Vec<Raw> {
    let (columns, rows) = (pair.width.div_ceil(size), pair.height.div_ceil(size));
    let tile = |column: usize, row: usize| {
        let (x, y) = (column * size, row * size);
        let (width, height) = (size.min(pair.width - x), size.min(pair.height - y));
        let pixels = (y..y + height).flat_map(|y| (x..x + width).map(move |x| pair.pixel(x, y)));
        Raw { column, row, width, height, sums: Sums::over(pixels) }
    };
    (0..rows).flat_map(|row| (0..columns).map(move |column| tile(column, row))).collect()
}

/// The typical ratio of the noise of b to that of a, as variances, over tiles of this size; `None` without
/// noise.
///
/// Of two medians, over tiles and over pixels, the one that is farther from 1. If one image has met a rare event
/// in most of its tiles and the other in hardly one, the median over tiles is that of the rare events, which few
/// samples have not met; most pixels have not met one in either image. Over few samples the variance of a pixel
/// is a guess, and zero in pixels without light: there tiles know better.
pub(super) fn noise_ratio_of(pair: &Pair, size: usize) -> Option<f64> {
    noise_ratio(&cut(pair, size), pair)
}

fn noise_ratio(tiles: &[Raw], pair: &Pair) -> Option<f64> {
    let of_tiles = typical(tiles.iter().map(|tile| (tile.sums.a.variance, tile.sums.b.variance)))?;
    let of_pixels = typical(pair.pixels().map(|(_, _, pixel)| (pixel.variance_a, pixel.variance_b)));
    let distance = |ratio: f64| libm::fabs(libm::log(ratio));
    Some(of_pixels.filter(|ratio| distance(*ratio) > distance(of_tiles)).unwrap_or(of_tiles))
}

/// The median of the ratios of second to first variances, of those that are positive and finite.
///
/// Each counts by the noise that it is of, a standard error of which is the geometric mean of both. A background
/// that is seen directly may be most of a picture; its noise, which may be no more than rounding in one of the
/// images, tells nothing of the noise of what stands before it. What only one image has met counts little more.
fn typical(variances: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let ratios = variances.map(|(a, b)| (b / a, (a * b).sqrt().sqrt()));
    let sound = |value: f64| value.is_finite() && value > 0.0;
    let mut ratios: Vec<(f64, f64)> =
        ratios.filter(|(ratio, weight)| sound(*ratio) && sound(*weight)).collect();
    ratios.sort_by(|one, other| one.0.total_cmp(&other.0));
    let half = 0.5 * ratios.iter().map(|(_, weight)| weight).sum::<f64>();
    let up_to = ratios.iter().scan(0.0, |sum, (_, weight)| {
        *sum += weight;
        Some(*sum)
    });
    let middle = up_to.take_while(|sum| *sum < half).count();
    ratios.get(middle).map(|(ratio, _)| *ratio)
}

/// The side's variance, or what the other side's variance predicts for it if that is larger.
///
/// An image in which a rare event has not occurred yet (no caustic path in the tile) has a mean that is too
/// low *and* a variance that does not include the event; against a converged reference it would differ by
/// many of its own standard errors although nothing is wrong. The image with more information tells how large
/// the variance should be.
fn informed_by(side: Side, other: Side, ratio: f64) -> Side {
    if other.variance * ratio <= side.variance {
        return side;
    }
    let squared_variance = other.squared_variance * ratio * ratio;
    Side { mean: side.mean, variance: other.variance * ratio, squared_variance }
}

/// Both sides, informed by each other, b being `ratio` times as noisy as a.
pub(super) fn informed(a: Side, b: Side, ratio: Option<f64>) -> (Side, Side) {
    ratio.map_or((a, b), |ratio| (informed_by(a, b, 1.0 / ratio), informed_by(b, a, ratio)))
}

/// Tests every tile at the Šidák level at which all tests together have the level `corrected`; equivalent if
/// each tile's interval at the level of the settings lies within ± their margin for tiles. Equivalence of all
/// needs no correction: it is claimed only if every single test accepts (intersection–union).
///
/// `noise` is that of each pair.
pub(super) fn compare(
    pairs: &[Pair],
    noise: &[NoiseOf],
    settings: &Settings,
    corrected: f64,
) -> TileComparison {
    let size = settings.tile_size.max(1);
    let cuts: Vec<Vec<Raw>> = pairs.iter().map(|pair| cut(pair, size)).collect();
    let tested = cuts.iter().flatten().filter(|tile| tile.sums.count > 0.0).count();
    let each = sidak(corrected, tested);
    let mut tiles = Vec::new();
    for ((pair, cut), noise) in pairs.iter().zip(&cuts).zip(noise) {
        let total = Sums::over(pair.pixels().map(|(_, _, pixel)| pixel));
        let image_mean = (total.a.mean + total.b.mean).abs() / (2.0 * total.count);
        for raw in cut.iter().filter(|raw| raw.sums.count > 0.0) {
            tiles.push(test(raw, pair.name, size, image_mean, *noise, each, settings));
        }
    }
    summarise(tiles, pairs, size, each, settings)
}

/// The comparison of the means of a tile's pixels.
fn welch(sums: &Sums, noise: NoiseOf) -> Welch {
    let (a, b) = informed(sums.a, sums.b, noise.ratio);
    let estimate = |side: Side| side.estimate(sums.count, noise.shared);
    Welch::new(estimate(a), estimate(b))
}

fn test(
    raw: &Raw,
    channel: &str,
    size: usize,
    image: f64,
    noise: NoiseOf,
    each: f64,
    settings: &Settings,
) -> Tile {
    let Sums { count, a, b } = raw.sums;
    let welch = welch(&raw.sums, noise);
    let scale = image.max((a.mean + b.mean).abs() / (2.0 * count));
    let p_value = welch.p_value();
    let room = Interval::around(welch.difference, welch.half_width(settings.level));
    let verdict = if room.within(0.0, settings.tile_margin * scale) {
        Verdict::Equivalent
    } else if p_value <= each {
        Verdict::Different
    } else if settings.tiles_settled {
        Verdict::Inconclusive
    } else {
        Verdict::Equivalent
    };
    let relative = |value: f64| if value == 0.0 { 0.0 } else { value / scale };
    Tile {
        channel: channel.to_string(),
        column: raw.column,
        row: raw.row,
        x: raw.column * size,
        y: raw.row * size,
        width: raw.width,
        height: raw.height,
        difference: relative(welch.difference),
        standard_error: relative(welch.standard_error),
        z: welch.statistic(),
        p_value,
        verdict,
    }
}

fn summarise(
    tiles: Vec<Tile>,
    pairs: &[Pair],
    size: usize,
    each: f64,
    settings: &Settings,
) -> TileComparison {
    let smaller =
        |a: &&Tile, b: &&Tile| a.p_value.total_cmp(&b.p_value).then(b.z.abs().total_cmp(&a.z.abs()));
    let noisiest = tiles.iter().map(|tile| tile.standard_error).fold(0.0, f64::max);
    // Where nothing is known of the noise only values that agree leave nothing to ask.
    let agree = |pair: &Pair| pair.pixels().all(|(_, _, pixel)| pixel.agrees(settings.rounding));
    let verdict = match tiles.is_empty() && pairs.iter().all(agree) {
        true => Verdict::Equivalent,
        false => Verdict::all(tiles.iter().map(|tile| tile.verdict)),
    };
    let worst = tiles.iter().min_by(smaller).cloned();
    let open = verdict == Verdict::Inconclusive && noisiest.is_finite();
    let tested = tiles.len();
    let mut different: Vec<Tile> =
        tiles.into_iter().filter(|tile| tile.verdict == Verdict::Different).collect();
    different.sort_by(|a, b| smaller(&a, &b));
    TileComparison {
        columns: pairs.first().map_or(0, |pair| pair.width.div_ceil(size)),
        rows: pairs.first().map_or(0, |pair| pair.height.div_ceil(size)),
        tested,
        level: each,
        smallest_p_value: worst.as_ref().map_or(1.0, |tile| tile.p_value),
        verdict,
        worst,
        different,
        more_samples: open.then(|| more_samples(noisiest, settings.level, settings.tile_margin, tested)),
    }
}

/// Welch's z of each tile of `pair`, in row-major order, for drawing; NaN of one without any pixel to test.
pub(super) fn scores(pair: &Pair, size: usize) -> Vec<f64> {
    let cut = cut(pair, size);
    let ratio = noise_ratio(&cut, pair);
    let noise = NoiseOf { ratio, shared: Correlation::of(pair, ratio).shared_noise() };
    cut.iter().map(|raw| welch(&raw.sums, noise).statistic()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::grey;

    /// That of a pair whose pixels are independent.
    fn noise(pairs: &[Pair]) -> [NoiseOf; 1] {
        [NoiseOf { ratio: noise_ratio_of(&pairs[0], 16), shared: 1.0 }]
    }

    #[test]
    fn a_wrong_tile_is_found_at_its_place() {
        let (width, height) = (40, 20);
        let a = grey(width, &vec![1.0; width * height], 1e-4);
        let mut b = a.clone();
        for (x, y) in (16..20).flat_map(|y| (32..40).map(move |x| (x, y))) {
            b.channels[0].mean[y * width + x] = 1.1;
        }
        let (pairs, _) = Pair::all(&a, &b);
        let found = compare(&pairs, &noise(&pairs), &Settings::default(), 0.005);
        assert_eq!((found.columns, found.rows, found.tested), (3, 2, 6));
        assert_eq!(found.different.len(), 1);
        let tile = &found.different[0];
        assert_eq!((tile.column, tile.row, tile.x, tile.y, tile.width, tile.height), (2, 1, 32, 16, 8, 4));
        // 32 pixels of variance 1e-4 on each side: √(2·1e-4/32) = 0.0025, so 0.1 is 40 standard errors.
        assert!((tile.z - 40.0).abs() < 1e-9, "{}", tile.z);
    }

    #[test]
    fn a_missed_rare_event_is_no_difference() {
        // The reference saw the caustic in the last tile (variance 0.01 each pixel); b, with 100 times fewer
        // samples and so 100 times the variance elsewhere, missed it.
        let a = grey(64, &[vec![1.0; 64 * 15], vec![1.5; 64]].concat(), 1e-4);
        let mut a = a;
        let mut b = grey(64, &[1.0; 64 * 16], 1e-2);
        for x in 48..64 {
            a.channels[0].variance.as_mut().unwrap()[64 * 15 + x] = 0.01;
            b.channels[0].variance.as_mut().unwrap()[64 * 15 + x] = 0.0;
        }
        for x in 0..48 {
            a.channels[0].mean[64 * 15 + x] = 1.0;
        }
        let (pairs, _) = Pair::all(&a, &b);
        assert!(compare(&pairs, &noise(&pairs), &Settings::default(), 0.005).different.is_empty());
    }

    /// A backdrop that fills three quarters, whose noise is that of rounding in one image, and an object that is a fifth
    /// too dark in the other.
    #[test]
    fn a_backdrop_without_noise_hides_no_difference() {
        let (width, height) = (64, 64);
        let is_object = |i: usize| (i % width) / 32 + (i / width) / 32 == 0;
        let picture = |object: f64, backdrop_variance: f64| {
            let mut image = grey(width, &vec![1.0; width * height], backdrop_variance);
            let channel = &mut image.channels[0];
            for i in (0..width * height).filter(|i| is_object(*i)) {
                channel.mean[i] = object;
                channel.variance.as_mut().unwrap()[i] = 1e-4;
            }
            image
        };
        let reference = picture(0.5, 1e-6);
        for backdrop_variance in [1e-6, 1e-10, 1e-18, 0.0] {
            for (object, verdict) in [(0.5, Verdict::Equivalent), (0.4, Verdict::Different)] {
                let other = picture(object, backdrop_variance);
                for (a, b) in [(&reference, &other), (&other, &reference)] {
                    let (pairs, _) = Pair::all(a, b);
                    let noise = noise(&pairs);
                    assert!((noise[0].ratio.unwrap() - 1.0).abs() < 1e-9, "{backdrop_variance} {noise:?}");
                    let found = compare(&pairs, &noise, &Settings::default(), 0.005);
                    assert_eq!(found.verdict, verdict, "{backdrop_variance} {object}");
                }
            }
        }
    }

    #[test]
    fn a_picture_the_wrong_way_round_is_different_however_noisy_tiles_may_be() {
        // Bright at the top, dark at the bottom; turned upside down, the mean over all pixels is the same.
        let picture = |first: f64, second: f64, variance: f64| {
            grey(32, &[vec![first; 32 * 16], vec![second; 32 * 16]].concat(), variance)
        };
        let settings = Settings::default().with_tiles_within_noise();
        let verdict = |a, b| {
            let (pairs, _) = Pair::all(a, b);
            compare(&pairs, &noise(&pairs), &settings, 0.005).verdict
        };
        let (upright, turned) = (picture(1.5, 0.5, 0.1), picture(0.5, 1.5, 0.1));
        assert_eq!(verdict(&upright, &turned), Verdict::Different);
        // Noisier than the margin, and one standard error apart.
        let error = (2.0 * 0.1 / 256.0f64).sqrt();
        assert_eq!(verdict(&upright, &picture(1.5 + error, 0.5, 0.1)), Verdict::Equivalent);
    }
}
