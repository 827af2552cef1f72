//! The directions from which models are asked.

use std::f64::consts::TAU;
use std::fmt;
use validation::Laws;
use validation::scatterer::{DVec3, direction};
use validation::statistics::Stream;

/// Angles of incidence in degrees; those above 90 are from below.
const ANGLES: [f64; 5] = [0.0, 35.0, 75.0, 89.0, 150.0];

/// The direction of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// At so many degrees from the normal, off the coordinate axes.
    At(f64),
    /// Anywhere above the surface, another for every check and every number: faults may be anywhere.
    Drawn,
}

impl Direction {
    /// The unit vector for the trial of this name and number.
    pub fn vector(self, trial: &str, number: u64) -> DVec3 {
        match self {
            Self::At(degrees) => from(degrees),
            Self::Drawn => {
                let mut stream = Stream::named(&format!("direction of {trial}"), number);
                let cos = stream.uniform();
                direction(cos, TAU * stream.uniform())
            }
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::At(degrees) => degrees.fmt(formatter),
            Self::Drawn => formatter.write_str("drawn"),
        }
    }
}

/// The direction at an angle in degrees from the normal, off the coordinate axes.
pub fn from(degrees: f64) -> DVec3 {
    direction(etalon::math::function::cos(degrees.to_radians()), 0.7)
}

/// The directions from which a model with these laws is asked: the usual ones, one at which smooth glass reflects all
/// light, halfway from the critical angle to the surface, if the model refracts, and one that is drawn.
pub fn directions(laws: &Laws) -> Vec<Direction> {
    let index = laws.eta.unwrap_or(1.0);
    let critical = libm::asin(index.min(1.0 / index)).to_degrees();
    let beyond = ((critical + 90.0) / 2.0).round();
    let beyond = if index > 1.0 { 180.0 - beyond } else { beyond };
    // Between next to equal indices it would be as good as along the surface.
    let reflects_all = laws.eta.is_some() && critical < 88.0;
    let angles = ANGLES.into_iter().chain(reflects_all.then_some(beyond));
    angles.map(Direction::At).chain([Direction::Drawn]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_refracts_is_asked_where_it_reflects_all_light() {
        let at = |eta: Option<f64>| directions(&Laws { eta, ..Laws::default() })[5];
        // The critical angles are 41.8 degrees, from the side of the larger index.
        assert_eq!([Some(1.5), Some(1.0 / 1.5)].map(at), [Direction::At(114.0), Direction::At(66.0)]);
        assert_eq!([None, Some(1.00001)].map(at), [Direction::Drawn; 2]);
    }

    #[test]
    fn drawn_directions_differ_by_trial_and_number() {
        let drawn = |trial, number| Direction::Drawn.vector(trial, number);
        let all = [drawn("a", 0), drawn("a", 1), drawn("b", 0)];
        assert!(all.iter().all(|wo| wo.z >= 0.0 && (wo.length() - 1.0).abs() < 1e-12));
        assert!(all[0] == drawn("a", 0) && all[0] != all[1] && all[0] != all[2] && all[1] != all[2]);
        assert_eq!(Direction::At(150.0).vector("a", 0), Direction::At(150.0).vector("b", 1));
    }
}
