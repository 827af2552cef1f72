//! Valid names of channels in a file.

use super::VARIANCE;

/// Most characters of a channel's name: OpenEXR must have room for the name of its variance.
const LONGEST: usize = 255 - VARIANCE.len();

/// Finds out whether a file can hold channels of these names, each with its variance.
///
/// # Errors
/// With the place in the list of the first that it cannot hold, and the reason.
pub fn check_names(names: &[String]) -> Result<(), (usize, String)> {
    names.iter().enumerate().try_for_each(|(i, name)| {
        let count = name.chars().count();
        let why = if name.is_empty() {
            "a channel would have no name".into()
        } else if count > LONGEST {
            format!("the name of a channel would have {count} characters, more than {LONGEST}")
        } else if !name.is_ascii() {
            // Readers take the bytes for UTF-8, for Latin-1, or for neither.
            format!("the name `{name}` of a channel has characters beyond ASCII")
        } else if name.starts_with(VARIANCE) {
            format!(
                "a channel would have the name `{name}`: `variance` is taken by the variances of channels"
            )
        } else if names[..i].contains(name) {
            format!("two channels would have the name `{name}`")
        } else {
            return Ok(());
        };
        Err((i, why))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_name_that_no_file_can_hold_is_found() {
        let found = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            check_names(&names)
                .map_err(|(index, why)| (index, why.split(' ').next_back().unwrap().to_owned()))
        };
        assert_eq!(found(&["R", "G", "variances", "variance", &"x".repeat(246)]), Ok(()));
        for (bad, word) in
            [("", "name"), ("R", "`R`"), ("variance.R", "channels"), ("é", "ASCII"), ("λ", "ASCII")]
        {
            assert_eq!(found(&["R", bad, bad]), Err((1, word.to_owned())));
        }
        assert_eq!(found(&["R", &"x".repeat(247)]), Err((1, "246".to_owned())));
    }
}
