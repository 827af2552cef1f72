//! The selection of trials, closed forms and relations of a report, and their evaluation.

use crate::crew::{ask_all, settled};
use crate::trial::Trial;
use std::collections::BTreeSet;
use validation::Outcome;

/// If `sparse`, only the second of the trials that differ in direction only, which is oblique; otherwise all.
pub fn thin(trials: Vec<Trial>, sparse: bool) -> Vec<Trial> {
    let about = |trial: &Trial| trial.name.rsplit_once("::").map(|(about, _)| about.to_string());
    let groups = trials.chunk_by(|a, b| about(a) == about(b));
    groups
        .flat_map(|group| if sparse { &group[group.len().min(2) - 1..group.len().min(2)] } else { group })
        .cloned()
        .collect()
}

/// If `sparse`, only the first of each family of things named `family::thing`; otherwise all.
pub fn one_of_a_family<T>(mut things: Vec<T>, name: impl Fn(&T) -> &String, sparse: bool) -> Vec<T> {
    let mut seen = BTreeSet::new();
    let family = |thing: &T| name(thing).split("::").next().map(String::from);
    things.retain(|thing| !sparse || seen.insert(family(thing)));
    things
}

/// The outcomes of all questions, in their order. One that could not be evaluated is inconclusive, with the
/// error as its message.
pub fn judge<T: Sync>(
    questions: &[T],
    name: impl Fn(&T) -> &str + Sync,
    ask: impl Fn(&T) -> Result<Option<Outcome>, String> + Sync,
) -> Result<Vec<Outcome>, String> {
    let answers = ask_all(questions, settled(name, ask))?;
    Ok(answers.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials;
    use validation::Verdict;

    #[test]
    fn answers_keep_the_order_of_questions() {
        let questions: Vec<String> = (0..100).map(|i| i.to_string()).collect();
        let answers = judge(
            &questions,
            |question| question,
            |question| match question.len() {
                1 => Ok(None),
                _ if question == "50" => Err("why".into()),
                _ => Ok(Some(Outcome::new("x", Verdict::Equivalent, "").of(question))),
            },
        );
        let answers = answers.unwrap();
        assert_eq!(
            answers.iter().map(|o| &o.subject).collect::<Vec<_>>(),
            questions[10..].iter().collect::<Vec<_>>()
        );
        assert_eq!((answers[40].verdict, answers[40].message.as_str()), (Verdict::Inconclusive, "why"));
    }

    #[test]
    fn sparse_keeps_one_direction_of_each_check() {
        let all = materials::trials(Some("diffuse"));
        let few = thin(all.clone(), true);
        assert!(all.len() == 6 * few.len() && few.iter().all(|trial| trial.name.ends_with("::35")));
        assert_eq!(thin(all.clone(), false).len(), all.len());
    }
}
