//! First and second moments of what another integrator sees, beside its image.
//!
//! Mitsuba's test suite keeps its references so: with the mean m₁ and the mean square m₂ of n samples the
//! variance of a pixel is (m₂ − m₁²)/n. It holds for independent samples through a box filter; the `variance`
//! channels that Etalon writes of its own accord hold for others as well. A sample's square is that of what
//! it adds to its pixel, light paths included, so it is a property of the estimator: unlike the mean, it is
//! not the same in another renderer.

use super::{AnyIntegrator, INTEGRATORS, nested_integrator};
use crate::image::check_names;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::construct;
use crate::spectrum::observer::RGB_TO_XYZ;

pub const NAME: &str = "moment";
pub const ABOUT: &str = "Mean (CIE XYZ) and mean square of another integrator's samples as further channels.";
pub const EXAMPLES: &[&str] =
    &[r#"<integrator type="moment"><integrator type="path" name="image"/></integrator>"#];

/// The second moments of what another integrator finds.
#[derive(Clone, Debug)]
pub struct Moment {
    pub nested: AnyIntegrator,
    /// First moments: what the nested integrator adds to the colours, then X, Y, Z; second moments in the
    /// same order.
    pub channels: Vec<String>,
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    let found = nested_integrator(params, "whose moments are asked for")?;
    let (element, name) = found.ok_or_else(|| params.lacks("integrator", "expected one <integrator>"))?;
    let nested = construct(INTEGRATORS, element, params.loader, Usage::Unbounded)?;
    if !nested.has_radiance() {
        let message = format!("`{}` sees no light", nested.name());
        return Err(SceneError::at(&element.span, message, "expected an integrator that fills R, G and B"));
    }
    let means = nested.extra_channels().into_iter().chain(["X", "Y", "Z"].map(String::from));
    let means: Vec<String> = means.map(|channel| format!("{name}.{channel}")).collect();
    let squares = means.iter().map(|mean| format!("m2_{mean}"));
    let channels: Vec<String> = means.iter().cloned().chain(squares).collect();
    check_names(&channels)
        .map_err(|(_, why)| SceneError::at(&element.span, why, "expected another `name`"))?;
    Ok(AnyIntegrator::Moment(Box::new(Moment { nested, channels })))
}

impl Moment {
    /// See [`AnyIntegrator::without_media`].
    pub fn without_media(self) -> Self {
        Self { nested: self.nested.without_media(), ..self }
    }

    /// How many channels the nested integrator adds to the colours.
    pub fn nested_channels(&self) -> usize {
        self.channels.len() / 2 - 3
    }

    /// Fills the moments of a sample that has all other channels: R, G, B first.
    pub fn complete(&self, values: &mut [f64]) {
        let own = values.len() - self.channels.len() + self.nested_channels();
        let (seen, moments) = values.split_at_mut(own);
        self.nested.complete(seen);
        let rgb = [seen[0], seen[1], seen[2]];
        let xyz = RGB_TO_XYZ.map(|row| row.iter().zip(rgb).map(|(m, c)| m * c).sum::<f64>());
        let (colours, squares) = moments.split_at_mut(3);
        colours.copy_from_slice(&xyz);
        let means = seen[own - self.nested_channels()..].iter().chain(colours.iter());
        for (square, mean) in squares.iter_mut().zip(means) {
            *square = *mean * *mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::render::{Progress, Settings, render};
    use crate::scene::trial::ball_of_glass;
    use crate::spectrum::ColorMode;
    use crate::spectrum::observer::luminance;

    const INTEGRATOR: &str = r#"<integrator type="moment"><integrator type="aov" name="it"><string name="aovs" value="d:depth"/>
        <integrator type="path"><float name="light_paths" value="8"/></integrator></integrator></integrator>"#;

    /// Of so many samples: names of the channels and, channel by channel, the means.
    fn rendered(samples: u64) -> (Vec<String>, Vec<Vec<f64>>) {
        let scene = load_text("scene.xml", &ball_of_glass(INTEGRATOR), ColorMode::Rgb).unwrap();
        assert!(scene.techniques.caustics.is_some());
        let settings = Settings::of(&scene, 0..samples);
        let (image, _) = render(&scene, &settings, &Progress::default()).unwrap();
        let mean = |values: &[f32]| values.iter().map(|v| f64::from(*v)).collect();
        image.channels.iter().map(|c| (c.name.clone(), mean(&c.mean))).unzip()
    }

    /// Equal but for the rounding of what is stored.
    fn alike(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-6 * a.abs().max(b.abs())
    }

    #[test]
    fn moments_of_one_sample_are_itself_and_its_square() {
        let (names, means) = rendered(1);
        let means_of = ["_arg_0.R", "_arg_0.G", "_arg_0.B", "d.T", "X", "Y", "Z"];
        let moments = ["it.", "m2_it."].map(|of| means_of.map(|channel| format!("{of}{channel}")));
        assert_eq!(names, [&["R", "G", "B"].map(String::from)[..], moments.as_flattened()].concat());
        let pixels = means[0].len();
        let value = |channel: usize, pixel: usize| means[channel][pixel];
        let shown = |i: usize| luminance([value(0, i), value(1, i), value(2, i)]);
        assert!((0..pixels).all(|i| alike(value(8, i), shown(i))));
        assert!((0..pixels).all(|i| (3..10).all(|c| alike(value(c + 7, i), value(c, i) * value(c, i)))));
    }

    #[test]
    fn squares_are_averaged_after_squaring() {
        let (_, means) = rendered(64);
        // Where light varies, the mean square exceeds the squared mean; the mean itself stays that of the
        // image.
        let (first, second) = (&means[8], &means[15]);
        let noisy = (0..means[0].len()).filter(|&i| second[i] > 1.5 * first[i] * first[i]).count();
        assert!(noisy > means[0].len() / 4, "{noisy}");
        assert!((0..means[0].len()).all(|i| second[i] >= (1.0 - 1e-6) * first[i] * first[i]));
    }
}
