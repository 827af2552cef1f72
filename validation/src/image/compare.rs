//! The whole comparison: how the level is divided among tests, and how findings are summarised in one
//! sentence.

use serde::Serialize;

use super::{
    DetailComparison, Errors, Faults, Image, ImageError, MeanComparison, PixelFigures, TileComparison,
    detail, errors,
    maps::comparable,
    mean::{self, NoiseOf},
    pair::Pair,
    pixels, tiles,
};
use crate::{
    report::Outcome,
    statistics::{Verdict, least_of, multiplicity::smallest_of, sidak, worst_of},
};

/// Level and margins of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Probability with which two images of the same scene may be called different.
    pub level: f64,
    /// The ratio of the means must lie within 1 ± `margin`.
    pub margin: f64,
    /// A tile's difference within this margin, relative to the larger of its and the image's mean, counts as
    /// none even if it is significant; so does one of pixels, relative to the image's mean.
    pub tile_margin: f64,
    /// Whether a tile too noisy to decide makes the whole comparison inconclusive. If not, it suffices that
    /// no tile differs significantly.
    pub tiles_settled: bool,
    /// Pixels along a tile's side.
    pub tile_size: usize,
    /// Largest relative difference of noiseless pixels that counts as none.
    pub rounding: f64,
}

impl Settings {
    /// The default with another margin of the mean, and 8 times that for tiles: in an image of 8×8 tiles a
    /// tile's mean has 8 times the standard error of the whole, so one sample count decides both.
    pub fn with_margin(margin: f64) -> Self {
        // Four units in the last place of an f32.
        let rounding = 4.0 * 0.5 * f64::from(f32::EPSILON);
        Self { level: 0.01, margin, tile_margin: 8.0 * margin, tiles_settled: true, tile_size: 16, rounding }
    }

    /// The same settings, but no tile may differ significantly and by more than the margin of the mean; a
    /// tile too noisy to decide is accepted.
    pub fn with_tiles_within_noise(self) -> Self {
        Self { tile_margin: self.margin, tiles_settled: false, ..self }
    }
}

impl Default for Settings {
    /// Level 1 %, mean within 0.25 %, tiles of 16×16 within 2 %.
    fn default() -> Self {
        Self::with_margin(0.0025)
    }
}

/// The results for one channel.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelComparison {
    pub name: String,
    pub mean: MeanComparison,
    pub detail: DetailComparison,
    pub pixels: PixelFigures,
    pub errors: Errors,
}

/// The results for two images.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    pub verdict: Verdict,
    /// One sentence that gives the reason for the verdict, and the place of a difference.
    pub message: String,
    /// p-value of "both are unbiased images of the same scene", to be compared with the level.
    pub p_value: f64,
    /// Factor by which more samples, on both sides, would decide an inconclusive comparison with 90 % power;
    /// absent if samples would not help.
    pub more_samples: Option<f64>,
    /// Whether the compared values are identical bit for bit: one image, not two independent ones.
    pub identical: bool,
    pub faults: Faults,
    pub channels: Vec<ChannelComparison>,
    pub tiles: TileComparison,
    /// Channels that only one image has. They are not compared, and images that have any are not equivalent.
    pub uncompared: Vec<String>,
    pub settings: Settings,
}

/// Compares `b` with the reference `a`, on all channels they share.
///
/// A third of the level goes to the means (shared by channels), one to the tiles, one to finer detail.
/// Different if any of them rejects and the difference is not inside its margin, or if [`Faults`] contains a
/// failure; equivalent if all intervals of means and tiles lie inside their margins, or the values are
/// identical, and both have the same channels; else inconclusive. Detail that noise may hide is no obstacle;
/// [`DetailComparison::rms_bound`] says how much. Errors: different sizes, no common channel.
pub fn compare(a: &Image, b: &Image, settings: &Settings) -> Result<Comparison, ImageError> {
    let (pairs, uncompared) = comparable(a, b)?;
    let faults = Faults::find(&pairs, settings.rounding);
    let third = sidak(settings.level, 3);
    let each = sidak(third, pairs.len());
    let (level, margin, tile_size) = (settings.level, settings.tile_margin, settings.tile_size.max(1));
    let limits = detail::Limits { level, corrected: sidak(each, 2), margin, tile_size };
    let of_means = mean::Limits { level, corrected: each, margin: settings.margin, channels: pairs.len() };
    let channel = |pair: &Pair| {
        let ratio = tiles::noise_ratio_of(pair, tile_size);
        let pixels = pixels::figures(pair, ratio);
        let noise = NoiseOf { ratio, shared: pixels.shared_noise };
        let found = ChannelComparison {
            name: pair.name.to_string(),
            mean: mean::compare(pair, noise, of_means),
            detail: detail::compare(pair, ratio, limits),
            pixels,
            errors: errors::errors(pair),
        };
        (found, noise)
    };
    let (channels, noise): (Vec<ChannelComparison>, Vec<NoiseOf>) = pairs.iter().map(channel).unzip();
    let tiles = tiles::compare(&pairs, &noise, settings, third);
    let means = channels.iter().map(|channel| channel.mean.p_value).fold(1.0, least_of);
    let details = channels.iter().flat_map(|channel| [channel.detail.p_value, channel.detail.worst_p_value]);
    let p_values = [
        smallest_of(means, channels.len()),
        smallest_of(tiles.smallest_p_value, tiles.tested),
        smallest_of(details.fold(1.0, least_of), 2 * channels.len()),
    ];
    let identical = pairs.iter().all(|pair| pair.pixels().all(|(_, _, pixel)| pixel.a == pixel.b));
    let mut comparison = Comparison {
        verdict: Verdict::Inconclusive,
        message: String::new(),
        p_value: smallest_of(p_values.into_iter().fold(1.0, least_of), 3),
        more_samples: None,
        identical,
        faults,
        channels,
        tiles,
        uncompared,
        settings: settings.clone(),
    };
    (comparison.verdict, comparison.message) = comparison.incomplete(comparison.conclude());
    let could_be_told = comparison.faults.unknown_variance.is_empty() && comparison.uncompared.is_empty();
    if comparison.verdict == Verdict::Inconclusive && could_be_told {
        let means = comparison.channels.iter().filter_map(|channel| channel.mean.more_samples);
        comparison.more_samples = means.chain(comparison.tiles.more_samples).reduce(f64::max);
        if let Some(factor) = comparison.more_samples {
            comparison.message.push_str(&format!("; about {factor:.0} times more samples would tell"));
        }
    }
    Ok(comparison)
}

impl Comparison {
    fn conclude(&self) -> (Verdict, String) {
        let more = |count: usize| if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
        let Faults { not_finite, exact_but_different: exact, .. } = &self.faults;
        let flaw = not_finite
            .first()
            .map(|flaw| format!("{} at {}{}", flaw.what, flaw.place, more(not_finite.len())));
        let exact = || {
            exact
                .first()
                .map(|place| format!("both are noiseless and differ at {place}{}", more(exact.len())))
        };
        flaw.or_else(exact)
            .map(|message| (Verdict::Different, message))
            .or_else(|| self.identical.then(|| (Verdict::Equivalent, "identical bit for bit".to_string())))
            .or_else(|| self.different())
            .unwrap_or_else(|| self.undecided())
    }

    fn different(&self) -> Option<(Verdict, String)> {
        let means = self.channels.iter().filter(|channel| channel.mean.verdict == Verdict::Different);
        let mean = means.min_by(|a, b| a.mean.p_value.total_cmp(&b.mean.p_value)).map(describe_mean);
        let tile = self.tiles.different.first().map(|worst| match self.tiles.different.len() {
            1 => worst.to_string(),
            count => format!("{count} tiles, the worst {worst}"),
        });
        let details = self.channels.iter().filter(|channel| channel.detail.different);
        let detail = details.max_by(|a, b| a.detail.rms.total_cmp(&b.detail.rms)).map(describe_detail);
        let findings: Vec<String> = mean.into_iter().chain(tile).chain(detail).collect();
        (!findings.is_empty()).then(|| (Verdict::Different, findings.join("; ")))
    }

    fn undecided(&self) -> (Verdict, String) {
        if let Some(place) = self.faults.unknown_variance.first() {
            let count = self.faults.unknown_variance.len();
            let message = format!(
                "{count} values differ that have no noise, or of which none is known, the first at {place}"
            );
            return (Verdict::Inconclusive, message);
        }
        let means = Verdict::all(self.channels.iter().map(|channel| channel.mean.verdict));
        let open = self.channels.iter().find(|channel| channel.mean.verdict != Verdict::Equivalent);
        let message = match (open, self.tiles.verdict) {
            (Some(channel), _) => describe_mean(channel),
            (None, Verdict::Equivalent) if !self.settings.tiles_settled => {
                format!("means within {}%, no tile beyond its noise", percent(self.settings.margin))
            }
            (None, Verdict::Equivalent) => {
                format!(
                    "means within {}%, all tiles within {}%",
                    percent(self.settings.margin),
                    percent(self.settings.tile_margin)
                )
            }
            (None, _) => {
                format!("means agree, but tiles are noisier than {}%", percent(self.settings.tile_margin))
            }
        };
        (Verdict::all([means, self.tiles.verdict]), message)
    }

    /// Adds the channels that only one image has to the message, and downgrades equivalence to inconclusive
    /// because of them.
    fn incomplete(&self, (verdict, message): (Verdict, String)) -> (Verdict, String) {
        if self.uncompared.is_empty() {
            return (verdict, message);
        }
        let alone = format!("only one image has {}", self.uncompared.join(", "));
        match verdict {
            Verdict::Equivalent => (Verdict::Inconclusive, format!("{alone}; else {message}")),
            _ => (verdict, format!("{message}; {alone}")),
        }
    }

    /// The comparison as an [`Outcome`] of the check `images`.
    pub fn outcome(&self) -> Outcome {
        let mut outcome = Outcome::new("images", self.verdict, &self.message).p_value(self.p_value);
        let detectable = self.channels.iter().map(|channel| channel.mean.detectable).fold(0.0, worst_of);
        outcome.detectable = Some(detectable);
        outcome.figures.extend(self.more_samples.map(|factor| ("more_samples".to_string(), factor)));
        for channel in &self.channels {
            outcome.figures.insert(format!("ratio.{}", channel.name), channel.mean.ratio);
            outcome.figures.insert(format!("relative_mse.{}", channel.name), channel.errors.relative_mse);
        }
        outcome
    }
}

fn percent(share: f64) -> f64 {
    100.0 * share
}

fn describe_detail(channel: &ChannelComparison) -> String {
    let DetailComparison { rms, worst, single, .. } = &channel.detail;
    let worst = worst.as_ref().map(|(place, z)| format!("{place}, {z:.0} standard errors"));
    let worst = worst.unwrap_or_default();
    if *single {
        return format!("one pixel at least is not the same: {worst}");
    }
    format!(
        "pixels of channel {} differ by {:.3} % of the mean more than noise explains (rms), the worst {worst}",
        channel.name,
        percent(*rms)
    )
}

fn describe_mean(channel: &ChannelComparison) -> String {
    let mean = &channel.mean;
    let (ratio, low, high) = (percent(mean.ratio), percent(mean.interval.low), percent(mean.interval.high));
    format!("mean of channel {}: {ratio:.3} % of the reference ({low:.3} to {high:.3} %)", channel.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channel;

    #[test]
    fn without_variances_values_within_rounding_are_the_same() {
        let image = |mean: Vec<f64>| Image {
            width: 32,
            height: 32,
            channels: vec![Channel { name: "Y".into(), mean, variance: None }],
        };
        let halves = |left: f64, right: f64| {
            image((0..1024).map(|i| if i % 32 < 16 { left } else { right }).collect())
        };
        let verdict =
            |other: Image| compare(&halves(1.0, 2.0), &other, &Settings::default()).unwrap().verdict;
        assert_eq!(verdict(halves(1.0, 2.0)), Verdict::Equivalent);
        assert_eq!(verdict(halves(1.0 + f64::from(f32::EPSILON), 2.0)), Verdict::Equivalent);
        // What noise they have is not known.
        assert_eq!(verdict(halves(1.001, 2.0)), Verdict::Inconclusive);
        assert_eq!(verdict(halves(2.0, 1.0)), Verdict::Inconclusive);
        assert_eq!(verdict(halves(f64::NAN, 2.0)), Verdict::Different);
    }
}
