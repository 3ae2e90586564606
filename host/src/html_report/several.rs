//! The answers of several results side by side.

use super::answer::{cell, label};
use super::for_people;
use super::values::words;
use crate::error::Result;
use crate::picture::{ImageFormat, Picture};
use crate::result_file::{LAYOUT_NEEDED, ResultFile, distinct_names};

/// A table: a row for each property, a column for each result.
pub(super) struct Several {
    pub header: Vec<String>,
    /// Symbol, index and unit, and the cells.
    pub rows: Vec<([&'static str; 3], Vec<String>)>,
    pub files: Vec<String>,
    pub measured: Vec<String>,
    pub methods: Vec<String>,
    pub boards: Vec<String>,
    /// The picture of the answers, where the layouts are known.
    pub figure: Option<String>,
}

impl Several {
    /// The table; `None` for a single result.
    ///
    /// # Errors
    /// When a result is malformed.
    pub fn of(sources: &[ResultFile]) -> Result<Option<Self>> {
        if sources.len() < 2 {
            return Ok(None);
        }
        let mut answers = Vec::new();
        for source in sources {
            answers.push(source.answers()?.into_iter().next());
        }
        let row = |k: usize| {
            let cells = answers.iter().map(|of| of.as_ref().map_or("–".into(), |of| cell(of, k)));
            (label(k), cells.collect())
        };
        let dash = |text: String| if text.is_empty() { "–".into() } else { text };
        Ok(Some(Self {
            header: sources.iter().map(|of| of.title.clone()).collect(),
            rows: (0..10).map(row).collect(),
            figure: picture(sources)?,
            files: distinct_names(sources),
            measured: sources
                .iter()
                .map(|of| dash(for_people(&words(&of.document()["measured"]))))
                .collect(),
            methods: answers
                .iter()
                .map(|of| dash(of.as_ref().map_or(String::new(), |of| of.method.clone())))
                .collect(),
            boards: sources
                .iter()
                .map(|of| {
                    dash(
                        of.archive().map_or_else(
                            || words(&of.document()["board"]),
                            |a| a.rig.board.clone(),
                        ),
                    )
                })
                .collect(),
        }))
    }
}

/// The answers drawn against each other.
fn picture(sources: &[ResultFile]) -> Result<Option<String>> {
    match Picture::Estimates.of(sources, ImageFormat::Svg) {
        Ok(drawn) => {
            let first = drawn.into_iter().next();
            Ok(first.map(|file| String::from_utf8_lossy(&file.bytes).into_owned()))
        }
        Err(error) if error.code() == LAYOUT_NEEDED => Ok(None),
        Err(error) => Err(error),
    }
}
