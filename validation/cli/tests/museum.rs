//! Tests that the catalogue of bugs fits the sources.

use std::collections::BTreeSet;
use validate::museum::{bugs, root};

#[test]
fn every_bug_still_applies() {
    let bugs = bugs::catalogue(&bugs::folder()).unwrap();
    let errors: Vec<String> = bugs.iter().filter_map(|bug| bug.change(&root()).err()).collect();
    assert!(errors.is_empty(), "{}", errors.join("\n"));
    assert!(bugs.len() >= 60, "{} bugs", bugs.len());
}

#[test]
fn every_bug_has_a_name_of_its_own_and_a_source() {
    let mut names = BTreeSet::new();
    for bug in bugs::catalogue(&bugs::folder()).unwrap() {
        assert!(names.insert(bug.name.clone()), "{} is there twice", bug.name);
        assert!(bug.about.len() > 20 && bug.source.len() > 10, "{} says too little of itself", bug.name);
        assert_ne!(bug.find, bug.replace, "{} changes nothing", bug.name);
    }
}

#[test]
fn every_bug_is_an_expression_in_place_of_another() {
    for bug in bugs::catalogue(&bugs::folder()).unwrap() {
        for code in [&bug.find, &bug.replace] {
            let parsed = syn::parse_str::<syn::Expr>(code);
            assert!(parsed.is_ok(), "{}: `{code}` is no expression", bug.name);
        }
    }
}
