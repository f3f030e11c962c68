//! A page that shows documents alone.

use std::path::Path;

use crate::error::Result;
use fmu_points::tell::visible;
use minijinja::{Environment, context};
use point_journal::files::write_text;
use result_document::Document;

/// A page of documents under one answer.
pub struct Page<'a> {
    /// Its kind.
    pub kicker: &'a str,
    /// Its subject.
    pub title: &'a str,
    /// The answer.
    pub headline: &'a str,
    /// Whether the answer is the wanted one.
    pub is_good: bool,
    /// The documents.
    pub documents: &'a [Document],
}

impl Page<'_> {
    /// Writes the page as a file.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&self, file: &Path) -> Result {
        let sections: String = self.documents.iter().map(Document::as_html).collect();
        let page = context! {
            kicker => self.kicker,
            title => self.title,
            headline => self.headline,
            kind => if self.is_good { "yes" } else { "no" },
            style => [result_document::svg::STYLE, include_str!("report/assets/report.css")].concat(),
            sections,
        };
        let template = include_str!("report/assets/plain.html");
        let html = Environment::new().render_named_str("plain.html", template, page)?;
        Ok(write_text(file, &*visible(&html))?)
    }
}
