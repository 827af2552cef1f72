//! Errors that point at a place in a scene file.

pub use crate::spelling::known;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// A scene file as it was read.
#[derive(Debug)]
pub struct Source {
    pub path: PathBuf,
    pub text: String,
}

/// A stretch of a scene file, in bytes.
#[derive(Clone, Debug)]
pub struct Span {
    pub source: Arc<Source>,
    pub range: Range<usize>,
}

/// What is wrong with a scene, where, and what was expected instead.
#[derive(Debug)]
pub struct SceneError {
    pub message: String,
    /// What was expected, shown at the marked place; may be empty.
    pub expected: String,
    /// The place; boxed because every `Result` is as large as this type.
    pub span: Option<Box<Span>>,
}

impl SceneError {
    /// An error at a place.
    pub fn at(span: &Span, message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { message: line(message.into()), expected: expected.into(), span: Some(Box::new(span.clone())) }
    }

    /// An error about no place in particular, such as a file that cannot be opened.
    pub fn nowhere(message: impl Into<String>) -> Self {
        Self { message: line(message.into()), expected: String::new(), span: None }
    }

    /// Gives an error without a place the place that led to it.
    pub fn or_at(mut self, span: &Span) -> Self {
        self.span.get_or_insert_with(|| Box::new(span.clone()));
        self
    }

    /// Line and column, both from 1, of the place; columns count characters.
    pub fn line_column(&self) -> Option<(usize, usize)> {
        self.span.as_ref().map(|span| span.line_column())
    }
}

/// A message as one line, cut where what it quotes of a file is long.
fn line(mut message: String) -> String {
    const MOST: usize = 400;
    if let Some((end, _)) = message.char_indices().nth(MOST) {
        message.truncate(end);
        message.push('…');
    }
    if message.contains(char::is_control) { message.replace(char::is_control, "�") } else { message }
}

impl Span {
    fn line_column(&self) -> (usize, usize) {
        let before = &self.source.text[..self.range.start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// File, line and column, as messages write them.
    pub fn place(&self) -> String {
        let (line, column) = self.line_column();
        format!("{}:{line}:{column}", self.source.path.display())
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(span) = &self.span else {
            return write!(f, "error: {}", self.message);
        };
        let path = span.source.path.display().to_string();
        let mark = AnnotationKind::Primary.span(span.range.clone());
        let mark = if self.expected.is_empty() { mark } else { mark.label(&*self.expected) };
        let snippet = Snippet::source(&*span.source.text).path(&*path).annotation(mark);
        let report = &[Level::ERROR.primary_title(&*self.message).element(snippet)];
        write!(f, "{}", Renderer::plain().render(report))
    }
}

impl std::error::Error for SceneError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_shows_its_line_and_what_was_expected() {
        let source =
            Arc::new(Source { path: "a.xml".into(), text: "<scene>\n  <float nme=\"x\"/>\n".into() });
        let start = source.text.find("nme").unwrap();
        let error =
            SceneError::at(&Span { source, range: start..start + 3 }, "unknown attribute", "known: name");
        assert_eq!(error.line_column(), Some((2, 10)));
        let text = error.to_string();
        assert!(
            text.contains("a.xml:2:10") && text.contains("<float nme") && text.contains("known: name"),
            "{text}"
        );
    }

    #[test]
    fn a_message_is_one_line_of_bounded_length() {
        let error = SceneError::nowhere(format!("`{}\n`", "é".repeat(399)));
        assert_eq!(error.message, format!("`{}…", "é".repeat(399)));
        assert_eq!(SceneError::nowhere("a\nb").message, "a�b");
    }

    #[test]
    fn near_names_are_suggested_first() {
        assert!(known("alhpa", &["beta", "alpha"]).starts_with("did you mean `alpha`?"));
        assert_eq!(known("zzzzzz", &["beta", "alpha"]), "known: beta, alpha");
    }
}
