//! From XML text to a tree of elements: parameters substituted, includes spliced in, old names upgraded, nothing
//! interpreted yet. Every piece remembers where it stood.

use super::error::{SceneError, Source, Span};
use super::upgrade;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Includes may be nested this deep, as in Mitsuba.
const MAX_INCLUDE_DEPTH: usize = 15;
/// So many files may be included, one often counted as often: files that include two each multiply.
const MOST_INCLUDES: usize = 1 << 12;
/// Attributes in which parameters stand are no longer all together, in bytes: a parameter of two others doubles.
const MOST_SUBSTITUTED: usize = 1 << 27;
/// Elements may be nested this deep; no scene needs a tenth of it, and recursion over the tree must end.
const MAX_ELEMENT_DEPTH: usize = 128;

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
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }

    /// The value of an attribute, or an error that names it.
    pub fn require(&self, name: &str) -> Result<&Attribute, SceneError> {
        self.attribute(name).ok_or_else(|| {
            SceneError::at(&self.span, format!("<{}> has no `{name}`", self.tag), format!("add {name}=\"…\""))
        })
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
                super::error::known(&a.name, names),
            )),
        }
    }
}

/// A scene file and everything it includes.
#[derive(Debug)]
pub struct Document {
    pub root: Element,
    /// `<alias id as>`: the second name of an object, and its first.
    pub aliases: BTreeMap<String, String>,
    /// The scene file and what it includes; none of a text.
    pub files: Vec<PathBuf>,
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

struct Parameter {
    value: String,
    given: bool,
    used: bool,
}

struct Reader {
    parameters: BTreeMap<String, Parameter>,
    aliases: BTreeMap<String, String>,
    /// The files being read, innermost last.
    open: Vec<PathBuf>,
    /// Those that were read, each as often as it was.
    files: Vec<PathBuf>,
    /// Bytes of attributes in which parameters stand.
    substituted: usize,
    search: Vec<PathBuf>,
}

/// What the elements of one file share.
struct File {
    source: Arc<Source>,
    version: u32,
    search: Arc<Vec<PathBuf>>,
}

impl Reader {
    fn new(definitions: &[(String, String)]) -> Self {
        let parameter = |(name, value): &(String, String)| {
            (name.clone(), Parameter { value: value.clone(), given: true, used: false })
        };
        let parameters = definitions.iter().map(parameter).collect();
        Self {
            parameters,
            aliases: BTreeMap::new(),
            open: vec![],
            files: vec![],
            substituted: 0,
            search: vec![],
        }
    }

    fn finish(self, root: Element) -> Result<Document, SceneError> {
        if let Some((name, _)) = self.parameters.iter().find(|(_, p)| p.given && !p.used) {
            let names: Vec<&str> =
                self.parameters.iter().filter(|p| p.1.used).map(|p| p.0.as_str()).collect();
            return Err(SceneError::nowhere(format!(
                "-D {name}: the scene has no parameter ${name}; {}",
                super::error::known(name, &names)
            )));
        }
        Ok(Document { root, aliases: self.aliases, files: self.files })
    }

    fn file(&mut self, path: &Path, from: Option<&Span>) -> Result<Element, SceneError> {
        let located = |e: SceneError| match from {
            Some(span) => e.or_at(span),
            None => e,
        };
        let bytes = read_file(path)
            .map_err(|e| located(SceneError::nowhere(format!("cannot read {}: {e}", path.display()))))?;
        self.files.push(path.to_owned());
        let text = super::encoding::decode(path, bytes)?;
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if self.open.contains(&canonical) {
            return Err(located(SceneError::nowhere(format!("{} includes itself", path.display()))));
        }
        if self.open.len() > MAX_INCLUDE_DEPTH {
            return Err(located(SceneError::nowhere(format!(
                "includes are nested over {MAX_INCLUDE_DEPTH} deep"
            ))));
        }
        self.open.push(canonical);
        let element = self.text(path, text);
        self.open.pop();
        element
    }

    fn text(&mut self, path: &Path, text: String) -> Result<Element, SceneError> {
        let source = Arc::new(Source { path: path.to_owned(), text });
        check_nesting(&source)?;
        let document = roxmltree::Document::parse(&source.text).map_err(|e| {
            let range = offset(&source.text, e.pos());
            SceneError::at(&Span { source: source.clone(), range }, format!("not well-formed XML: {e}"), "")
        })?;
        let root = document.root_element();
        let span = Span { source: source.clone(), range: start_tag(root) };
        let version = root.attribute("version").ok_or_else(|| {
            SceneError::at(&span, "the root element has no `version`", "add version=\"3.0.0\"")
        })?;
        let major = version.split('.').next().and_then(|v| v.parse().ok());
        let version = major.filter(|_| version.split('.').count() == 3).ok_or_else(|| {
            SceneError::at(
                &span,
                format!("`{version}` is no version"),
                "expected three numbers such as 3.0.0",
            )
        })?;
        let depth = self.search.len();
        self.search.push(path.parent().unwrap_or(Path::new("")).to_owned());
        let search = Arc::new(self.search.iter().rev().cloned().collect());
        let mut file = File { source: source.clone(), version, search };
        let element = self.element(root, &mut file);
        self.search.truncate(depth);
        element
    }

    fn element(&mut self, node: roxmltree::Node, file: &mut File) -> Result<Element, SceneError> {
        let source = file.source.clone();
        let span = |range| Span { source: source.clone(), range };
        let mut attributes = vec![];
        for a in node.attributes() {
            let value_span = span(a.range_value());
            let mut value = self.substitute(a.value(), &value_span)?;
            let name = if file.version < 2 && a.name() == "name" {
                value = upgrade::name(&value, node);
                a.name()
            } else {
                a.name()
            };
            attributes.push(Attribute {
                name: name.into(),
                value,
                name_span: span(a.range_qname()),
                value_span,
            });
        }
        let element_span = span(start_tag(node));
        let mut children = vec![];
        for child in node.children() {
            if child.is_text() && !child.text().unwrap_or("").trim().is_empty() {
                let text = &source.text[child.range()];
                let start = child.range().end - text.trim_start().len();
                let words = span(start..start + text.trim().len());
                return Err(SceneError::at(&words, "text between elements", "expected an element"));
            }
            if !child.is_element() {
                continue;
            }
            match child.tag_name().name() {
                "default" => self.default(child, file)?,
                "path" => self.path(child, file)?,
                "alias" => self.alias(child, file)?,
                "include" => self.include(child, file, &mut children)?,
                _ => children.push(self.element(child, file)?),
            }
        }
        let mut element = Element {
            tag: node.tag_name().name().into(),
            attributes,
            children,
            span: element_span,
            search: file.search.clone(),
        };
        if file.version < 2 {
            upgrade::texture_offsets(&mut element);
        }
        Ok(element)
    }

    /// Replaces `$name`; where several names fit, the longest does.
    fn substitute(&mut self, text: &str, span: &Span) -> Result<String, SceneError> {
        let mut result = String::new();
        let mut rest = text;
        while let Some(i) = rest.find('$') {
            result.push_str(&rest[..i]);
            rest = &rest[i + 1..];
            let fits = |(name, _): &(&String, &mut Parameter)| rest.starts_with(name.as_str());
            let found = self.parameters.iter_mut().filter(fits).max_by_key(|(name, _)| name.len());
            let Some((name, parameter)) = found else {
                let names: Vec<&str> = self.parameters.keys().map(String::as_str).collect();
                let word: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let known =
                    if names.is_empty() { String::new() } else { super::error::known(&word, &names) + "; " };
                let help = format!("{known}define it with <default> or -D");
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

    fn default(&mut self, node: roxmltree::Node, file: &mut File) -> Result<(), SceneError> {
        let element = self.element(node, file)?;
        element.only(&["name", "value"])?;
        let name = element.require("name")?;
        if name.value.is_empty() {
            return Err(SceneError::at(&name.value_span, "a parameter needs a name", "expected a name"));
        }
        let value = element.require("value")?.value.clone();
        let fresh = Parameter { value, given: false, used: false };
        // A definition on the command line is used even where no attribute reads it yet.
        self.parameters.entry(name.value.clone()).and_modify(|p| p.used = true).or_insert(fresh);
        Ok(())
    }

    fn path(&mut self, node: roxmltree::Node, file: &mut File) -> Result<(), SceneError> {
        let element = self.element(node, file)?;
        element.only(&["value"])?;
        let value = element.require("value")?;
        let folder = find(&element.search, &value.value).filter(|f| f.is_dir()).ok_or_else(|| {
            SceneError::at(&value.value_span, format!("there is no folder `{}`", value.value), "")
        })?;
        self.search.push(folder);
        file.search = Arc::new(self.search.iter().rev().cloned().collect());
        Ok(())
    }

    fn alias(&mut self, node: roxmltree::Node, file: &mut File) -> Result<(), SceneError> {
        let element = self.element(node, file)?;
        element.only(&["id", "as"])?;
        let (id, name) = (element.require("id")?, element.require("as")?);
        if self.aliases.insert(name.value.clone(), id.value.clone()).is_some() {
            return Err(SceneError::at(
                &name.value_span,
                format!("`{}` is taken", name.value),
                "expected a new name",
            ));
        }
        Ok(())
    }

    fn include(
        &mut self,
        node: roxmltree::Node,
        file: &mut File,
        children: &mut Vec<Element>,
    ) -> Result<(), SceneError> {
        let element = self.element(node, file)?;
        element.only(&["filename", "name"])?;
        let name = element.require("filename")?;
        let path = find(&element.search, &name.value).ok_or_else(|| {
            SceneError::at(&name.value_span, format!("there is no file `{}`", name.value), "")
        })?;
        if self.files.len() > MOST_INCLUDES {
            return Err(SceneError::at(
                &name.value_span,
                format!("more than {MOST_INCLUDES} files are included"),
                "",
            ));
        }
        let mut included = self.file(&path, Some(&name.value_span))?;
        if included.tag == "scene" {
            children.append(&mut included.children);
        } else {
            included.attributes.retain(|a| a.name != "name" && a.name != "version");
            included.attributes.extend(element.attributes.iter().find(|a| a.name == "name").cloned());
            children.push(included);
        }
        Ok(())
    }
}

/// The bytes of a file. A device or pipe may have no end, and is no file.
fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(std::io::Error::other(if metadata.is_dir() {
            "it is a folder"
        } else {
            "it is no regular file"
        }));
    }
    std::fs::read(path)
}

/// The text of a file in UTF-8, or why there is none.
pub fn read_utf8(path: &Path) -> Result<String, String> {
    let bytes = read_file(path).map_err(|e| e.to_string())?;
    String::from_utf8(bytes).map_err(|e| e.to_string())
}

/// The first of `folders` that has `name`.
pub fn find(folders: &[PathBuf], name: &str) -> Option<PathBuf> {
    folders.iter().map(|folder| folder.join(name)).find(|path| path.exists())
}

/// Refuses nesting that would exhaust the stack of any recursive reader, before one sees it.
fn check_nesting(source: &Arc<Source>) -> Result<(), SceneError> {
    let mut depth = 0usize;
    let bytes = source.text.as_bytes();
    for (i, byte) in bytes.iter().enumerate() {
        match (byte, bytes.get(i + 1)) {
            (b'<', Some(b'/')) => depth = depth.saturating_sub(1),
            (b'<', Some(c)) if *c != b'!' && *c != b'?' => depth += 1,
            (b'/', Some(b'>')) => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_ELEMENT_DEPTH {
            let span = Span { source: source.clone(), range: i..i + 1 };
            return Err(SceneError::at(
                &span,
                format!("elements are nested over {MAX_ELEMENT_DEPTH} deep"),
                "",
            ));
        }
    }
    Ok(())
}

/// The bytes of a node's start tag.
fn start_tag(node: roxmltree::Node) -> std::ops::Range<usize> {
    let range = node.range();
    let text = &node.document().input_text()[range.clone()];
    let end = node.attributes().next_back().map_or(0, |a| a.range().end - range.start);
    range.start..range.start + end + text[end..].find('>').map_or(0, |i| i + 1)
}

/// The byte range of one character at a line and column (both from 1).
fn offset(text: &str, position: roxmltree::TextPos) -> std::ops::Range<usize> {
    let mut start = 0;
    for _ in 1..position.row {
        start += text[start..].find('\n').map_or(text.len() - start, |i| i + 1);
    }
    let column = (position.col as usize).saturating_sub(1);
    start += text[start..].char_indices().nth(column).map_or(text.len() - start, |(i, _)| i);
    start..(start + text[start..].chars().next().map_or(0, char::len_utf8))
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
    fn malformed_documents_are_refused_with_a_place() {
        assert_eq!(error("<scene version=\"3.0.0\">\n  <bsdf></scene>").line_column().unwrap().0, 2);
        assert!(error("<scene/>").message.contains("version"));
        assert!(error("<scene version=\"x\"/>").message.contains("no version"));
        assert!(
            error("<!DOCTYPE a [<!ENTITY b \"c\">]><scene version=\"3.0.0\">&b;</scene>")
                .line_column()
                .is_some()
        );
        assert!(error("<scene version=\"3.0.0\">hello</scene>").message.contains("text"));
        let deep = format!("<scene version=\"3.0.0\">{}", "<a>".repeat(100_000));
        assert!(error(&deep).message.contains("nested"));
    }
}
