//! Multiplexer and converter, as calibration tests show them, in words and as JSON.

use massline_analysis::calibration::electronics::{
    Asymmetry, Electronics, LARGE_ASYMMETRY, Memory,
};
use massline_shared::calibration::memory::LARGE_MEMORY;
use nalgebra::Vector3;

use crate::document;
use crate::words::{channel_name, deviation, with_sigma};

/// What a channel keeps of the one before it.
pub fn memory_text(memory: &Memory) -> String {
    format!(
        "{} keeps {} % of the voltage of {}, which is converted before it",
        channel_name(memory.channel),
        with_sigma(100.0 * memory.share.value, 100.0 * memory.share.sigma),
        channel_name(memory.before),
    )
}

/// A warning about it with what to do; `None` when it is not large.
pub fn memory_warning(memory: &Memory) -> Option<String> {
    memory.is_large().then(|| {
        format!(
            "{} (more than {} % matters): the converter's input does not settle; check the follower between filter \
             and converter, its 100 Ω, and the 10 nF at the input, and calibrate again",
            memory_text(memory),
            100.0 * LARGE_MEMORY,
        )
    })
}

pub(crate) fn memory_json(memory: &Memory) -> document::Memory {
    document::Memory {
        channel: channel_name(memory.channel),
        before: channel_name(memory.before),
        share: memory.share.value,
        sigma: memory.share.sigma,
        large: memory.is_large(),
    }
}

fn asymmetry_text(asymmetry: &Asymmetry) -> String {
    let [x, y, z] = asymmetry.direction.map(|v| format!("{v:.2}")).into();
    let along = match named(&asymmetry.direction) {
        Some(axis) => format!("along {axis}"),
        None => format!("along ({x} {y} {z})"),
    };
    format!(
        "pushes {along} against those from the other side: {} %",
        deviation(100.0 * asymmetry.difference.value, 100.0 * asymmetry.difference.sigma)
    )
}

fn asymmetry_warning(asymmetry: &Asymmetry) -> Option<String> {
    asymmetry.is_large().then(|| {
        format!(
            "{} in response (more than {} % matters): the chain is not linear near the level at rest; look for a \
             converter with a large INL or bow, a channel that is compressed, or a rest level near the end of a \
             buffer's range",
            asymmetry_text(asymmetry),
            100.0 * LARGE_ASYMMETRY,
        )
    })
}

/// All warnings.
pub fn warnings(electronics: &Electronics) -> Vec<String> {
    let memory = electronics.memory.iter().filter_map(memory_warning);
    memory.chain(electronics.asymmetry.iter().filter_map(asymmetry_warning)).collect()
}

/// All findings, a line for each.
pub(super) fn text(electronics: &Electronics) -> String {
    let memory = electronics.memory.as_ref().map_or_else(
        || {
            "memory of the multiplexer: not seen, for want of a sensor axis that is converted after the hammer, or of \
             three sensors and hits from both sides"
                .into()
        },
        memory_text,
    );
    let lines = electronics.asymmetry.iter().map(asymmetry_text);
    std::iter::once(memory).chain(lines).collect::<Vec<_>>().join("\n")
}

pub(super) fn json(electronics: &Electronics) -> document::Electronics {
    let asymmetry = |asymmetry: &Asymmetry| document::Asymmetry {
        direction: asymmetry.direction.into(),
        difference: asymmetry.difference.value,
        sigma: asymmetry.difference.sigma,
        large: asymmetry.is_large(),
    };
    document::Electronics {
        memory: electronics.memory.as_ref().map(memory_json),
        asymmetry: electronics.asymmetry.iter().map(asymmetry).collect(),
    }
}

/// `+X` for a direction along an axis.
fn named(direction: &Vector3<f64>) -> Option<String> {
    let axis = direction.iamax();
    let sign = if direction[axis] < 0.0 { '-' } else { '+' };
    (direction[axis].abs() > 0.999).then(|| format!("{sign}{}", ["X", "Y", "Z"][axis]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::EstimatedValue;

    #[test]
    fn a_share_is_large_when_it_is_significant() {
        let warning = |value, sigma| {
            let share = EstimatedValue { value, sigma };
            memory_warning(&Memory { channel: 1, before: 0, share })
        };
        assert_eq!(warning(0.0015, 1e-5), None);
        assert_eq!(warning(0.01, 0.004), None);
        let text = warning(0.01, 0.0002).unwrap();
        assert!(
            text.contains("sensor 1 x keeps 1.000 ± 0.020 % of the voltage of the hammer"),
            "{text}"
        );
    }

    #[test]
    fn a_direction_has_the_name_of_its_axis() {
        let text = |direction: [f64; 3]| {
            let difference = EstimatedValue { value: 0.012, sigma: 0.001 };
            asymmetry_text(&Asymmetry { direction: direction.into(), difference })
        };
        assert!(text([0.0, -1.0, 0.0]).contains("along -Y against"), "{}", text([0.0, -1.0, 0.0]));
        assert!(text([0.6, 0.8, 0.0]).contains("along (0.60 0.80 0.00)"));
    }
}
