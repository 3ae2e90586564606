//! The units of the exported properties.

use clap::ValueEnum;

use massline_files::units::{FOOT, INCH, POUND_FORCE};

/// Units of mass and length that people use together. Each but `lb-in` is consistent: with the time in its help, a
/// force is mass times length over time squared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum UnitSystem {
    /// kg, m: N with s
    #[default]
    Si,
    /// tonne, mm: N and MPa with s
    TMm,
    /// kg, mm: kN and GPa with ms
    KgMm,
    /// g, mm: N and MPa with ms
    GMm,
    /// g, cm: dyn with s
    GCm,
    /// lbf s²/in, in: lbf and psi with s
    SlinchIn,
    /// slug, ft: lbf with s
    SlugFt,
    /// Pound of mass, in: as CAD programs print; no force unit in use belongs to it
    LbIn,
}

impl UnitSystem {
    /// Names of the units of mass, length and time, and what a unit of mass and one of length are in SI.
    pub(super) fn entry(self) -> (&'static str, &'static str, &'static str, f64, f64) {
        const POUND: f64 = 0.453_592_37;
        match self {
            Self::Si => ("kg", "m", "N with s", 1.0, 1.0),
            Self::TMm => ("t", "mm", "N, MPa with s", 1e3, 1e-3),
            Self::KgMm => ("kg", "mm", "kN, GPa with ms", 1.0, 1e-3),
            Self::GMm => ("g", "mm", "N, MPa with ms", 1e-3, 1e-3),
            Self::GCm => ("g", "cm", "dyn with s", 1e-3, 1e-2),
            Self::SlinchIn => ("lbf s^2/in", "in", "lbf, psi with s", POUND_FORCE / INCH, INCH),
            Self::SlugFt => ("slug", "ft", "lbf with s", POUND_FORCE / FOOT, FOOT),
            Self::LbIn => ("lb", "in", "no force unit in use", POUND, INCH),
        }
    }

    /// Name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Unit of mass.
    pub fn mass_unit(self) -> &'static str {
        self.entry().0
    }

    /// Unit of length.
    pub fn length_unit(self) -> &'static str {
        self.entry().1
    }

    /// Unit of inertia.
    pub fn inertia_unit(self) -> String {
        match self {
            // The length cancels against the one in the unit of mass.
            Self::SlinchIn => "lbf s^2 in".into(),
            _ => format!("{} {}^2", self.mass_unit(), self.length_unit()),
        }
    }

    /// The units of force and time that make the system consistent.
    pub fn force_and_time(self) -> &'static str {
        self.entry().2
    }

    /// The unit of the property at this place of the order.
    pub fn unit_of(self, place: usize) -> String {
        match place {
            0 => self.mass_unit().into(),
            1..4 => self.length_unit().into(),
            _ => self.inertia_unit(),
        }
    }

    /// All units in one line.
    pub(super) fn words(self) -> String {
        format!(
            "{}, {}, {}; force {}",
            self.mass_unit(),
            self.length_unit(),
            self.inertia_unit(),
            self.force_and_time()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consistent_systems_have_the_force_that_they_state() {
        // Mass times length over time squared, in N.
        for (units, time, force) in [
            (UnitSystem::Si, 1.0, 1.0),
            (UnitSystem::TMm, 1.0, 1.0),
            (UnitSystem::KgMm, 1e-3, 1e3),
            (UnitSystem::GMm, 1e-3, 1.0),
            (UnitSystem::GCm, 1.0, 1e-5),
            (UnitSystem::SlinchIn, 1.0, 4.448_222),
            (UnitSystem::SlugFt, 1.0, 4.448_222),
        ] {
            let (.., mass, length) = units.entry();
            // Seven digits of the pound-force.
            assert!((mass * length / (time * time) / force - 1.0).abs() < 2e-7, "{units:?}");
        }
        // 1 slug = 14.593 90 kg, 1 slinch = 175.126 8 kg: the usual digits.
        assert!((UnitSystem::SlugFt.entry().3 - 14.593_90).abs() < 1e-5);
        assert!((UnitSystem::SlinchIn.entry().3 - 175.126_8).abs() < 1e-4);
    }
}
