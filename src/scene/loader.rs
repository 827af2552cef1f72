//! What all parts of a scene share while it is being read.

use super::error::SceneError;
use super::xml::{Document, Element};
use crate::spectrum::ColorMode;
use crate::spectrum::upsample::Upsampler;
use crate::texture::bitmap::Pixels;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// No object is within so many others.
const DEEPEST: usize = 64;
/// Objects within objects are read again, by `<ref>`s, so many times for each element of the document, and
/// this often besides. Each time costs some hundred bytes.
const REPEATS: (usize, usize) = (16, 1 << 16);

/// Names, caches and the colour mode of one reading.
pub struct Loader<'d> {
    pub mode: ColorMode,
    pub upsampler: Arc<Upsampler>,
    ids: BTreeMap<&'d str, &'d Element>,
    aliases: &'d BTreeMap<String, String>,
    /// The objects being read, outermost first: a second visit to one of them is a cycle.
    open: RefCell<Vec<*const Element>>,
    /// Those that have been read, and how often one of them was read again within two others and more.
    read: RefCell<HashSet<*const Element>>,
    repeats: Cell<usize>,
    /// How many elements the document has.
    elements: usize,
    /// Decoded bitmaps; many materials share one.
    bitmaps: RefCell<BTreeMap<PathBuf, Arc<Pixels>>>,
    /// Every file that was read, for the scene's hash.
    files: RefCell<Vec<PathBuf>>,
}

impl<'d> Loader<'d> {
    /// Collects the ids of a document.
    pub fn new(document: &'d Document, mode: ColorMode) -> Result<Self, SceneError> {
        let mut ids = BTreeMap::new();
        collect(&document.root, &mut ids)?;
        Ok(Self {
            mode,
            upsampler: Upsampler::shared(),
            ids,
            aliases: &document.aliases,
            open: RefCell::default(),
            read: RefCell::default(),
            repeats: Cell::new(0),
            elements: count(&document.root),
            bitmaps: RefCell::default(),
            files: RefCell::default(),
        })
    }

    /// The object a `<ref>` means; other elements mean themselves.
    pub fn resolve(&self, element: &'d Element) -> Result<&'d Element, SceneError> {
        if element.tag != "ref" {
            return Ok(element);
        }
        element.only(&["id", "name"])?;
        let id = element.require("id")?;
        let name = first_name(self.aliases, &id.value);
        self.ids.get(name).copied().ok_or_else(|| {
            let names: Vec<&str> = self.ids.keys().copied().collect();
            let help = super::error::known(&id.value, &names);
            SceneError::at(&id.value_span, format!("there is no object with id `{}`", id.value), help)
        })
    }

    /// Marks an object as being read; refuses one that is being read already, and references that lead deeper
    /// or repeat objects more often than the size of the document accounts for: each level of objects that
    /// refer to the level below twice doubles the work.
    pub(super) fn enter(&self, element: &Element) -> Result<(), SceneError> {
        let mut open = self.open.borrow_mut();
        if open.iter().any(|e| std::ptr::eq(*e, element)) {
            return Err(SceneError::at(
                &element.span,
                "this object contains itself",
                "a <ref> inside leads back here",
            ));
        }
        if open.len() >= DEEPEST {
            let message = format!("objects lead to objects more than {DEEPEST} deep");
            return Err(SceneError::at(&element.span, message, ""));
        }
        if !self.read.borrow_mut().insert(element) && open.len() > 1 {
            self.repeats.set(self.repeats.get() + 1);
        }
        let (each, besides) = REPEATS;
        let most = each * self.elements + besides;
        if self.repeats.get() > most {
            let message = format!("<ref>s repeat objects within objects more than {most} times");
            return Err(SceneError::at(
                &element.span,
                message,
                "<ref>s to objects that have <ref>s multiply",
            ));
        }
        open.push(element);
        Ok(())
    }

    pub(super) fn leave(&self) {
        self.open.borrow_mut().pop();
    }

    /// Notes a file that the scene depends on.
    pub fn depends_on(&self, path: &Path) {
        self.files.borrow_mut().push(path.to_owned());
    }

    /// The files the scene depends on, in order of first use, without repetition.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> = vec![];
        for file in self.files.borrow().iter() {
            if !files.contains(file) {
                files.push(file.clone());
            }
        }
        files
    }

    /// A bitmap, decoded once.
    pub fn bitmap(&self, path: &Path) -> Result<Arc<Pixels>, SceneError> {
        if let Some(pixels) = self.bitmaps.borrow().get(path) {
            return Ok(pixels.clone());
        }
        self.depends_on(path);
        let pixels = Arc::new(Pixels::read(path).map_err(SceneError::nowhere)?);
        self.bitmaps.borrow_mut().insert(path.to_owned(), pixels.clone());
        Ok(pixels)
    }
}

/// The id behind a name that may be an alias.
pub(super) fn first_name<'a>(aliases: &'a BTreeMap<String, String>, mut name: &'a str) -> &'a str {
    // Each alias leads to another name, so a chain longer than the table is a circle.
    for _ in 0..aliases.len() {
        name = aliases.get(name).map_or(name, String::as_str);
    }
    name
}

fn count(element: &Element) -> usize {
    1 + element.children.iter().map(count).sum::<usize>()
}

fn collect<'d>(element: &'d Element, ids: &mut BTreeMap<&'d str, &'d Element>) -> Result<(), SceneError> {
    if element.tag != "ref"
        && let Some(id) = element.attribute("id")
        && ids.insert(&id.value, element).is_some()
    {
        return Err(SceneError::at(
            &id.value_span,
            format!("the id `{}` is taken", id.value),
            "expected a unique id",
        ));
    }
    element.children.iter().try_for_each(|child| collect(child, ids))
}
