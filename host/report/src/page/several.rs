//! The answers of several results side by side: by test, by method and by the sensors.

use massline_result::{Estimate, Verdict};

use super::facts::{board, method_and_day};
use super::for_people;
use super::section::method_text;
use super::tables::{Cell, Label, PropertyRow, PropertyTable, RowGroup, intervals_in};
use crate::picture::{ImageFormat, Picture};
use crate::result_file::ResultFile;
use massline_result::Result;

/// What the page says of several results together.
pub(super) struct ResultComparison {
    /// The titles of the results.
    pub header: Vec<String>,
    /// The properties of the best answers, a cell for each result.
    pub rows: Vec<(Label, Vec<Cell>)>,
    /// What their caption says of intervals.
    pub intervals: &'static str,
    /// What else is known of the results.
    pub facts: Vec<(&'static str, Vec<String>)>,
    /// The picture of the best answers.
    pub figure: Option<String>,
    /// The answers in other orders.
    pub tables: Vec<PropertyTable>,
}

/// A result with its answers, the best first.
struct NumberedResult<'a> {
    /// Its place in the page, from 1.
    number: usize,
    source: &'a ResultFile,
    answers: &'a [Estimate],
}

impl ResultComparison {
    /// The tables; `None` for a single result.
    ///
    /// # Errors
    /// When a result is malformed.
    pub fn of<'a>(sources: &'a [ResultFile]) -> Result<Option<Self>> {
        if sources.len() < 2 {
            return Ok(None);
        }
        let answered = |(number, source): (usize, &'a ResultFile)| NumberedResult {
            number,
            source,
            answers: &source.result().results,
        };
        let results: Vec<_> = (1..).zip(sources).map(answered).collect();
        let rows = rows(&results);
        Ok(Some(Self {
            header: sources.iter().map(|source| source.title.clone()).collect(),
            intervals: intervals_in(rows.iter().flat_map(|(_, cells)| cells)),
            rows,
            facts: facts(&results)?,
            figure: picture(sources)?,
            tables: [by_method(&results), by_sensors(&results)].into_iter().flatten().collect(),
        }))
    }
}

impl<'a> NumberedResult<'a> {
    fn row(&self, answer: &Estimate) -> PropertyRow {
        let name = format!("{}: {}", self.number, self.source.title);
        PropertyRow { result: Some(self.number), ..PropertyRow::of(name, answer) }
    }

    /// The method of the best answer, with what has to be said of its intervals.
    fn method(&self) -> String {
        self.answers.first().map_or(String::new(), method_text)
    }

    /// The verdict in a few words.
    fn verdict(&self) -> &'static str {
        self.source.result().verdict.map_or("no answer", Verdict::words)
    }

    /// The sensors as the layout file states them; empty where it does not.
    fn sensors(&self) -> &'a str {
        self.source.layout_file().map_or("", |file| file.statements.sensors.trim())
    }
}

/// The best answers, a row for each property.
fn rows(results: &[NumberedResult<'_>]) -> Vec<(Label, Vec<Cell>)> {
    let best = results.iter().map(|result| match result.answers.first() {
        Some(best) => Cell::all(best),
        None => (0..10).map(|_| Cell::none()).collect(),
    });
    let mut columns: Vec<_> = best.map(Vec::into_iter).collect();
    let row = |label| (label, columns.iter_mut().filter_map(Iterator::next).collect());
    Label::all().into_iter().map(row).collect()
}

/// Where the answers come from, a row for each subject.
fn facts(results: &[NumberedResult<'_>]) -> Result<Vec<(&'static str, Vec<String>)>> {
    let row = |label, text_of: &dyn Fn(&NumberedResult<'_>) -> Result<String>| {
        let cell = |text: String| if text.is_empty() { "–".to_owned() } else { text };
        let cells = results.iter().map(|answered| text_of(answered).map(cell));
        Ok((label, cells.collect::<Result<Vec<_>>>()?))
    };
    let facts = [
        row("file", &|result| Ok(result.source.name.clone())),
        row("measured", &|result| {
            Ok(for_people(result.source.result().measured.as_deref().unwrap_or_default()))
        }),
        row("method", &|result| Ok(result.method())),
        row("verdict", &|result| Ok(result.verdict().to_owned())),
        row("sensors", &|result| Ok(result.sensors().to_owned())),
        row("calibration", &|result| method_and_day(result.source)),
        row("board", &|result| Ok(board(result.source))),
    ];
    facts.into_iter().collect()
}

/// The answers of all results by each method; `None` without any.
fn by_method(results: &[NumberedResult<'_>]) -> Option<PropertyTable> {
    let pairs = || {
        results.iter().flat_map(|result| result.answers.iter().map(move |answer| (result, answer)))
    };
    let groups = grouped(
        pairs(),
        |(_, answer)| answer.method.to_string(),
        |(result, answer)| result.row(answer),
    );
    let caption = "The answers of all results by each method";
    (!groups.is_empty()).then(|| PropertyTable::new(caption, "method and result", groups))
}

/// The best answers by the sensors; `None` unless several kinds of sensors are stated.
fn by_sensors(results: &[NumberedResult<'_>]) -> Option<PropertyTable> {
    let stated = results.iter().filter(|result| !result.sensors().is_empty());
    let pairs = stated.filter_map(|result| Some((result, result.answers.first()?)));
    let groups = grouped(
        pairs,
        |(result, _)| result.sensors().to_owned(),
        |(result, best)| result.row(best),
    );
    let caption = "The best answers by the sensors, as the layouts state them";
    (groups.len() > 1).then(|| PropertyTable::new(caption, "sensors and result", groups))
}

/// Rows with the same heading in one group, in the order in which the headings come first.
fn grouped<T: Copy>(
    items: impl Iterator<Item = T>,
    heading: impl Fn(T) -> String,
    row: impl Fn(T) -> PropertyRow,
) -> Vec<RowGroup> {
    let mut groups: Vec<RowGroup> = Vec::new();
    for one in items {
        let (heading, row) = (heading(one), row(one));
        match groups.iter_mut().find(|group| group.heading == heading) {
            Some(group) => group.rows.push(row),
            None => groups.push(RowGroup { heading, rows: vec![row] }),
        }
    }
    groups
}

/// The best answers drawn against each other.
fn picture(sources: &[ResultFile]) -> Result<Option<String>> {
    let first = Picture::Estimates.of(sources, ImageFormat::Svg)?.into_iter().next();
    Ok(first.map(|file| String::from_utf8_lossy(&file.bytes).into_owned()))
}
