//! Typed access to the parameters of one object.
//!
//! A model asks for each parameter by name, with a default and a sentence about it. What was asked for is the
//! model's parameter table: `etalon plugins` prints it, and a parameter in the file that nobody asked for is
//! an error.

mod objects;
mod values;

use super::error::{SceneError, Span, known};
use super::loader::Loader;
use super::xml::Element;
use crate::spectrum::ColorMode;
use std::ops::RangeInclusive;

pub use values::number;

/// Largest amount of light, or of anything else that becomes `f32`: `f32` holds twice as much.
pub const MOST: f64 = 1.7e38;

/// What an error says of a number that is not from 0 to [`MOST`].
pub const EXPECTED_AMOUNT: &str = "expected no negative number, and none above 1.7e38";

/// What a colour is for, which decides how Mitsuba turns it into a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Usage {
    /// Between 0 and 1.
    Reflectance,
    /// Radiance and its like: RGB colours are relative to D65.
    Emission,
    /// A spectrum that is neither, such as an index of refraction.
    Unbounded,
    /// Three numbers that are no colour, such as a direction: no mode makes a spectrum of them.
    Vector,
    /// Not known, for a texture that stands by itself: only what no use could accept is refused, and no
    /// spectrum is made.
    Any,
}

impl Usage {
    /// Whether three numbers are meant as they are, and no spectrum is made of them.
    pub fn is_numbers(self, mode: ColorMode) -> bool {
        mode == ColorMode::Rgb || matches!(self, Self::Vector | Self::Any)
    }

    /// The numbers that a texture may have for this use, and how to say so.
    pub fn allowed(self) -> (RangeInclusive<f32>, &'static str) {
        const LARGEST: f32 = MOST as f32;
        match self {
            Self::Reflectance => (0.0..=1.0, "expected 0 to 1"),
            Self::Emission | Self::Unbounded => (0.0..=LARGEST, EXPECTED_AMOUNT),
            // A bump's height may be below zero.
            Self::Vector | Self::Any => (-LARGEST..=LARGEST, "expected finite numbers, none above 1.7e38"),
        }
    }
}

/// One row of a model's parameter table.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Parameter {
    pub name: &'static str,
    pub kind: &'static str,
    pub default: String,
    pub about: &'static str,
}

struct Child<'d> {
    name: Option<&'d str>,
    /// The element itself, or what a `<ref>` stands for.
    element: &'d Element,
    /// The child in the parent that stands for it: the element itself, or the `<ref>`.
    site: &'d Element,
    taken: bool,
}

/// The parameters of one object.
pub struct Params<'a, 'd> {
    pub element: &'d Element,
    pub loader: &'a Loader<'d>,
    /// What the object is used for by its parent; decides what colours inside a texture mean.
    pub usage: Usage,
    children: Vec<Child<'d>>,
    asked: Vec<Parameter>,
}

impl Drop for Params<'_, '_> {
    fn drop(&mut self) {
        self.loader.leave();
    }
}

impl<'a, 'd> Params<'a, 'd> {
    pub fn new(element: &'d Element, loader: &'a Loader<'d>, usage: Usage) -> Result<Self, SceneError> {
        element.only(&["type", "id", "name", "version"])?;
        loader.enter(element)?;
        let mut params = Self { element, loader, usage, children: vec![], asked: vec![] };
        for site in &element.children {
            let element = loader.resolve(site)?;
            let name = if site.tag == "ref" { site.name() } else { element.name() };
            params.children.push(Child { name, element, site, taken: false });
        }
        Ok(params)
    }

    /// The parameters asked for so far.
    pub fn asked(&self) -> &[Parameter] {
        &self.asked
    }

    /// Refuses what nobody asked for.
    pub fn finish(&self) -> Result<(), SceneError> {
        let Some(child) = self.children.iter().find(|c| !c.taken) else {
            return Ok(());
        };
        let kind = self.element.attribute("type").map_or(self.element.tag.as_str(), |a| a.value.as_str());
        let names: Vec<&str> = self.asked.iter().map(|p| p.name).collect();
        Err(match child.site.attribute("name") {
            Some(name) => SceneError::at(
                &name.value_span,
                format!("{} `{kind}` has no parameter `{}`", self.element.tag, name.value),
                known(&name.value, &names),
            ),
            // Only what is a model of its own is known by its kind.
            None if child.element.tag == "transform" || child.element.is_value() => SceneError::at(
                &child.site.span,
                format!("this <{}> of {} `{kind}` has no `name`", child.element.tag, self.element.tag),
                format!("known: {}", names.join(", ")),
            ),
            None => SceneError::at(
                &child.site.span,
                format!("{} `{kind}` cannot contain this <{}>", self.element.tag, child.element.tag),
                format!("known: {}", names.join(", ")),
            ),
        })
    }

    fn ask(&mut self, name: &'static str, kind: &'static str, default: String, about: &'static str) {
        if !self.asked.iter().any(|p| p.name == name) {
            self.asked.push(Parameter { name, kind, default, about });
        }
    }

    fn take(&mut self, name: &str) -> Result<Option<&'d Element>, SceneError> {
        let mut found: Option<&'d Element> = None;
        for child in self.children.iter_mut().filter(|c| c.name == Some(name)) {
            if found.is_some() {
                let message = format!("`{name}` is given twice");
                return Err(SceneError::at(&child.site.span, message, "expected it once"));
            }
            child.taken = true;
            found = Some(child.element);
        }
        Ok(found)
    }

    /// Whether the file gives the parameter.
    pub fn has(&self, name: &str) -> bool {
        self.children.iter().any(|c| c.name == Some(name))
    }

    /// The place of a parameter, or of the object when the file does not give it.
    pub fn span_of(&self, name: &str) -> &Span {
        let child = self.children.iter().find(|c| c.name == Some(name));
        child.map_or(&self.element.span, |c| {
            c.element.attribute("value").map_or(&c.site.span, |a| &a.value_span)
        })
    }

    /// An error at a parameter.
    pub fn error(&self, name: &str, message: impl Into<String>, expected: impl Into<String>) -> SceneError {
        SceneError::at(self.span_of(name), message, expected)
    }
}
