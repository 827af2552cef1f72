//! Objects within an object, which are told apart by their kind instead of their name.

use super::Params;
use crate::medium::Medium;
use crate::scene::error::SceneError;
use crate::scene::xml::Element;
use std::sync::Arc;

impl<'d> Params<'_, 'd> {
    /// All nested objects that are `meant`, whatever their name, in order. With each comes what names it
    /// here: itself, or the `<ref>` to it.
    pub fn nested(
        &mut self,
        kind: &'static str,
        about: &'static str,
        meant: impl Fn(&Element) -> bool,
    ) -> Vec<(&'d Element, &'d Element)> {
        self.ask(kind, "object", "none".into(), about);
        let matching = self.children.iter_mut().filter(|c| !c.taken && meant(c.element));
        matching
            .map(|c| {
                c.taken = true;
                (c.element, c.site)
            })
            .collect()
    }

    /// At most one nested object that is `meant`.
    pub fn one_nested(
        &mut self,
        kind: &'static str,
        about: &'static str,
        meant: impl Fn(&Element) -> bool,
    ) -> Result<Option<(&'d Element, &'d Element)>, SceneError> {
        let found = self.nested(kind, about, meant);
        match found[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            [_, (_, second), ..] => {
                Err(SceneError::at(&second.span, format!("a second <{kind}>"), "expected only one"))
            }
        }
    }

    /// The error that there is no nested object of a kind: at what stands in its place, if anything does.
    pub fn lacks(&self, kind: &str, expected: &str) -> SceneError {
        match self.children.iter().find(|c| !c.taken && c.name.is_none()) {
            Some(other) => SceneError::at(
                &other.site.span,
                format!("a <{}> is no <{kind}>", other.element.tag),
                expected,
            ),
            None => SceneError::at(&self.element.span, format!("there is no nested <{kind}>"), expected),
        }
    }

    /// At most one medium, whatever its name.
    pub fn any_medium(&mut self, about: &'static str) -> Result<Option<Arc<Medium>>, SceneError> {
        let found = self.object("medium", about)?;
        found.map(|element| self.loader.medium(element)).transpose()
    }

    /// The medium of this name, if the file gives one.
    pub fn medium(
        &mut self,
        name: &'static str,
        about: &'static str,
    ) -> Result<Option<Arc<Medium>>, SceneError> {
        let Some(element) = self.raw(name, "medium", "none", about)? else { return Ok(None) };
        if element.tag != "medium" {
            let message = format!("`{name}` cannot be a <{}>", element.tag);
            return Err(SceneError::at(&element.span, message, "expected <medium>, or a <ref> to one"));
        }
        self.loader.medium(element).map(Some)
    }

    /// All nested objects of a kind, whatever their name, in order.
    pub fn objects(&mut self, tag: &'static str, about: &'static str) -> Vec<&'d Element> {
        let found = self.nested(tag, about, |element| element.tag == tag);
        found.into_iter().map(|(element, _)| element).collect()
    }

    /// At most one nested object of a kind.
    pub fn object(
        &mut self,
        tag: &'static str,
        about: &'static str,
    ) -> Result<Option<&'d Element>, SceneError> {
        let found = self.one_nested(tag, about, |element| element.tag == tag)?;
        Ok(found.map(|(element, _)| element))
    }
}
