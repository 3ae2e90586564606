//! Everything about one result.

mod contents;

use askama::Template;

use massline_result::{Estimate, SingleFaults, Suspect, TestResult};

use super::answer::{Row, SharedRefusal, Verdict, notes, principal, refused, scale_text};
use super::facts::{Group, groups, simulated};
use super::hits::HitTable;
use super::limits::{Limits, cannot_see, tested, tested_text};
use super::points::{DofRow, dofs, sensors};
use super::scene::Scene;
use super::tables::{PropertyRow, PropertyTable, RowGroup, SCATTER_ONLY};
use super::values::Sentence;
use crate::picture::{DrawnFile, ImageFormat, Picture, ellipsoid};
use crate::result_file::{ResultFile, shortened};
use crate::typography::with_minus_signs;
use crate::words::suspected_text;
use massline_files::embedded;
use massline_result::Result;

/// Longest heading, characters.
const MOST_IN_HEADING: usize = 160;
/// Bytes of pictures of all hits that a page has room for; they are the largest ones.
const MOST_OF_HITS: usize = 640 << 10;

/// One result in the page.
#[derive(Template)]
#[template(path = "section.html")]
pub(super) struct Section {
    number: usize,
    /// Whether the page has a table of contents.
    is_one_of_several: bool,
    title: String,
    simulated: String,
    method: String,
    verdict: Verdict,
    rows: Vec<Row>,
    has_intervals: bool,
    has_expected: bool,
    has_sources: bool,
    scale: String,
    principal: Vec<String>,
    corrected: Option<PropertyTable>,
    limits: Limits,
    cannot_see: Vec<Sentence>,
    /// Small faults: name, what was found, sizes and effect.
    tested: Vec<[String; 5]>,
    tested_text: Sentence,
    agreement: Option<Agreement>,
    refusals: Vec<SharedRefusal>,
    notes: Vec<Sentence>,
    dofs: Vec<DofRow>,
    has_hits: bool,
    has_coherence: bool,
    has_details: bool,
    sensors: Vec<[String; 4]>,
    hits: HitTable,
    figures: Figures,
    scene: Option<String>,
    /// Whether a real body has the inertia that was found.
    has_ellipsoid: bool,
    groups: Vec<Group>,
    data: String,
}

/// The pictures of a result.
#[derive(Default)]
struct Figures {
    /// The test in space: in the place of the one that turns, where that cannot be.
    still: Option<String>,
    /// Those that are shown at once.
    first: Vec<Figure>,
    /// Those to be opened.
    more: Vec<Figure>,
    /// The DOFs whose pictures of all hits are left out.
    omitted: Vec<String>,
}

/// A picture.
struct Figure {
    caption: String,
    /// The element that draws it.
    svg: String,
}

/// What the methods say together.
struct Agreement {
    verdict: Sentence,
    table: PropertyTable,
}

impl Section {
    /// The section of a result; `number` is its place in the page, from 1, and `results` how many share the page.
    ///
    /// # Errors
    /// When the result is malformed or a picture cannot be drawn.
    pub fn of(number: usize, results: usize, source: &ResultFile) -> Result<Self> {
        let result = source.result();
        let answer = result.answer();
        let limits = answer.map(|answer| Limits::of(source, answer)).unwrap_or_default();
        let rows = answer.map(|answer| Row::all(source, answer, &limits)).unwrap_or_default();
        let dofs = dofs(source);
        Ok(Self {
            number,
            is_one_of_several: results > 1,
            title: shortened(&source.whole_title, MOST_IN_HEADING),
            simulated: simulated(source),
            method: answer.map(method_text).unwrap_or_default(),
            verdict: Verdict::of(result),
            has_intervals: rows.iter().any(|row| !row.half_width.is_empty()),
            has_expected: rows.iter().any(|row| !row.expected.is_empty()),
            has_sources: rows.iter().any(|row| !row.mostly.is_empty()),
            scale: scale_text(source),
            rows,
            principal: answer.map(principal).unwrap_or_default(),
            corrected: result.single_faults.as_ref().and_then(corrected),
            limits,
            cannot_see: cannot_see(result),
            tested: result.score_tests.iter().map(tested).collect(),
            tested_text: tested_text(result),
            agreement: Agreement::of(result),
            // Without an answer, they are the reasons of the verdict.
            refusals: if answer.is_some() { refused(&result.not_applicable) } else { Vec::new() },
            notes: notes(result),
            has_hits: dofs.iter().any(|row| !row.hits.is_empty()),
            has_coherence: dofs.iter().any(|row| !row.coherence[0].is_empty()),
            has_details: dofs.iter().any(|row| !row.pull.is_empty()),
            dofs,
            sensors: source.layout().map(sensors).unwrap_or_default(),
            hits: HitTable::of(source),
            figures: Figures::of(source, MOST_OF_HITS / results)?,
            scene: Scene::of(source, answer),
            has_ellipsoid: answer.is_some_and(|answer| ellipsoid(&answer.body()).is_some()),
            groups: groups(source)?,
            data: embedded::element(number, &source.json()?),
        })
    }
}

/// The method of an answer, with what has to be said of its intervals.
pub(super) fn method_text(answer: &Estimate) -> String {
    match answer.covers_scatter_only() {
        true => format!("{} ({SCATTER_ONLY})", answer.method),
        false => answer.method.to_string(),
    }
}

/// The ten properties as they would be without each of the mistakes that explain the data; `None` without such a
/// mistake.
fn corrected(faults: &SingleFaults) -> Option<PropertyTable> {
    let row = |suspect: &Suspect| {
        let corrected = suspect.corrected.as_ref()?;
        Some(PropertyRow::of(
            with_minus_signs(&format!("if {}", suspected_text(suspect))),
            corrected,
        ))
    };
    let rows: Vec<_> = faults.suspects.iter().filter_map(row).collect();
    let caption = "Not the answer of this test: the properties without a mistake";
    let groups = vec![RowGroup { heading: String::new(), rows }];
    (!groups[0].rows.is_empty()).then(|| PropertyTable::new(caption, "mistake", groups))
}

impl Agreement {
    /// What is said of several answers; `None` for fewer.
    fn of(result: &TestResult) -> Option<Self> {
        let agreement = result.agreement.as_ref().filter(|_| result.results.len() > 1)?;
        let row = |answer: &Estimate| PropertyRow::of(answer.method.to_string(), answer);
        let combined = agreement.combined.as_ref().map(PropertyRow::combined);
        let rows = result.results.iter().map(row).chain(combined).collect();
        let caption = "All answers from the same data";
        let groups = vec![RowGroup { heading: String::new(), rows }];
        let table = PropertyTable::new(caption, "method", groups);
        Some(Self { verdict: Sentence(agreement.sentence.clone()), table })
    }
}

impl Figures {
    /// The pictures; of those of hits the first one, and others as long as they take no more bytes than `most_of_hits`.
    fn of(source: &ResultFile, most_of_hits: usize) -> Result<Self> {
        let (mut figures, mut bytes_of_hits) = (Self::default(), 0);
        for picture in Picture::all() {
            for file in picture.of(std::slice::from_ref(source), ImageFormat::Svg)? {
                if *picture == Picture::Hits {
                    let bytes = bytes_of_hits + file.bytes.len();
                    if bytes_of_hits > 0 && bytes > most_of_hits {
                        figures.omitted.extend(file.dof.map(|dof| dof.to_string()));
                        continue;
                    }
                    bytes_of_hits = bytes;
                }
                figures.add(&file);
            }
        }
        Ok(figures)
    }

    fn add(&mut self, file: &DrawnFile) {
        let svg = String::from_utf8_lossy(&file.bytes).into_owned();
        let list = match file.picture {
            Picture::Layout => {
                self.still = Some(svg);
                return;
            }
            Picture::Frf | Picture::Hits => &mut self.more,
            _ => &mut self.first,
        };
        list.push(Figure { caption: file.caption(), svg });
    }

    fn is_empty(&self) -> bool {
        self.first.is_empty() && self.more.is_empty()
    }
}
