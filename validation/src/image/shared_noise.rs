//! Noise that is correlated between neighbouring pixels because a reconstruction filter shares samples
//! between them.

use super::Image;

impl Image {
    /// For each channel the variance of the image's mean over what it would be if the noise of pixels were
    /// independent, at least 1, for those whose mean has a given standard error.
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
}

#[cfg(test)]
mod tests {
    use crate::image::synthetic::grey;

    #[test]
    fn variances_grow_by_the_factor_of_their_channel() {
        let image = grey(2, &[1.0; 4], 0.25);
        let name = "Y".to_owned();
        // Independent pixels would have a standard error of 1/4.
        let factors = image.shared_noise_of_means([(&name, &0.75)]);
        assert_eq!(factors, [(name.clone(), 9.0)]);
        assert_eq!(image.shared_noise_of_means([(&name, &0.1)]), [(name, 1.0)]);
        let after = image.with_variances_times(&[factors, vec![("X".into(), 2.0)]].concat());
        assert_eq!(after.channels[0].variance, Some(vec![2.25; 4]));
    }
}
