//! Noise that is correlated between neighbouring pixels because a reconstruction filter shares samples
//! between them.

use super::Image;
use crate::statistics::Estimate;

/// Edge length in pixels of the tiles within which the correlation is measured.
const TILE: usize = 16;

impl Image {
    /// For each channel the variance of a tile's mean in these replicates over what it would be if the noise
    /// of pixels were independent; at least 1. The sum over all tiles is accurate even with few replicates,
    /// although the variance of a single tile is not.
    pub fn shared_noise(replicates: &[Image]) -> Vec<(String, f64)> {
        let Some(first) = replicates.first() else { return vec![] };
        let variance = |channel: usize, pixels: &[usize]| {
            let total = |image: &Image| pixels.iter().map(|&i| image.channels[channel].mean[i]).sum::<f64>();
            Estimate::of(replicates.iter().map(total)).variance
        };
        let (tiles, pixels) = (first.tiles(), 0..first.width * first.height);
        let factor = |channel: usize| {
            let together: f64 = tiles.iter().map(|tile| variance(channel, tile)).sum();
            let alone: f64 = pixels.clone().map(|pixel| variance(channel, &[pixel])).sum();
            if together > alone { together / alone } else { 1.0 }
        };
        first.channels.iter().enumerate().map(|(i, channel)| (channel.name.clone(), factor(i))).collect()
    }

    /// The same ratio for the mean of the whole image, for those channels whose mean has a given standard
    /// error.
    pub fn shared_noise_of_means<'a>(
        &self,
        errors: impl IntoIterator<Item = (&'a String, &'a f64)>,
    ) -> Vec<(String, f64)> {
        let factor = |(name, error): (&String, &f64)| {
            let channel = self.channels.iter().find(|channel| channel.name == *name)?;
            let count = channel.mean.len() as f64;
            let alone = channel.variance.as_ref()?.iter().sum::<f64>() / (count * count);
            let factor = error * error / alone;
            Some((name.clone(), if factor.is_finite() { factor.max(1.0) } else { 1.0 }))
        };
        errors.into_iter().filter_map(factor).collect()
    }

    /// The same image with the variances of the named channels multiplied by the given factors.
    pub fn with_variances_times(mut self, factors: &[(String, f64)]) -> Image {
        for channel in &mut self.channels {
            let factor =
                factors.iter().find(|(name, _)| *name == channel.name).map_or(1.0, |(_, factor)| *factor);
            channel.variance.iter_mut().flatten().for_each(|variance| *variance *= factor);
        }
        self
    }

    /// The pixel indices of each tile.
    fn tiles(&self) -> Vec<Vec<usize>> {
        let corners = |extent: usize| (0..extent).step_by(TILE);
        let tile = |x: usize, y: usize| {
            let row = move |y: usize| (x..self.width.min(x + TILE)).map(move |x| y * self.width + x);
            (y..self.height.min(y + TILE)).flat_map(row).collect()
        };
        corners(self.height).flat_map(|y| corners(self.width).map(move |x| tile(x, y))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channel;
    use crate::statistics::Stream;

    /// Replicates in which each pixel is the mean of its own noise and that of the `reach` pixels after it.
    fn blurred(reach: usize) -> Vec<Image> {
        let mut stream = Stream::named("shared noise", reach as u64);
        let (width, height) = (64, 48);
        let mut replicate = || {
            let noise: Vec<f64> = (0..width * height + reach).map(|_| stream.normal()).collect();
            let mean = (0..width * height).map(|i| noise[i..=i + reach].iter().sum::<f64>()).collect();
            Image { width, height, channels: vec![Channel { name: "Y".into(), mean, variance: None }] }
        };
        (0..16).map(|_| replicate()).collect()
    }

    #[test]
    fn a_filter_shows_and_independent_noise_does_not() {
        let [alone, two] = [0, 1].map(|reach| Image::shared_noise(&blurred(reach))[0].1);
        // In a row of 16 pixels, 15 pairs share half their variance: 1 + 2 · 15/16 · 1/2.
        assert!((1.0..1.15).contains(&alone), "{alone}");
        assert!((1.7..2.15).contains(&two), "{two}");
    }

    #[test]
    fn variances_grow_by_the_factor_of_their_channel() {
        let image = Image::from_replicates(&blurred(0)).unwrap();
        let before = image.channels[0].variance.clone().unwrap();
        let after = image.with_variances_times(&[("X".into(), 9.0), ("Y".into(), 2.0)]);
        let after = after.channels[0].variance.clone().unwrap();
        assert!(before.iter().zip(after).all(|(before, after)| after == 2.0 * before));
    }
}
