//! Histograms of samples with the counts expected from the density, as an illustration of `chi2`.

use crate::direction::from;
use crate::materials::Subject;
use validation::Scatterer;
use validation::quadrature::{Cell, integrate};
use validation::scatterer::direction;
use validation::statistics::Stream;

/// Bins of the angle from the normal, in which the lobes are visible.
const BINS: usize = 36;

/// Angle of the outgoing direction in degrees.
const ANGLE: f64 = 35.0;

/// The plotted models: a name and a scene-file snippet.
const SUBJECTS: [(&str, &str); 6] = [
    ("diffuse", r#"<bsdf type="diffuse"/>"#),
    ("roughconductor, α = 0.1", r#"<bsdf type="roughconductor"><float name="alpha" value="0.1"/></bsdf>"#),
    ("roughdielectric, α = 0.2", r#"<bsdf type="roughdielectric"><float name="alpha" value="0.2"/></bsdf>"#),
    ("roughplastic, α = 0.1", r#"<bsdf type="roughplastic"><float name="alpha" value="0.1"/></bsdf>"#),
    (
        "roughconductor, Beckmann, α = 0.4",
        r#"<bsdf type="roughconductor"><string name="distribution" value="beckmann"/><float name="alpha" value="0.4"/></bsdf>"#,
    ),
    (
        "blendbsdf of diffuse and roughconductor",
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/><bsdf type="diffuse"/><bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf></bsdf>"#,
    ),
];

/// Counts by angle from the normal, 0 to 180°, in equal steps.
#[derive(Clone, Debug)]
pub struct Histogram {
    pub name: String,
    pub samples: usize,
    pub observed: Vec<f64>,
    pub expected: Vec<f64>,
}

/// The histograms of a few models.
pub fn histograms(samples: usize) -> Result<Vec<Histogram>, String> {
    let of = |(name, snippet): &(&str, &str)| Ok(histogram(name, &Subject::new(snippet)?.placed(), samples));
    SUBJECTS.iter().map(of).collect()
}

fn histogram(name: &str, subject: &dyn Scatterer, samples: usize) -> Histogram {
    let wo = from(ANGLE);
    let edge = |i: usize| libm::cos(std::f64::consts::PI * i as f64 / BINS as f64);
    let mut observed = vec![0.0; BINS];
    let mut stream = Stream::named(name, 0);
    for _ in 0..samples {
        let u = [stream.uniform(), stream.uniform(), stream.uniform()];
        if let Some(sample) = subject.sample(wo, u).filter(|sample| !sample.delta) {
            let degrees = libm::acos(sample.wi.z.clamp(-1.0, 1.0)).to_degrees();
            observed[((degrees * BINS as f64 / 180.0) as usize).min(BINS - 1)] += 1.0;
        }
    }
    let expected = |i: usize| {
        let step = std::f64::consts::TAU / 16.0;
        let cells: Vec<Cell> = (0..16)
            .map(|k| [f64::from(k) * step, f64::from(k + 1) * step])
            .map(|[low, high]| Cell { low: [edge(i + 1), low], high: [edge(i), high] })
            .collect();
        let density = |[z, φ]: [f64; 2]| subject.pdf(wo, direction(z, φ));
        // The tolerance is a tenth of a sample.
        samples as f64 * integrate(&cells, 0.1 / samples as f64, 100_000, density).value
    };
    Histogram { name: name.into(), samples, observed, expected: (0..BINS).map(expected).collect() }
}

impl Histogram {
    /// Pearson residuals (observed − expected) / √expected of the bins that expect at least five.
    pub fn residuals(&self) -> Vec<Option<f64>> {
        let residual = |(o, e): (&f64, &f64)| (*e >= 5.0).then(|| (o - e) / e.sqrt());
        self.observed.iter().zip(&self.expected).map(residual).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_follow_the_density() {
        for histogram in histograms(1 << 14).unwrap() {
            let n = histogram.samples as f64;
            let (drawn, promised): (f64, f64) =
                (histogram.observed.iter().sum(), histogram.expected.iter().sum());
            // Six standard deviations of a binomial count, and of the largest of 36 residuals.
            assert!((drawn - promised).abs() <= 3.0 * n.sqrt() + 1.0, "{histogram:?}");
            assert!(histogram.residuals().iter().flatten().all(|z| z.abs() < 6.0), "{histogram:?}");
        }
    }
}
