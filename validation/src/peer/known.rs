//! Answers, quick to find for who asks again and again in about the same order.
//!
//! A check that runs anew asks what it asked before, with further questions here and there. So the questions of the
//! run before are kept in order, and the next one is expected where the last one was found; only what comes
//! unexpectedly is looked up.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::{BuildHasher, RandomState};

/// The bits of a question: two directions, or a direction and three numbers.
pub type Key = [u64; 6];

struct Question<A> {
    key: Key,
    /// `None` until the answer is known.
    answer: Option<A>,
    /// Where the run before asked it, the last time.
    asked: usize,
}

/// See the module.
#[derive(Default)]
pub struct Known<A> {
    questions: Vec<Question<A>>,
    /// The question of each hash of a key; the next number is taken if another has it already. There may be tens
    /// of millions, and keys would take three times as much room.
    places: HashMap<u64, u32>,
    hasher: RandomState,
    /// The questions of the run before and of this one, in order.
    before: Vec<u32>,
    now: Vec<u32>,
    /// Where in `before` the next question is expected.
    next: usize,
}

impl<A> Known<A> {
    /// The answer to a question, or `None`; and whether it was asked for the first time ever.
    pub fn ask(&mut self, key: Key) -> (Option<&A>, bool) {
        let expected = self.before.get(self.next).copied();
        let (place, new) = match expected.filter(|&place| self.questions[place as usize].key == key) {
            Some(place) => {
                self.next += 1;
                (place, false)
            }
            None => {
                let (place, new) = self.find(key);
                if !new {
                    self.next = self.questions[place as usize].asked + 1;
                }
                (place, new)
            }
        };
        self.now.push(place);
        (self.questions[place as usize].answer.as_ref(), new)
    }

    /// Keeps the answer to a question.
    pub fn learn(&mut self, key: Key, answer: A) {
        let (place, _) = self.find(key);
        self.questions[place as usize].answer = Some(answer);
    }

    /// Begins another run.
    pub fn again(&mut self) {
        self.before = std::mem::take(&mut self.now);
        self.now.reserve(self.before.len());
        self.next = 0;
        for (asked, &place) in self.before.iter().enumerate() {
            self.questions[place as usize].asked = asked;
        }
    }

    /// The place of a question, and whether it is new.
    fn find(&mut self, key: Key) -> (u32, bool) {
        let mut hash = self.hasher.hash_one(key);
        loop {
            match self.places.entry(hash) {
                Entry::Occupied(place) if self.questions[*place.get() as usize].key == key => {
                    return (*place.get(), false);
                }
                Entry::Occupied(_) => hash = hash.wrapping_add(1),
                Entry::Vacant(free) => {
                    let place = self.questions.len() as u32;
                    free.insert(place);
                    self.questions.push(Question { key, answer: None, asked: 0 });
                    return (place, true);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_found_in_whatever_order_they_are_asked_for() {
        let mut known = Known::default();
        let key = |i: u64| [i; 6];
        for (i, new) in [(3, true), (1, true), (4, true), (1, false), (5, true)] {
            assert_eq!(known.ask(key(i)), (None, new), "{i}");
        }
        for i in [1, 3, 4, 5] {
            known.learn(key(i), 10 * i);
        }
        let orders: [&[u64]; 4] = [&[3, 1, 4, 1, 5], &[3, 7, 1, 1, 5, 4], &[5, 4, 3, 1, 8, 5, 5], &[9, 3]];
        for order in orders {
            known.again();
            for &i in order {
                let (answer, _) = known.ask(key(i));
                assert_eq!(answer.copied(), (i < 6).then_some(10 * i), "{order:?}");
            }
        }
    }

    #[test]
    fn questions_of_one_hash_are_told_apart() {
        let mut known = Known::default();
        let (one, other) = ([1; 6], [2; 6]);
        known.learn(one, "one");
        // As if the other had the same hash.
        let place = known.places[&known.hasher.hash_one(one)];
        known.places.insert(known.hasher.hash_one(other), place);
        known.learn(other, "other");
        assert_eq!(known.ask(one), (Some(&"one"), false));
        assert_eq!(known.ask(other), (Some(&"other"), false));
    }
}
