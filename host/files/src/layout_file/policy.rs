//! The `[policy]` table: how hits with a fault are treated.

use std::sync::LazyLock;

use massline_shared::diagnosis::Code;
use massline_shared::layout::{HitPolicy, HitTreatment};
use serde::de::{Error, MapAccess};

use super::keyed::{KeyedTable, OneOf, TableKeys};

/// The policy of the rig; entries that the table omits have their default.
pub(super) fn policy(raw: &KeyedTable<PolicyKeys>) -> HitPolicy {
    let stated = |code: Code| Some((code, *raw.get(code.name())?));
    HitPolicy::CODES
        .into_iter()
        .filter_map(stated)
        .fold(HitPolicy::default(), |policy, (code, treatment)| policy.with(code, treatment))
}

/// The keys of `[policy]`: the faults of a hit.
pub(super) struct PolicyKeys;

impl TableKeys for PolicyKeys {
    type Value = HitTreatment;
    const WRITTEN: &'static str = "a table [policy]";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| HitPolicy::CODES.iter().map(|code| code.name()).collect());
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<HitTreatment, A::Error> {
        let name = map.next_value_seed(OneOf(&HitTreatment::NAMES))?;
        HitTreatment::from_name(name).ok_or_else(|| A::Error::custom("no treatment"))
    }
}
