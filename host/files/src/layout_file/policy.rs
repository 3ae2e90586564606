//! The `[policy]` table: how hits with a fault are treated.

use massline_shared::diagnosis::Code;
use massline_shared::layout::HitPolicy;

use super::keyed::{KeyedTable, PolicyKeys};

/// The policy of the rig; entries that the table omits have their default.
pub(super) fn policy(raw: &KeyedTable<PolicyKeys>) -> HitPolicy {
    let stated = |code: Code| Some((code, *raw.get(code.name())?));
    HitPolicy::CODES
        .into_iter()
        .filter_map(stated)
        .fold(HitPolicy::default(), |policy, (code, treatment)| policy.with(code, treatment))
}
