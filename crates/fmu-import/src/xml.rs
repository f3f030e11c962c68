//! XML of strangers. What would take minutes or gigabytes to read is refused before it is read.

use roxmltree::{Document, Node, ParsingOptions};
use thiserror::Error;

/// A number that is not exceeded.
struct SizeLimit {
    most: usize,
    what: &'static str,
}

const NODES: SizeLimit = SizeLimit { most: 10_000_000, what: "elements, comments and pieces of text" };
const ATTRIBUTES: SizeLimit = SizeLimit { most: 10_000_000, what: "attributes" };
/// The reader compares each attribute of an element with all others.
const IN_ELEMENT: SizeLimit = SizeLimit { most: 1_000, what: "attributes in an element" };
/// The start values of an array of a million numbers have fewer.
const BYTES: SizeLimit = SizeLimit { most: 1 << 25, what: "bytes in an element's attributes" };
const DEPTH: SizeLimit = SizeLimit { most: 256, what: "elements within each other" };
/// Elements take over the namespaces of those around them.
const NAMESPACES: SizeLimit = SizeLimit { most: 64, what: "namespaces in an element" };

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
    #[error("line {line}: refused: more than {most} {what}; the file is damaged or hostile")]
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
    let nodes_limit = u32::try_from(NODES.most).unwrap_or(u32::MAX);
    let options = ParsingOptions { nodes_limit, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::DtdDetected => XmlError::DocumentType,
        roxmltree::Error::NodesLimitReached => NODES.exceeded(text, text.len()),
        other => XmlError::Syntax(other),
    })
}

/// The child elements; those of foreign namespaces don't count.
pub fn elements<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(|child| child.is_element() && child.tag_name().namespace().is_none())
}

/// The name of an element's kind.
pub fn tag<'a>(node: Node<'a, '_>) -> &'a str {
    node.tag_name().name()
}

/// The child elements of this name.
pub fn children<'a>(node: Node<'a, 'a>, name: &str) -> impl Iterator<Item = Node<'a, 'a>> {
    elements(node).filter(move |child| tag(*child) == name)
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

impl SizeLimit {
    fn allows(&'static self, count: usize) -> Result<(), &'static Self> {
        if count > self.most { Err(self) } else { Ok(()) }
    }

    fn exceeded(&self, text: &str, place: usize) -> XmlError {
        let line = text.as_bytes()[..place].iter().filter(|byte| **byte == b'\n').count() + 1;
        XmlError::Large { line, most: self.most, what: self.what }
    }
}

/// How the marks that are no start tags begin and end.
const OTHER_MARKS: [(&str, &str); 4] = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), (END_TAG, ">")];
const END_TAG: &str = "</";

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
            let length = self.count(&text[start..]).map_err(|limit| limit.exceeded(text, start))?;
            let Some(length) = length else { break };
            place = start + length;
        }
        Ok(())
    }

    /// Counts the mark at the start of the text, and returns its length where it ends.
    fn count(&mut self, text: &str) -> Result<Option<usize>, &'static SizeLimit> {
        self.nodes += 1;
        NODES.allows(self.nodes)?;
        let Some((begin, end)) = OTHER_MARKS.iter().find(|(begin, _)| text.starts_with(begin)) else {
            let tag = StartTag::scan(text);
            self.enter(&tag)?;
            return Ok(tag.is_closed.then_some(tag.bytes));
        };
        if *begin == END_TAG {
            self.open.pop();
        }
        // The begin holds no part of the end: the comment `<!-->` is still open.
        Ok(text[begin.len()..].find(end).map(|offset| begin.len() + offset + end.len()))
    }

    fn enter(&mut self, tag: &StartTag) -> Result<(), &'static SizeLimit> {
        IN_ELEMENT.allows(tag.attributes)?;
        BYTES.allows(tag.bytes)?;
        self.attributes += tag.attributes;
        ATTRIBUTES.allows(self.attributes)?;
        let namespaces = self.open.last().copied().unwrap_or(0) + tag.namespaces;
        NAMESPACES.allows(namespaces)?;
        if !tag.is_empty {
            self.open.push(namespaces);
        }
        DEPTH.allows(self.open.len())
    }
}

/// The parts of a start tag, as far as the text goes.
#[derive(Default)]
struct StartTag {
    bytes: usize,
    attributes: usize,
    namespaces: usize,
    /// Whether the text has the tag's end.
    is_closed: bool,
    /// Whether the tag is the whole element.
    is_empty: bool,
}

impl StartTag {
    fn scan(text: &str) -> Self {
        let mut tag = Self::default();
        while let Some(offset) = text[tag.bytes..].find(['=', '>', '"', '\'']) {
            let before = &text[tag.bytes..][..offset];
            let (sign, after) = text[tag.bytes + offset..].split_at(1);
            tag.bytes += offset + 1;
            match sign {
                ">" => return Self { is_closed: true, is_empty: before.ends_with('/'), ..tag },
                "=" => {
                    let name = before.split_ascii_whitespace().next_back();
                    tag.attributes += 1;
                    tag.namespaces += usize::from(name.is_some_and(|name| name.starts_with("xmlns")));
                }
                quote => match after.find(quote) {
                    Some(length) => tag.bytes += length + 1,
                    None => break,
                },
            }
        }
        Self { bytes: text.len(), ..tag }
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
            "line 2: refused: more than 1000 attributes in an element; the file is damaged or hostile"
        );
        let long = "x".repeat(BYTES.most);
        assert_eq!(
            refused(&format!("<a>\n<b c='{long}'/></a>")),
            "line 2: refused: more than 33554432 bytes in an element's attributes; the file is damaged or hostile"
        );
        let depth = many(100_000, |_| "<a>".to_owned());
        assert_eq!(
            refused(&depth),
            "line 1: refused: more than 256 elements within each other; the file is damaged or hostile"
        );
        let namespaces = many(65, |k| format!("<a xmlns:n{k}=\"n\">"));
        assert_eq!(
            refused(&namespaces),
            "line 1: refused: more than 64 namespaces in an element; the file is damaged or hostile"
        );
    }

    #[test]
    fn what_would_take_gigabytes_is_refused_by_its_limit() {
        let nearly_full = |text: &str| {
            let mut sizes = Sizes { nodes: NODES.most - 2, attributes: ATTRIBUTES.most - 2, ..Sizes::default() };
            sizes.check(text).map_err(|error| error.to_string())
        };
        assert_eq!(nearly_full("<a b='' c=''>x<d/>"), Ok(()));
        assert_eq!(
            nearly_full("<a>\n<b/></a>").unwrap_err(),
            "line 2: refused: more than 10000000 elements, comments and pieces of text; the file is damaged or hostile"
        );
        assert_eq!(
            nearly_full("<a b=''>\n<c d='' e=''/>").unwrap_err(),
            "line 2: refused: more than 10000000 attributes; the file is damaged or hostile"
        );
    }

    #[test]
    fn a_comment_does_not_end_within_its_own_begin() {
        let attributes = (0..1_001).map(|k| format!(" a{k}=''")).collect::<String>();
        assert_eq!(
            refused(&format!("<r><!--><a b='--><x{attributes}/><y c='/>'/></r>")),
            "line 1: refused: more than 1000 attributes in an element; the file is damaged or hostile"
        );
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
