//! The `[policy]` table: how hits with a fault are treated.

use massline_shared::diagnosis::Code;
use massline_shared::layout::{HitPolicy, HitTreatment};

use super::raw::{RawPolicy, RawTreatment};

/// The policy of the rig; entries that the table omits have their default.
pub(super) fn policy(raw: &RawPolicy) -> HitPolicy {
    let entries = [
        (raw.overload, Code::Overload),
        (raw.too_weak, Code::TooWeak),
        (raw.too_hard, Code::TooHard),
        (raw.double_hit, Code::DoubleHit),
        (raw.force_spectrum_low, Code::ForceSpectrumLow),
        (raw.pre_trigger_not_quiet, Code::PreTriggerNotQuiet),
        (raw.clipped_record, Code::ClippedRecord),
        (raw.trigger_too_early, Code::TriggerTooEarly),
        (raw.duplicate_hit, Code::DuplicateHit),
        (raw.hit_inconsistent, Code::HitInconsistent),
        (raw.motion_not_rigid, Code::MotionNotRigid),
        (raw.impulse_too_small, Code::ImpulseTooSmall),
        (raw.impulse_too_large, Code::ImpulseTooLarge),
        (raw.hit_elsewhere, Code::HitElsewhere),
    ];
    entries.into_iter().fold(HitPolicy::default(), |policy, (treatment, code)| match treatment {
        Some(RawTreatment::Keep) => policy.with(code, HitTreatment::Keep),
        Some(RawTreatment::Warn) => policy.with(code, HitTreatment::Warn),
        Some(RawTreatment::Reject) => policy.with(code, HitTreatment::Reject),
        None => policy,
    })
}
