//! What emitter samples of the first vertex leave of the variance, whatever their number.
//!
//! Since direct light is never shared, its variance adds to that of the rest and falls as the number of its
//! samples grows, whatever is shared. So two looks at pixels that share nothing, with few emitter samples and
//! with many, predict any other look for any number of these, and all is chosen together.

use super::look::{Cell, Look};

/// Cost of an emitter sample besides its ray, in rays.
const EMITTER_SAMPLE: f64 = 0.75;

/// Noise and cost of the emitter samples of the first vertex.
pub struct Direct {
    /// Variance of each cell that one emitter sample leaves; n of them leave an nth.
    variances: Vec<f64>,
    /// Cost of one emitter sample, in rays.
    cost: f64,
}

impl Direct {
    /// From looks with few and with many samples.
    pub fn between((n, few): (u32, Look), (m, many): (u32, Look)) -> Self {
        let (n, m) = (f64::from(n), f64::from(m));
        let one = |(few, many): (&Cell, &Cell)| (few.variance - many.variance).max(0.0) / (1.0 / n - 1.0 / m);
        Self {
            variances: few.cells.iter().zip(&many.cells).map(one).collect(),
            cost: (1.0 + EMITTER_SAMPLE) * (many.cost - few.cost).max(0.0) / (m - n),
        }
    }

    /// Predicts what a look with n samples would have been with m.
    pub fn foretell(&self, look: &Look, n: u32, m: u32) -> Look {
        let (n, m) = (f64::from(n), f64::from(m));
        let with = |(cell, direct): (&Cell, &f64)| Cell {
            variance: (cell.variance - direct * (1.0 / n - 1.0 / m)).max(0.0),
            ..*cell
        };
        Look {
            cells: look.cells.iter().zip(&self.variances).map(with).collect(),
            cost: look.cost + (m - n) * self.cost,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_looks_foretell_any_number_of_emitter_samples() {
        // Shared light leaves so much of each cell, one sample of direct light so much more.
        let (shared, direct) = ([3.0, 0.5, 0.0], [1.0, 8.0, 2.0]);
        let look = |shared: [f64; 3], samples: f64, cost: f64| Look {
            cells: shared
                .iter()
                .zip(&direct)
                .map(|(shared, direct)| Cell { variance: shared + direct / samples, ..Cell::default() })
                .collect(),
            cost: cost + samples * (1.0 + EMITTER_SAMPLE),
        };
        // A ray is all that looks know of the cost of a sample.
        let alone = |samples: f64| Look { cost: 5.0 + samples, ..look(shared, samples, 0.0) };
        let direct = Direct::between((2, alone(2.0)), (8, alone(8.0)));
        let fewer = shared.map(|variance| variance / 16.0);
        let (foretold, seen) = (direct.foretell(&look(fewer, 1.0, 9.0), 1, 4), look(fewer, 4.0, 9.0));
        assert!((foretold.cost - seen.cost).abs() < 1e-12);
        for (foretold, seen) in foretold.cells.iter().zip(&seen.cells) {
            assert!((foretold.variance - seen.variance).abs() < 1e-12);
        }
    }
}
