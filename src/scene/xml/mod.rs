//! From XML text to a tree of elements: parameters substituted, includes spliced in, old names upgraded,
//! nothing interpreted yet. Every piece remembers where it stood.

mod lenient;
mod parameters;
mod place;
mod reader;

use super::error::{SceneError, Span};
pub use place::{find, looked_in, read_utf8};
use reader::Reader;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An attribute whose `$parameters` are substituted.
#[derive(Clone, Debug)]
pub struct Attribute {
    pub name: String,
    pub value: String,
    pub name_span: Span,
    pub value_span: Span,
}

/// One XML element.
#[derive(Clone, Debug)]
pub struct Element {
    pub tag: String,
    pub attributes: Vec<Attribute>,
    pub children: Vec<Element>,
    /// The element's start tag.
    pub span: Span,
    /// Folders in which this element's relative file names are looked up, most specific first.
    pub search: Arc<Vec<PathBuf>>,
}

impl Element {
    /// A new one that claims to stand where `place` does.
    pub fn made_at(place: &Element, tag: &str, attributes: &[(&str, &str)]) -> Self {
        let attribute = |(name, value): &(&str, &str)| Attribute {
            name: (*name).into(),
            value: (*value).into(),
            name_span: place.span.clone(),
            value_span: place.span.clone(),
        };
        Self {
            tag: tag.into(),
            attributes: attributes.iter().map(attribute).collect(),
            children: vec![],
            span: place.span.clone(),
            search: place.search.clone(),
        }
    }

    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }

    /// The value of an attribute, or an error that names it.
    pub fn require(&self, name: &str) -> Result<&Attribute, SceneError> {
        self.attribute(name).ok_or_else(|| {
            SceneError::at(&self.span, format!("<{}> has no `{name}`", self.tag), format!("add {name}=\"…\""))
        })
    }

    /// Whether it is a number, a colour or the like, and no object.
    pub fn is_value(&self) -> bool {
        reader::is_value(&self.tag, self.attribute("type").is_some())
    }

    /// The property name under which the parent looks for this element.
    pub fn name(&self) -> Option<&str> {
        self.attribute("name").map(|a| a.value.as_str())
    }

    /// Refuses attributes beyond the named ones.
    pub fn only(&self, names: &[&str]) -> Result<(), SceneError> {
        match self.attributes.iter().find(|a| !names.contains(&a.name.as_str())) {
            None => Ok(()),
            Some(a) => Err(SceneError::at(
                &a.name_span,
                format!("<{}> has no attribute `{}`", self.tag, a.name),
                crate::spelling::known(&a.name, names),
            )),
        }
    }
}

/// A scene file and everything it includes.
#[derive(Debug)]
pub struct Document {
    pub root: Element,
    /// `<alias id as>`: the second name of an object, and what says its first.
    pub aliases: BTreeMap<String, Attribute>,
    /// The scene file and what it includes; none of a text.
    pub files: Vec<PathBuf>,
    /// Where the scene file's own `<path>`s and its folder lead, wherever they stand in it.
    pub search: Vec<PathBuf>,
}

/// Reads a scene file; `definitions` are the command line's `-D name=value`.
pub fn read(path: &Path, definitions: &[(String, String)]) -> Result<Document, SceneError> {
    let mut reader = Reader::new(definitions);
    let root = reader.file(path, None)?;
    reader.finish(root)
}

/// Reads a scene from text, as if it stood in a file called `name`.
pub fn read_text(name: &str, text: &str) -> Result<Document, SceneError> {
    let mut reader = Reader::new(&[]);
    let root = reader.text(Path::new(name), text.to_owned())?;
    reader.finish(root)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> SceneError {
        read_text("test.xml", text).unwrap_err()
    }

    #[test]
    fn parameters_are_substituted_longest_name_first() {
        let text = r#"<scene version="3.0.0"><default name="a" value="1"/><default name="ab" value="2"/>
            <float name="x" value="$ab,$a,$b"/></scene>"#;
        assert!(error(text).message.contains("undefined parameter `$b`"));
        let document = read_text("t", &text.replace(",$b", "")).unwrap();
        assert_eq!(document.root.children[0].attribute("value").unwrap().value, "2,1");
    }

    #[test]
    fn a_dollar_behind_a_backslash_is_no_parameter() {
        let text = r#"<scene version="3.0.0"><default name="a" value="1"/><float name="\$a" value="$a\\$"/></scene>"#;
        let root = read_text("t", text).unwrap().root;
        assert_eq!(
            (root.children[0].name(), root.children[0].attribute("value").unwrap().value.as_str()),
            (Some("$a"), r"1\$")
        );
    }

    #[test]
    fn parameters_and_steps_hold_nothing() {
        for outer in ["float", "rgb", "srgb", "spectrum", "ref", "include", "translate", "look_at"] {
            let text = format!(
                "<scene version=\"3.0.0\">\n<{outer} name=\"a\"><default name=\"b\" value=\"1\"/></{outer}></scene>"
            );
            let error = error(&text);
            assert!(error.message.contains("cannot contain a <default>"), "{error}");
            assert_eq!(error.line_column(), Some((2, outer.len() + 12)), "{error}");
        }
        let inner = "<scene version=\"3.0.0\">\n<bsdf version=\"3.0.0\"/></scene>";
        assert!(error(inner).message.contains("no attribute `version`"));
        let typed = "<scene version=\"3.0.0\"><spectrum type=\"d65\"><float name=\"scale\" value=\"2\"/></spectrum></scene>";
        assert!(read_text("t", typed).is_ok());
    }

    #[test]
    fn a_mark_of_the_encoding_is_no_column() {
        let bad = error("\u{feff}<?xml version=\"1.0\"?><scene version=\"x\"/>");
        assert_eq!(bad.line_column(), Some((1, 22)));
    }

    #[test]
    fn namespaces_are_refused() {
        assert!(error("<scene version=\"3.0.0\" xmlns=\"a\"/>").message.contains("namespace"));
        let prefixed = "<scene version=\"3.0.0\" xml:id=\"a\"/>";
        assert!(read_text("t", prefixed).unwrap().root.attribute("xml:id").is_some());
    }

    #[test]
    fn malformed_documents_are_refused_with_a_place() {
        assert_eq!(error("<scene version=\"3.0.0\">\n  <bsdf></scene>").line_column().unwrap().0, 2);
        assert!(error("<scene/>").message.contains("version"));
        for cut in [
            "<scene version=\"3.0.0\">\n  <bsdf",
            "<scene version=\"3.0.0\">\n  <bsdf/>\n",
            "<scene\n version",
        ] {
            let error = error(cut);
            assert!(error.message.contains("ends too early"), "{error}");
            assert_eq!(error.line_column().unwrap().0, 2, "{error}");
        }
        for version in ["x", "3.0", "3..0", "3.0.x"] {
            assert!(error(&format!("<scene version=\"{version}\"/>")).message.contains("no version"));
        }
        assert!(
            error("<!DOCTYPE a [<!ENTITY b \"c\">]><scene version=\"3.0.0\">&b;</scene>")
                .line_column()
                .is_some()
        );
        assert!(error("<scene version=\"3.0.0\">hello</scene>").message.contains("text"));
    }

    #[test]
    fn depth_is_counted_in_elements() {
        let nested = |depth: usize, tag: &str| {
            format!("<scene version=\"3.0.0\">{}{}</scene>", tag.repeat(depth), "</a>".repeat(depth))
        };
        // Whatever their attributes look like.
        for tag in ["<a>", "<a x=\"/>\">"] {
            assert!(read_text("t", &nested(127, tag)).is_ok());
            for depth in [128, 100_000] {
                assert!(error(&nested(depth, tag)).message.contains("nested"), "{depth}");
            }
        }
        let comment = format!("<scene version=\"3.0.0\"><!-- {} --></scene>", "a <b ".repeat(1000));
        assert!(read_text("t", &comment).is_ok());
    }

    /// As Mitsuba's parser does, and places are those of the file.
    #[test]
    fn comments_hold_whatever_does_not_end_them() {
        let scene = "\n<?xml version=\"1.0\"?>\n<!-- -- -->\n<scene version=\"3.0.0\"><!-- ---- é ---->\n  <float name=\"a--b\" value=\"1\"/></scene>";
        let root = read_text("t", scene).unwrap().root;
        let name = root.children[0].attribute("name").unwrap();
        assert_eq!((name.value.as_str(), &scene[name.value_span.range.clone()]), ("a--b", "a--b"));
        let unfinished = error("<scene version=\"3.0.0\">\n  <!-- -- </scene>");
        assert_eq!(unfinished.line_column(), Some((2, 3)));
        assert!(unfinished.message.contains("comment"), "{}", unfinished.message);
    }

    /// Beside the including file before the folders of its `<path>`s.
    #[test]
    fn included_files_are_looked_for_as_in_mitsuba() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("more")).unwrap();
        let part = |id: &str| format!("<scene version=\"3.0.0\"><bsdf id=\"{id}\"/></scene>");
        std::fs::write(at("part.xml"), part("beside")).unwrap();
        for name in ["more/part.xml", "more/other.xml"] {
            std::fs::write(at(name), part("more")).unwrap();
        }
        let scene = "<scene version=\"3.0.0\"><path value=\"more\"/><include filename=\"part.xml\"/><include filename=\"other.xml\"/></scene>";
        std::fs::write(at("scene.xml"), scene).unwrap();
        let root = read(&at("scene.xml"), &[]).unwrap().root;
        let id = |element: &Element| element.attribute("id").unwrap().value.clone();
        assert_eq!(root.children.iter().map(id).collect::<Vec<_>>(), ["beside", "more"]);
    }
}
