//! The tests for small faults as part of a result, and in sentences.

use massline_analysis::score_tests::{ScoreTest, ScoreTests, SmallFault};
use massline_result::{Fault, FaultUnit, FindingCode};
use massline_shared::layout::{AXIS_LETTERS, Axis, HostLayout};

use super::suspects::hit_name;
use super::{two_digits, with_interval};

/// A fault of so many standard deviations of its size begins to show.
pub const BEGINS_TO_SHOW: f64 = 3.0;

/// The tests as part of a result.
pub fn score_tests_in(tests: &ScoreTests, layout: &HostLayout) -> Vec<massline_result::ScoreTest> {
    let one = |test: &ScoreTest| massline_result::ScoreTest {
        fault: described(test, layout),
        unit: test.fault.unit(),
        size: test.size().into(),
        sigma: test.sigma,
        shift_sigma: test.shift,
        significance: test.significance(),
        limit: test.limit,
        shown: test.is_shown(),
    };
    tests.tests.iter().map(one).collect()
}

/// The fault with its words: what was found where it shows, otherwise what it is about.
fn described(test: &ScoreTest, layout: &HostLayout) -> Fault {
    let fault = fault_of(test.fault);
    let message = if test.is_shown() { clause(test, layout) } else { fault_name(&fault) };
    Fault { message, ..fault }
}

/// The fault without words. Sensors and hits are counted from 1.
fn fault_of(fault: SmallFault) -> Fault {
    let plain = Fault::of(fault.code());
    let letter = |axis: Axis| AXIS_LETTERS[axis.index()];
    match fault {
        SmallFault::NodeMisplaced { node, axis } => {
            Fault { node: Some(node), axis: Some(letter(axis)), ..plain }
        }
        SmallFault::ChannelDrifts { sensor, axis }
        | SmallFault::ChannelGainOff { sensor, axis } => {
            Fault { sensor: Some(sensor + 1), axis: Some(letter(axis)), ..plain }
        }
        SmallFault::SensorTurned { sensor } => Fault { sensor: Some(sensor + 1), ..plain },
        SmallFault::HitLeans { hit } | SmallFault::HitForceOff { hit } => {
            Fault { hit: Some(hit + 1), ..plain }
        }
        SmallFault::HammerDrifts
        | SmallFault::HammerGainOff
        | SmallFault::HitsTurned
        | SmallFault::ChipsAboveMarks
        | SmallFault::MarksLoaded => plain,
    }
}

/// A fault with the size that was found, as a clause.
pub(super) fn clause(test: &ScoreTest, layout: &HostLayout) -> String {
    let size = test.size();
    let factor = factor(test.fault.unit());
    let value = with_interval(factor * size.value.abs(), factor * size.sigma);
    let rises = if size.value < 0.0 { "falls" } else { "rises" };
    match test.fault {
        SmallFault::NodeMisplaced { node, axis } => format!(
            "node {node} lies {value} mm further along {}{} than the layout says",
            if size.value < 0.0 { "-" } else { "+" },
            AXIS_LETTERS[axis.index()],
        ),
        SmallFault::HammerDrifts => {
            format!("the gain of the hammer {rises} by {value} % over the test")
        }
        SmallFault::ChannelDrifts { sensor, axis } => format!(
            "the gain of sensor {} {} {rises} by {value} % over the test",
            sensor + 1,
            AXIS_LETTERS[axis.index()],
        ),
        SmallFault::ChannelGainOff { sensor, axis } => format!(
            "the gain of sensor {} {} is {value} % {} than the layout says",
            sensor + 1,
            AXIS_LETTERS[axis.index()],
            if size.value < 0.0 { "smaller" } else { "larger" },
        ),
        SmallFault::SensorTurned { sensor } => {
            format!("sensor {} is turned by {value} mrad", sensor + 1)
        }
        SmallFault::HitForceOff { hit } => format!(
            "the force at {} is {value} % {} than the hammer says",
            hit_name(hit, layout),
            if size.value < 0.0 { "smaller" } else { "larger" },
        ),
        SmallFault::HammerGainOff => format!(
            "the hammer reads {value} % too {}",
            if size.value < 0.0 { "much" } else { "little" },
        ),
        SmallFault::HitLeans { hit } => {
            format!("{} leans by {value} mrad in all its hits", hit_name(hit, layout))
        }
        SmallFault::HitsTurned => format!("all hits are turned alike by {value} mrad"),
        SmallFault::MarksLoaded if size.value < 0.0 => {
            format!("the object is {value} g lighter at each mark while it is hit")
        }
        SmallFault::MarksLoaded => format!("each mark carries {value} g while it is hit"),
        SmallFault::ChipsAboveMarks => format!(
            "the chips of all sensors lie {value} mm {} their marks, along their z axes",
            if size.value < 0.0 { "below" } else { "above" },
        ),
    }
}

/// What to do about small faults that show, as a further clause.
pub(super) fn advice_on(tests: &[ScoreTest]) -> &'static str {
    let [only] = tests else { return "; put right what applies, and measure again" };
    match only.fault {
        SmallFault::NodeMisplaced { .. } => "; measure where it lies and correct the layout",
        SmallFault::ChipsAboveMarks => {
            "; the layout wants the places of the chips, not of the marks: correct it"
        }
        SmallFault::HammerDrifts | SmallFault::ChannelDrifts { .. } => {
            "; let the electronics warm up and measure again"
        }
        SmallFault::ChannelGainOff { .. } => "; calibrate the sensors and measure again",
        SmallFault::HammerGainOff => {
            "; check the mass that is stated, calibrate the hammer and measure again"
        }
        SmallFault::SensorTurned { .. } => "; correct its axes in the layout, or mount it straight",
        SmallFault::HitForceOff { .. } => {
            "; see that no hit there is clipped or slides off, and measure it again"
        }
        SmallFault::HitLeans { .. } | SmallFault::HitsTurned => {
            "; hit along the directions of the layout, or state in it how you hit"
        }
        SmallFault::MarksLoaded => {
            "; hit the object itself, or leave equal pads on all marks and declare their mass"
        }
    }
}

/// The factor from SI to the unit that a text has: mm, mrad, g or %.
fn factor(unit: FaultUnit) -> f64 {
    match unit {
        FaultUnit::Meters | FaultUnit::Radians | FaultUnit::Kilograms => 1e3,
        FaultUnit::Relative => 100.0,
    }
}

/// A size in the unit that a text has.
pub fn in_unit(unit: FaultUnit, size: f64) -> String {
    let name = match unit {
        FaultUnit::Meters => "mm",
        FaultUnit::Radians => "mrad",
        FaultUnit::Kilograms => "g",
        FaultUnit::Relative => "%",
    };
    format!("{} {name}", two_digits(factor(unit) * size))
}

/// What a fault is about, without a size.
pub fn fault_name(fault: &Fault) -> String {
    let axis = fault.axis.map(String::from).unwrap_or_default();
    match (fault.node, fault.sensor, fault.hit) {
        (Some(node), ..) => format!("node {node} misplaced along {axis}"),
        (_, Some(sensor), _) => match fault.code {
            FindingCode::ChannelGainOff => format!("another gain of sensor {sensor} {axis}"),
            FindingCode::SensorTurned => format!("sensor {sensor} turned"),
            _ => format!("drift of sensor {sensor} {axis} over the test"),
        },
        (.., Some(hit)) => match fault.code {
            FindingCode::HitForceOff => format!("another force of hit {hit}"),
            _ => format!("hit {hit} leans"),
        },
        _ => match fault.code {
            FindingCode::HammerDrifts => "drift of the hammer over the test".into(),
            FindingCode::HammerGainOff => "another gain of the hammer".into(),
            FindingCode::HitsTurned => "all hits turned alike".into(),
            FindingCode::MarksLoaded => "a mass on each mark while it is hit".into(),
            _ => "chips above their marks".into(),
        },
    }
}

/// What the answer was tested for: each kind with the sizes at which it begins to show; empty without tests.
pub fn score_tests_text(tests: &[massline_result::ScoreTest]) -> String {
    let mut kinds: Vec<(&massline_result::ScoreTest, [f64; 2])> = Vec::new();
    for test in tests {
        let size = BEGINS_TO_SHOW * test.sigma;
        match kinds.iter_mut().find(|(kind, _)| kind.fault.code == test.fault.code) {
            Some((_, [least, most])) => (*least, *most) = (least.min(size), most.max(size)),
            None => kinds.push((test, [size; 2])),
        }
    }
    if kinds.is_empty() {
        return String::new();
    }
    let shown = tests.iter().filter(|test| test.shown).count();
    let result = if shown == 0 { "none shows".into() } else { format!("{shown} show") };
    let sizes: Vec<String> = kinds
        .iter()
        .map(|(kind, [least, most])| {
            let most_text = in_unit(kind.unit, *most);
            let number = two_digits(factor(kind.unit) * least);
            let from = if most_text.starts_with(&format!("{number} ")) {
                String::new()
            } else {
                format!("{number} to ")
            };
            format!("{} {from}{most_text}", kind_name(kind))
        })
        .collect();
    format!(
        "small faults: {result} of {} tested; they begin to show at {}\n",
        tests.len(),
        sizes.join(", ")
    )
}

fn kind_name(test: &massline_result::ScoreTest) -> &'static str {
    match test.fault.code {
        FindingCode::NodeMisplaced => "a node off by",
        FindingCode::HammerDrifts => "a drift of the hammer of",
        FindingCode::ChannelDrifts => "a drift of a channel of",
        FindingCode::HitLeans => "a leaning hit of",
        FindingCode::HitsTurned => "a turn of all hits of",
        FindingCode::MarksLoaded => "a mass on the mark that is hit of",
        FindingCode::ChannelGainOff => "a gain of a channel off by",
        FindingCode::SensorTurned => "a turn of a sensor of",
        FindingCode::HitForceOff => "a force of a hit off by",
        FindingCode::HammerGainOff => "a gain of the hammer off by",
        _ => "chips above their marks by",
    }
}
