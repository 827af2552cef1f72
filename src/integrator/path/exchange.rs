//! How a group's sources are handed on to its receivers.

use super::lobes::{At, Lobed};
use super::questions::Questions;
use super::receivers::Receivers;
use super::shared::{Shared, Source};
use crate::integrator::{CameraPath, Counters};
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// What handing on needs, kept for the next group.
#[derive(Default)]
pub struct Exchange {
    receivers: Receivers,
    parts: Vec<(usize, Part)>,
    questions: Questions,
}

/// The part that a receiver has of the light of a source, not yet divided by the sum of densities. As if π were 1: it cancels.
#[derive(Clone, Copy)]
pub struct Part {
    /// What scatters it on its way to the camera.
    pub weight: Spectrum,
    /// The rest, of which a number of the weight's might not hold the range.
    pub geometry: f64,
    /// With which the receiver's own path would have come to the source, in area, and gone on.
    pub density: f64,
}

impl Part {
    /// Of a matte source for a matte receiver.
    fn matte(weight: Spectrum, geometry: f64) -> Self {
        Self { weight, geometry, density: geometry }
    }
}

impl Exchange {
    /// Hands on what every path found to all whose receivers see its source.
    pub fn share(
        &mut self,
        scene: &Scene,
        paths: &mut [CameraPath],
        shared: &[Shared],
        counters: &mut Counters,
    ) {
        let mut first = 0;
        for receiving in paths.chunk_by_mut(|a, b| a.group == b.group) {
            let group = &shared[first..first + receiving.len()];
            self.receivers.begin(group);
            let λ = receiving[0].λ;
            let lobed = Lobed::new(scene, group, &λ);
            for (j, path) in group.iter().enumerate() {
                if let Some(source) = path.source.as_ref().filter(|_| !path.radiance.is_zero()) {
                    self.propose(scene, receiving, (group, &lobed), (first, j, source), counters);
                }
            }
            first += group.len();
        }
        self.questions.settle(scene, paths, shared, counters);
    }

    /// A share of the source of path j for each receiver of its group that faces it: at once if all of them are in sight, else once the
    /// rays have been traced that ask.
    fn propose(
        &mut self,
        scene: &Scene,
        receiving: &mut [CameraPath],
        (group, lobed): (&[Shared], &Lobed),
        (first, j, source): (usize, usize, &Source),
        counters: &mut Counters,
    ) {
        let Self { receivers, parts, questions, .. } = self;
        let mut weights = [0.0; 64];
        let facing = receivers.weights(j, source, &mut weights);
        // A path knows of itself that it met its source, whatever rounding says.
        let own = 1 << j;
        let in_sight = receivers.in_sight(scene, source) | own;
        let source = (first, j, source);
        if lobed.is_empty() && source.2.lobes.is_none() {
            if facing & own == 0 {
                weights[j] = f64::MIN_POSITIVE;
            }
            let parts = bits(facing | own).map(|i| (i, Part::matte(receivers.weight(i), weights[i])));
            if (facing | own) & !in_sight == 0 {
                hand_on(receiving, group[j].radiance, parts);
            } else {
                questions.ask(group, source, (in_sight, true), parts);
            }
            return;
        }
        rough_parts(scene, (group, lobed), (j, source.2), (facing, &weights), parts, counters);
        let parts = parts.iter().copied();
        if parts.clone().all(|(i, _)| in_sight >> i & 1 == 1) {
            hand_on(receiving, group[j].radiance, parts);
        } else {
            questions.ask(group, source, (in_sight, false), parts);
        }
    }
}

/// The parts of the source of path j, where it or a receiver is rough.
fn rough_parts(
    scene: &Scene,
    (group, lobed): (&[Shared], &Lobed),
    (j, source): (usize, &Source),
    (facing, weights): (u64, &[f64; 64]),
    parts: &mut Vec<(usize, Part)>,
    counters: &mut Counters,
) {
    let onward = source.lobes.as_ref().map(|lobes| At::new(scene, lobes, lobed.λ));
    let part = |i: usize| {
        let receiver = group[i].receiver.as_ref()?;
        let mut part = match lobed.at(i) {
            None => Part::matte(receiver.weight, weights[i]),
            Some(at) => at.receives(receiver, source),
        };
        if let Some(onward) = &onward {
            onward.sends(receiver, source, &mut part);
        }
        (part.density > 0.0 && part.density.is_finite()).then_some((i, part))
    };
    parts.clear();
    parts.extend(bits(facing).filter_map(part));
    counters.evaluations += u64::from(facing.count_ones());
    if parts.iter().all(|(i, _)| *i != j) {
        parts.push((j, Part::matte(group[j].own, f64::MIN_POSITIVE)));
    }
}

/// Parts light among receivers.
fn hand_on(paths: &mut [CameraPath], light: Spectrum, parts: impl Iterator<Item = (usize, Part)> + Clone) {
    let all = 1.0 / parts.clone().map(|(_, part)| part.density).sum::<f64>();
    for (receiver, part) in parts {
        paths[receiver].radiance += part.weight * light * (part.geometry * all) as f32;
    }
}

/// The places of the ones.
fn bits(mut left: u64) -> impl Iterator<Item = usize> + Clone {
    std::iter::from_fn(move || {
        let first = left.trailing_zeros();
        left &= left.wrapping_sub(1);
        (first < 64).then_some(first as usize)
    })
}
