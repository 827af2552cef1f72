//! Places of objects in a document, `<ref>`s followed.

use crate::scene::loader::first_name;
use crate::scene::xml::{Document, Element};

/// The path of an element from the root: at each level the index of a child.
pub type Place = Vec<usize>;

/// The element at a place.
pub fn at<'a>(root: &'a mut Element, place: &[usize]) -> &'a mut Element {
    place.iter().fold(root, |element, &child| &mut element.children[child])
}

/// The first object of a kind within another, or the one elsewhere that a `<ref>` there means.
pub fn inner(document: &Document, parent: &[usize], tag: &str) -> Option<Place> {
    let element = parent.iter().fold(&document.root, |element, &child| &element.children[child]);
    element.children.iter().enumerate().find_map(|(number, child)| {
        if child.tag == tag { Some([parent, &[number]].concat()) } else { meant(document, child, tag) }
    })
}

/// The scene's sensors in order, by themselves or within shapes: each with the number of the scene's child that it is
/// or is in.
pub fn sensors(document: &Document) -> Vec<(usize, Place)> {
    const TAG: &str = "sensor";
    let of = |(number, child): (usize, &Element)| {
        let place = match child.tag.as_str() {
            TAG => Some(vec![number]),
            "shape" => inner(document, &[number], TAG),
            _ => meant(document, child, TAG)
                .or_else(|| inner(document, &meant(document, child, "shape")?, TAG)),
        };
        place.map(|place| (number, place))
    };
    document.root.children.iter().enumerate().filter_map(of).collect()
}

/// The object of a kind that a `<ref>` means.
fn meant(document: &Document, child: &Element, tag: &str) -> Option<Place> {
    let id = child.attribute("id").filter(|_| child.tag == "ref")?;
    with_id(&document.root, first_name(&document.aliases, &id.value), tag)
}

/// The object of a kind with this id.
fn with_id(element: &Element, id: &str, tag: &str) -> Option<Place> {
    element.children.iter().enumerate().find_map(|(number, child)| {
        if child.tag == tag && child.attribute("id").is_some_and(|given| given.value == id) {
            return Some(vec![number]);
        }
        let within = with_id(child, id, tag)?;
        Some([&[number], &within[..]].concat())
    })
}
