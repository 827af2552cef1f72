//! How a group's sources are handed on to its receivers.

use super::lobes::{At, Lobed};
use super::part::Part;
use super::questions::Questions;
use super::receivers::Receivers;
use super::shared::{Shared, Source};
use crate::integrator::{CameraPath, Counters};
use crate::scene::Scene;

/// What handing on needs, kept for the next group.
#[derive(Default)]
pub struct Exchange {
    receivers: Receivers,
    parts: Vec<(usize, Part)>,
    questions: Questions,
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
            // Path 0 may have lost lanes since, but nothing rough asks which are alive.
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
        let from = (first, j, source);
        if lobed.is_empty() && source.lobes.is_none() {
            if facing & own == 0 {
                weights[j] = f64::MIN_POSITIVE;
            }
            let weight = |i: usize| Some(group[i].receiver.as_ref()?.weight);
            let parts = bits(facing | own).filter_map(|i| Some((i, Part::matte(weight(i)?, weights[i]))));
            questions.offer(receiving, group, from, (in_sight, true), parts);
        } else {
            rough_parts(scene, (group, lobed), (j, source), (facing, &weights), parts, counters);
            questions.offer(receiving, group, from, (in_sight, false), parts.iter().copied());
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

/// The places of the ones.
fn bits(mut left: u64) -> impl Iterator<Item = usize> + Clone {
    std::iter::from_fn(move || {
        let first = left.trailing_zeros();
        left &= left.wrapping_sub(1);
        (first < 64).then_some(first as usize)
    })
}
