//! One channel of both images, pixel by pixel, and the faults of pixels that need no statistics.

use serde::Serialize;

use super::{Channel, Image};

/// A pixel and a channel, the place of a finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    pub x: usize,
    pub y: usize,
    pub channel: String,
}

impl std::fmt::Display for Place {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(formatter, "pixel ({}, {}) channel {}", self.x, self.y, self.channel)
    }
}

/// What of a pixel is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsound {
    /// A value that is not finite.
    Value,
    /// A variance that is negative or not a number; an infinite one is unknown.
    Variance,
}

impl Unsound {
    /// The first of them in a pixel of an image, if there is any.
    pub fn of(value: f64, variance: f64) -> Option<Self> {
        match (value.is_finite(), variance >= 0.0) {
            (true, true) => None,
            (true, false) => Some(Self::Variance),
            (false, _) => Some(Self::Value),
        }
    }
}

/// A pixel of both images with the variances of their means.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    pub a: f64,
    pub b: f64,
    pub variance_a: f64,
    pub variance_b: f64,
}

impl Pixel {
    pub fn difference(&self) -> f64 {
        self.b - self.a
    }

    pub fn variance(&self) -> f64 {
        self.variance_a + self.variance_b
    }

    /// Both values are the same but for this relative rounding.
    pub fn agrees(&self, rounding: f64) -> bool {
        self.difference().abs() <= rounding * self.a.abs().max(self.b.abs())
    }

    /// Difference in standard errors; 0/0 is 0.
    pub fn z(&self) -> f64 {
        if self.difference() == 0.0 { 0.0 } else { self.difference() / self.variance().sqrt() }
    }

    /// The same pixel with each variance at least the one that the other image predicts, b being `ratio`
    /// times as noisy as a: an image with few samples that missed a rare event underestimates its variance
    /// (see `tiles`).
    pub fn informed(mut self, ratio: Option<f64>) -> Self {
        if let Some(ratio) = ratio {
            let (a, b) = (self.variance_a, self.variance_b);
            self.variance_a = a.max(b / ratio);
            self.variance_b = b.max(a * ratio);
        }
        self
    }

    /// Both values are finite, and both variances are numbers ≥ 0 (or infinite: unknown).
    fn is_sound(&self) -> bool {
        self.flaw().is_none()
    }

    /// What is wrong with the pixel, in the first image that it is wrong in.
    fn flaw(&self) -> Option<String> {
        let images = [("first", self.a, self.variance_a), ("second", self.b, self.variance_b)];
        images.into_iter().find_map(|(image, value, variance)| {
            Some(match Unsound::of(value, variance)? {
                Unsound::Variance => format!("the {image} image's variance is negative or not a number"),
                Unsound::Value => format!("the {image} image's value is not finite"),
            })
        })
    }

    /// Both values are sound and both variances known.
    pub fn is_testable(&self) -> bool {
        self.is_sound() && self.variance().is_finite()
    }
}

/// One channel of both images.
pub(super) struct Pair<'a> {
    pub name: &'a str,
    pub width: usize,
    pub height: usize,
    a: &'a Channel,
    b: &'a Channel,
}

impl<'a> Pair<'a> {
    /// The channels that both images have, in the order of `a`, and the names of those that only one has.
    pub fn all(a: &'a Image, b: &'a Image) -> (Vec<Pair<'a>>, Vec<String>) {
        let find = |image: &'a Image, name: &str| image.channels.iter().find(|channel| channel.name == name);
        let pair = |channel: &'a Channel| {
            let other = find(b, &channel.name)?;
            Some(Pair { name: &channel.name, width: a.width, height: a.height, a: channel, b: other })
        };
        let only_a = a.channels.iter().filter(|channel| find(b, &channel.name).is_none());
        let only_b = b.channels.iter().filter(|channel| find(a, &channel.name).is_none());
        let alone = only_a.chain(only_b).map(|channel| channel.name.clone()).collect();
        (a.channels.iter().filter_map(pair).collect(), alone)
    }

    pub fn pixel(&self, x: usize, y: usize) -> Pixel {
        let index = y * self.width + x;
        let variance =
            |channel: &Channel| channel.variance.as_ref().map_or(f64::INFINITY, |variance| variance[index]);
        Pixel {
            a: self.a.mean[index],
            b: self.b.mean[index],
            variance_a: variance(self.a),
            variance_b: variance(self.b),
        }
    }

    /// Every pixel with its coordinates, in row-major order.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, usize, Pixel)> {
        (0..self.height).flat_map(move |y| (0..self.width).map(move |x| (x, y, self.pixel(x, y))))
    }

    pub fn place(&self, x: usize, y: usize) -> Place {
        Place { x, y, channel: self.name.to_string() }
    }
}

/// A pixel with a value that is not finite, or a variance that is negative or not a number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flaw {
    #[serde(flatten)]
    pub place: Place,
    /// What is wrong, and in which image.
    pub what: String,
}

/// Faults that need no statistics. Each list is in row-major order and holds the places of all pixels with
/// the fault.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Faults {
    /// Always a failure.
    pub not_finite: Vec<Flaw>,
    /// Pixels whose values differ by more than rounding although all variances of the channel are zero in
    /// both images. Always a failure: there is no noise to explain the difference.
    pub exact_but_different: Vec<Place>,
    /// Pixels whose values differ although a variance is unknown or both are zero in a noisy channel, as few
    /// samples of a value that is mostly constant sometimes estimate. Nothing can be concluded from them, so
    /// the verdict is at best inconclusive.
    pub unknown_variance: Vec<Place>,
}

impl Faults {
    pub(super) fn find(pairs: &[Pair], rounding: f64) -> Self {
        let mut faults = Faults::default();
        for pair in pairs {
            let exact = pair.pixels().all(|(_, _, pixel)| pixel.variance() == 0.0);
            for (x, y, pixel) in pair.pixels() {
                let differs = !pixel.agrees(rounding);
                if let Some(what) = pixel.flaw() {
                    faults.not_finite.push(Flaw { place: pair.place(x, y), what });
                } else if differs && exact {
                    faults.exact_but_different.push(pair.place(x, y));
                } else if differs && (pixel.variance() == 0.0 || pixel.variance().is_infinite()) {
                    faults.unknown_variance.push(pair.place(x, y));
                }
            }
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::synthetic::grey;

    #[test]
    fn every_kind_of_broken_pixel_is_named() {
        let a = grey(7, &[1.0, f64::NAN, 1.0, 1.0, 1.0, 1.0, 1.0], 0.0);
        let mut b = grey(7, &[1.0, 1.0, f64::INFINITY, 1.0 + 1e-8, 1.1, 1.1, 1.0], 0.0);
        let variance = b.channels[0].variance.as_mut().unwrap();
        (variance[5], variance[6]) = (f64::INFINITY, -1.0);
        let (pairs, alone) = Pair::all(&a, &b);
        let faults = Faults::find(&pairs, 2e-7);
        let columns = |places: &[Place]| places.iter().map(|place| place.x).collect::<Vec<_>>();
        assert!(alone.is_empty());
        let places: Vec<Place> = faults.not_finite.iter().map(|flaw| flaw.place.clone()).collect();
        assert_eq!(columns(&places), [1, 2, 6]);
        assert!(faults.exact_but_different.is_empty());
        assert_eq!(columns(&faults.unknown_variance), [4, 5]);
        let [a, b] = [[1.0, 1.0], [1.0, 1.1]].map(|values| grey(2, &values, 0.0));
        let faults = Faults::find(&Pair::all(&a, &b).0, 2e-7);
        assert_eq!((columns(&faults.exact_but_different), faults.unknown_variance.len()), (vec![1], 0));
    }
}
