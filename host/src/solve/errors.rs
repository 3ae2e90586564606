//! Why there is no answer, as one error.

use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::layout::HostLayout;

use crate::{Error, ErrorKind};
use massline_analysis::single_fault::Examination;
use massline_report::words;

/// Why neither mass lines nor suspension modes answer; a bad file outweighs data that determine nothing.
pub(super) fn both_errors(of_lines: Error, of_modes: Error) -> Error {
    if of_lines.to_string() == of_modes.to_string() {
        return of_modes;
    }
    let text = format!(
        "no answer from suspension modes: {of_modes}; no answer from mass lines: {of_lines}"
    );
    match (of_modes.kind, of_lines.kind) {
        (ErrorKind::Undetermined, ErrorKind::Input) if of_lines.code != "band_too_narrow" => {
            Error::new(of_lines.kind, of_lines.code, text)
        }
        (ErrorKind::Undetermined | ErrorKind::Input, _) => {
            Error::new(of_modes.kind, of_modes.code, text)
        }
        _ => of_modes,
    }
}

/// The errors among `diagnostics` as one error with the messages that `say` returns and the code of the first;
/// `None` when there is none.
pub(crate) fn first_error(
    diagnostics: &[Diagnostic],
    message_of: impl Fn(&Diagnostic) -> String,
) -> Option<Error> {
    let errors: Vec<&Diagnostic> = diagnostics.iter().filter(|d| d.is_error()).collect();
    let first = errors.first()?;
    let text = errors.iter().map(|d| message_of(d)).collect::<Vec<_>>().join("; ");
    let code = words::code_name(first);
    Some(match first.code {
        Code::TwoSensorsOnOneNode
        | Code::UnknownNode
        | Code::AxesNotOrthonormal
        | Code::LayoutNotFinite
        | Code::SettingOutOfRange
        | Code::HitNotInLayout
        | Code::DataNotFinite
        | Code::FrfMissing
        | Code::BandTooNarrow => Error::input(code, text),
        _ => Error::undetermined(code, text),
    })
}

pub(super) fn undetermined() -> Error {
    Error::undetermined("no_answer", "the data do not determine the ten properties")
}

/// Adds to `error` that the layout alone is sound, so that frequency responses must be missing or wrong.
pub(super) fn blame_the_responses(
    error: Error,
    examination: &Examination,
    layout: &HostLayout,
) -> Error {
    match error {
        Error { kind: ErrorKind::Undetermined, code, message } => {
            let mistakes: Vec<String> = words::findings_in(examination, layout)
                .into_iter()
                .map(|finding| finding.message)
                .collect();
            let mistakes = mistakes.join("; ");
            Error::undetermined(
                code,
                format!(
                    "the layout is good but its frequency responses are not: {message}; check that \
                     the file holds this object's responses and what quantity they are \
                     (--quantity); {mistakes}"
                ),
            )
        }
        other => other,
    }
}
