//! XML of strangers. What would take minutes or gigabytes to read is refused before it is read.

use roxmltree::{Document, Node, ParsingOptions};
use thiserror::Error;

/// The most elements, comments and pieces of text in a document.
const MOST_NODES: usize = 10_000_000;
/// The most attributes in a document.
const MOST_ATTRIBUTES: usize = 10_000_000;
/// The most attributes of one element, of which the reader compares each with all others.
const MOST_IN_ELEMENT: usize = 1_000;
/// The most characters of one element's attributes: the start values of an array of a million numbers have fewer.
const MOST_CHARACTERS: usize = 1 << 25;
/// The most elements within each other.
const MOST_DEPTH: usize = 256;
/// The most namespaces of one element, which those within it take over.
const MOST_NAMESPACES: usize = 64;

/// Why a document cannot be read.
#[derive(Debug, Error)]
pub enum XmlError {
    /// It is not well-formed.
    #[error("{0}")]
    Syntax(roxmltree::Error),
    /// It has a document type, whose entities could grow a small file beyond all memory.
    #[error(
        "a DOCTYPE, which is not read here, because its entities may grow without limit: remove it; FMI needs none"
    )]
    DocumentType,
    /// It is unreasonably large.
    #[error("line {line}: refused: more than {most} {what}")]
    Large {
        /// The line, from 1.
        line: usize,
        /// The number that is read at most.
        most: usize,
        /// The things that are counted.
        what: &'static str,
    },
}

/// Reads a document.
///
/// # Errors
/// When it is not well-formed, has a document type, or is larger than what is read here.
pub fn parse(text: &str) -> Result<Document<'_>, XmlError> {
    Sizes::default().check(text)?;
    let options =
        ParsingOptions { nodes_limit: u32::try_from(MOST_NODES).unwrap_or(u32::MAX), ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::DtdDetected => XmlError::DocumentType,
        roxmltree::Error::NodesLimitReached => nodes().at(text, text.len()),
        other => XmlError::Syntax(other),
    })
}

/// The child elements; those of foreign namespaces don't count.
pub fn elements<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(|child| child.is_element() && child.tag_name().namespace().is_none())
}

/// The child elements of this name.
pub fn children<'a>(node: Node<'a, 'a>, name: &str) -> impl Iterator<Item = Node<'a, 'a>> {
    elements(node).filter(move |child| child.tag_name().name() == name)
}

/// The first child element of this name.
pub fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    children(node, name).next()
}

/// The elements of this name in the first list of that name.
pub fn within<'a>(root: Node<'a, 'a>, list: &str, name: &str) -> impl Iterator<Item = Node<'a, 'a>> {
    let list = child(root, list).into_iter();
    list.flat_map(move |list| children(list, name))
}

/// A limit that is exceeded, and the name of what is counted.
struct Excess(usize, &'static str);

fn nodes() -> Excess {
    Excess(MOST_NODES, "elements, comments and pieces of text")
}

impl Excess {
    fn at(self, text: &str, place: usize) -> XmlError {
        let before = &text.as_bytes()[..place];
        XmlError::Large { line: before.iter().filter(|byte| **byte == b'\n').count() + 1, most: self.0, what: self.1 }
    }
}

/// The sizes of a document, as far as it has been looked through.
#[derive(Default)]
struct Sizes {
    nodes: usize,
    attributes: usize,
    /// The namespaces of each open element, those of the elements around it included.
    open: Vec<usize>,
}

impl Sizes {
    /// Looks through the marks of a document. Where these are not well-formed it ends: the reader says what is wrong.
    fn check(&mut self, text: &str) -> Result<(), XmlError> {
        let mut place = 0;
        while let Some(start) = text[place..].find('<').map(|offset| place + offset) {
            let mark = &text[start..];
            let special = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("</", ">")]
                .iter()
                .find(|(begin, _)| mark.starts_with(begin));
            let length = match special {
                Some((begin, end)) => {
                    if *begin == "</" {
                        self.open.pop();
                    }
                    mark.find(end).map(|offset| offset + end.len())
                }
                None => self.element(mark).map_err(|excess| excess.at(text, start))?,
            };
            self.nodes += 1;
            if self.nodes > MOST_NODES {
                return Err(nodes().at(text, start));
            }
            let Some(length) = length else { break };
            place = start + length;
        }
        Ok(())
    }

    /// Counts the parts of the element at the start of the text, and returns the length of its mark where that ends.
    fn element(&mut self, mark: &str) -> Result<Option<usize>, Excess> {
        let (mut quote, mut attributes) = (None, 0);
        // Where the last word began, and whether it goes on.
        let (mut word, mut within) = (0, false);
        let mut namespaces = self.open.last().copied().unwrap_or(0);
        for (place, byte) in mark.bytes().enumerate() {
            let letter = quote.is_none() && !byte.is_ascii_whitespace() && byte != b'=';
            if letter && !within {
                word = place;
            }
            within = letter;
            if place > MOST_CHARACTERS {
                return Err(Excess(MOST_CHARACTERS, "characters in an element's attributes"));
            }
            match (byte, quote) {
                (b'"' | b'\'', None) => quote = Some(byte),
                (_, Some(open)) if byte == open => quote = None,
                (_, Some(_)) => {}
                (b'=', None) => {
                    attributes += 1;
                    namespaces += usize::from(mark.as_bytes()[word..].starts_with(b"xmlns"));
                    if attributes > MOST_IN_ELEMENT {
                        return Err(Excess(MOST_IN_ELEMENT, "attributes in an element"));
                    }
                    if namespaces > MOST_NAMESPACES {
                        return Err(Excess(MOST_NAMESPACES, "namespaces in an element"));
                    }
                }
                (b'>', None) => {
                    self.attributes += attributes;
                    if self.attributes > MOST_ATTRIBUTES {
                        return Err(Excess(MOST_ATTRIBUTES, "attributes"));
                    }
                    if !mark[..place].ends_with('/') {
                        self.open.push(namespaces);
                    }
                    if self.open.len() > MOST_DEPTH {
                        return Err(Excess(MOST_DEPTH, "elements within each other"));
                    }
                    return Ok(Some(place + 1));
                }
                _ => {}
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn what_would_be_too_much_is_refused_by_its_limit() {
        let many = |count: usize, part: fn(usize) -> String| (0..count).map(part).collect::<String>();
        let attributes = many(200_000, |k| format!(" a{k}=\"\""));
        assert_eq!(
            refused(&format!("<a>\n<b{attributes}/></a>")),
            "line 2: refused: more than 1000 attributes in an element"
        );
        let long = "x".repeat(MOST_CHARACTERS);
        assert_eq!(
            refused(&format!("<a>\n<b c='{long}'/></a>")),
            "line 2: refused: more than 33554432 characters in an element's attributes"
        );
        let depth = many(100_000, |_| "<a>".to_owned());
        assert_eq!(refused(&depth), "line 1: refused: more than 256 elements within each other");
        let namespaces = many(65, |k| format!("<a xmlns:n{k}=\"n\">"));
        assert_eq!(refused(&namespaces), "line 1: refused: more than 64 namespaces in an element");
        // Refused without the gigabytes that reading them would take.
        let elements = "x<a/>".repeat(MOST_NODES / 2 + 1);
        assert_eq!(
            refused(&format!("<a>{elements}</a>")),
            "line 1: refused: more than 10000000 elements, comments and pieces of text"
        );
        let full = format!("<a{}/>", " a=''".repeat(MOST_IN_ELEMENT));
        let all = full.repeat(MOST_ATTRIBUTES / MOST_IN_ELEMENT + 1);
        assert_eq!(refused(&format!("<a>{all}</a>")), "line 1: refused: more than 10000000 attributes");
    }

    #[test]
    fn what_only_looks_like_much_is_read() {
        let equal = "a=b < ".repeat(2_000).replace('<', "&lt;");
        let text = format!(
            "<?xml version='1.0'?><a b='/>{equal}'><!--{equal}<a><a>--><![CDATA[<a><a>{equal}]]><b c=\">\"/>{equal}</a>"
        );
        assert_eq!(parse(&text).unwrap().descendants().count(), 6);
    }

    #[test]
    fn damage_is_told_by_the_reader() {
        for text in ["<a", "<a b='", "<!-- ", "</a>", "<a></b>", "", "<"] {
            assert!(matches!(parse(text), Err(XmlError::Syntax(_))), "{text}");
        }
        let entities = "<!DOCTYPE a [<!ENTITY e 'e'>]><a/>";
        assert!(matches!(parse(entities), Err(XmlError::DocumentType)));
    }
}
