//! Many questions asked by as many threads as there are cores, answered in their order.

use std::sync::atomic::{AtomicUsize, Ordering};

/// The answer to each question, in the order of the questions; an error if one of them panicked.
pub fn ask_all<T: Sync, A: Send>(questions: &[T], ask: impl Fn(&T) -> A + Sync) -> Result<Vec<A>, String> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut answers = vec![];
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(question) = questions.get(index) else { return answers };
            answers.push((index, ask(question)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let answers = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join()).collect::<Result<Vec<_>, _>>()
    });
    let mut answers: Vec<(usize, A)> =
        answers.map_err(|_| "a check stopped without an answer".to_string())?.into_iter().flatten().collect();
    answers.sort_by_key(|(index, _)| *index);
    Ok(answers.into_iter().map(|(_, answer)| answer).collect())
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
