//! Results as JSON and tables, diagnostics as sentences.
//!
//! The JSON of a result is a stable interface for other programs. The inertia is about the centre of mass in
//! body axes, as tensor elements; the covariance is in the order [m, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz,
//! Jyz], SI.

mod budget;
mod cannot_see;
mod comparison;
mod details;
mod digits;
mod estimate;
mod global_fit;
mod hammer;
mod hit;
mod measurement;
mod message;
mod modes;
mod refusals;
mod summary;
mod table;
mod where_to_hit;

use massline_shared::diagnosis::Diagnostic;

use crate::document::Finding;

pub use budget::{budget_json, budget_text};
pub use cannot_see::{cannot_see, cannot_see_text, glued, has_undeclared_mass};
pub use comparison::{comparison_json, comparison_text};
pub use details::{details_json, details_text};
pub use digits::{as_exact_as, deviation, two_digits, with_sigma};
pub use estimate::estimate_json;
pub use global_fit::{global_fit_json, global_fit_text};
pub use hammer::{CALIBRATE_HAMMER, hammer_text};
pub use hit::{HitSaid, swing_words};
pub use measurement::{SolvedHere, estimates_of, measurement_json, measurement_text};
pub use message::{
    by_code, channel_name, code_name, message, message_in, message_of_result, messages,
};
pub use modes::{
    assurance_text, indicators_text, mode_json, modes_json, modes_text, orders_text, remedies_text,
    shapes_text,
};
pub use refusals::{refusals_json, refusals_text};
pub use summary::{BestAnswer, ResultVerdict, Summary};
pub use table::{INERTIA_CONVENTION, Truth, table};
pub use where_to_hit::{HitDirections, new_direction};
pub(crate) use where_to_hit::{NEW, do_not_show, hardly_shown, not_shown};

/// The text of a layout's hash or a calibration's checksum; `None` for 0, which means that there is none.
pub fn hash_text(hash: u32) -> Option<String> {
    (hash != 0).then(|| format!("{hash:08x}"))
}

/// Diagnostics as JSON.
pub fn diagnostics_json(
    found: &[Diagnostic],
    message_of: impl Fn(&Diagnostic) -> String,
) -> Vec<Finding> {
    let entry = |d: &Diagnostic| Finding {
        code: code_name(d),
        severity: d.severity.name(),
        message: message_of(d),
    };
    found.iter().map(entry).collect()
}

/// Most diagnostics with one code that are printed.
const MOST_ALIKE: usize = 4;

/// Diagnostics as lines of text. Of many with the same code only the first are printed.
pub(crate) fn sentences(
    found: &[Diagnostic],
    message_of: impl Fn(&Diagnostic) -> String,
) -> String {
    let mut text = String::new();
    for (place, d) in found.iter().enumerate() {
        let alike = |other: &&Diagnostic| (other.code, other.severity) == (d.code, d.severity);
        let before = found[..place].iter().filter(alike).count();
        if before < MOST_ALIKE {
            text += &format!("{}: {}\n", d.severity.name(), message_of(d));
        } else if before == MOST_ALIKE {
            let more = found[place..].iter().filter(alike).count();
            text += &format!(
                "{}: {more} more of {}; --json has all\n",
                d.severity.name(),
                code_name(d)
            );
        }
    }
    text
}
