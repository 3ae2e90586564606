//! The codes by which every problem is named, on the wire, on the screen and in a report.
//!
//! A code travels as a raw integer, so that an older host can pass on a code that it does not know.

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
    /// The balanced regression matrix, or that of the readings' slopes by the ten, has a rank below ten
    /// (relative cut 1e-6).
    TenParametersNotIdentifiable = 8, "ten_parameters_not_identifiable";
    /// Two sensors stand on the same node.
    TwoSensorsOnOneNode = 9, "two_sensors_on_one_node";
    /// A sensor or hit names a node that the layout does not have.
    UnknownNode = 10, "unknown_node";
    /// Local axes are not of unit length or not orthogonal.
    AxesNotOrthonormal = 11, "axes_not_orthonormal";
    /// A number of the layout is NaN or infinite, or a standard deviation or mass is negative.
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
    /// The object was a block of known mass: the result calibrates, and has no ten properties.
    BlockTest = 52, "block_test";
    /// The residuals are larger than the stated uncertainties allow (χ² over its degrees of freedom; by
    /// chance in one test of a thousand).
    DataContradictBudget = 44, "data_contradict_budget";
    /// The sensor that would have to be wrong by most of its stated uncertainties (root mean square).
    SensorStrainsBudget = 45, "sensor_strains_budget";
    /// The hit that would have to be wrong by most of its stated uncertainties (root mean square).
    HitStrainsBudget = 46, "hit_strains_budget";
    /// The best fit was no physical body (its margin in kg m²); the best physical one is given.
    HeldToConsistency = 47, "held_to_consistency";
    /// The fit did not settle within its steps (zero: it left what can be computed).
    NotConverged = 48, "not_converged";
    /// The object would have no mass without what hangs on it (what is left, kg).
    AttachedTooHeavy = 49, "attached_too_heavy";
    /// The identified mass is not positive (kg).
    MassNotPositive = 50, "mass_not_positive";
    /// The mass line of a response moves with the ends of the band. Subject: DOF and response
    /// ([`Diagnostic::response`]). Value: by which part of the motion of the DOF.
    NoPlateau = 53, "no_plateau";
    /// The data show no band between suspension and elastic modes, so the usual one is used. Subject: the
    /// DOF.
    BandNotFound = 54, "band_not_found";
    /// Something that was said to be known of the object contradicts the data. Subject: the property, in
    /// the order of `theta`. Value: what the data say without it, SI.
    PriorContradictsData = 55, "prior_contradicts_data";

    /// A channel reached the end of its range: ADC rail, sensor range, or a flat top in what was
    /// clipped before. Subject: the channel. Value: the extreme from rest, N or m/s².
    Overload = 64, "overload";
    /// The peak force is below the smallest that gives a usable response. Value: the peak, N.
    TooWeak = 65, "too_weak";
    /// Scans were lost while the record was taken. Value: how many.
    ScansLost = 66, "scans_lost";
    /// The next hit may clip: a channel came near the end of its range. Subject: the channel. Value:
    /// the share of the range.
    TooHard = 67, "too_hard";
    /// The hammer touched twice. Value: the lesser peak over the greater.
    DoubleHit = 68, "double_hit";
    /// The force hardly excites the top of the band. Value: its level there against 0 Hz, dB.
    ForceSpectrumLow = 69, "force_spectrum_low";
    /// A channel moved before the hit. Subject: the channel. Value: the standard deviation before the
    /// hit over the peak.
    PreTriggerNotQuiet = 70, "pre_trigger_not_quiet";
    /// The record ends before force or response are over. Subject: the channel. Value: what is left
    /// at the end over the peak.
    ClippedRecord = 71, "clipped_record";
    /// Too few scans before the hit to know the rest value. Value: how many.
    TriggerTooEarly = 72, "trigger_too_early";
    /// The same record as the hit before.
    DuplicateHit = 73, "duplicate_hit";
    /// A hit differs from the others at its DOF. Subject: the DOF. Value: the relative distance of
    /// its responses per force from theirs.
    HitInconsistent = 74, "hit_inconsistent";
    /// No motion of a rigid body is what a sensor reads. Subject: the sensor. Value: its part of the
    /// residual over the norm of all readings.
    MotionNotRigid = 75, "motion_not_rigid";
    /// The first two hits at a DOF differ, so nothing tells which is wrong. Subject: the DOF. Value: the
    /// relative distance of their responses per force.
    HitsDisagree = 76, "hits_disagree";

    /// One sensor whose axes are reversed, swapped or turned explains the data. Value: χ².
    SensorAxesSuspect = 112, "sensor_axes_suspect";
    /// The cables of two sensors, swapped, explain the data. Value: χ².
    CablesSwapped = 113, "cables_swapped";
    /// One hit DOF that was hit at another node explains the data. Value: χ².
    HitAtWrongNode = 114, "hit_at_wrong_node";
    /// One hit DOF that was hit from the other side explains the data. Value: χ².
    HitReversed = 115, "hit_reversed";
    /// All accelerances are wrong by one factor (the value) against what is known of the object.
    CommonScale = 116, "common_scale";
    /// The data contradict the budget and no single mistake explains them. Value: the least χ².
    NoSingleFaultExplains = 117, "no_single_fault_explains";
    /// Single mistakes that the data would not show. Value: how many.
    FaultsNotVisible = 118, "faults_not_visible";
}

impl Code {
    /// True when the rig interrupts a campaign because of this, until it is told to go on.
    pub fn interrupts(self) -> bool {
        matches!(self, Self::ResultNotStored | Self::SamplerStopped)
    }
}

/// Responses that a subject can tell apart: more than any solver has.
const RESPONSES_OF_A_DOF: usize = 32;

/// One named fact with the number that decided it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

    /// The subject of a diagnostic about one response due to one hit DOF, both 0-based.
    pub fn response_subject(dof: usize, response: usize) -> u16 {
        (dof * RESPONSES_OF_A_DOF + response) as u16
    }

    /// DOF and response of a subject made by [`Diagnostic::response_subject`].
    pub fn response(&self) -> (usize, usize) {
        let subject = usize::from(self.subject);
        (subject / RESPONSES_OF_A_DOF, subject % RESPONSES_OF_A_DOF)
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
