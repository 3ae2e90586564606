//! The headings of a result, as the table of contents of the page lists them.

use super::Section;
use crate::page::answer::Verdict;

/// A result in the table of contents.
pub(in crate::page) struct Entry<'a> {
    pub number: usize,
    pub title: &'a str,
    pub verdict: &'a Verdict,
    /// The end of the identifier of each heading, and its text.
    pub headings: Vec<(&'static str, &'static str)>,
}

impl Section {
    /// The entry of the result.
    pub(in crate::page) fn entry(&self) -> Entry<'_> {
        let headings = [
            ("properties", "the ten properties", !self.rows.is_empty()),
            ("corrected", "the properties without a mistake", self.corrected.is_some()),
            ("space", "the test in space", self.scene.is_some()),
            ("limits", "what limits the answer", !self.limits.is_empty()),
            ("points", "sensors and hits", !self.dofs.is_empty()),
            ("hits", "every hit", !self.hits.is_empty()),
            ("pictures", "pictures", !self.figures.is_empty()),
            ("measurement", "how it was measured", true),
        ];
        let headings = headings.into_iter().filter(|(.., is_there)| *is_there);
        Entry {
            number: self.number,
            title: &self.title,
            verdict: &self.verdict,
            headings: headings.map(|(id, text, _)| (id, text)).collect(),
        }
    }
}
