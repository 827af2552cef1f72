//! State that all parts of a scene share while it is being read.

use super::error::{SceneError, known};
use super::params::Usage;
use super::registry::construct;
use super::xml::{Attribute, Document, Element, find, looked_in};
use crate::image::Pixels;
use crate::medium::{MEDIA, Medium};
use crate::shape::Chart;
use crate::spectrum::ColorMode;
use crate::spectrum::upsample::Upsampler;
use crate::texture::bitmap::Stored;
use crate::texture::{AnyTexture, mesh_attribute};
use crate::volume::Voxels;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most objects that are being read, each within the one before.
const DEEPEST: usize = 64;
/// A document of n elements may have objects within its objects read again, by `<ref>`s, n times this and
/// [`REPEATS_OF_ANY`] times. Each time costs some hundred bytes.
const REPEATS_OF_ELEMENT: usize = 16;
/// How often objects may be read again, however short the document is.
const REPEATS_OF_ANY: usize = 1 << 16;

/// Names, caches and the colour mode of one reading.
pub struct Loader<'d> {
    pub mode: ColorMode,
    pub upsampler: Arc<Upsampler>,
    ids: BTreeMap<&'d str, &'d Element>,
    aliases: &'d BTreeMap<String, Attribute>,
    search: &'d [PathBuf],
    /// The objects being read, outermost first: a second visit to one of them is a cycle.
    open: RefCell<Vec<*const Element>>,
    /// The objects that have been read.
    read: RefCell<HashSet<*const Element>>,
    /// How often one of those was read again within two others or more.
    repeats: Cell<usize>,
    /// Number of elements of the document.
    elements: usize,
    /// Decoded bitmaps; many materials share one.
    bitmaps: RefCell<BTreeMap<PathBuf, Arc<Pixels>>>,
    /// Their texels as textures look at them: by file, whether they are raw, and whether they are numbers.
    texels: RefCell<BTreeMap<(PathBuf, bool, bool), Arc<Stored>>>,
    /// Grids that were read; several volumes may share one.
    voxels: RefCell<BTreeMap<PathBuf, Arc<Voxels>>>,
    /// Media that were read, by their elements; many shapes share one.
    media: RefCell<BTreeMap<*const Element, Arc<Medium>>>,
    /// Whether the document has textures that are attributes of meshes.
    any_attributes: bool,
    /// The mesh whose material or lamp is being read, if textures of it are attributes of the mesh.
    chart: RefCell<Option<Arc<Chart>>>,
    /// Every file that was read, for the scene's hash.
    files: RefCell<Vec<PathBuf>>,
}

impl<'d> Loader<'d> {
    /// Collects the ids of a document.
    pub fn new(document: &'d Document, mode: ColorMode) -> Result<Self, SceneError> {
        let mut ids = BTreeMap::new();
        collect(&document.root, &mut ids)?;
        for (name, id) in &document.aliases {
            if ids.contains_key(name.as_str()) {
                let message = format!("`{name}` is the id of an object already");
                return Err(SceneError::at(&id.value_span, message, "expected another name for it in `as`"));
            }
            if !ids.contains_key(first_name(&document.aliases, &id.value)) {
                let message =
                    format!("`{name}` is another name for nothing: no object has the id `{}`", id.value);
                let names: Vec<&str> = ids.keys().copied().collect();
                return Err(SceneError::at(&id.value_span, message, known(&id.value, &names)));
            }
        }
        Ok(Self {
            mode,
            upsampler: Upsampler::shared(),
            ids,
            aliases: &document.aliases,
            search: &document.search,
            open: RefCell::default(),
            read: RefCell::default(),
            repeats: Cell::new(0),
            elements: count(&document.root),
            bitmaps: RefCell::default(),
            texels: RefCell::default(),
            voxels: RefCell::default(),
            media: RefCell::default(),
            any_attributes: has_attributes(&document.root),
            chart: RefCell::default(),
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
            let help = known(&id.value, &names);
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
            return Err(SceneError::at(&element.span, message, "expected less nesting"));
        }
        if !self.read.borrow_mut().insert(element) && open.len() > 1 {
            self.repeats.set(self.repeats.get() + 1);
        }
        let most = REPEATS_OF_ELEMENT * self.elements + REPEATS_OF_ANY;
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

    /// The file that an attribute of an element names. As in Mitsuba, all of the scene file's folders come
    /// first, wherever the name stands; then those of the file in which it stands, unlike in Mitsuba.
    pub fn find(&self, element: &Element, name: &Attribute) -> Result<PathBuf, SceneError> {
        let path = find(self.search, &name.value).or_else(|| find(&element.search, &name.value));
        let (message, help) = match path {
            Some(path) if path.is_file() => {
                self.depends_on(&path);
                return Ok(path);
            }
            Some(path) if path.is_dir() => {
                (format!("`{}` is a folder", name.value), "expected a file".to_owned())
            }
            Some(_) => (format!("`{}` is no regular file", name.value), "expected a file".to_owned()),
            None => {
                let folders = self.search.iter().chain(element.search.iter());
                (format!("there is no file `{}`", name.value), looked_in(folders))
            }
        };
        Err(SceneError::at(&name.value_span, message, help))
    }

    /// Notes a file that the scene depends on.
    pub fn depends_on(&self, path: &Path) {
        self.files.borrow_mut().push(path.to_owned());
    }

    /// The files the scene depends on, in order of first use, without repetition.
    pub fn files(&self) -> Vec<PathBuf> {
        let (files, mut seen) = (self.files.borrow(), HashSet::new());
        files.iter().filter(|file| seen.insert(*file)).cloned().collect()
    }

    /// A bitmap, decoded once; `place` is where its file is named.
    pub fn bitmap(&self, path: &Path, place: &Attribute) -> Result<Arc<Pixels>, SceneError> {
        let expected = "expected a whole OpenEXR, PNG, JPEG, BMP or Radiance picture";
        self.once(&self.bitmaps, (path, place), Pixels::read, expected)
    }

    /// The texels of a file, by whether they are raw and whether they are numbers, which `make` makes once.
    pub fn texels(&self, key: (PathBuf, bool, bool), make: impl FnOnce() -> Stored) -> Arc<Stored> {
        self.texels.borrow_mut().entry(key).or_insert_with(|| Arc::new(make())).clone()
    }

    /// A grid of values, read once; `place` is where its file is named.
    pub fn voxels(&self, path: &Path, place: &Attribute) -> Result<Arc<Voxels>, SceneError> {
        self.once(&self.voxels, (path, place), Voxels::read, "expected a whole grid, as Mitsuba writes it")
    }

    /// What is read from a file, unless it is known already.
    fn once<T>(
        &self,
        known: &RefCell<BTreeMap<PathBuf, Arc<T>>>,
        (path, place): (&Path, &Attribute),
        read: impl Fn(&Path) -> Result<T, String>,
        expected: &str,
    ) -> Result<Arc<T>, SceneError> {
        if let Some(found) = known.borrow().get(path) {
            return Ok(found.clone());
        }
        self.depends_on(path);
        let found = read(path).map_err(|e| SceneError::at(&place.value_span, e, expected))?;
        let found = Arc::new(found);
        known.borrow_mut().insert(path.to_owned(), found.clone());
        Ok(found)
    }

    /// The mesh whose attributes textures may ask for.
    pub fn chart(&self) -> Option<Arc<Chart>> {
        self.chart.borrow().clone()
    }

    /// Reads what is on a shape; with the chart of a mesh, textures may be its attributes.
    pub fn on_mesh<T>(&self, chart: Option<&Arc<Chart>>, read: impl FnOnce() -> T) -> T {
        let before = self.chart.replace(chart.cloned());
        // What every mesh has for itself is read for each, and not repeated by that.
        let known = chart.map(|_| self.read.take());
        let found = read();
        self.chart.replace(before);
        self.read.borrow_mut().extend(known.into_iter().flatten());
        found
    }

    /// Whether an object can only be read on a mesh: a texture within it is an attribute.
    pub fn needs_chart(&self, element: &'d Element) -> Result<bool, SceneError> {
        if !self.any_attributes {
            return Ok(false);
        }
        let (mut open, mut seen) = (vec![element], HashSet::new());
        while let Some(element) = open.pop() {
            let element = self.resolve(element)?;
            if !seen.insert(std::ptr::from_ref(element)) {
                continue;
            }
            if is_attribute(element) {
                return Ok(true);
            }
            open.extend(&element.children);
        }
        Ok(false)
    }

    /// A `<medium>`, read once.
    pub fn medium(&self, element: &'d Element) -> Result<Arc<Medium>, SceneError> {
        if let Some(medium) = self.media.borrow().get(&std::ptr::from_ref(element)) {
            return Ok(medium.clone());
        }
        let medium = construct(MEDIA, element, self, Usage::Unbounded)?;
        self.media.borrow_mut().insert(element, medium.clone());
        Ok(medium)
    }
}

/// The id behind a name that may be an alias.
pub(super) fn first_name<'a>(aliases: &'a BTreeMap<String, Attribute>, mut name: &'a str) -> &'a str {
    // Each alias leads to another name, so a chain longer than the table is a circle.
    for _ in 0..aliases.len() {
        name = aliases.get(name).map_or(name, |first| first.value.as_str());
    }
    name
}

/// Whether a texture is an attribute of the mesh that it is on.
fn is_attribute(element: &Element) -> bool {
    let is_named = |kind: &Attribute| kind.value == mesh_attribute::NAME;
    AnyTexture::is_object(element) && element.attribute("type").is_some_and(is_named)
}

fn has_attributes(element: &Element) -> bool {
    is_attribute(element) || element.children.iter().any(has_attributes)
}

fn count(element: &Element) -> usize {
    1 + element.children.iter().map(count).sum::<usize>()
}

fn collect<'d>(element: &'d Element, ids: &mut BTreeMap<&'d str, &'d Element>) -> Result<(), SceneError> {
    if element.tag != "ref"
        && let Some(id) = element.attribute("id")
        && let Some(first) = ids.insert(&id.value, element)
    {
        return Err(SceneError::at(
            &id.value_span,
            format!("the id `{}` is taken by the <{}> at {}", id.value, first.tag, first.span.place()),
            "expected a unique id",
        ));
    }
    element.children.iter().try_for_each(|child| collect(child, ids))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::xml;
    use std::fs;

    /// As in Mitsuba, the folders of the scene file come first, wherever a name stands, and the nearest last.
    #[test]
    fn files_are_found_in_the_folders_of_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["parts", "more"] {
            fs::create_dir(at(name)).unwrap();
        }
        let scene =
            r#"<scene version="3.0.0"><include filename="parts/part.xml"/><path value="more"/></scene>"#;
        fs::write(at("scene.xml"), scene).unwrap();
        let part = r#"<scene version="3.0.0"><texture type="bitmap"/></scene>"#;
        fs::write(at("parts/part.xml"), part).unwrap();
        let found = || {
            let document = xml::read(&at("scene.xml"), &[]).unwrap();
            let element = &document.root.children[0];
            let span = element.span.clone();
            let name = Attribute {
                name: "filename".into(),
                value: "a.png".into(),
                name_span: span.clone(),
                value_span: span,
            };
            Loader::new(&document, ColorMode::Rgb).unwrap().find(element, &name)
        };
        let told = found().unwrap_err().to_string();
        assert!(
            told.contains("no file `a.png`") && told.contains("parts") && told.contains("more"),
            "{told}"
        );
        for name in ["parts/a.png", "a.png", "more/a.png"] {
            fs::write(at(name), "").unwrap();
            assert_eq!(found().unwrap(), at(name));
        }
        fs::remove_file(at("more/a.png")).unwrap();
        fs::create_dir(at("more/a.png")).unwrap();
        assert!(found().unwrap_err().to_string().contains("is a folder"));
    }
}
