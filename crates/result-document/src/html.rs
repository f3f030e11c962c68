//! A document as a section of the page.

use minijinja::{AutoEscape, Environment, Value, context, value::Serde};

use super::format::escape;
use crate::document::{Block, Document};

impl Document {
    /// The section, with an anchor and a heading.
    pub fn as_html(&self) -> String {
        let Self { id, title, .. } = self;
        format!(
            "<section id=\"{id}\" aria-labelledby=\"{id}-title\">\n<h2 id=\"{id}-title\">{}</h2>\n{}</section>\n",
            escape(title),
            html(&self.blocks)
        )
    }
}

/// The parts of a document as HTML. A table scrolls for itself, and can be reached with the keyboard.
pub fn html(blocks: &[Block]) -> String {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.set_formatter(|out, _, value| {
        let text = value.to_string();
        let written = if value.is_safe() { text } else { escape(&text) };
        Ok(out.write_str(&written)?)
    });
    environment.add_filter("marked", |text: &str| Value::from_safe_string(marked(text)));
    environment.add_filter("stressed", |html: &str| Value::from_safe_string(emphasised(html)));
    let blocks = context! { blocks => Serde(blocks) };
    environment.render_str(include_str!("blocks.html"), blocks).expect("the template knows all kinds of blocks")
}

/// A message as HTML: what the terminal shows between backticks is code, `u_{num}` has an index, and a warning is told by its
/// first word.
pub fn marked(text: &str) -> String {
    let mut html = String::new();
    let mut rest = text;
    if let Some(warning) = rest.strip_prefix("Warning:") {
        html.push_str("<strong>Warning:</strong>");
        rest = warning;
    }
    // A mark without a second one stays what it is.
    for (part, is_code) in between(rest, "`", "`") {
        if is_code {
            html += &format!("<code>{}</code>", escape(part));
            continue;
        }
        for (part, is_index) in between(part, "_{", "}") {
            html += &if is_index { format!("<sub>{}</sub>", escape(part)) } else { escape(part) };
        }
    }
    html
}

/// Words between asterisks are stressed.
fn emphasised(html: &str) -> String {
    between(html, "*", "*")
        .into_iter()
        .map(|(part, is_stressed)| if is_stressed { format!("<em>{part}</em>") } else { part.to_owned() })
        .collect()
}

/// The parts of a text, each with whether it stands between two marks.
pub fn between<'a>(mut text: &'a str, open: &str, close: &str) -> Vec<(&'a str, bool)> {
    let mut parts = Vec::new();
    while let Some((before, (inside, after))) =
        text.split_once(open).and_then(|(before, from)| Some((before, from.split_once(close)?)))
    {
        parts.extend([(before, false), (inside, true)]);
        text = after;
    }
    parts.push((text, false));
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Column, Table, numbers, words};

    #[test]
    fn messages_are_escaped_and_their_code_is_marked() {
        assert_eq!(
            marked("Warning: T<1: use `statistic = \"mean\"` with a `window`"),
            "<strong>Warning:</strong> T&lt;1: use <code>statistic = &quot;mean&quot;</code> with a <code>window</code>"
        );
        assert_eq!(marked("`<b>` and one ` alone & more"), "<code>&lt;b&gt;</code> and one ` alone &amp; more");
        assert_eq!(marked("a Warning: inside"), "a Warning: inside");
        assert_eq!(marked("u_{num}, a_b"), "u<sub>num</sub>, a_b");
    }

    #[test]
    fn the_terminal_and_the_page_show_the_same_table() {
        let mut document = Document::new("parts", "Parts", "The parts");
        document.say("Two parts.");
        document.hint("*Length*: that of the part.");
        document.table(Table {
            name: "Parts".into(),
            columns: vec![words("Part"), Column { unit: "mm".into(), ..numbers("Length") }],
            rows: [["a<b", "1"], ["c", "100"]].map(|row| row.map(String::from).to_vec()).to_vec(),
            ..Table::default()
        });
        assert_eq!(document.as_text(), "Two parts.\n  Part  Length (mm)\n  a<b             1\n  c             100\n");
        let html = document.as_html();
        for part in [
            "<section id=\"parts\" aria-labelledby=\"parts-title\">",
            "<p class=\"hint\"><em>Length</em>: that of the part.</p>",
            "<th scope=\"col\" class=\"num\">Length<small>mm</small></th>",
            "<tr><th scope=\"row\">a&lt;b</th><td class=\"num\">1</td></tr>",
        ] {
            assert!(html.contains(part), "{html}");
        }
    }
}
