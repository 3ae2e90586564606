//! Results as one HTML page for people: readable on a phone, printable on A4, without any other file and without
//! network.
//!
//! | module | subject |
//! | --- | --- |
//! | `section` | everything about one result |
//! | `answer` | the verdict and the ten properties |
//! | `limits` | what limits the answer, and what to do next time |
//! | `facts` | how it was measured: rig, calibration, settings, spectra, error budget |
//! | `points` | the sensors and the hit DOFs |
//! | `hits` | every hit with its verdict |
//! | `scene` | the test in space, which a small script turns |
//! | `several` | the answers of several results side by side |
//! | `tables` | tables of answers, with a column for each property |
//! | `values` | values in the document of a result, and sentences as HTML |
//!
//! The page is `templates/page.html`; the template library escapes every text that is put into it.

mod answer;
mod facts;
mod hits;
mod limits;
mod points;
mod scene;
mod section;
mod several;
mod tables;
mod values;

use askama::Template;

use crate::result_file::ResultFile;
use massline_files::clock;
use massline_result::{Error, Result};

use section::Section;
use several::ResultComparison;

/// The page.
#[derive(Template)]
#[template(path = "page.html")]
struct Page {
    title: String,
    written: String,
    program: &'static str,
    sections: Vec<Section>,
    several: Option<ResultComparison>,
}

/// The report of one result, or of several side by side.
///
/// # Errors
/// When a result is malformed or a picture cannot be drawn.
pub fn html(sources: &[ResultFile]) -> Result<String> {
    let sections =
        (1..).zip(sources).map(|(number, source)| Section::of(number, sources.len(), source));
    let page = Page {
        title: match sources {
            [one] => one.title.clone(),
            _ => format!("{} results", sources.len()),
        },
        written: for_people(&clock::now()),
        program: env!("CARGO_PKG_VERSION"),
        sections: sections.collect::<Result<_>>()?,
        several: ResultComparison::of(sources)?,
    };
    page.render().map_err(|e| {
        Error::internal(
            "report_not_written",
            format!("the report cannot be written: {e}; report this"),
        )
    })
}

/// A time, RFC 3339 in UTC, as people write it.
fn for_people(time: &str) -> String {
    let minutes = time.get(..16).filter(|_| time.ends_with('Z'));
    minutes.map_or_else(|| time.to_owned(), |minutes| minutes.replacen('T', " ", 1) + " UTC")
}
