//! Typed access to the parameters of one object.
//!
//! A model asks for each parameter by name, with a default and a sentence about it. What was asked for is the
//! model's parameter table: `etalon plugins` prints it, and a parameter in the file that nobody asked for is
//! an error.

use super::error::{SceneError, Span, known};
use super::loader::Loader;
use super::xml::{Attribute, Element};
use crate::math::{DVec3, Transform};
use crate::texture::AnyTexture;
use std::path::PathBuf;

/// No amount of light, or of anything else that becomes `f32`, is larger: `f32` holds twice as much.
pub const MOST: f64 = 1.7e38;

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
    /// Where it stands in the parent.
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
                return Err(SceneError::at(&child.site.span, format!("`{name}` is given twice"), ""));
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

    fn value(&mut self, name: &'static str, tags: &[&str]) -> Result<Option<&'d Attribute>, SceneError> {
        let Some(element) = self.take(name)? else { return Ok(None) };
        if !tags.contains(&element.tag.as_str()) {
            let message = format!("`{name}` cannot be a <{}>", element.tag);
            return Err(SceneError::at(
                &element.span,
                message,
                format!("expected <{}>", tags.join("> or <")),
            ));
        }
        element.only(&["name", "value"])?;
        element.require("value").map(Some)
    }

    /// A finite number.
    pub fn float(
        &mut self,
        name: &'static str,
        default: f64,
        about: &'static str,
    ) -> Result<f64, SceneError> {
        self.float_where(name, default, about, "a finite number", |_| true)
    }

    /// A finite number with a further condition, which `expected` words.
    pub fn float_where(
        &mut self,
        name: &'static str,
        default: f64,
        about: &'static str,
        expected: &str,
        holds: impl Fn(f64) -> bool,
    ) -> Result<f64, SceneError> {
        self.ask(name, "float", default.to_string(), about);
        let Some(value) = self.value(name, &["float", "integer"])? else { return Ok(default) };
        number(&value.value).filter(|v| holds(*v)).ok_or_else(|| bad_value(name, value, expected))
    }

    /// No less than nothing, and no more than [`MOST`].
    pub fn amount(
        &mut self,
        name: &'static str,
        default: f64,
        about: &'static str,
    ) -> Result<f64, SceneError> {
        let expected = "no negative number, and none above 1.7e38";
        self.float_where(name, default, about, expected, |v| (0.0..=MOST).contains(&v))
    }

    /// A number that may be absent.
    pub fn optional_float(
        &mut self,
        name: &'static str,
        about: &'static str,
    ) -> Result<Option<f64>, SceneError> {
        self.ask(name, "float", "none".into(), about);
        let Some(value) = self.value(name, &["float", "integer"])? else { return Ok(None) };
        number(&value.value).map(Some).ok_or_else(|| bad_value(name, value, "a finite number"))
    }

    /// An integer within a range. A default outside stands for none that is given, and is listed as such.
    pub fn integer(
        &mut self,
        name: &'static str,
        default: i64,
        range: std::ops::RangeInclusive<i64>,
        about: &'static str,
    ) -> Result<i64, SceneError> {
        let listed = if range.contains(&default) { default.to_string() } else { "none".into() };
        self.ask(name, "integer", listed, about);
        let Some(value) = self.value(name, &["integer"])? else { return Ok(default) };
        let expected = format!("an integer from {} to {}", range.start(), range.end());
        value
            .value
            .trim()
            .parse()
            .ok()
            .filter(|v| range.contains(v))
            .ok_or_else(|| bad_value(name, value, &expected))
    }

    pub fn boolean(
        &mut self,
        name: &'static str,
        default: bool,
        about: &'static str,
    ) -> Result<bool, SceneError> {
        self.ask(name, "boolean", default.to_string(), about);
        let Some(value) = self.value(name, &["boolean"])? else { return Ok(default) };
        match value.value.to_ascii_lowercase().as_str() {
            "true" => Ok(true),
            "false" => Ok(false),
            _ => Err(bad_value(name, value, "true or false")),
        }
    }

    /// Free text that may be absent.
    pub fn string(
        &mut self,
        name: &'static str,
        about: &'static str,
    ) -> Result<Option<&'d Attribute>, SceneError> {
        self.ask(name, "string", "none".into(), about);
        self.value(name, &["string"])
    }

    /// One of a few words, by default the first, that are written in full.
    pub fn choice(
        &mut self,
        name: &'static str,
        options: &[&'static str],
        about: &'static str,
    ) -> Result<&'static str, SceneError> {
        self.one_of(name, options, about, |option, value| option == value)
    }

    /// The same of words that may be written in capitals.
    pub fn word(
        &mut self,
        name: &'static str,
        options: &[&'static str],
        about: &'static str,
    ) -> Result<&'static str, SceneError> {
        self.one_of(name, options, about, str::eq_ignore_ascii_case)
    }

    fn one_of(
        &mut self,
        name: &'static str,
        options: &[&'static str],
        about: &'static str,
        means: impl Fn(&str, &str) -> bool,
    ) -> Result<&'static str, SceneError> {
        self.ask(name, "string", options.join(" | "), about);
        let Some(value) = self.value(name, &["string"])? else { return Ok(options[0]) };
        let chosen = options.iter().find(|option| means(option, &value.value));
        chosen.copied().ok_or_else(|| {
            SceneError::at(
                &value.value_span,
                format!("unknown {name} `{}`", value.value),
                known(&value.value, options),
            )
        })
    }

    /// A point or vector.
    pub fn vector(
        &mut self,
        name: &'static str,
        default: Option<DVec3>,
        about: &'static str,
    ) -> Result<Option<DVec3>, SceneError> {
        self.ask(
            name,
            "vector",
            default.map_or("none".into(), |v| format!("{}, {}, {}", v.x, v.y, v.z)),
            about,
        );
        let Some(element) = self.take(name)? else { return Ok(default) };
        if element.tag != "point" && element.tag != "vector" {
            return Err(SceneError::at(
                &element.span,
                format!("`{name}` is no vector"),
                "expected <point> or <vector>",
            ));
        }
        super::transform::coordinates(element, &["name"], 0.0).map(Some)
    }

    pub fn transform(&mut self, name: &'static str, about: &'static str) -> Result<Transform, SceneError> {
        self.ask(name, "transform", "identity".into(), about);
        match self.take(name)? {
            None => Ok(Transform::IDENTITY),
            Some(element) => super::transform::parse(element),
        }
    }

    /// A file that exists, and the place that names it.
    pub fn file(
        &mut self,
        name: &'static str,
        about: &'static str,
    ) -> Result<Option<(PathBuf, &'d Attribute)>, SceneError> {
        let Some(value) = self.string(name, about)? else { return Ok(None) };
        Ok(Some((self.loader.find(self.element, value)?, value)))
    }

    /// A colour, spectrum or texture; a constant where the file gives none.
    pub fn texture(
        &mut self,
        name: &'static str,
        default: f64,
        usage: Usage,
        about: &'static str,
    ) -> Result<AnyTexture, SceneError> {
        let given = self.optional_texture(name, usage, about)?;
        if let Some(p) = self.asked.iter_mut().find(|p| p.name == name) {
            p.default = default.to_string();
        }
        Ok(given.unwrap_or_else(|| AnyTexture::default_value(default, usage, self.loader.mode)))
    }

    /// A colour, spectrum or texture that may be absent.
    pub fn optional_texture(
        &mut self,
        name: &'static str,
        usage: Usage,
        about: &'static str,
    ) -> Result<Option<AnyTexture>, SceneError> {
        self.ask(name, "texture", "none".into(), about);
        match self.take(name)? {
            None => Ok(None),
            Some(element) => AnyTexture::parse(element, self.loader, usage).map(Some),
        }
    }

    /// An element by parameter name, for a model that reads it in its own way.
    pub fn raw(
        &mut self,
        name: &'static str,
        kind: &'static str,
        default: &str,
        about: &'static str,
    ) -> Result<Option<&'d Element>, SceneError> {
        self.ask(name, kind, default.into(), about);
        self.take(name)
    }

    /// All nested objects of a kind, whatever their name, in order.
    pub fn objects(&mut self, tag: &'static str, about: &'static str) -> Vec<&'d Element> {
        self.ask(tag, "object", "none".into(), about);
        let matching = self.children.iter_mut().filter(|c| !c.taken && c.element.tag == tag);
        matching
            .map(|c| {
                c.taken = true;
                c.element
            })
            .collect()
    }

    /// At most one nested object of a kind.
    pub fn object(
        &mut self,
        tag: &'static str,
        about: &'static str,
    ) -> Result<Option<&'d Element>, SceneError> {
        let found = self.objects(tag, about);
        match found[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            [_, second, ..] => {
                Err(SceneError::at(&second.span, format!("a second <{tag}>"), "expected only one"))
            }
        }
    }
}

/// A finite number in Mitsuba's spelling.
pub fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|v| v.is_finite())
}

fn bad_value(name: &str, value: &Attribute, expected: &str) -> SceneError {
    let message = format!("`{}` is no value for `{name}`", value.value);
    SceneError::at(&value.value_span, message, format!("expected {expected}"))
}
