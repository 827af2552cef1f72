//! `validate calibrate`: the experiment of [`validation::converge::calibration`] with pictures of a real
//! renderer.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use validation::Verdict;
use validation::converge::calibration::{Pair, share_called_different};
use validation::converge::{errors, reference};
use validation::report::to_json;
use validation::statistics::Stream;
use validation::statistics::distributions::normal_quantile;

use crate::console::{all_known, check_writable, positive_seconds, say, write};
use crate::renderers::{self, Job};
use crate::report::machine;
use crate::study::{REFERENCES, seed};

/// The arguments of the command.
#[derive(Args)]
pub struct Arguments {
    scene: PathBuf,
    #[arg(long, default_value = "etalon")]
    renderer: String,
    /// Another file of renderers
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Sample counts
    #[arg(long, value_delimiter = ',', value_name = "N,N,…", default_value = "4,16,64", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Vec<u32>,
    /// Pairs of pictures
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pairs: u32,
    /// Draws from the pool
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..))]
    trials: u32,
    /// Number of threads; all unless given
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Count the processor's seconds, on a machine that does other things meanwhile
    #[arg(long)]
    processor_time: bool,
    /// Seconds that one picture may take
    #[arg(long, value_name = "SECONDS", value_parser = positive_seconds)]
    timeout: Option<Duration>,
    /// Write a JSON document
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// The results of the experiment.
#[derive(Serialize)]
struct Calibration {
    scene: String,
    renderer: String,
    samples: Vec<u32>,
    pairs: u32,
    trials: u32,
    processor_time: bool,
    machine: Vec<(String, String)>,
    found: Vec<Share>,
    /// Standard deviation of the logarithm of the ratio within a pair, averaged over rungs, for errors,
    /// seconds and their product.
    scatter: [f64; 3],
    /// Number of seeds that detect 5 % with 90 % power, according to the scatter of the product.
    seeds_needed: u32,
    pool: Vec<Pair>,
}

/// The share of trials in which the sides were called different.
#[derive(Serialize)]
struct Share {
    seeds: usize,
    factor: f64,
    share: f64,
}

/// Standard deviation over the pool of the mean over rungs of log(b/a), where a and b are the sides'
/// quantities.
fn scatter(pool: &[Pair], quantity: fn([f64; 2]) -> f64) -> f64 {
    let difference = |Pair([a, b]): &Pair| {
        let each = a.iter().zip(b).map(|(a, b)| libm::log(quantity(*b) / quantity(*a)));
        each.sum::<f64>() / a.len() as f64
    };
    // Neither side is better, so the mean is zero.
    let squares: f64 = pool.iter().map(|pair| difference(pair) * difference(pair)).sum();
    (squares / pool.len() as f64).sqrt()
}

/// Number of seeds whose mean is accurate enough to detect 5 % with 90 % power at a level of half a per cent.
fn seeds_needed(scatter: f64) -> u32 {
    let wanted = (normal_quantile(0.0025) + normal_quantile(0.1)) * scatter / libm::log(1.05);
    (wanted * wanted).ceil().max(3.0) as u32
}

/// The calibration holds if for some number of seeds equal sides are called different in at most 1 % of
/// trials, and sides that differ by 5 % in at least 90 %. A pool of fewer than 16 pairs is inconclusive.
pub fn run(arguments: &Arguments) -> Result<Verdict, Box<dyn std::error::Error>> {
    let file = arguments.file.clone().unwrap_or_else(renderers::file);
    check_writable(&[&arguments.scene, &file], &[&arguments.json])?;
    let known = renderers::load(&file)?;
    all_known("renderer", std::slice::from_ref(&arguments.renderer), known.keys().map(String::as_str))?;
    let renderer = &known[&arguments.renderer];
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("picture.exr");
    let (scene, threads, limit) = (&arguments.scene, arguments.threads, arguments.timeout);
    let render =
        |samples: u32, seed: u32| renderer.render(&Job { scene, samples, seed, threads, limit }, &out);
    let longest = arguments.spp.iter().max().copied().unwrap_or(1);
    let pictures: Result<Vec<_>, String> = (0..REFERENCES)
        .map(|k| Ok(render(longest.saturating_mul(8), seed("reference", k))?.picture))
        .collect();
    let reference = reference(&pictures?).ok_or("the pictures differ in size")?;
    let mut pool = vec![];
    for k in 0..arguments.pairs {
        eprintln!("pair {} of {}", k + 1, arguments.pairs);
        let mut sides = [vec![], vec![]];
        for samples in &arguments.spp {
            for (side, rungs) in sides.iter_mut().enumerate() {
                let found = render(*samples, seed("picture", 2 * k + side as u32))?;
                let seconds = found.took.counted(arguments.processor_time);
                let errors = errors(&found.picture, &reference).ok_or("the pictures differ in size")?;
                rungs.push([errors.trimmed, seconds]);
            }
        }
        pool.push(Pair(sides));
    }
    let mut stream = Stream::named("calibrate", 0);
    let mut found = vec![];
    for seeds in [8, 16, 32, 64].into_iter().filter(|s| *s <= pool.len() / 2) {
        for factor in [1.0, 1.05] {
            let share = share_called_different(&pool, seeds, factor, arguments.trials, &mut stream);
            let share = share.ok_or("an error is below the noise of the reference")?;
            say(format_args!(
                "{seeds} seeds, {:.0} % slower: called different in {:.2} %",
                100.0 * (factor - 1.0),
                100.0 * share
            ));
            found.push(Share { seeds, factor, share });
        }
    }
    let kept = found.chunks(2).any(|pair| pair[0].share <= 0.01 && pair[1].share >= 0.9);
    let asked_nothing = found.is_empty();
    let scatter = [scatter(&pool, |[e, _]| e), scatter(&pool, |[_, s]| s), scatter(&pool, |[e, s]| e * s)];
    let seeds_needed = seeds_needed(scatter[2]);
    let [by_error, by_seconds] = [0, 1].map(|i| 100.0 * scatter[i]);
    let wanted = if asked_nothing { String::new() } else { format!(": 5 % wants {seeds_needed} seeds") };
    say(format_args!(
        "within a pair errors scatter by {by_error:.1} %, seconds by {by_seconds:.1} %{wanted}"
    ));
    let calibration = Calibration {
        scene: arguments.scene.display().to_string(),
        renderer: arguments.renderer.clone(),
        samples: arguments.spp.clone(),
        pairs: arguments.pairs,
        trials: arguments.trials,
        processor_time: arguments.processor_time,
        machine: machine::here().into_iter().map(|(name, value)| (name.to_string(), value)).collect(),
        found,
        scatter,
        seeds_needed,
        pool,
    };
    write(arguments.json.as_deref(), || Ok(to_json(&calibration)?))?;
    Ok(match kept {
        _ if asked_nothing => Verdict::Inconclusive,
        true => Verdict::Equivalent,
        false => Verdict::Different,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_and_seeds_belong_together() {
        let side = |log: f64| vec![[libm::exp(log), 1.0]; 2];
        let pool = [Pair([side(0.1), side(0.0)]), Pair([side(0.0), side(0.1)])];
        assert!((scatter(&pool, |[e, s]| e * s) - 0.1).abs() < 1e-12);
        assert!(scatter(&pool, |[_, s]| s) == 0.0);
        // (2.807 + 1.282)² · (0.1 / 0.04879)² = 70.2
        assert_eq!((seeds_needed(0.1), seeds_needed(0.0)), (71, 3));
    }
}
