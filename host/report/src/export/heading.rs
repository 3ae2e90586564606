//! What every file says about itself: program, source, units, frame, convention, standard deviations.

use massline_shared::body::INERTIAL_PARAMETERS;

use super::number::shortest;
use super::subject::ExportedResult;
use massline_result::Verdict;

/// The program that writes the file.
pub(super) const PROGRAM: &str = concat!("massline ", env!("CARGO_PKG_VERSION"));

/// Columns of the lines.
const WIDTH: usize = 76;

/// The convention of the inertia.
pub(super) fn convention() -> &'static str {
    "inertia about the centre of mass, along the axes of the frame; products of inertia are elements of the tensor, \
     J_xy = -(integral of x y dm)"
}

/// The verdict on the result in words.
pub(super) fn verdict(exported: &ExportedResult) -> String {
    match exported.verdict {
        Verdict::DoNotUse => "DO NOT USE".into(),
        verdict => verdict.words().into(),
    }
}

/// The names of the ten properties in their order.
pub(super) fn order() -> [&'static str; 10] {
    INERTIAL_PARAMETERS.map(|parameter| parameter.symbol)
}

/// Where the frame lies, in one line.
pub(super) fn frame(exported: &ExportedResult) -> String {
    let placement = &exported.placement;
    let list = |values: Vec<String>| values.join(" ");
    let mut text = placement.words();
    if placement.frame != super::Frame::Body {
        let origin = list(placement.origin.iter().map(|&v| shortest(v)).collect());
        let axes: Vec<String> = (0..3)
            .map(|k| list(placement.axes.row(k).iter().map(|&v| shortest(v)).collect()))
            .collect();
        text += &format!(
            "; in the body frame of the layout: origin [{origin}] {}, x [{}], y [{}], z [{}]",
            exported.units.length_unit(),
            axes[0],
            axes[1],
            axes[2]
        );
    }
    text
}

/// The heading as lines; `own` says what the format does with the products of inertia.
pub(super) fn lines(exported: &ExportedResult, own: &str) -> Vec<String> {
    let mut sentences = vec![
        format!("{PROGRAM}: {}", exported.test.title),
        format!("result by {}, from {}", exported.method(), exported.test.source),
        format!("units: {}", exported.units.words()),
        format!("frame: {}", frame(exported)),
        format!("convention: {}", convention()),
    ];
    if !own.is_empty() {
        sentences.push(own.into());
    }
    let name = match exported.covers_scatter_only() {
        true => {
            "standard deviations, of the scatter between hits only (1.96 of them hold the truth in 64 of 100 tests, so \
             no interval is given)"
        }
        false => "standard deviations",
    };
    sentences.push(match exported.sigma() {
        Some(sigma) => {
            let one = |(name, value): (&str, &f64)| format!("{name} {value:.2e}");
            let deviations: Vec<String> = order().into_iter().zip(sigma.iter()).map(one).collect();
            format!("{name}: {}", deviations.join(", "))
        }
        None => "standard deviations: not known".into(),
    });
    sentences.insert(1, format!("verdict: {}", verdict(exported)));
    sentences.extend(exported.doubts.iter().map(|doubt| format!("IN DOUBT: {doubt}")));
    if let Some(condition) = exported.violated_condition() {
        sentences.push(format!("NOT A PHYSICAL BODY: {condition}"));
    }
    let wrapped = |sentence: &String| -> Vec<String> {
        let options = textwrap::Options::new(WIDTH).subsequent_indent("  ");
        textwrap::wrap(sentence, options).into_iter().map(Into::into).collect()
    };
    sentences.iter().flat_map(wrapped).collect()
}

/// Text for programs that read ASCII only.
pub(super) fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii() { c } else { '?' }).collect()
}
