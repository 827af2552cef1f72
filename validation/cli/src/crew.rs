//! Parallel evaluation of many items by as many threads as there are cores, with results in the order of the
//! items.

use crate::console::print;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use validation::{Outcome, Verdict};

/// Evaluates `ask` on all questions and passes the answers to `tell` in the order of the questions, each as
/// soon as those before it are known. A question that panicked is an error after all others have been answered.
fn ask_in_turn<T: Sync, A: Send>(
    questions: &[T],
    ask: impl Fn(&T) -> A + Sync,
    mut tell: impl FnMut(A),
) -> Result<(), String> {
    let next = AtomicUsize::new(0);
    let (answered, answers) = mpsc::channel();
    let work = |answered: mpsc::Sender<(usize, A)>| {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(question) = questions.get(index) else { return };
            // The other end is open until all of these are closed.
            let _ = answered.send((index, ask(question)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|_| {
                let answered = answered.clone();
                scope.spawn(|| work(answered))
            })
            .collect();
        drop(answered);
        let mut early = BTreeMap::new();
        let mut told = 0;
        for (index, answer) in answers {
            early.insert(index, answer);
            while let Some(answer) = early.remove(&told) {
                tell(answer);
                told += 1;
            }
        }
        // All threads are joined, since a scope panics if a thread that was not joined has panicked.
        let panicked = workers.into_iter().map(|worker| worker.join()).filter(Result::is_err).count();
        if panicked > 0 { Err("a check stopped without an answer".into()) } else { Ok(()) }
    })
}

/// The answer to each question, in the order of the questions; an error if one of them panicked.
pub fn ask_all<T: Sync, A: Send>(questions: &[T], ask: impl Fn(&T) -> A + Sync) -> Result<Vec<A>, String> {
    let mut answers = Vec::with_capacity(questions.len());
    ask_in_turn(questions, ask, |answer| answers.push(answer))?;
    Ok(answers)
}

/// The outcome of a question that could not be evaluated.
pub fn unanswered(subject: &str, error: String) -> Outcome {
    Outcome::new("question", Verdict::Inconclusive, error).of(subject)
}

/// The outcome of any question, by one that may fail.
pub fn settled<T>(
    name: impl Fn(&T) -> &str + Sync,
    ask: impl Fn(&T) -> Result<Option<Outcome>, String> + Sync,
) -> impl Fn(&T) -> Option<Outcome> + Sync {
    move |question| ask(question).unwrap_or_else(|error| Some(unanswered(name(question), error)))
}

/// The outcomes of all questions, printed as they become known. One that could not be evaluated is
/// inconclusive, with the error as its message, so that it takes no other with it.
pub fn ask_and_print<T: Sync>(
    questions: &[T],
    name: impl Fn(&T) -> &str + Sync,
    ask: impl Fn(&T) -> Result<Option<Outcome>, String> + Sync,
) -> Result<Vec<Outcome>, String> {
    let mut outcomes = vec![];
    ask_in_turn(questions, settled(name, ask), |outcome| outcomes.extend(outcome.inspect(print)))?;
    Ok(outcomes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_keep_the_order_of_questions() {
        let questions: Vec<usize> = (0..1000).collect();
        assert_eq!(
            ask_all(&questions, |question| 2 * question).unwrap(),
            (0..2000).step_by(2).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_panic_is_an_error() {
        assert!(ask_all(&[0, 1, 2], |&question| assert_ne!(question, 1)).is_err());
    }
}
