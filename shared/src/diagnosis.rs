//! The codes by which every problem is named, on the wire, on the screen and in a report.
//!
//! A code travels as a raw integer, so that an older host can pass on a code that it does not know.

use serde::{Deserialize, Serialize};

/// What a diagnostic means for the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; the answer stands.
    Note = 0,
    /// The answer stands with a reservation.
    Warning = 1,
    /// There is no answer.
    Error = 2,
}

impl Severity {
    /// The name in reports and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }

    /// Read from the wire; an unknown number is the gravest.
    pub fn from_raw(raw: u8) -> Self {
        match raw {
            0 => Self::Note,
            1 => Self::Warning,
            _ => Self::Error,
        }
    }
}

macro_rules! codes {
    ($($(#[$doc:meta])* $variant:ident = $value:literal, $name:literal;)*) => {
        /// A named fact about a layout, a hit, the data or a result.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u16)]
        pub enum Code { $($(#[$doc])* $variant = $value),* }

        impl Code {
            /// Every code.
            pub const ALL: &'static [Code] = &[$(Code::$variant),*];

            /// The stable name in reports and JSON.
            pub fn name(self) -> &'static str {
                match self { $(Code::$variant => $name),* }
            }

            /// The code of a raw number, `None` when a newer rig has sent one that this program
            /// does not know.
            pub fn from_raw(raw: u16) -> Option<Self> {
                match raw { $($value => Some(Code::$variant),)* _ => None }
            }
        }
    };
}

codes! {
    /// Fewer than three triaxial sensors.
    FewerThanThreeSensors = 1, "fewer_than_three_sensors";
    /// The second singular value of the centred sensor positions is below 2 % of the first.
    SensorsCollinear = 2, "sensors_collinear";
    /// `G diag(1,1,1,1/L,1/L,1/L)` has a rank below six (relative cut 1e-6).
    ResponseRankDeficient = 3, "response_rank_deficient";
    /// Fewer than three hit degrees of freedom.
    FewerThanThreeHits = 4, "fewer_than_three_hits";
    /// The second singular value of the stacked directions is below 2 % of the first.
    HitsAllParallel = 5, "hits_all_parallel";
    /// All lines of action pass one point within 2 % of L.
    HitsConcurrent = 6, "hits_concurrent";
    /// All lines of action pass the centre of mass within 2 % of L.
    HitsThroughCentreOfMass = 7, "hits_through_centre_of_mass";
    /// The balanced regression matrix has a rank below ten (relative cut 1e-6).
    TenParametersNotIdentifiable = 8, "ten_parameters_not_identifiable";
    /// Two sensors stand on the same node.
    TwoSensorsOnOneNode = 9, "two_sensors_on_one_node";
    /// A sensor or hit names a node that the layout does not have.
    UnknownNode = 10, "unknown_node";
    /// Local axes are not of unit length or not orthogonal.
    AxesNotOrthonormal = 11, "axes_not_orthonormal";
    /// A number of the layout is NaN or infinite.
    LayoutNotFinite = 12, "layout_not_finite";
    /// A setting of the `[test]` table lies outside what the rig can do.
    SettingOutOfRange = 13, "setting_out_of_range";

    /// A frequency response or mass line is NaN or infinite.
    DataNotFinite = 32, "data_not_finite";
    /// A degree of freedom has no frequency response.
    FrfMissing = 33, "frf_missing";
    /// The band holds too few lines for the fit.
    BandTooNarrow = 34, "band_too_narrow";
    /// Fewer than three accepted hits: no scatter, so no standard deviation.
    TooFewHitsForSigma = 35, "too_few_hits_for_sigma";
    /// The standard deviations cover the scatter between hits only.
    SigmaCoversScatterOnly = 36, "sigma_covers_scatter_only";
    /// The estimate belongs to no physical body: mass or a triangle inequality is violated.
    NotPhysicallyConsistent = 37, "not_physically_consistent";
    /// The regression matrix is nearly rank deficient.
    IllConditioned = 38, "ill_conditioned";
    /// A degree of freedom was left out by the operator.
    DofSkipped = 39, "dof_skipped";
    /// A degree of freedom has fewer hits than configured.
    DofFinishedEarly = 40, "dof_finished_early";
    /// No gravity vector is given: its effect on the sensors is left to the B/s² term.
    GravityNotGiven = 41, "gravity_not_given";
    /// The flash did not keep the result: make room or try again, then resume.
    ResultNotStored = 42, "result_not_stored";
    /// The converter of the rig does not answer.
    SamplerStopped = 43, "sampler_stopped";

    /// A channel reached the end of its range: ADC rail or sensor range.
    Overload = 64, "overload";
    /// The peak force is below the smallest that gives a usable response.
    TooWeak = 65, "too_weak";
    /// Scans were lost while the record was taken.
    ScansLost = 66, "scans_lost";
}

impl Code {
    /// True when the rig interrupts a campaign because of this, until it is told to go on.
    pub fn interrupts(self) -> bool {
        matches!(self, Self::ResultNotStored | Self::SamplerStopped)
    }
}

/// One named fact with the number that decided it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnostic {
    /// Raw [`Code`].
    pub code: u16,
    /// Raw [`Severity`].
    pub severity: u8,
    /// Which sensor, hit DOF or channel (0-based), [`Diagnostic::WHOLE`] when it concerns all.
    pub subject: u16,
    /// The number that decided, in the unit that the code's documentation gives; 0 when none
    /// or not finite.
    pub value: f32,
}

impl Diagnostic {
    /// The subject of a diagnostic that concerns no single sensor, hit or channel.
    pub const WHOLE: u16 = u16::MAX;

    /// A diagnostic about the whole layout or data set.
    pub fn whole(code: Code, severity: Severity, value: f32) -> Self {
        Self::about(code, severity, Self::WHOLE, value)
    }

    /// A diagnostic about one sensor, hit or channel.
    pub fn about(code: Code, severity: Severity, subject: u16, value: f32) -> Self {
        // NaN is not equal to itself: a status that carries it would differ from itself for ever.
        let value = if value.is_finite() { value } else { 0.0 };
        Self { code: code as u16, severity: severity as u8, subject, value }
    }

    /// True when there is no answer because of this.
    pub fn is_error(&self) -> bool {
        Severity::from_raw(self.severity) == Severity::Error
    }

    /// True when the rig has interrupted the campaign because of this.
    pub fn interrupts(&self) -> bool {
        self.known_code().is_some_and(Code::interrupts)
    }

    /// The code, when this program knows it.
    pub fn known_code(&self) -> Option<Code> {
        Code::from_raw(self.code)
    }
}

/// As many diagnostics as one answer carries.
pub type Diagnostics = heapless::Vec<Diagnostic, 16>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_the_wire() {
        for &code in Code::ALL {
            assert_eq!(Code::from_raw(code as u16), Some(code));
        }
    }

    #[test]
    fn a_value_that_is_no_number_is_zero() {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let diagnostic = Diagnostic::whole(Code::IllConditioned, Severity::Warning, value);
            assert_eq!(diagnostic, diagnostic);
            assert_eq!(diagnostic.value, 0.0);
        }
        assert_eq!(Diagnostic::about(Code::TooWeak, Severity::Error, 2, -1.5).value, -1.5);
    }

    #[test]
    fn names_are_unique() {
        for (i, a) in Code::ALL.iter().enumerate() {
            assert!(Code::ALL[i + 1..].iter().all(|b| b.name() != a.name()));
        }
    }
}
