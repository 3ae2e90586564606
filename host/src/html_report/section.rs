//! Everything about one result.

use askama::Template;

use super::answer::{Row, Verdict, cell, findings, label, principal};
use super::facts::{Group, groups};
use super::limits::{Limits, unseen};
use super::points::{DofRow, dofs, sensors};
use super::scene::Scene;
use super::values::{list, words};
use crate::embedded;
use crate::error::Result;
use crate::export::Exported;
use crate::picture::{ImageFormat, Picture};
use crate::result_file::{LAYOUT_NEEDED, ResultFile, shortened};

/// How many of the ten properties the table of methods has room for: mass, centre and moments.
const SHOWN: usize = 7;
/// Longest title, characters.
const MOST_OF_TITLE: usize = 160;
/// Bytes of pictures of all hits of one DOF that a report has room for; they are the largest ones.
const MOST_OF_HITS: usize = 400 << 10;

/// One result in the page.
#[derive(Template)]
#[template(path = "report/section.html")]
pub(super) struct Section {
    number: usize,
    title: String,
    method: String,
    verdict: Verdict,
    rows: Vec<Row>,
    has_expected: bool,
    principal: Vec<String>,
    limits: Limits,
    unseen: Vec<String>,
    agreement: Option<Agreement>,
    refusals: Vec<(String, String)>,
    notes: Vec<String>,
    dofs: Vec<DofRow>,
    sensors: Vec<[String; 4]>,
    figures: Vec<Figure>,
    more_figures: Vec<Figure>,
    omitted: bool,
    scene: Option<String>,
    groups: Vec<Group>,
    data: String,
}

/// A picture.
struct Figure {
    caption: String,
    /// The element that draws it.
    svg: String,
}

/// What the methods say together.
struct Agreement {
    verdict: String,
    /// Method and its values with standard deviations, mass, centre and moments.
    rows: Vec<(String, Vec<String>)>,
    header: Vec<String>,
}

impl Section {
    /// The section of a result; `number` is its place in the page, from 1.
    ///
    /// # Errors
    /// When the result is malformed or a picture cannot be drawn.
    pub fn of(number: usize, source: &ResultFile) -> Result<Self> {
        let answers = source.answers()?;
        let answer = answers.first();
        let limits = answer.map(|answer| Limits::of(source, answer)).unwrap_or_default();
        let rows = answer.map(|answer| Row::all(source, answer, &limits)).transpose()?;
        let rows = rows.unwrap_or_default();
        let (figures, more_figures, omitted) = figures(source)?;
        let document = source.document();
        let refusals = list(&document["not_applicable"]).iter();
        Ok(Self {
            number,
            title: shortened(&source.whole_title, MOST_OF_TITLE),
            method: answer.map(|of| of.method.clone()).unwrap_or_default(),
            verdict: Verdict::of(source, answer),
            has_expected: rows.iter().any(|row| !row.expected.is_empty()),
            rows,
            principal: answer.map(|answer| principal(source, answer)).unwrap_or_default(),
            limits,
            unseen: unseen(source),
            agreement: Agreement::of(source, &answers),
            refusals: refusals.map(|of| (words(&of["method"]), words(&of["message"]))).collect(),
            notes: findings(source)
                .into_iter()
                .filter(|(severity, _)| severity == "note")
                .map(|(_, sentence)| sentence)
                .collect(),
            dofs: dofs(source)?,
            sensors: source.layout().map(sensors).unwrap_or_default(),
            figures,
            more_figures,
            omitted,
            scene: Scene::of(source, answer),
            groups: groups(source)?,
            data: embedded::element(number, &source.json()?),
        })
    }
}

impl Agreement {
    fn of(source: &ResultFile, answers: &[Exported]) -> Option<Self> {
        let verdict = words(&source.document()["agreement"]["verdict"]);
        if verdict.is_empty() || answers.len() < 2 {
            return None;
        }
        let row = |answer: &Exported| {
            let cells = (0..SHOWN).map(|k| cell(answer, k));
            (answer.method.clone(), cells.collect())
        };
        Some(Self {
            verdict,
            rows: answers.iter().map(row).collect(),
            header: (0..SHOWN).map(label).collect(),
        })
    }
}

/// The pictures that are shown at once, those to be opened, and whether some are left out.
fn figures(source: &ResultFile) -> Result<(Vec<Figure>, Vec<Figure>, bool)> {
    let (mut first, mut more, mut omitted) = (Vec::new(), Vec::new(), false);
    for picture in Picture::ALL {
        let drawn = match picture.of(std::slice::from_ref(source), ImageFormat::Svg) {
            Ok(drawn) => drawn,
            // The others do not need it.
            Err(error) if error.code() == LAYOUT_NEEDED => continue,
            Err(error) => return Err(error),
        };
        let is_too_large = drawn.iter().map(|of| of.bytes.len()).sum::<usize>() > MOST_OF_HITS;
        if picture == Picture::Hits && is_too_large {
            omitted = true;
            continue;
        }
        let many = matches!(picture, Picture::Frf | Picture::Hits);
        for file in drawn {
            let dof =
                file.stem.strip_prefix(picture.name()).unwrap_or_default().trim_start_matches('-');
            let caption = match dof {
                "" => picture.caption().to_owned(),
                dof => format!("{}, hits at {}", picture.caption(), with_colon(dof)),
            };
            let figure = Figure { caption, svg: String::from_utf8_lossy(&file.bytes).into_owned() };
            if many { more.push(figure) } else { first.push(figure) }
        }
    }
    Ok((first, more, omitted))
}

/// The name of a DOF from that of its file, which has no colon.
fn with_colon(stem: &str) -> String {
    match stem.find(['+', '-']) {
        Some(at) => format!("{}:{}", &stem[..at], &stem[at..]),
        None => stem.to_owned(),
    }
}
