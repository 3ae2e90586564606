//! The offline solver: computes the ten properties in double precision from a layout and the frequency
//! responses of a universal file.
//!
//! The file must hold one frequency response function for every sensor axis and hit of the layout; one that is stored
//! for the opposite direction is negated. Where the file has a band for it, a mass line is fitted to every accelerance
//! with equal weights and passed to [`identification`] as the average of as many hits as `[test]` asks for. Where it
//! has the lines of the suspension modes, they go to [`suspension`](massline_analysis::suspension). What both say is
//! compared.
//!
//! [`identification`]: massline_analysis::identification

mod answer;
mod driving_points;
mod errors;
mod frfs;
mod layout_checks;
mod missing;
mod pair;
mod reading;
mod responses;
mod selection;
mod suspension;
mod suspension_lines;

use std::path::{Path, PathBuf};

use massline_shared::diagnosis::Code;
use massline_shared::identify::inertia_restraint;
use massline_shared::identify::{IdentifySettings, Method, Observable, Observations};
use massline_shared::layout::{Dof, HostLayout, TestProfile, TestSettings};
use massline_shared::modes::LinesPerSide;

use crate::{Error, ErrorKind, Result};
use answer::{Settings, failed, solution};
use driving_points::{after_points, blame_option, reversed_points};
use errors::{blame_the_responses, both_errors, undetermined};
use frfs::{FittedLines, LayoutResponses, stated_band};
use layout_checks::{admitted, layout_problem};
use massline_analysis::design::assumed_for_solving;
use massline_analysis::identification::{Identification, Selection, identify, learned};
use massline_analysis::plausibility::suspicions;
use massline_analysis::score_tests::ScoreTests;
use massline_analysis::single_fault::{Examination, NominalTest};
use massline_analysis::suspension::{
    Comparison, MassLineAnswers, ModeChoice, SuspensionModes, compare, reciprocity_of_mass_lines,
};
use massline_files::archive::Archive;
use massline_files::layout_file::LayoutFile;
use massline_files::uff::{Encoding, Quantity, UffFile, write};
use massline_report::solution::Solution;
use massline_report::words::message_in;
use reading::reading_text;
use suspension::{LookOutcome, ModalPart};
pub(crate) use suspension::{lacking, no_modal_answer};

pub(crate) use errors::first_error;
pub use responses::responses_of;

/// The point about which the equations are set up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReferencePoint {
    /// The mean of the sensor positions, which gives the least noise.
    #[default]
    Centroid,
    /// The origin of the body frame.
    Origin,
}

impl ReferencePoint {
    /// The name in options and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Centroid => "centroid",
            Self::Origin => "origin",
        }
    }
}

/// Band in which the suspension modes are looked for, Hz: that of the literature.
pub const SUSPENSION_BAND_HZ: [f64; 2] = [0.5, 12.5];

/// How to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The point about which the equations are set up.
    pub reference_point: ReferencePoint,
    /// The quantity of the responses; overrides what the file states. `None` takes it from the file.
    pub quantity: Option<Quantity>,
    /// The selected methods.
    pub selection: Selection,
    /// σ of the exponential window that was applied to force and responses, 1/s; 0 for no window.
    pub decay: f64,
    /// Band in which the suspension modes are looked for, Hz; `None` for that of the literature, or of the test in an
    /// archive.
    pub suspension_band_hz: Option<[f64; 2]>,
    /// The modes that the methods get which use them.
    pub mode_choice: ModeChoice,
    /// Lines about each mode for the direct methods.
    pub lines: LinesPerSide,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            reference_point: ReferencePoint::default(),
            quantity: None,
            selection: Selection::default(),
            decay: 0.0,
            suspension_band_hz: None,
            mode_choice: ModeChoice::default(),
            lines: LinesPerSide::default(),
        }
    }
}

impl Options {
    /// The band in which the suspension modes are looked for, Hz.
    pub fn suspension_band(&self) -> [f64; 2] {
        self.suspension_band_hz.unwrap_or(SUSPENSION_BAND_HZ)
    }
}

/// The digits of a frequency that single precision keeps, Hz.
const SINGLE: f64 = 1e4;

/// The band of the suspension modes in a test of their profile, Hz.
pub fn band_of_modes(test: &TestSettings<f64>) -> [f64; 2] {
    test.expected_band().map(|end| (end * SINGLE).round() / SINGLE)
}

/// A layout with its frequency responses, read from files.
pub struct Problem {
    /// The layout, with the hits in use.
    pub layout: LayoutFile,
    uff: UffFile,
    /// The files of both.
    paths: [PathBuf; 2],
}

impl Problem {
    /// Reads both files, with these hits of the layout, or all of them for none.
    ///
    /// # Errors
    /// Exit 2 when a file cannot be read.
    pub fn read(layout: &Path, frfs: &Path, hits: &[Dof]) -> Result<Self> {
        let paths = [layout, frfs].map(Path::to_owned);
        Ok(Self { layout: layout_with_hits(layout, hits)?, uff: UffFile::read(frfs)?, paths })
    }

    /// What is understood of the frequency responses, in one line; none where they are refused.
    pub fn understood(&self, options: &Options) -> Option<String> {
        let [_, frfs] = &self.paths;
        understood(&self.layout.layout, (&self.uff, frfs), options)
    }
}

/// What is understood of the frequency responses of a layout in a universal file, in one line that names the file; none
/// where they are refused.
pub fn understood(
    layout: &HostLayout,
    (uff, path): (&UffFile, &Path),
    options: &Options,
) -> Option<String> {
    let band = options.suspension_band();
    let responses = LayoutResponses::of(layout, uff, options.quantity, band).ok()?;
    Some(format!("{}: {}", path.display(), reading_text(responses.reading.document())))
}

/// Solves a problem. `progress` is told how many of all perturbations are done.
///
/// # Errors
/// As [`solve`]; the message names the file.
pub fn solve_problem(
    problem: &Problem,
    options: &Options,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<Solution> {
    let [layout, frfs] = problem.paths.each_ref().map(|path| path.display());
    solve(&problem.layout, &problem.uff, options, progress).map_err(|error| match error.kind {
        ErrorKind::Undetermined => error.within(format!("{layout} with {frfs}")),
        _ => error.within(frfs),
    })
}

/// A layout file with these of its hits, or all of them for none.
fn layout_with_hits(path: &Path, hits: &[Dof]) -> Result<LayoutFile> {
    let mut file = LayoutFile::read(path)?;
    keep_hits(&mut file.layout, hits, path)?;
    Ok(file)
}

/// Drops all hits but these, or none for none; `path` has the layout.
fn keep_hits(layout: &mut HostLayout, hits: &[Dof], path: &Path) -> Result<()> {
    if let Some(missing) = hits.iter().find(|dof| !layout.hits.iter().any(|h| h.dof == **dof)) {
        let text = format!("{}: the layout has no hit {missing}; see its `hits`", path.display());
        return Err(Error::input("hit_not_in_layout", text));
    }
    if let Some((_, twice)) = hits.iter().enumerate().find(|(k, dof)| hits[..*k].contains(dof)) {
        return Err(Error::input(
            "usage",
            format!("--hits has {twice} twice; state every hit once"),
        ));
    }
    if !hits.is_empty() {
        layout.hits.retain(|hit| hits.contains(&hit.dof));
    }
    Ok(())
}

/// Solves a layout with frequency responses: by mass lines where the file has a band for them, and by the suspension
/// modes where it has those.
///
/// # Errors
/// Exit 2 for a function that is missing, duplicated, not finite, or of wrong type or units; exit 3 when
/// layout or data cannot determine the ten properties.
pub fn solve(
    file: &LayoutFile,
    uff: &UffFile,
    options: &Options,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<Solution> {
    let mut file = file.clone();
    // These responses are not those of a rig, whose band the profile states and whose converter the budget of the
    // suspension profile contains.
    let test = &mut file.layout.test;
    (test.band_hz, test.profile) = (stated_band(test), TestProfile::MassLine);
    solve_as_stated(&file, uff, options, progress).map_err(|error| blame_option(error, options))
}

fn solve_as_stated(
    file: &LayoutFile,
    uff: &UffFile,
    options: &Options,
    mut progress: impl FnMut(u32, u32) + Send,
) -> Result<Solution> {
    let layout = &file.layout;
    let wanted = options.selection.methods();
    let uses_mass_lines = |method: &Method| method.entry().observes == Observable::MassLines;
    let (of_mass_lines, of_modes): (Vec<_>, Vec<_>) =
        wanted.iter().copied().partition(uses_mass_lines);
    let (body, about_body) = assumed_for_solving(file);
    let (of_modes, blocked) = admitted(layout, &body, of_modes);
    let checked = |methods: &[Method]| layout_problem(file, &body, &about_body, methods);
    // A layout that no method can use is named before its responses are looked for.
    checked(&wanted)?;
    let responses = LayoutResponses::of(layout, uff, options.quantity, options.suspension_band())
        .or_else(|error| {
        checked(&of_mass_lines)?;
        Err(error)
    })?;
    let named = matches!(options.selection, Selection::Only(_)) && !of_modes.is_empty();
    let (look, few_lines) = match suspension::look(layout, &responses, options) {
        LookOutcome::TooFewLines(error) if !named => (None, Some(error)),
        looked => (Some(looked.needed()), None),
    };
    let highest = look.as_ref().and_then(|look| look.as_ref().ok()?.highest_hz());
    let mass_lines = (!of_mass_lines.is_empty()).then(|| {
        checked(&of_mass_lines)?;
        let mut lines = responses.mass_lines(layout, options.decay)?;
        refuse_suspension_in_band(lines.band_hz, highest)?;
        let reversed = reversed_points(layout, &responses, lines.band_hz)?;
        lines.diagnostics.extend(reciprocity_of_mass_lines(layout, &lines.lines));
        mass_line_part(file, lines, options).map_err(|error| after_points(&reversed, error, layout))
    });
    let answers = mass_lines.as_ref().and_then(|part| part.as_ref().ok());
    let answers = answers.map(|part| part.answers(layout));
    let asked_for = !(of_modes.is_empty() && blocked.is_empty());
    let modal = look.filter(|_| asked_for).map(|look| {
        if of_modes.is_empty() {
            let reasons = blocked.first().map(|(_, reasons)| reasons.as_slice());
            let error = first_error(reasons.unwrap_or_default(), |d| message_in(d, layout));
            return Err(error.unwrap_or_else(undetermined));
        }
        let mut part =
            suspension::part(layout, &look?, options, &of_modes, answers.as_ref(), &mut progress)?;
        part.solution.not_applicable.extend(blocked);
        Ok(part)
    });
    let mut notes = responses.reading.notes().to_vec();
    notes.push(about_body);
    let reading = responses.reading.document().clone();
    let settings = Settings::new(file, options.reference_point, reading);
    // The answers of both parts are compared together; those to mass lines alone only where there are no others.
    let comparison = match (&answers, &modal) {
        (Some(answers), None | Some(Err(_))) => compare(answers, progress),
        _ => Comparison::default(),
    };
    // Where nothing answers, the lines that are missing for the modes are worth a word.
    let modal = match (&mass_lines, modal) {
        (Some(Err(error)), None) if !of_modes.is_empty() && error.code() == NARROW => {
            few_lines.map(Err)
        }
        (_, modal) => modal,
    };
    let asked = RequestedMethods { of_mass_lines, of_modes };
    let mut solution = combine(settings, asked, (mass_lines, comparison), modal, notes)?;
    solution.suspicions = responses.reading.suspicions().collect();
    let estimates = &solution.identification.estimates;
    solution.suspicions.extend(suspicions(&NominalTest::of_file(file), estimates));
    Ok(solution)
}

/// The code of a band of which the file has too little.
const NARROW: &str = "band_too_narrow";

/// The methods that were asked for, by what they use.
struct RequestedMethods {
    of_mass_lines: Vec<Method>,
    of_modes: Vec<Method>,
}

/// Suspension modes, with what they were found with.
#[derive(Clone, Debug)]
pub struct FoundModes {
    /// The modes.
    pub modes: SuspensionModes,
    /// The layout.
    pub layout: HostLayout,
    /// The band, Hz.
    pub band_hz: [f64; 2],
}

/// The suspension modes of a problem.
///
/// # Errors
/// As [`solve_problem`].
pub fn modes_of_problem(
    problem: &Problem,
    options: &Options,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<FoundModes> {
    let [_, frfs] = &problem.paths;
    let modes = modes_of(problem.layout.layout.clone(), &problem.uff, options, progress);
    modes.map_err(|error| error.within(frfs.display()))
}

/// The suspension modes of an archive whose spectra were kept, with its layout or a corrected one; `path` is that of
/// the archive. The exponential window is that of the spectra, and in the suspension profile the band that of the test.
///
/// # Errors
/// As [`solve_problem`]; `no_spectra` for an archive without them.
pub fn modes_of_archive(
    (archive, path): (&Archive, &Path),
    mut layout: HostLayout,
    hits: &[Dof],
    options: &Options,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<FoundModes> {
    let frfs = archive.frfs();
    let Some(decay) = archive.decay_per_s().filter(|_| !frfs.is_empty()) else {
        let text = format!(
            "{}: it holds no frequency responses; `massline measure -o` keeps them, `results get -o` cannot",
            path.display()
        );
        return Err(Error::input("no_spectra", text));
    };
    keep_hits(&mut layout, hits, path)?;
    let uff = UffFile::parse(&write(&frfs, Encoding::Binary))?;
    let of_test = match archive.result.profile() {
        TestProfile::MassLine => None,
        TestProfile::Suspension => Some(band_of_modes(&layout.test)),
    };
    let suspension_band_hz = options.suspension_band_hz.or(of_test);
    let options = Options { decay, suspension_band_hz, ..*options };
    modes_of(layout, &uff, &options, progress).map_err(|error| error.within(path.display()))
}

fn modes_of(
    layout: HostLayout,
    uff: &UffFile,
    options: &Options,
    progress: impl FnMut(u32, u32) + Send,
) -> Result<FoundModes> {
    let responses = LayoutResponses::of(&layout, uff, options.quantity, options.suspension_band())?;
    let modes = suspension::modes_alone(&layout, &responses, options, progress)
        .map_err(|error| blame_option(error, options))?;
    Ok(FoundModes { modes, layout, band_hz: options.suspension_band() })
}

/// The mass line begins this much above the highest suspension mode at least (theory, section 5).
const LEAST_ABOVE_SUSPENSION: f64 = 2.0;

/// Refuses mass lines whose band begins too near to the highest suspension mode.
fn refuse_suspension_in_band([begins, _]: [f64; 2], highest_hz: Option<f64>) -> Result<()> {
    let Some(highest) = highest_hz else { return Ok(()) };
    if begins >= LEAST_ABOVE_SUSPENSION * highest {
        return Ok(());
    }
    let text = format!(
        "the band of the mass lines begins at {begins:.1} Hz, and the highest suspension mode lies at {highest:.2} Hz; \
         let test.band_hz begin at {:.0} Hz, provided that no elastic mode is near",
        (3.0 * highest).ceil()
    );
    Err(Error::undetermined(Code::SuspensionInBand.name(), text))
}

/// The answers from mass lines and from suspension modes as one solution.
fn combine(
    settings: Settings,
    asked: RequestedMethods,
    (mass_lines, comparison): (Option<Result<MassLinePart>>, Comparison),
    modal: Option<Result<ModalPart>>,
    notes: Vec<String>,
) -> Result<Solution> {
    let (mass_lines, modal) = match (mass_lines, modal) {
        (Some(Err(of_lines)), Some(Err(of_modes))) => return Err(both_errors(of_lines, of_modes)),
        (None, Some(Err(error))) | (Some(Err(error)), None) => return Err(error),
        (None, None) => return Err(Error::undetermined("no_answer", "no method was asked for")),
        both => both,
    };
    let mut without_answer = Vec::new();
    let mut failed_by = |methods: Vec<Method>, error: &Error| {
        without_answer.extend(methods.into_iter().map(|method| failed(method, error)));
    };
    if let Some(Err(error)) = &mass_lines {
        failed_by(asked.of_mass_lines, error);
    }
    if let Some(Err(error)) = &modal {
        failed_by(asked.of_modes, error);
    }
    let (mass_lines, modal) = (mass_lines.and_then(Result::ok), modal.and_then(Result::ok));
    let mut solution = solution(settings, mass_lines, modal, notes);
    solution.failed = without_answer;
    if solution.modes.is_none() {
        solution.comparison = comparison;
    }
    Ok(solution)
}

/// What the mass lines of a file say.
pub(crate) struct MassLinePart {
    lines: FittedLines,
    identification: Identification,
    examination: Examination,
    score_tests: ScoreTests,
    settings: IdentifySettings<f64>,
}

impl MassLinePart {
    fn answers(&self, layout: &HostLayout) -> MassLineAnswers<'_> {
        let best = self.identification.estimates.first();
        let budget = best.map_or_else(|| layout.clone(), |estimate| learned(layout, estimate));
        let estimates = &self.identification.estimates;
        MassLineAnswers::new(estimates, &self.lines.lines, budget, self.settings.inertia_restraint)
    }
}

fn mass_line_part(
    file: &LayoutFile,
    mut lines: FittedLines,
    options: &Options,
) -> Result<MassLinePart> {
    let layout = &file.layout;
    let reference = match options.reference_point {
        ReferencePoint::Centroid => inertia_restraint::ReferencePoint::Centroid,
        ReferencePoint::Origin => inertia_restraint::ReferencePoint::Origin,
    };
    let settings =
        IdentifySettings { inertia_restraint: reference.into(), ..IdentifySettings::default() };
    let examination = NominalTest::of_file(file).examine(&lines.lines);
    let observed = Observations::of_mass_lines(layout, &lines.lines);
    let identification = identify(&observed, options.selection, &settings).answered();
    let mut identification = identification.map_err(|reasons| {
        let error = first_error(&reasons, |d| message_in(d, layout)).unwrap_or_else(undetermined);
        blame_the_responses(error, &examination, layout)
    })?;
    let score_tests = ScoreTests::of(layout, &lines.lines, &identification.estimates);
    score_tests.in_proportion(&mut lines.diagnostics);
    identification.each_diagnostics(|diagnostics| score_tests.in_proportion(diagnostics));
    Ok(MassLinePart { lines, identification, examination, score_tests, settings })
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod wheel_tests;
