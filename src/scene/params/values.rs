//! Parameters that are values: numbers, words, places, textures, files.

use super::{MOST, Params, Usage};
use crate::math::{DVec3, Transform};
use crate::scene::error::{SceneError, known};
use crate::scene::xml::{Attribute, Element};
use crate::spelling::shortened;
use crate::texture::AnyTexture;
use std::ops::RangeInclusive;
use std::path::PathBuf;

impl<'d> Params<'_, 'd> {
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
        Ok(self.given_float(name, expected, holds)?.unwrap_or(default))
    }

    /// The number that the file gives, if it does.
    fn given_float(
        &mut self,
        name: &'static str,
        expected: &str,
        holds: impl Fn(f64) -> bool,
    ) -> Result<Option<f64>, SceneError> {
        let Some(value) = self.value(name, &["float", "integer"])? else { return Ok(None) };
        let found = number(&value.value).filter(|v| holds(*v));
        found.map(Some).ok_or_else(|| bad_value(name, value, expected))
    }

    /// A number from 0 to [`MOST`].
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
        self.optional_float_where(name, about, "a finite number", |_| true)
    }

    /// The same with a further condition, which `expected` words.
    pub fn optional_float_where(
        &mut self,
        name: &'static str,
        about: &'static str,
        expected: &str,
        holds: impl Fn(f64) -> bool,
    ) -> Result<Option<f64>, SceneError> {
        self.ask(name, "float", "none".into(), about);
        self.given_float(name, expected, holds)
    }

    /// An integer within a range. A default outside stands for none that is given, and is listed as such.
    pub fn integer(
        &mut self,
        name: &'static str,
        default: i64,
        range: RangeInclusive<i64>,
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

    /// A number of things within a range. As with [`Params::integer`], a default outside stands for none.
    pub fn count(
        &mut self,
        name: &'static str,
        default: u32,
        range: RangeInclusive<u32>,
        about: &'static str,
    ) -> Result<u32, SceneError> {
        let within = i64::from(*range.start())..=i64::from(*range.end());
        self.integer(name, default.into(), within, about).map(|count| count as u32)
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

    /// What one of a few words, by default the first, stands for.
    pub fn choice_of<T: Copy>(
        &mut self,
        name: &'static str,
        options: &[(&'static str, T)],
        about: &'static str,
    ) -> Result<T, SceneError> {
        let words: Vec<&'static str> = options.iter().map(|(word, _)| *word).collect();
        let chosen = self.choice(name, &words, about)?;
        let meant = words.iter().position(|word| *word == chosen).unwrap_or(0);
        Ok(options[meant].1)
    }

    /// One of a few words, by default the first, that may be written in capitals.
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
        crate::scene::transform::coordinates(element, &["name"], 0.0).map(Some)
    }

    pub fn transform(&mut self, name: &'static str, about: &'static str) -> Result<Transform, SceneError> {
        self.ask(name, "transform", "identity".into(), about);
        match self.take(name)? {
            None => Ok(Transform::IDENTITY),
            Some(element) => crate::scene::transform::parse(element),
        }
    }

    /// The unit vector that an object faces along: its `direction`, or where its `to_world` turns +z.
    pub fn direction(
        &mut self,
        about: &'static str,
        about_to_world: &'static str,
    ) -> Result<DVec3, SceneError> {
        if self.has("direction") && self.has("to_world") {
            return Err(self.error("to_world", "both `direction` and `to_world`", "expected one of them"));
        }
        let direction = self.vector("direction", None, about)?;
        let to_world = self.transform("to_world", about_to_world)?;
        self.unit_direction(direction.unwrap_or_else(|| to_world.vector(DVec3::Z)))
    }

    /// The unit vector along a `direction`, or along what stands for it.
    pub fn unit_direction(&self, along: DVec3) -> Result<DVec3, SceneError> {
        along.try_normalize().ok_or_else(|| {
            self.error("direction", "the direction has no length", "expected a vector other than 0")
        })
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
}

/// A finite number in Mitsuba's spelling.
pub fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|v| v.is_finite())
}

fn bad_value(name: &str, value: &Attribute, expected: &str) -> SceneError {
    let message = format!("`{}` is no value for `{name}`", shortened(&value.value));
    SceneError::at(&value.value_span, message, format!("expected {expected}"))
}
