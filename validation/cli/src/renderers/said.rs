//! What a renderer says of the time that it took.

/// Times from the JSON at the end of standard output: on the last line that is JSON, or the whole output.
#[derive(Debug, Default, PartialEq)]
pub struct Said {
    pub seconds: Option<f64>,
    pub planning: Option<f64>,
    pub cpu_seconds: Option<f64>,
}

impl Said {
    /// Error: a time that is none.
    pub fn of(text: &str) -> Result<Said, String> {
        let read =
            |text: &str| serde_json::from_str::<serde_json::Value>(text).ok().filter(|v| v.is_object());
        let Some(document) = text.lines().rev().find_map(read).or_else(|| read(text)) else {
            return Ok(Said::default());
        };
        let number = |name: &str, is_time: fn(f64) -> bool| match document.get(name) {
            None => Ok(None),
            Some(value) => match value.as_f64().filter(|s| is_time(*s)) {
                Some(seconds) => Ok(Some(seconds)),
                None => Err(format!("it says {name:?}: {value}, which is no time")),
            },
        };
        Ok(Said {
            // No clock tells less.
            seconds: number("seconds", |s| s >= 1e-9)?,
            planning: number("plan_seconds", |s| s >= 0.0)?,
            // A clock of hundredths may say that nothing passed.
            cpu_seconds: number("cpu_seconds", |s| s >= 0.0)?.filter(|s| *s > 0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_found_at_the_end() {
        let said = |text: &str| Said::of(text).unwrap().seconds;
        assert_eq!(said("noise\n{\"seconds\": 1.5, \"startup\": 9}\n"), Some(1.5));
        assert_eq!(said("{\"seconds\": 1.5}\nlast words\n"), Some(1.5));
        assert_eq!(said("{\n\"seconds\": 2\n}\n"), Some(2.0));
        assert_eq!(Said::of("{\"seconds\": 1.5, \"plan_seconds\": 0.25}").unwrap().planning, Some(0.25));
        assert_eq!(said("done"), None);
        for wrong in ["-1", "0", "\"fast\"", "null"] {
            let error = Said::of(&format!("{{\"seconds\": {wrong}}}")).unwrap_err();
            assert_eq!(error, format!("it says \"seconds\": {wrong}, which is no time"));
        }
    }
}
