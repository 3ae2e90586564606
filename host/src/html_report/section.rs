//! Everything about one result.

use askama::Template;

use super::answer::{Finding, Refusal, Row, Verdict, findings, principal, relies_on, scale_text};
use super::facts::{Group, groups, simulated};
use super::hits::HitTable;
use super::limits::{Limits, cannot_see};
use super::points::{DofRow, dofs, sensors};
use super::scene::Scene;
use super::tables::{PropertyRow, PropertyTable, RowGroup};
use super::values::{Sentence, words};
use crate::embedded;
use crate::error::Result;
use crate::export::Exported;
use crate::picture::{DrawnFile, ImageFormat, Picture, ellipsoid};
use crate::result_file::{LAYOUT_NEEDED, ResultFile, shortened};

/// Longest heading, characters.
const MOST_IN_HEADING: usize = 160;
/// Bytes of pictures of all hits that a page has room for; they are the largest ones.
const MOST_OF_HITS: usize = 640 << 10;

/// One result in the page.
#[derive(Template)]
#[template(path = "report/section.html")]
pub(super) struct Section {
    number: usize,
    title: String,
    simulated: String,
    method: String,
    verdict: Verdict,
    rows: Vec<Row>,
    has_expected: bool,
    has_sources: bool,
    scale: String,
    principal: Vec<String>,
    limits: Limits,
    cannot_see: Vec<Sentence>,
    agreement: Option<Agreement>,
    refusals: Vec<Refusal>,
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
        let answers = source.answers()?;
        let answer = answers.first();
        let limits = answer.map(|answer| Limits::of(source, answer)).transpose()?;
        let limits = limits.unwrap_or_default();
        let rows = answer.map(|answer| Row::all(source, answer, &limits)).transpose()?;
        let rows = rows.unwrap_or_default();
        let dofs = dofs(source)?;
        Ok(Self {
            number,
            title: shortened(&source.whole_title, MOST_IN_HEADING),
            simulated: simulated(source),
            method: answer.map(|of| of.method.clone()).unwrap_or_default(),
            verdict: Verdict::of(source, answer),
            has_expected: rows.iter().any(|row| !row.expected.is_empty()),
            has_sources: rows.iter().any(|row| !row.mostly.is_empty()),
            scale: scale_text(source),
            rows,
            principal: answer.map(|answer| principal(source, answer)).unwrap_or_default(),
            limits,
            cannot_see: cannot_see(source),
            agreement: Agreement::of(source, &answers)?,
            // Without an answer, they are the reasons of the verdict.
            refusals: if answer.is_some() { Refusal::all(source) } else { Vec::new() },
            notes: findings(source)
                .into_iter()
                .filter(Finding::is_note)
                .map(|of| of.sentence)
                .collect(),
            has_hits: dofs.iter().any(|row| !row.hits.is_empty()),
            has_coherence: dofs.iter().any(|row| !row.coherence[0].is_empty()),
            has_details: dofs.iter().any(|row| !row.pull.is_empty()),
            dofs,
            sensors: source.layout().map(sensors).unwrap_or_default(),
            hits: HitTable::of(source)?,
            figures: Figures::of(source, MOST_OF_HITS / results)?,
            scene: Scene::of(source, answer),
            has_ellipsoid: answer.is_some_and(|of| ellipsoid(&of.body).is_some()),
            groups: groups(source)?,
            data: embedded::element(number, &source.json()?),
        })
    }
}

impl Agreement {
    /// What is said of several answers; `None` for fewer.
    ///
    /// # Errors
    /// When the combined answer is malformed.
    fn of(source: &ResultFile, answers: &[Exported]) -> Result<Option<Self>> {
        let verdict = words(&source.document()["agreement"]["verdict"]);
        if verdict.is_empty() || answers.len() < 2 {
            return Ok(None);
        }
        let row = |answer: &Exported| PropertyRow::of(source, answer.method.clone(), answer);
        let combined = source.combined()?.map(|of| PropertyRow::combined(&of));
        let rows = answers.iter().map(row).chain(combined).collect();
        let caption = "All answers from the same data, ± 95\u{a0}%";
        let groups = vec![RowGroup { heading: String::new(), rows }];
        let table = PropertyTable::new(caption, "method", groups);
        let verdict = match relies_on(source, &answers[0]) {
            true => "no: the note above says which one to rely on, and why".into(),
            false => verdict,
        };
        Ok(Some(Self { verdict: Sentence(verdict), table }))
    }
}

impl Figures {
    /// The pictures; of those of hits the first one, and others as long as they take no more bytes than `most_of_hits`.
    fn of(source: &ResultFile, most_of_hits: usize) -> Result<Self> {
        let (mut all, mut bytes_of_hits) = (Self::default(), 0);
        for picture in Picture::all() {
            let drawn = match picture.of(std::slice::from_ref(source), ImageFormat::Svg) {
                Ok(drawn) => drawn,
                // The others do not need it.
                Err(error) if error.code() == LAYOUT_NEEDED => continue,
                Err(error) => return Err(error),
            };
            for file in drawn {
                if *picture == Picture::Hits {
                    let bytes = bytes_of_hits + file.bytes.len();
                    if bytes_of_hits > 0 && bytes > most_of_hits {
                        all.omitted.extend(file.dof.map(|dof| dof.to_string()));
                        continue;
                    }
                    bytes_of_hits = bytes;
                }
                all.add(&file);
            }
        }
        Ok(all)
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
