//! Parts of a rig: what the bill of materials and the drawings say of them.

use serde::Deserialize;

/// One line of the bill of materials.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Designators in the drawing. `{n}` stands for the number of each sensor.
    #[serde(default)]
    pub refs: Vec<String>,
    /// Pieces of what has no designator.
    pub pieces: Option<u32>,
    /// What it is.
    pub what: String,
    /// What the drawing says beside the designator.
    #[serde(default)]
    pub value: String,
    /// The manufacturer, and its number of the part.
    pub maker: String,
    /// The manufacturer's number, or an example of the kind.
    pub number: String,
    /// Assumed price of one piece, with VAT, without shipping; cents.
    pub cents: u32,
    /// Mean current of one piece while the rig measures, µA.
    #[serde(default)]
    pub microamps: u32,
    /// True for what the regulator of the panel supplies, not the board's.
    #[serde(default)]
    pub panel: bool,
}

impl Part {
    /// Its designators, `{n}` being 1 to `sensors`.
    pub fn designators(&self, sensors: usize) -> Vec<String> {
        let expand = |name: &String| match name.contains("{n}") {
            true => (1..=sensors).map(|n| name.replace("{n}", &n.to_string())).collect(),
            false => vec![name.clone()],
        };
        self.refs.iter().flat_map(expand).collect()
    }

    /// How many pieces a rig with this number of sensors has.
    pub fn count(&self, sensors: usize) -> u32 {
        let named = u32::try_from(self.designators(sensors).len()).unwrap_or(u32::MAX);
        self.pieces.unwrap_or(named)
    }
}

/// A value such as `10 nF` or `1 kΩ` in F or Ω; `None` for one without such a unit.
pub fn in_si(value: &str) -> Option<f64> {
    let (number, unit) = value.split_once(' ')?;
    let prefix = unit.strip_suffix(['F', 'Ω'])?;
    let factor = match prefix {
        "p" => 1e-12,
        "n" => 1e-9,
        "µ" => 1e-6,
        "" => 1.0,
        "k" => 1e3,
        "M" => 1e6,
        _ => return None,
    };
    Some(number.parse::<f64>().ok()? * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_units() {
        for (text, value) in [("10 nF", 1e-8), ("100 Ω", 100.0), ("1 kΩ", 1e3), ("10 µF", 1e-5)]
        {
            assert!((in_si(text).unwrap() / value - 1.0).abs() < 1e-12, "{text}");
        }
        for text in ["SSD1306", "3 V", "OLED SSD1306", "a Ω", "1 xF"] {
            assert_eq!(in_si(text), None, "{text}");
        }
    }

    #[test]
    fn a_part_of_each_sensor_is_counted_for_each() {
        let text =
            "refs = [\"C1\", \"C{n}1\"]\nwhat = \"c\"\nmaker = \"m\"\nnumber = \"n\"\ncents = 5";
        let part: Part = toml::from_str(text).unwrap();
        assert_eq!(part.designators(3), ["C1", "C11", "C21", "C31"]);
        assert_eq!(part.count(3), 4);
        assert_eq!(Part { pieces: Some(2), refs: vec![], ..part }.count(3), 2);
    }
}
