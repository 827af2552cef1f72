//! Reads files and what they include into one tree.

use super::lenient::forgive;
use super::parameters::Parameters;
use super::place::{find, looked_in, offset, read_file, start_tag};
use super::{Attribute, Document, Element};
use crate::scene::error::{SceneError, Source, Span};
use crate::scene::{encoding, upgrade};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Greatest depth of nested elements, those around an `<include>` counted; no scene needs a tenth of it, and
/// recursion over the tree must end.
const MAX_ELEMENT_DEPTH: usize = 128;
/// Greatest depth of nested includes, as in Mitsuba.
const MAX_INCLUDE_DEPTH: usize = 15;
/// Most files that are included, each counted as often as it is: files that include two each multiply.
const MOST_INCLUDES: usize = 1 << 12;
/// Elements that hold nothing, if they are no objects.
const EMPTY: [&str; 21] = [
    "float",
    "integer",
    "boolean",
    "string",
    "rgb",
    "spectrum",
    "point",
    "vector",
    "ref",
    "default",
    "path",
    "alias",
    "include",
    "translate",
    "rotate",
    "scale",
    "lookat",
    "matrix",
    "blackbody",
    "srgb",
    "look_at",
];

/// State while files are read.
pub struct Reader {
    parameters: Parameters,
    aliases: BTreeMap<String, Attribute>,
    /// How many elements are being read, each within the one before.
    depth: usize,
    /// The files being read, innermost last.
    open: Vec<PathBuf>,
    /// The files that were read, each as often as it was.
    files: Vec<PathBuf>,
    /// Folders of the files being read and of their `<path>`s so far, the nearest last.
    search: Vec<PathBuf>,
    /// The search folders of the scene file, once it has been read, the nearest first.
    of_scene: Vec<PathBuf>,
}

/// State that the elements of one file share.
struct File {
    source: Arc<Source>,
    version: u32,
    search: Arc<Vec<PathBuf>>,
}

impl Reader {
    pub fn new(definitions: &[(String, String)]) -> Self {
        Self {
            parameters: Parameters::new(definitions),
            aliases: BTreeMap::new(),
            depth: 0,
            open: vec![],
            files: vec![],
            search: vec![],
            of_scene: vec![],
        }
    }

    /// The document of this root.
    pub fn finish(self, root: Element) -> Result<Document, SceneError> {
        self.parameters.finish()?;
        Ok(Document { root, aliases: self.aliases, files: self.files, search: self.of_scene })
    }

    /// The root element of a file that is named at `from`.
    pub fn file(&mut self, path: &Path, from: Option<&Span>) -> Result<Element, SceneError> {
        let located = |e: SceneError| match from {
            Some(span) => e.or_at(span),
            None => e,
        };
        let bytes = read_file(path)
            .map_err(|e| located(SceneError::nowhere(format!("cannot read {}: {e}", path.display()))))?;
        self.files.push(path.to_owned());
        let text = encoding::decode(path, bytes)?;
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if self.open.contains(&canonical) {
            let message = format!("{} includes itself", path.display());
            return Err(match from {
                Some(span) => SceneError::at(span, message, "expected another file"),
                None => SceneError::nowhere(message),
            });
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

    /// The root element of a text, as if it stood in a file.
    pub fn text(&mut self, path: &Path, text: String) -> Result<Element, SceneError> {
        // No column of the file.
        let text = text.strip_prefix(encoding::MARK).map(str::to_owned).unwrap_or(text);
        let source = Arc::new(Source { path: path.to_owned(), text });
        let text = forgive(&source.text).map_err(|range| {
            let message = "not well-formed XML: a comment that does not end";
            SceneError::at(&Span { source: source.clone(), range }, message, "expected --> behind it")
        })?;
        let document = roxmltree::Document::parse(&text).map_err(|e| malformed(&source, &e))?;
        let root = document.root_element();
        let span = Span { source: source.clone(), range: start_tag(root) };
        let version = root.attribute("version").ok_or_else(|| match root.tag_name().name() {
            "scene" => SceneError::at(&span, "the root element has no `version`", "add version=\"3.0.0\""),
            tag => {
                SceneError::at(&span, format!("the root is a <{tag}>"), "expected <scene version=\"3.0.0\">")
            }
        })?;
        let numbers = version.split('.').map(|number| number.trim().parse().ok());
        let numbers: Option<Vec<u32>> = numbers.collect();
        let major = numbers.filter(|numbers| numbers.len() == 3).map(|numbers| numbers[0]);
        let version = major.ok_or_else(|| {
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
        if depth == 0 {
            self.of_scene = self.search.iter().rev().cloned().collect();
        }
        self.search.truncate(depth);
        element
    }

    fn element(&mut self, node: roxmltree::Node, file: &mut File) -> Result<Element, SceneError> {
        let source = file.source.clone();
        let span = |range| Span { source: source.clone(), range };
        let element_span = span(start_tag(node));
        if self.depth == MAX_ELEMENT_DEPTH {
            let message = format!("elements are nested over {MAX_ELEMENT_DEPTH} deep");
            return Err(SceneError::at(&element_span, message, "expected less nesting"));
        }
        self.depth += 1;
        if node.tag_name().namespace().is_some() {
            return Err(SceneError::at(&element_span, "an element of a namespace", "expected none"));
        }
        let mut attributes = vec![];
        for a in node.attributes() {
            let name = &source.text[a.range_qname()];
            if name == "version" && node.parent_element().is_some() {
                let message = format!("<{}> has no attribute `version`", node.tag_name().name());
                return Err(SceneError::at(
                    &span(a.range_qname()),
                    message,
                    "expected one only at the root of a file",
                ));
            }
            let value_span = span(a.range_value());
            let mut value = self.parameters.substitute(a.value(), &value_span)?;
            // A parameter of the file is called what the file calls it.
            if file.version < 2 && name == "name" && !node.has_tag_name("default") {
                value = upgrade::name(&value, node);
            }
            attributes.push(Attribute {
                name: name.into(),
                value,
                name_span: span(a.range_qname()),
                value_span,
            });
        }
        if node.has_tag_name("integer") {
            check_integer(&attributes)?;
        }
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
            if is_value(node.tag_name().name(), node.has_attribute("type")) {
                let message =
                    format!("<{}> cannot contain a <{}>", node.tag_name().name(), child.tag_name().name());
                return Err(SceneError::at(&span(start_tag(child)), message, "expected nothing in it"));
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
        self.depth -= 1;
        Ok(element)
    }

    fn default(&mut self, node: roxmltree::Node, file: &mut File) -> Result<(), SceneError> {
        let element = self.element(node, file)?;
        element.only(&["name", "value"])?;
        let name = element.require("name")?;
        if name.value.is_empty() {
            return Err(SceneError::at(&name.value_span, "a parameter needs a name", "expected a name"));
        }
        let value = element.require("value")?.value.clone();
        self.parameters.default(&name.value, value);
        Ok(())
    }

    fn path(&mut self, node: roxmltree::Node, file: &mut File) -> Result<(), SceneError> {
        let element = self.element(node, file)?;
        element.only(&["value"])?;
        let value = element.require("value")?;
        let folder = find(&element.search, &value.value).filter(|f| f.is_dir()).ok_or_else(|| {
            SceneError::at(&value.value_span, format!("there is no folder `{}`", value.value), "expected one")
        })?;
        self.search.push(folder);
        file.search = Arc::new(self.search.iter().rev().cloned().collect());
        Ok(())
    }

    fn alias(&mut self, node: roxmltree::Node, file: &mut File) -> Result<(), SceneError> {
        let element = self.element(node, file)?;
        element.only(&["id", "as"])?;
        let (id, name) = (element.require("id")?, element.require("as")?);
        if self.aliases.insert(name.value.clone(), id.clone()).is_some() {
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
        // Unlike other files, and as in Mitsuba, beside the including file before the folders of `<path>`s.
        let beside = [file.source.path.parent().unwrap_or(Path::new("")).to_owned()];
        let path = find(&beside, &name.value).or_else(|| find(&element.search, &name.value));
        let path = path.ok_or_else(|| {
            let help = looked_in(beside.iter().chain(element.search.iter()));
            SceneError::at(&name.value_span, format!("there is no file `{}`", name.value), help)
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

/// Whether an element of this tag, with a `type` or without, holds nothing.
pub fn is_value(tag: &str, has_type: bool) -> bool {
    EMPTY.contains(&tag) && !has_type
}

/// Refuses an `<integer>` that is none, although a model might accept any number.
fn check_integer(attributes: &[Attribute]) -> Result<(), SceneError> {
    match attributes.iter().find(|a| a.name == "value") {
        Some(a) if a.value.trim().parse::<i64>().is_err() => {
            let message = format!("`{}` is no integer", a.value);
            Err(SceneError::at(&a.value_span, message, "expected an integer of 64 bits"))
        }
        _ => Ok(()),
    }
}

/// Why a text is not read as XML. Documents with a DTD are refused whole, for entities may stand for much.
fn malformed(source: &Arc<Source>, error: &roxmltree::Error) -> SceneError {
    let at = |range, message: String, expected: &str| {
        SceneError::at(&Span { source: source.clone(), range }, message, expected)
    };
    const DTD: &str = "<!DOCTYPE";
    match (error, source.text.find(DTD)) {
        (roxmltree::Error::DtdDetected, Some(begin)) => {
            at(begin..begin + DTD.len(), "a DTD is not read".into(), "expected none: leave it out")
        }
        // They have no place, but are noticed where the text ends.
        (roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode, _) => {
            let end = source.text.trim_end().len();
            let begin = source.text[..end].char_indices().last().map_or(0, |(at, _)| at);
            at(
                begin..end,
                "not well-formed XML: the document ends too early".into(),
                "expected the rest of it",
            )
        }
        (roxmltree::Error::UnexpectedCloseTag(open, closed, place), _) => {
            let message = format!("not well-formed XML: </{closed}> where <{open}> is open");
            at(offset(&source.text, *place), message, &format!("expected </{open}> before it"))
        }
        _ => {
            let range = offset(&source.text, error.pos());
            // The place is told anyway.
            let what = error.to_string().replace(&format!(" at {}", error.pos()), "");
            at(range, format!("not well-formed XML: {what}"), "expected well-formed XML")
        }
    }
}
