//! Grades the hits of a recording: each on its own, then against the others.

mod cut;
mod polarity;
mod repeats;
mod understanding;

use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::TestSettings;
use massline_shared::signal::{
    ChannelRange, FftError, HitAnalysis, HitGrader, HitReport, Signal, divide_by_force,
};
use nalgebra::Complex;

use crate::{Error, Result};
use massline_files::recording::{Channel, Recording, Statements, column};
use repeats::Repeats;
pub use understanding::Understanding;

/// Largest number of hits that are compared, as their spectra are held in memory; repeat hits are never so
/// many.
const MOST_HITS: usize = 2000;

/// How a recording is graded. `None` takes the value from the file or leaves it unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Name or number (from 1) of the column of the force.
    pub force: Option<String>,
    /// Names or numbers (from 1) of the columns that are not graded.
    pub leave_out: Vec<String>,
    /// Units, sensitivities and signs of columns.
    pub statements: Statements,
    /// Sampling rate, Hz; overrides that of the file.
    pub rate_hz: Option<f64>,
    /// Force from which on the hammer channel counts as overloaded, N.
    pub force_range_n: Option<f64>,
    /// Deviation from the zero level from which on a sensor channel counts as overloaded, m/s².
    pub response_range: Option<f64>,
    /// Time before the trigger, s; for a continuous recording.
    pub pre_trigger_s: f64,
    /// Length of the record of a hit, s; for a continuous recording.
    pub record_s: f64,
    /// Largest number of hits to keep.
    pub keep: Option<usize>,
    /// Trigger, band, windows, minimum peak force and policy.
    pub test: TestSettings<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            force: None,
            leave_out: Vec::new(),
            statements: Statements::default(),
            rate_hz: None,
            force_range_n: None,
            response_range: None,
            // The values of the rig: 80 and 2048 scans at 4 kS/s.
            pre_trigger_s: 0.02,
            record_s: 0.512,
            keep: None,
            test: TestSettings::default(),
        }
    }
}

/// The hits of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Hits {
    /// The hits, in the order of the file.
    pub hits: Vec<Hit>,
    /// The channels in the order of grading: the force first.
    pub channels: Vec<Channel>,
    /// What was understood of the recording.
    pub understanding: Understanding,
    /// Warnings about the recording.
    pub warnings: Vec<String>,
}

/// A recording in N and m/s² whose rate is known.
#[derive(Clone, Debug)]
pub struct PreparedRecording {
    recording: Recording,
    /// The channels in the order of grading: the force first.
    order: Vec<usize>,
    /// The force as it is named on the command line.
    force: String,
    rate: f64,
    understanding: Understanding,
    warnings: Vec<String>,
}

/// A graded hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// Segment of the file, or number of the hit in a continuous recording, from 0.
    pub segment: usize,
    /// Time of first contact, s after the beginning of the segment or the recording.
    pub start_s: f64,
    /// The findings of the grading.
    pub report: HitReport,
    /// Relative distance of its responses per force from the mean of the other consistent hits.
    pub distance: Option<f64>,
    /// True when the hit belongs to the best consistent set.
    pub kept: bool,
}

/// One hit cut out of a recording.
struct CutHit {
    segment: usize,
    start_s: f64,
    /// Samples before first contact.
    pre_trigger: usize,
    /// The force, then the responses.
    channels: Vec<Vec<f64>>,
}

/// Grades the hits of a recording.
///
/// # Errors
/// Exit 2 when there is no force, response, unit or rate, no hit, or more hits than can be compared.
pub fn grade(recording: Recording, options: &Options) -> Result<Hits> {
    PreparedRecording::new(recording, options)?.grade(options)
}

impl PreparedRecording {
    /// Finds force, responses, units and rate of a recording.
    ///
    /// # Errors
    /// Exit 2 when one of them is not stated, is not understood or is contradicted.
    pub fn new(mut recording: Recording, options: &Options) -> Result<Self> {
        let order = cut::channel_order(&mut recording, options)?;
        let scales = recording.scales(&order, &options.statements);
        let time_unit = options
            .statements
            .units
            .iter()
            .rfind(|stated| recording.is_time_column(&stated.column));
        let rate = recording.rate(options.rate_hz, time_unit.map(|stated| stated.unit.as_str()));
        let ((scales, notes), rate) = match (scales, rate) {
            (Ok(scales), Ok(rate)) => (scales, rate),
            // One run tells all that is to be stated.
            (Err(units), Err(rate)) => return Err(units.advising(rate)),
            (Err(error), _) | (_, Err(error)) => return Err(error),
        };
        cut::check_rate(&rate, options)?;
        let warnings = recording.notes.iter().chain(&notes).chain(&rate.notes).cloned().collect();
        let understanding = Understanding::new(&recording, &order, &scales, rate.clone());
        let force = order.first().copied().unwrap_or_default();
        let force = recording
            .channels
            .get(force)
            .map_or_else(String::new, |channel| column(force, channel));
        let recording = recording.scaled(&order, &scales);
        Ok(Self { recording, order, force, rate: rate.hz, understanding, warnings })
    }

    /// What was understood.
    pub fn understanding(&self) -> &Understanding {
        &self.understanding
    }

    /// Grades the hits.
    ///
    /// # Errors
    /// Exit 2 when there is no hit, when the force has the wrong sign, or there are more hits than can be compared.
    pub fn grade(self, options: &Options) -> Result<Hits> {
        let Self { recording, order, force, rate, understanding, warnings } = self;
        let place = order.first().copied().unwrap_or_default();
        polarity::check(&recording.segments, place, &force, rate, options)?;
        let cut = cut::hits(&recording, &order, rate, options)?;
        let channels = order.iter().filter_map(|&k| recording.channels.get(k).cloned()).collect();
        // The hits are copies of its samples.
        drop(recording);
        let mut hits: Vec<Hit> = Vec::new();
        for hit in &cut {
            let ranges = ranges(hit, options);
            let grader = HitGrader {
                ranges: &ranges,
                rate,
                pre_trigger: hit.pre_trigger,
                test: &options.test,
                last: hits.last().map(|last| last.report.fingerprint),
            };
            let signals: Vec<&[f64]> = hit.channels.iter().map(Vec::as_slice).collect();
            hits.push(Hit {
                segment: hit.segment,
                start_s: hit.start_s,
                report: grader.grade(signals.as_slice()),
                distance: None,
                kept: false,
            });
        }
        compare(&mut hits, &cut, rate, options)?;
        Ok(Hits { hits, channels, understanding, warnings })
    }
}

/// Range and resolution of the channels of a hit, as far as they are known.
fn ranges(hit: &CutHit, options: &Options) -> Vec<ChannelRange<f64>> {
    let range = |k: usize| if k == 0 { options.force_range_n } else { options.response_range };
    hit.channels
        .iter()
        .enumerate()
        .map(|(k, samples)| ChannelRange {
            scale: 1.0,
            rails: [f64::NEG_INFINITY, f64::INFINITY],
            range: range(k).unwrap_or(f64::INFINITY),
            resolution: resolution(samples),
            noise: 0.0,
        })
        .collect()
}

/// The smallest difference between two unequal samples.
fn resolution(samples: &[f64]) -> f64 {
    let steps = samples.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let least = steps.filter(|&step| step > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Compares the hits that are not rejected with each other.
fn compare(hits: &mut [Hit], cut: &[CutHit], rate: f64, options: &Options) -> Result<()> {
    let good: Vec<usize> = (0..hits.len()).filter(|&k| hits[k].report.good()).collect();
    let lines = |&k: &usize| FrfLines::of(&cut[k], rate, &options.test).map_err(not_transformed);
    let lines = good.iter().map(lines).collect::<Result<Vec<_>>>()?;
    let repeats = Repeats::new(weighted(&lines));
    let kept = repeats.best(options.keep.unwrap_or(usize::MAX));
    for (place, &k) in good.iter().enumerate() {
        let hit = &mut hits[k];
        let beside = repeats.beside_the_others(place);
        hit.distance = beside.distance();
        hit.kept = kept.contains(&place);
        let standing = beside.standing();
        if let Some((code, far)) = standing.finding() {
            let severity = standing.treatment(options.test.policy).severity();
            let diagnostic = Diagnostic::whole(code, severity, far as f32);
            // There is room: a hit that is not rejected has few findings.
            let _ = hit.report.findings.push(diagnostic);
            hit.kept &= !diagnostic.is_error();
        }
    }
    Ok(())
}

/// The responses per force of each hit as one vector. Each bin is weighted by the excitation of all hits
/// together.
fn weighted(hits: &[FrfLines]) -> Vec<Vec<f64>> {
    let count = hits.iter().map(|hit| hit.weight.len()).min().unwrap_or(0);
    let weight = |line: usize| hits.iter().map(|hit| hit.weight[line]).sum::<f64>().sqrt();
    let weights: Vec<f64> = (0..count).map(weight).collect();
    let vector = |hit: &FrfLines| {
        let lines = hit.frf.iter().flat_map(|lines| lines.iter().zip(&weights));
        lines.flat_map(|(h, weight)| [h.re * weight, h.im * weight]).collect()
    };
    hits.iter().map(vector).collect()
}

fn not_transformed(error: FftError) -> Error {
    Error::internal("fft", format!("the hit was not transformed: {error}"))
}

/// The responses per force of a hit over the band, with the weights |F|².
struct FrfLines {
    weight: Vec<f64>,
    /// FRFs, response by response.
    frf: Vec<Vec<Complex<f64>>>,
}

impl FrfLines {
    fn of(
        hit: &CutHit,
        rate: f64,
        test: &TestSettings<f64>,
    ) -> std::result::Result<Self, FftError> {
        let samples = hit.channels.iter().map(Vec::len).min().unwrap_or(0);
        let points = samples.next_power_of_two().max(4);
        let signals = vec![Signal::new(1.0, 0.0); hit.channels.len()];
        let analysis = HitAnalysis::of_signals(rate, 0.0, signals, test, hit.pre_trigger);
        let resolution = analysis.resolution(points);
        let line = |frequency: f64| (frequency / resolution) as usize;
        let [low, high] = test.expected_band();
        let end = (line(high) + 1).min(points / 2);
        let band = (line(low) + 1).min(end)..end;
        let signals: Vec<&[f64]> = hit.channels.iter().map(|c| &c[..samples]).collect();
        let record = signals.as_slice();
        let zero = Complex::new(0.0, 0.0);
        let (mut force, mut lines) = (vec![zero; end], vec![zero; end]);
        let mut scratch = vec![0.0; points];
        analysis.force(record, &mut scratch, &mut force)?;
        let of_band =
            |values: &[Complex<f64>]| values.get(band.clone()).unwrap_or_default().to_vec();
        let mut frf = Vec::new();
        for response in 0..hit.channels.len().saturating_sub(1) {
            analysis.response(record, response, &mut scratch, &mut lines)?;
            divide_by_force(&mut lines, &force);
            frf.push(of_band(&lines));
        }
        Ok(Self { weight: of_band(&force).iter().map(|f| f.norm_sqr()).collect(), frf })
    }
}
