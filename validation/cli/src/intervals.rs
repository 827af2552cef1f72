//! The command line of `validate intervals`.

use crate::console::{check_writable, percentage, say};
use etalon::film::BLOCK;
use etalon::image::{Attribute, Channel, Image, read_exr, write_exr};
use etalon::render::quality::{Correlation, Quality};
use std::error::Error;
use std::path::PathBuf;
use validation::Verdict;
use validation::image::{Unsound, half_widths};
use validation::statistics::distributions::student_quantile;

/// Writes how far each pixel may be from what it expects
#[derive(clap::Args)]
pub struct Arguments {
    /// An OpenEXR file with channels `variance.X`
    image: PathBuf,
    /// Where the channels go, with `interval.X`, half the width of the interval of X, beside `variance.X`
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The probability with which an interval holds what its pixel expects
    #[arg(long, default_value = "95%", value_parser = confidence)]
    confidence: f64,
    /// Degrees of freedom of the variances, one less than the number of independent values that each comes from.
    /// Etalon's files tell it; those of others are taken for exact unless it is given
    #[arg(long, value_parser = degrees)]
    degrees: Option<f64>,
}

/// Adds intervals to an image.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn Error>> {
    let Arguments { image: path, output, confidence, degrees } = arguments;
    check_writable(&[&path], &[&Some(output.clone())])?;
    let mut image = read_exr(&path)?;
    let degrees = degrees.unwrap_or_else(|| degrees_of(&image));
    if degrees <= 0.0 {
        return Err(format!(
            "{}: too few samples for variances; Etalon's are from {} a pixel on",
            path.display(),
            2 * BLOCK
        )
        .into());
    }
    if let Some(flaw) = flaw(&image) {
        return Err(format!("{}: {flaw}", path.display()).into());
    }
    let found = image.channels.iter().filter_map(|channel| {
        let variances: Vec<f64> = channel.variance.as_ref()?.iter().copied().map(f64::from).collect();
        let widths = half_widths(image.crop.width as usize, &variances, degrees, confidence);
        tell(channel, &widths, of_mean(&image, channel, &variances, confidence));
        let mean = widths.into_iter().map(|width| width as f32).collect();
        Some(Channel { name: format!("interval.{}", channel.name), mean, variance: None })
    });
    let intervals: Vec<Channel> = found.collect();
    if intervals.is_empty() {
        return Err(format!("{}: it has no channel X with a `variance.X` beside it", path.display()).into());
    }
    if image.provenance.is_none() {
        say(format_args!(
            "pixels are taken to be independent, for the file does not tell: where a filter has let neighbours share \
             samples, the mean is known less well"
        ));
    }
    image.channels.extend(intervals);
    // The sums of a part of a render are those of the channels that it had.
    image.accumulators = None;
    if let Some(provenance) = &mut image.provenance {
        provenance.extra.insert("intervals".into(), Attribute::Real(confidence as f32));
    }
    write_exr(&output, &image)?;
    Ok(Verdict::Equivalent)
}

/// The first pixel, in the order of channels and rows, whose value or variance is none. Infinite variances are unknown
/// ones.
fn flaw(image: &Image) -> Option<String> {
    let with_variance =
        image.channels.iter().filter_map(|channel| Some((channel, channel.variance.as_ref()?)));
    let mut pixels = with_variance.flat_map(|(channel, variances)| {
        let pairs = channel.mean.iter().zip(variances).enumerate();
        pairs.map(move |(pixel, (value, variance))| (&channel.name, pixel, *value, *variance))
    });
    pixels.find_map(|(name, pixel, value, variance)| {
        let (what, found, expected) = match Unsound::of(value.into(), variance.into())? {
            Unsound::Value => ("value", value, "a finite number"),
            Unsound::Variance => ("variance", variance, "0 or more"),
        };
        let width = image.crop.width as usize;
        let (x, y) = (pixel % width, pixel / width);
        Some(format!("pixel ({x}, {y}) channel {name}: its {what} is {found}, expected {expected}"))
    })
}

/// Those of the variances of an image: of Etalon's that of blocks of samples, of others' unknown, and taken for many.
fn degrees_of(image: &Image) -> f64 {
    image.provenance.as_ref().map_or(f64::INFINITY, |told| {
        let samples = told.samples.end.saturating_sub(told.samples.start);
        (samples / BLOCK) as f64 - 1.0
    })
}

/// The mean of a channel, and half the width of its interval: by Student's distribution, for few pixels may hold most
/// of the variance. What distant pixels share, as noise of light paths, is not in it.
fn of_mean(image: &Image, channel: &Channel, variances: &[f64], confidence: f64) -> (f64, f64) {
    let pixels = channel.mean.iter().map(|value| f64::from(*value)).zip(variances.iter().copied());
    let quality = Quality::new(image.crop, Correlation::told(image.provenance.as_ref()), [pixels]);
    let [mean, ..] = quality.mean;
    let error = quality.relative_standard_error_of_mean * mean.abs();
    // The variance of an estimated variance is 2/ν of its square.
    (mean, student_quantile(1.0 - confidence, 2.0 / quality.uncertainty) * error)
}

fn tell(channel: &Channel, widths: &[f64], (mean, of_mean): (f64, f64)) {
    let mut widths = widths.to_vec();
    widths.sort_by(f64::total_cmp);
    let (median, largest) = (widths[widths.len() / 2], widths[widths.len() - 1]);
    let name = &channel.name;
    say(format_args!(
        "{name}: mean of the image {mean:.6} ± {of_mean:.2e}; pixels ± {median:.2e} in the median, ± {largest:.2e} at most"
    ));
}

fn confidence(text: &str) -> Result<f64, String> {
    percentage(text)
        .ok()
        .filter(|share| *share < 1.0)
        .ok_or_else(|| "expected such as 95%, below 100%".into())
}

fn degrees(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| *number > 0.0);
    number.ok_or_else(|| "expected a positive number".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(name: &str, variance: Option<f32>) -> Channel {
        Channel { name: name.to_string(), mean: vec![1.0; 6], variance: variance.map(|v| vec![v; 6]) }
    }

    fn written(channels: Vec<Channel>) -> Result<Image, String> {
        let folder = tempfile::tempdir().unwrap();
        let (from, to) = (folder.path().join("in.exr"), folder.path().join("out.exr"));
        let crop = etalon::film::Window { x: 0, y: 0, width: 3, height: 2 };
        let image = Image { full: (3, 2), crop, channels, provenance: None, accumulators: None };
        write_exr(&from, &image).unwrap();
        let arguments = Arguments { image: from, output: to.clone(), confidence: 0.95, degrees: Some(4.0) };
        run(arguments).map_err(|error| error.to_string())?;
        Ok(read_exr(&to).unwrap())
    }

    #[test]
    fn channels_with_variances_get_intervals() {
        let image = written(vec![flat("G", Some(0.25)), flat("A", None)]).unwrap();
        let names: Vec<&str> = image.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["G", "A", "interval.G"]);
        let width = image.channel("interval.G").unwrap().mean[0];
        // Half of Student's quantile of 97.5 % with four degrees of freedom, 2.776445.
        assert!((width - 1.388_222_5).abs() < 1e-6, "{width}");
        assert_eq!(image.channel("G").unwrap().variance, Some(vec![0.25; 6]));
    }

    #[test]
    fn without_variances_there_are_none() {
        let error = written(vec![flat("A", None)]).unwrap_err();
        assert!(error.ends_with("it has no channel X with a `variance.X` beside it"), "{error}");
    }

    #[test]
    fn what_is_no_variance_is_named() {
        for (value, variance, told) in [
            (1.0, -1.0, "its variance is -1, expected 0 or more"),
            (1.0, f32::NAN, "its variance is NaN, expected 0 or more"),
            (f32::INFINITY, 0.5, "its value is inf, expected a finite number"),
        ] {
            let mut broken = flat("G", Some(0.25));
            broken.mean[4] = value;
            broken.variance.as_mut().unwrap()[4] = variance;
            let error = written(vec![broken]).unwrap_err();
            assert!(error.ends_with(&format!("pixel (1, 1) channel G: {told}")), "{error}");
        }
        let mut unknown = flat("G", Some(0.25));
        unknown.variance.as_mut().unwrap()[4] = f32::INFINITY;
        assert!(written(vec![unknown]).is_ok());
    }

    #[test]
    fn a_share_below_one_is_a_confidence() {
        assert_eq!(confidence("99.5%"), Ok(0.995));
        assert!(["100%", "0%", "0.95"].into_iter().all(|text| confidence(text).is_err()));
        assert!(["0", "-1", "NaN", "x"].into_iter().all(|text| degrees(text).is_err()));
    }
}
