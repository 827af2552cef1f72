//! The parameters of a scene: `$name` in an attribute, from `<default>` or the command line.

use crate::scene::error::{SceneError, Span, known};
use std::collections::BTreeMap;

/// Most bytes of all attributes with parameters together, after substitution: a parameter made of two others
/// doubles.
const MOST_SUBSTITUTED: usize = 1 << 27;

struct Parameter {
    value: String,
    given: bool,
    used: bool,
}

/// All parameters by name.
pub struct Parameters {
    known: BTreeMap<String, Parameter>,
    /// Bytes of all attributes with parameters so far, after substitution.
    substituted: usize,
}

impl Parameters {
    /// The parameters that the command line defines.
    pub fn new(definitions: &[(String, String)]) -> Self {
        let parameter = |(name, value): &(String, String)| {
            (name.clone(), Parameter { value: value.clone(), given: true, used: false })
        };
        Self { known: definitions.iter().map(parameter).collect(), substituted: 0 }
    }

    /// Adds a `<default>`: the value where the command line gives none.
    pub fn default(&mut self, name: &str, value: String) {
        let fresh = Parameter { value, given: false, used: false };
        // A definition on the command line is used even where no attribute reads it yet.
        self.known.entry(name.to_owned()).and_modify(|p| p.used = true).or_insert(fresh);
    }

    /// Refuses what the command line gives and the scene does not have.
    pub fn finish(&self) -> Result<(), SceneError> {
        let Some((name, _)) = self.known.iter().find(|(_, p)| p.given && !p.used) else { return Ok(()) };
        let names: Vec<&str> = self.known.iter().filter(|p| p.1.used).map(|p| p.0.as_str()).collect();
        let message = format!("-D {name}: the scene has no parameter ${name}; {}", known(name, &names));
        Err(SceneError::nowhere(message))
    }

    /// Replaces `$name`; where several names fit, the longest does. `\$` is a dollar sign.
    pub fn substitute(&mut self, text: &str, span: &Span) -> Result<String, SceneError> {
        let mut result = String::new();
        let mut rest = text;
        while let Some(i) = rest.find('$') {
            let before = &rest[..i];
            rest = &rest[i + 1..];
            if let Some(before) = before.strip_suffix('\\') {
                result.push_str(before);
                result.push('$');
                continue;
            }
            result.push_str(before);
            let fits = |(name, _): &(&String, &mut Parameter)| rest.starts_with(name.as_str());
            let found = self.known.iter_mut().filter(fits).max_by_key(|(name, _)| name.len());
            let Some((name, parameter)) = found else {
                let names: Vec<&str> = self.known.keys().map(String::as_str).collect();
                let word: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let others = if names.is_empty() { String::new() } else { known(&word, &names) + "; " };
                let help = format!("{others}define it with a <default> before this, or with -D");
                return Err(SceneError::at(span, format!("undefined parameter `${word}`"), help));
            };
            parameter.used = true;
            self.substituted += parameter.value.len();
            if self.substituted > MOST_SUBSTITUTED {
                let message =
                    format!("with this the scene's parameters are longer than {MOST_SUBSTITUTED} bytes");
                return Err(SceneError::at(span, message, "parameters of parameters multiply"));
            }
            result.push_str(&parameter.value);
            rest = &rest[name.len()..];
        }
        result.push_str(rest);
        Ok(result)
    }
}
