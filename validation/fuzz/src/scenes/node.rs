//! Scene files as trees of elements that can be changed and printed.

use std::fmt;

/// An element.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Node>,
}

impl Node {
    /// An element with these attributes.
    pub fn new(tag: &str, attributes: &[(&str, &str)]) -> Self {
        let attributes = attributes.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
        Self { tag: tag.into(), attributes, children: vec![] }
    }

    /// The first element of a text. Error: the text is not XML, with the parser's message.
    pub fn parse(text: &str) -> Result<Self, String> {
        let document = roxmltree::Document::parse(text).map_err(|e| format!("{e}: {text}"))?;
        Ok(Self::from(document.root_element()))
    }

    fn from(node: roxmltree::Node) -> Self {
        let attributes = node.attributes().map(|a| (a.name().into(), a.value().into())).collect();
        let children = node.children().filter(|c| c.is_element()).map(Self::from).collect();
        Self { tag: node.tag_name().name().into(), attributes, children }
    }

    /// The same element with one more child.
    pub fn with(mut self, child: Node) -> Self {
        self.children.push(child);
        self
    }

    pub fn get(&self, attribute: &str) -> Option<&str> {
        self.attributes.iter().find(|(name, _)| name == attribute).map(|(_, value)| value.as_str())
    }

    pub fn set(&mut self, attribute: &str, value: &str) {
        match self.attributes.iter_mut().find(|(name, _)| name == attribute) {
            Some((_, old)) => *old = value.into(),
            None => self.attributes.push((attribute.into(), value.into())),
        }
    }

    /// The child of this name.
    pub fn child(&self, name: &str) -> Option<&Node> {
        self.children.iter().find(|child| child.get("name") == Some(name))
    }

    /// Whether it is an element of this tag and type.
    pub fn is(&self, tag: &str, kind: &str) -> bool {
        self.tag == tag && self.get("type") == Some(kind)
    }

    /// This element and all its descendants.
    pub fn all(&self) -> Vec<&Node> {
        let mut found = vec![self];
        self.children.iter().for_each(|child| found.extend(child.all()));
        found
    }
}

impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "<{}", self.tag)?;
        for (name, value) in &self.attributes {
            write!(f, " {name}=\"{value}\"")?;
        }
        if self.children.is_empty() {
            return f.write_str("/>\n");
        }
        f.write_str(">\n")?;
        self.children.iter().try_for_each(|child| write!(f, "{child}"))?;
        writeln!(f, "</{}>", self.tag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let text =
            "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.8\"/><bsdf type=\"diffuse\"/></bsdf>";
        let node = Node::parse(text).unwrap();
        assert_eq!(Node::parse(&node.to_string()).unwrap(), node);
        assert!(node.is("bsdf", "mask") && node.all().len() == 3);
        assert_eq!(node.child("opacity").and_then(|o| o.get("value")), Some("0.8"));
        assert!(Node::parse("<a>").is_err());
    }
}
