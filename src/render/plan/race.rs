//! A race of the ways to render a scene that [`reuse`] chooses from. All are looked at in the same few cells;
//! those that are far behind the best drop out, the rest are looked at in more cells, and so on.

use super::cells::Cells;
use super::direct::Direct;
use super::light_paths::LightPathGain;
use super::look::{Cell, Look, Measurements};
use super::reuse::{self, Candidate};
use crate::integrator::caustics::Caustics;
use crate::integrator::path::Open;
use crate::math::function::ln;
use crate::sampler::blocks::MOST_EMITTER_SAMPLES;
use crate::scene::Scene;

/// A number to choose, and the factor by which the product of variance and cost is multiplied for comparison if it
/// is chosen: correlated errors are a price as well, which a small gain is not worth.
#[derive(Clone, Copy)]
struct Priced {
    number: u32,
    price: f64,
}

const fn priced(number: u32, price: f64) -> Priced {
    Priced { number, price }
}

/// Numbers of pixels that share, to choose from besides one.
const PIXELS: [Priced; 2] = [priced(16, 1.1), priced(64, 1.2)];

/// Pixels per shared light path. The pilot, which looks at one colour and few samples, overestimates what light
/// paths gain where little noise is left.
const PIXELS_PER_LIGHT_PATH: Priced = priced(8, 1.4);

/// Numbers of emitter samples, as multiples of what other vertices take.
const SAMPLES: [Priced; 4] = [priced(1, 1.0), priced(2, 1.05), priced(4, 1.1), priced(8, 1.15)];

/// Numbers of cells of the stages of a race; the last is all that a look goes on to.
const STAGES: [usize; 4] = [8, 16, 32, usize::MAX];

/// A candidate that shares more pixels, or has shared light paths, enters the race only when one that shares
/// less has a product within this factor of the best. In no scene that was tried would it have won otherwise.
const FAR: f64 = 1.3;

/// What is not better than the best so far by this factor, however unlucky it was, drops out.
const GAIN: f64 = 1.1;

/// Standard errors within which ratios of products are believed to be.
const SURE: f64 = 2.0;

/// Cells that the number of light paths for caustics is chosen by.
const BALANCED: usize = 24;

/// A choice, and what is known or foretold of it with as many light paths for caustics to a camera path as
/// are best.
pub struct Judged {
    pub choice: Candidate,
    pub caustics: Option<f64>,
    look: Look,
    /// Variance times cost times prices.
    product: f64,
}

impl Judged {
    /// By a look that was measured or is predicted.
    fn new(choice: Candidate, look: Look, price: f64, brought: Option<&LightPathGain>) -> Self {
        let (look, caustics) = match brought.map(|brought| brought.best_with(&look)) {
            Some((look, light_paths)) => (look, Some(light_paths)),
            None => (look, None),
        };
        Self { choice, caustics, product: price * look.product(), look }
    }

    /// Whether this would gain little over the best so far even if chance had been against it. What two
    /// choices have in each cell, relative to their means over the cells, differs; the logarithm of the ratio
    /// of the means is uncertain by the standard error of the mean difference.
    fn is_far_behind(&self, best: &Self) -> bool {
        let means = [self.look.deviation(), best.look.deviation()];
        let cells = self.look.cells.len() as f64;
        let square = |(own, best): (&Cell, &Cell)| {
            let difference = own.variance.sqrt() / means[0] - best.variance.sqrt() / means[1];
            own.weight * difference * (own.weight * difference)
        };
        let squares: f64 = self.look.cells.iter().zip(&best.look.cells).map(square).sum();
        // The product has the square of the mean.
        let error = 2.0 * (squares * (cells / (cells - 1.0))).sqrt();
        self.product > best.product && ln(self.product / best.product) > SURE * error - ln(GAIN)
    }
}

/// A way to render, with several numbers of emitter samples.
struct Entrant {
    /// With the fewest emitter samples.
    choice: Candidate,
    price: f64,
    /// Numbers of emitter samples that are in the race.
    samples: Vec<Priced>,
    measured: Measurements,
}

/// All ways to render with light paths for caustics, or without them.
struct Field {
    caustics: bool,
    /// The first shares nothing. It is looked at as long as it is in the race or predicts others.
    entrants: Vec<Entrant>,
    /// The first entrant with the most emitter samples, while their number is open.
    with_most_samples: Option<Entrant>,
    waiting: Vec<Waiting>,
}

/// What enters the race once one of others is within [`FAR`] of the best.
struct Waiting {
    candidate: Candidate,
    price: f64,
    others: Vec<Candidate>,
}

/// All fields of a scene.
pub struct Race<'a> {
    scene: &'a mut Scene,
    cells: Cells,
    fields: Vec<Field>,
    /// All numbers of emitter samples to choose from.
    samples: Vec<Priced>,
    /// What light paths for caustics bring.
    brought: Option<LightPathGain>,
    /// These light paths, while the scene is without them.
    unused_caustics: Option<Caustics>,
}

impl<'a> Race<'a> {
    /// Of the settings of a scene that are open; the others are as given.
    pub fn new(scene: &'a mut Scene, given: Candidate, open: Open) -> Self {
        let times = |Priced { number: times, price }| {
            priced((times * given.samples).min(MOST_EMITTER_SAMPLES), price)
        };
        let all = open.first_emitter_samples;
        let samples = if all { SAMPLES.map(times).into() } else { vec![priced(given.samples, 1.0)] };
        let brought = LightPathGain::of(scene);
        let evenly = || Cells::of(scene.sensor.film.crop, |_| false);
        let cells = brought.as_ref().map_or_else(evenly, LightPathGain::cells);
        let relieved =
            scene.techniques.links.as_ref().is_some_and(|links| links.everywhere) && open.light_paths;
        let field = |caustics| Field::new(caustics, given, &samples, open.shared_light_paths);
        let with = brought.is_some();
        let fields = if with && relieved { vec![field(true), field(false)] } else { vec![field(with)] };
        Self { scene, cells, fields, samples, brought, unused_caustics: None }
    }

    /// Runs it, and gives the scene the settings of the winner.
    pub fn run(mut self) -> Judged {
        for stage in STAGES {
            let count = stage.min(self.cells.len());
            loop {
                self.look(count);
                if !self.let_in() {
                    break;
                }
            }
            self.drop_those_behind();
            self.fields.iter_mut().for_each(Field::settle_samples);
            let still =
                self.fields.iter().flat_map(|field| &field.entrants).map(|entrant| entrant.samples.len());
            if still.sum::<usize>() == 1 && (self.brought.is_none() || count >= BALANCED) {
                break;
            }
        }
        let best = self.best();
        self.apply(best.caustics.is_some(), best.choice);
        best
    }

    /// Gives the scene these settings.
    fn apply(&mut self, caustics: bool, choice: Candidate) {
        if self.brought.is_some() && self.scene.techniques.caustics.is_some() != caustics {
            std::mem::swap(&mut self.scene.techniques.caustics, &mut self.unused_caustics);
        }
        reuse::set(self.scene, choice);
    }

    /// Looks at all that is in the race until the first so many cells have been seen.
    fn look(&mut self, count: usize) {
        let mut fields = std::mem::take(&mut self.fields);
        for field in &mut fields {
            let caustics = field.caustics;
            for entrant in field.looked_at() {
                self.apply(caustics, entrant.choice);
                entrant.measured.extend(self.scene, &self.cells, count);
            }
        }
        self.fields = fields;
    }

    /// The best that is in the race; of equals the first.
    fn best(&self) -> Judged {
        let judged = self.fields.iter().flat_map(|field| field.judged(self.brought.as_ref()));
        let better = |a: Judged, b: Judged| if b.product < a.product { b } else { a };
        judged.flatten().reduce(better).expect("the best stays in the race")
    }

    /// Takes out of the race what is far behind.
    fn drop_those_behind(&mut self) {
        let best = self.best();
        for field in &mut self.fields {
            let judged: Vec<_> = field.judged(self.brought.as_ref()).collect();
            for (entrant, judged) in field.entrants.iter_mut().zip(judged) {
                let mut behind = judged.iter().map(|judged| judged.is_far_behind(&best));
                entrant.samples.retain(|_| behind.next() != Some(true));
            }
        }
    }

    /// Lets in those that need wait no longer, and says whether there were any.
    fn let_in(&mut self) -> bool {
        let limit = FAR * self.best().product;
        let (brought, samples) = (self.brought.as_ref(), &self.samples);
        let entered: usize = self.fields.iter_mut().map(|field| field.let_in(limit, brought, samples)).sum();
        entered > 0
    }
}

impl Field {
    fn new(caustics: bool, given: Candidate, samples: &[Priced], shares_light_paths: bool) -> Self {
        let Priced { number: each, price: more } = PIXELS_PER_LIGHT_PATH;
        let (mut waiting, mut unlit_before, mut lit_before) = (vec![], given, None);
        for Priced { number: pixels, price } in PIXELS {
            let unlit = Candidate { pixels, ..given };
            let lit = Candidate { light_paths: pixels / each, ..unlit };
            waiting.push(Waiting { candidate: unlit, price, others: vec![unlit_before] });
            if shares_light_paths {
                let others = [unlit].into_iter().chain(lit_before).collect();
                waiting.push(Waiting { candidate: lit, price: price * more, others });
            }
            (unlit_before, lit_before) = (unlit, Some(lit));
        }
        let most = samples.iter().map(|samples| samples.number).max().filter(|most| *most > given.samples);
        Self {
            caustics,
            entrants: vec![Entrant::new(given, 1.0, samples)],
            with_most_samples: most.map(|samples| Entrant::new(Candidate { samples, ..given }, 1.0, &[])),
            waiting,
        }
    }

    /// What is to be looked at.
    fn looked_at(&mut self) -> impl Iterator<Item = &mut Entrant> {
        let predicts = self.with_most_samples.is_some();
        let raced = self.entrants.iter_mut().enumerate();
        let raced = raced.filter(move |(i, entrant)| !entrant.samples.is_empty() || (*i == 0 && predicts));
        raced.map(|(_, entrant)| entrant).chain(&mut self.with_most_samples)
    }

    /// What is in the race, judged, by entrant.
    fn judged(&self, brought: Option<&LightPathGain>) -> impl Iterator<Item = Vec<Judged>> {
        let (first, brought) = (&self.entrants[0], brought.filter(|_| self.caustics));
        let direct = self.with_most_samples.as_ref().map(|many| {
            let looked = |entrant: &Entrant| (entrant.choice.samples, entrant.measured.look());
            Direct::between(looked(first), looked(many))
        });
        self.entrants.iter().map(move |entrant| entrant.judged(direct.as_ref(), brought))
    }

    /// Lets in those that wait for what is within a limit, and says how many there were.
    fn let_in(&mut self, limit: f64, brought: Option<&LightPathGain>, samples: &[Priced]) -> usize {
        let judged: Vec<_> = self.judged(brought).collect();
        let near = |(entrant, judged): (&Entrant, Vec<Judged>)| {
            judged.iter().any(|judged| judged.product <= limit).then_some(entrant.choice)
        };
        let near: Vec<_> = self.entrants.iter().zip(judged).filter_map(near).collect();
        let (entering, waiting): (Vec<_>, Vec<_>) = std::mem::take(&mut self.waiting)
            .into_iter()
            .partition(|waiting| waiting.others.iter().any(|other| near.contains(other)));
        self.waiting = waiting;
        let entered = entering.len();
        self.entrants.extend(entering.into_iter().map(|new| Entrant::new(new.candidate, new.price, samples)));
        entered
    }

    /// Predicts nothing any more once nothing in the race has more emitter samples than it is looked at with.
    fn settle_samples(&mut self) {
        let several =
            |entrant: &Entrant| entrant.samples.iter().any(|samples| samples.number > entrant.choice.samples);
        self.with_most_samples.take_if(|_| !self.entrants.iter().any(several));
    }
}

impl Entrant {
    fn new(choice: Candidate, price: f64, samples: &[Priced]) -> Self {
        Self { choice, price, samples: samples.into(), measured: Measurements::default() }
    }

    /// With each number of emitter samples that is in the race.
    fn judged(&self, direct: Option<&Direct>, brought: Option<&LightPathGain>) -> Vec<Judged> {
        if self.samples.is_empty() {
            return vec![];
        }
        let seen = self.measured.look();
        let with = |Priced { number: samples, price: more }: &Priced| {
            let choice = Candidate { samples: *samples, ..self.choice };
            let foretold = match direct {
                Some(direct) => direct.foretell(&seen, self.choice.samples, *samples),
                None => seen.clone(),
            };
            Judged::new(choice, foretold, self.price * more, brought)
        };
        self.samples.iter().map(with).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(variances: &[f64], cost: f64) -> Judged {
        let weight = 1.0 / variances.len() as f64;
        let cells = variances.iter().map(|v| Cell { variance: *v, weight, ..Cell::default() }).collect();
        let choice = Candidate { pixels: 1, light_paths: 0, samples: 1 };
        Judged::new(choice, Look { cells, cost }, 1.0, None)
    }

    #[test]
    fn what_drops_out_is_what_luck_cannot_explain() {
        let best = judged(&[1.0, 4.0, 9.0, 1.0], 1.0);
        // A little dearer in each cell alike: nothing to hope for.
        assert!(judged(&[1.0, 4.0, 9.0, 1.0], 1.01).is_far_behind(&best));
        assert!(judged(&[2.0, 8.0, 18.0, 2.0], 1.0).is_far_behind(&best));
        // Much noisier in one cell, and calmer in the others.
        let unlucky = judged(&[0.8, 3.0, 7.0, 9.0], 1.0);
        assert!(unlucky.product > 1.3 * best.product && !unlucky.is_far_behind(&best));
        assert!(!best.is_far_behind(&best) && !best.is_far_behind(&unlucky));
        let dark = judged(&[0.0; 4], 1.0);
        assert!(!dark.is_far_behind(&dark) && !judged(&[0.0; 4], 2.0).is_far_behind(&dark));
    }
}
