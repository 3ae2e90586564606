//! The table `[uncertainty]`, also that of a sensor or hit: the error budget.

use std::sync::LazyLock;

use massline_shared::layout::{
    ApparatusUncertainty, CalibratedGains, HitUncertainty, SensorUncertainty, UncertaintyKey,
    uncertainty_keys,
};
use serde::de::MapAccess;
use toml::Spanned;

use super::error::LayoutFileError;
use super::keyed::{KeyedTable, TableKeys};
use super::source::Source;

/// The key of `[uncertainty]` that is no standard deviation.
pub(super) const LEARN: &str = "learn";

/// The keys of `[uncertainty]`.
pub(super) struct BudgetKeys;

/// A value of `[uncertainty]`.
#[derive(Debug)]
pub(super) enum BudgetValue {
    /// A standard deviation.
    Sigma(Spanned<f64>),
    /// Whether the data may correct the budget.
    Learn(bool),
}

impl KeyedTable<BudgetKeys> {
    /// The standard deviation that is stated for a key.
    pub(super) fn sigma(&self, name: &str) -> Option<&Spanned<f64>> {
        match self.get(name) {
            Some(BudgetValue::Sigma(sigma)) => Some(sigma),
            Some(BudgetValue::Learn(_)) | None => None,
        }
    }

    /// Whether the data may correct the budget, where it is stated.
    pub(super) fn learn(&self) -> Option<bool> {
        match self.get(LEARN) {
            Some(BudgetValue::Learn(learn)) => Some(*learn),
            Some(BudgetValue::Sigma(_)) | None => None,
        }
    }
}

impl TableKeys for BudgetKeys {
    type Value = BudgetValue;
    const WRITTEN: &'static str = "a table [uncertainty]";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| uncertainty_keys().map(|key| key.name).chain([LEARN]).collect());
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        name: &'static str,
        map: &mut A,
    ) -> Result<BudgetValue, A::Error> {
        match name {
            LEARN => map.next_value().map(BudgetValue::Learn),
            _ => map.next_value().map(BudgetValue::Sigma),
        }
    }
}

/// The keys of the uncertainty of one sensor.
pub(super) struct SensorKeys;

impl TableKeys for SensorKeys {
    type Value = Spanned<f64>;
    const WRITTEN: &'static str = "a table such as { gain = 0.01 }";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| names(SensorUncertainty::<f64>::KEYS));
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<Spanned<f64>, A::Error> {
        map.next_value()
    }
}

/// The keys of the uncertainty of one hit.
pub(super) struct HitKeys;

impl TableKeys for HitKeys {
    type Value = Spanned<f64>;
    const WRITTEN: &'static str = "a table such as { hit_position_m = 0.002 }";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| names(HitUncertainty::<f64>::KEYS));
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<Spanned<f64>, A::Error> {
        map.next_value()
    }
}

fn names(keys: &[UncertaintyKey]) -> Vec<&'static str> {
    keys.iter().map(|key| key.name).collect()
}

/// The `[uncertainty]` table: default uncertainties of sensors and hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Uncertainty of a sensor.
    pub sensor: SensorUncertainty<f64>,
    /// Uncertainty of a hit.
    pub hit: HitUncertainty<f64>,
    /// Uncertainty of hammer, converter and gravity.
    pub apparatus: ApparatusUncertainty<f64>,
    /// Which standard deviations of the sensors a calibration supplies, because the table states none.
    pub calibrated: CalibratedGains,
    /// True when a calibration supplies that of the hammer's gain.
    pub calibrated_hammer: bool,
    /// True when the data may correct the budget.
    pub learn: bool,
}

impl Uncertainty {
    pub(super) fn of(
        raw: &KeyedTable<BudgetKeys>,
        source: &Source<'_>,
    ) -> Result<Self, LayoutFileError> {
        let mut uncertainty = Self {
            sensor: SensorUncertainty::default(),
            hit: HitUncertainty::default(),
            apparatus: ApparatusUncertainty::default(),
            calibrated: CalibratedGains { gain: true, cross_axis: true },
            calibrated_hammer: true,
            learn: true,
        };
        let is_stated = |name| raw.sigma(name).is_some();
        uncertainty.calibrated =
            CalibratedGains { gain: !is_stated("gain"), cross_axis: !is_stated("cross_axis") };
        uncertainty.calibrated_hammer = !is_stated("hammer_gain");
        uncertainty.learn = raw.learn().unwrap_or(uncertainty.learn);
        let sensor = uncertainty.sensor.values_mut().zip(SensorUncertainty::<f64>::KEYS);
        let hit = uncertainty.hit.values_mut().zip(HitUncertainty::<f64>::KEYS);
        let apparatus = uncertainty.apparatus.values_mut().zip(ApparatusUncertainty::<f64>::KEYS);
        for (to, key) in sensor.chain(hit).chain(apparatus) {
            replace_stated(to, raw.sigma(key.name), "uncertainty", key, source)?;
        }
        Ok(uncertainty)
    }

    /// Every key with its standard deviation.
    pub fn sigmas(&self) -> impl Iterator<Item = (&'static UncertaintyKey, f64)> {
        let rows = self.sensor.rows().chain(self.hit.rows()).chain(self.apparatus.rows());
        rows.map(|(key, sigma)| (key, *sigma))
    }
}

/// Replaces a standard deviation by the one that a table states.
pub(super) fn replace_stated(
    sigma: &mut f64,
    stated: Option<&Spanned<f64>>,
    table: &str,
    key: &UncertaintyKey,
    source: &Source<'_>,
) -> Result<(), LayoutFileError> {
    if let Some(stated) = stated {
        let key = format!("{table}.{}", key.name);
        *sigma = source.within(stated, &key, |v| v >= 0.0, "zero or a positive number")?;
    }
    Ok(())
}
