//! Comparison of two noisy images of the same scene.
//!
//! [`Image`] holds means and the variances of those means; [`compare`] returns a [`Verdict`](crate::Verdict)
//! with the place and the channel of a difference. The verdict is based on three levels whose false positive
//! rates are controlled:
//!
//! - **image**: the ratio of the means of each channel, with its confidence interval against a margin
//!   (`mean.rs`);
//! - **tiles**: the difference of each 16×16 tile's mean, Šidák-corrected over tiles × channels (`tiles.rs`);
//! - **detail**: the mean square of what noise does not explain of the differences of pixels, and the worst
//!   of them (`detail.rs`).
//!
//! Scores of single pixels are *reported* (`pixels.rs`) but do not decide: a pixel's mean is far from normal
//! in the tail that a correction for 10⁶ tests requires, so a firefly would make a correct renderer fail.
//! Three conditions fail at any pixel, because they need no statistics: a value that is not finite, a
//! variance that is not a number or negative, and two noiseless values that differ.
//!
//! The noise of different pixels should be independent: use a box filter, or filter importance sampling.
//! Reconstruction filters that share samples between pixels make the variance of sums larger than the sum of
//! variances; where neighbours are significantly correlated, all sums are judged by as much larger a variance as
//! their correlation tells (`correlation.rs`). Samples that distant pixels share no comparison can see.

#[cfg(test)]
mod calibration;
mod compare;
mod correlation;
mod detail;
mod errors;
mod intervals;
mod load;
mod maps;
mod mean;
mod pair;
mod pixels;
mod shared_noise;
mod similarity;
#[cfg(test)]
mod synthetic;
mod tiles;

pub use compare::{ChannelComparison, Comparison, Settings, compare};
pub use detail::DetailComparison;
pub use errors::Errors;
pub use intervals::half_widths;
pub use load::{Loaded, from_exr, load, load_whole};
pub use maps::{difference_map, tile_map};
pub use mean::MeanComparison;
pub use pair::{Faults, Place, Unsound};
pub use pixels::PixelFigures;
pub use tiles::{Tile, TileComparison};

/// The reason why images could not be read or compared; it names the file, pixel or channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageError(pub String);

impl std::fmt::Display for ImageError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for ImageError {}

/// One channel: row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    pub name: String,
    pub mean: Vec<f64>,
    /// Variance of each pixel's mean. +∞ marks a pixel whose variance is unknown; `None` means that all are
    /// unknown.
    pub variance: Option<Vec<f64>>,
}

/// Means and variances of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub width: usize,
    pub height: usize,
    pub channels: Vec<Channel>,
}

impl Image {
    /// The mean of independent images of the same scene (different seeds), with its variance estimated from
    /// theirs. Variance channels of the images are not used. Errors: fewer than two images, different sizes
    /// or channels.
    pub fn from_replicates(images: &[Image]) -> Result<Image, ImageError> {
        let [first, .., _] = images else {
            return Err(ImageError("the variance needs at least two images".into()));
        };
        if let Some(other) = images.iter().find(|image| !image.same_layout(first)) {
            let size = format!("{}×{} and {}×{}", first.width, first.height, other.width, other.height);
            return Err(ImageError(format!("replicates differ in size or channels ({size})")));
        }
        let channels = first.channels.iter().enumerate().map(|(index, channel)| {
            let estimate = |pixel: usize| {
                crate::statistics::Estimate::of(images.iter().map(|image| image.channels[index].mean[pixel]))
            };
            let estimates: Vec<_> = (0..channel.mean.len()).map(estimate).collect();
            Channel {
                name: channel.name.clone(),
                mean: estimates.iter().map(|estimate| estimate.mean).collect(),
                variance: Some(estimates.iter().map(|estimate| estimate.variance).collect()),
            }
        });
        Ok(Image { width: first.width, height: first.height, channels: channels.collect() })
    }

    /// The same image, declared free of noise, for closed forms.
    pub fn exact(mut self) -> Image {
        for channel in &mut self.channels {
            channel.variance = Some(vec![0.0; channel.mean.len()]);
        }
        self
    }

    /// The same image with the variances of its means taken from the channels of the same names of a separate
    /// image. (A file of *sample* variances must be divided by the number of samples first.)
    pub fn with_variance(mut self, variances: &Image) -> Result<Image, ImageError> {
        if (self.width, self.height) != (variances.width, variances.height) {
            return Err(ImageError("the variance image has another size".into()));
        }
        for channel in &mut self.channels {
            let found = variances.channels.iter().find(|candidate| candidate.name == channel.name);
            let found =
                found.ok_or_else(|| ImageError(format!("no variance for channel {}", channel.name)))?;
            channel.variance = Some(found.mean.clone());
        }
        Ok(self)
    }

    /// The same image with variances from the second moments that Mitsuba's `moment` integrator writes: a
    /// channel `m2_X` is the mean of squares of `X` over `samples` samples, so X's mean has the variance (m2
    /// − X²)/(samples − 1).
    ///
    /// The subtraction cannot resolve a variance below the rounding of an f32 m2, so that rounding is a lower
    /// bound.
    pub fn with_second_moments(mut self, samples: usize) -> Result<Image, ImageError> {
        if samples < 2 {
            return Err(ImageError("the variance needs at least two samples".into()));
        }
        let (moments, mut means): (Vec<Channel>, Vec<Channel>) =
            self.channels.into_iter().partition(|channel| channel.name.starts_with("m2_"));
        for channel in &mut means {
            let moment = moments.iter().find(|moment| moment.name["m2_".len()..] == channel.name);
            let Some(moment) = moment else { continue };
            let variance = |(mean, square): (&f64, &f64)| {
                let resolved = f64::from(f32::EPSILON) * square;
                let spread = square - mean * mean;
                // Not `max`, which would drop a NaN.
                let spread = if spread < resolved { resolved } else { spread };
                spread / (samples - 1) as f64
            };
            channel.variance = Some(channel.mean.iter().zip(&moment.mean).map(variance).collect());
        }
        self.channels = means;
        Ok(self)
    }

    fn same_layout(&self, other: &Image) -> bool {
        let names =
            |image: &Image| image.channels.iter().map(|channel| channel.name.clone()).collect::<Vec<_>>();
        (self.width, self.height) == (other.width, other.height) && names(self) == names(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(mean: [f64; 2]) -> Image {
        let channel = Channel { name: "Y".into(), mean: mean.to_vec(), variance: None };
        Image { width: 2, height: 1, channels: vec![channel] }
    }

    #[test]
    fn replicates_give_the_variance_of_their_mean() {
        let image = Image::from_replicates(&[grey([1.0, 5.0]), grey([2.0, 5.0]), grey([3.0, 5.0])]).unwrap();
        assert_eq!(image.channels[0].mean, [2.0, 5.0]);
        let variance = image.channels[0].variance.as_ref().unwrap();
        assert!((variance[0] - 1.0 / 3.0).abs() < 1e-15 && variance[1] == 0.0);
        assert!(Image::from_replicates(&[grey([1.0, 2.0])]).is_err());
    }

    #[test]
    fn second_moments_become_variances() {
        let mut image = grey([3.0, 1.0]);
        image.channels.push(Channel { name: "m2_Y".into(), mean: vec![10.0, 1.0 - 1e-9], variance: None });
        let image = image.with_second_moments(5).unwrap();
        assert_eq!(image.channels.len(), 1);
        let variance = image.channels[0].variance.as_ref().unwrap();
        assert_eq!(variance[0], 0.25);
        assert!(variance[1] > 0.0 && variance[1] < 1e-7);
        assert!(image.with_second_moments(1).is_err());
    }

    #[test]
    fn variances_come_by_name() {
        let image = grey([1.0, 2.0]).with_variance(&grey([0.1, 0.2])).unwrap();
        assert_eq!(image.channels[0].variance.as_deref(), Some(&[0.1, 0.2][..]));
        let mut other = grey([0.1, 0.2]);
        other.channels[0].name = "R".into();
        assert!(grey([1.0, 2.0]).with_variance(&other).unwrap_err().0.contains('Y'));
    }
}
