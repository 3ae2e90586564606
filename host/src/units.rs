//! Units of force and motion, as people write them.

use massline_shared::STANDARD_GRAVITY;

/// Gravity on Earth, m/s²: from 9.76 on the highest mountains near the equator to 9.83 at the poles, and what two digits
/// make of it.
pub(crate) const GRAVITY_ON_EARTH: std::ops::RangeInclusive<f64> = 9.75..=9.85;

/// The response quantity of a frequency response function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Accelerance, acceleration over force.
    Acceleration,
    /// Mobility, velocity over force.
    Velocity,
    /// Receptance, displacement over force.
    Displacement,
}

impl Quantity {
    /// Every quantity.
    pub const ALL: [Self; 3] = [Self::Acceleration, Self::Velocity, Self::Displacement];

    /// The name of this quantity over force.
    pub fn frf_name(self) -> &'static str {
        match self {
            Self::Acceleration => "accelerance",
            Self::Velocity => "mobility",
            Self::Displacement => "receptance",
        }
    }
}

pub(crate) const FOOT: f64 = 0.3048;
pub(crate) const INCH: f64 = 0.0254;
pub(crate) const KILOGRAM_FORCE: f64 = STANDARD_GRAVITY;
pub(crate) const POUND_FORCE: f64 = 0.453_592_37 * STANDARD_GRAVITY;
pub(crate) const POUNDAL: f64 = 0.453_592_37 * FOOT;

/// A label without blanks and brackets and with a uniform notation of powers.
pub(crate) fn plain(label: &str) -> String {
    let text: String = label
        .chars()
        .filter(|c| !c.is_whitespace() && !"()[]".contains(*c))
        .map(|c| match c {
            '²' => '2',
            'μ' => 'µ',
            c => c,
        })
        .collect();
    text.replace("**", "").replace('^', "")
}

/// The size of a motion unit in m, m/s or m/s².
pub(crate) fn motion_unit(label: &str, quantity: Quantity) -> Option<f64> {
    let label = plain(label).to_ascii_lowercase().replace("sec", "s").replace("s/s", "s2");
    let length = |unit: &str| match unit {
        "m" => Some(1.0),
        "cm" => Some(1e-2),
        "mm" => Some(1e-3),
        "µm" | "um" => Some(1e-6),
        "in" => Some(INCH),
        "ft" => Some(FOOT),
        _ => None,
    };
    match quantity {
        Quantity::Displacement => length(&label),
        Quantity::Velocity => length(label.strip_suffix("/s")?),
        Quantity::Acceleration => match label.as_str() {
            "g" | "gn" | "g_n" | "g0" => Some(STANDARD_GRAVITY),
            _ => length(label.strip_suffix("/s2")?),
        },
    }
}

/// The size of a force unit, N.
pub(crate) fn force_unit(label: &str) -> Option<f64> {
    match plain(label).as_str() {
        "N" | "n" | "newton" | "Newton" | "newtons" | "Newtons" => Some(1.0),
        "kN" => Some(1e3),
        "mN" => Some(1e-3),
        "lbf" | "lb" | "LBF" | "LB" => Some(POUND_FORCE),
        "kgf" => Some(KILOGRAM_FORCE),
        "pdl" => Some(POUNDAL),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_read_as_people_write_them() {
        use Quantity::*;
        for (label, quantity, expected) in [
            ("m/s^2", Acceleration, 1.0),
            ("(m/s²)", Acceleration, 1.0),
            ("m/sec**2", Acceleration, 1.0),
            ("m/s/s", Acceleration, 1.0),
            ("mm/s2", Acceleration, 1e-3),
            ("g", Acceleration, STANDARD_GRAVITY),
            ("in/s", Velocity, 0.0254),
            ("ft", Displacement, 0.3048),
        ] {
            assert_eq!(motion_unit(label, quantity), Some(expected), "{label}");
        }
        for (label, quantity) in [("m/s", Acceleration), ("g", Velocity), ("V", Displacement)] {
            assert_eq!(motion_unit(label, quantity), None, "{label}");
        }
    }

    #[test]
    fn a_newton_is_the_same_force_in_every_system() {
        // 1 lbf = 4.448 222 N, 1 poundal = 0.138 255 N: the usual six digits.
        assert!((POUND_FORCE - 4.448_222).abs() < 1e-6);
        assert!((POUNDAL - 0.138_255).abs() < 1e-6);
    }
}
