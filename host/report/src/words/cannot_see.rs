//! What a test cannot see: errors that shift the answer without showing in the data, and for which the error budget
//! has no term or only part of one.
//!
//! | source | its term in the budget |
//! | --- | --- |
//! | the hammer's gain | `hammer_gain`, unless it is stated as zero |
//! | hits that all land on the same side of a mark | `node_position_m` and `node_direction_rad` |
//! | lateral force and free moment of the tip | those of the marks, except for a moment about the hit |
//! | mass of the sensors | `attached_mass_kg` or `[[attached]]`, if declared |
//! | liquid and loose parts, in mass lines | none |
//! | nonlinearity of the converter | `converter_gain` in the suspension profile, as one gain of all channels; for mass lines none of its own: the gains of the sensors have to cover it |

use massline_shared::body::RigidBody;
use massline_shared::layout::{AttachedBody, HostLayout, Sensor, TestProfile};
use nalgebra::{Matrix3, SVector};

use massline_result::UnseenError;

/// Mass on each sensor for which the effect is computed, kg.
const GRAM: f64 = 0.001;

/// The errors that a test with this layout cannot see. `body` is the answer, and `by_rig` says
/// whether a rig has measured, which this program can calibrate.
pub fn cannot_see(
    layout: &HostLayout,
    body: Option<&RigidBody<f64>>,
    by_rig: bool,
) -> Vec<UnseenError> {
    let entry = |(source, message): (&'static str, Option<String>)| {
        message.map(|message| UnseenError { source: source.into(), message })
    };
    let candidates = [
        ("hammer_gain", hammer_gain(layout)),
        ("same_side_miss", Some(same_side_miss(layout))),
        ("lateral_force_or_free_moment", lateral_force(layout)),
        ("sensor_mass", sensor_mass(layout, body)),
        ("loose_parts", loose_parts(layout, body)),
        ("nonlinearity", nonlinearity(layout, by_rig)),
    ];
    candidates.into_iter().filter_map(entry).collect()
}

/// The errors as text under a heading; empty without any.
pub fn cannot_see_text(unseen: &[UnseenError]) -> String {
    let lines: String = unseen.iter().map(|error| format!("  {}\n", error.message)).collect();
    if lines.is_empty() { lines } else { format!("what this test cannot see:\n{lines}") }
}

/// The sensors that are glued on, whose mass moves with the object.
pub fn glued(layout: &HostLayout) -> impl Iterator<Item = &Sensor<f64>> {
    // A laser or a camera adds nothing.
    layout.sensors.iter().filter(|sensor| sensor.senses_gravity)
}

/// True when the mass of the sensors counts as the object's.
pub fn has_undeclared_mass(layout: &HostLayout) -> bool {
    layout.attached.is_empty() && glued(layout).next().is_some()
}

fn hammer_gain(layout: &HostLayout) -> Option<String> {
    // After a block test alone, the gains of the sensors contain the hammer's.
    let stated_as_exact = layout.apparatus.hammer_gain == 0.0 && !layout.calibrated_hammer;
    stated_as_exact.then(|| {
        "the hammer's gain: [uncertainty] states it as exact (hammer_gain = 0); a hammer that reads 1 % low makes \
         mass and inertia 1 % too small and leaves the centre of mass"
            .into()
    })
}

fn same_side_miss(layout: &HostLayout) -> String {
    let (position, direction) = mark(layout);
    let exact = match (position > 0.0, direction > 0.0) {
        (true, true) => "",
        (false, true) => "; node_position_m = 0 states the marks as exact",
        (true, false) => "; node_direction_rad = 0 states their directions as exact",
        (false, false) => {
            "; node_position_m = 0 and node_direction_rad = 0 state the marks as exact"
        }
    };
    format!(
        "hits that all land on the same side of a mark, or lean the same way: the marks' uncertainty covers {:.1} mm \
         and {:.0} mrad (1 sd){exact}",
        1e3 * position,
        1e3 * direction,
    )
}

fn lateral_force(layout: &HostLayout) -> Option<String> {
    let (position, direction) = mark(layout);
    Some(format!(
        "a tip that always pushes sideways or twists, which the hammer does not measure: at each mark a lateral force \
         counts as an error of direction and a moment across the hit as one of position, so the marks' uncertainty \
         covers {:.1} % of the force and {:.1} mm times it (1 sd); a moment about the hit itself has no term",
        100.0 * direction,
        1e3 * position,
    ))
}

fn sensor_mass(layout: &HostLayout, body: Option<&RigidBody<f64>>) -> Option<String> {
    if !has_undeclared_mass(layout) {
        return None;
    }
    let effect = body.and_then(|body| effect_of_a_gram(layout, body)).map_or_else(String::new, |effect| {
        let Effect { mass, center, inertia } = effect;
        format!(
            "; each gram on each of them adds {:.1} g to the mass ({:+.2} %), moves the centre of mass by {:.2} mm and \
             changes the moments of inertia by up to {:.2} %",
            1e3 * mass,
            100.0 * mass / body.map_or(f64::NAN, |body| body.mass),
            1e3 * center,
            100.0 * inertia,
        )
    });
    Some(format!(
        "the mass of the sensors: none is declared, so it counts as the object's{effect}; weigh one and give \
         attached_mass_kg"
    ))
}

fn loose_parts(layout: &HostLayout, body: Option<&RigidBody<f64>>) -> Option<String> {
    let effect = body.map_or_else(String::new, |body| {
        format!(
            ": {:.0} g, 1 % of the mass, at {:.0} mm from the centre of mass make the mass 1 % too small and move its centre \
             by {:.2} mm",
            10.0 * body.mass,
            1e3 * layout.characteristic_length(),
            10.0 * layout.characteristic_length(),
        )
    });
    // In the suspension profile it has a mode of its own.
    (layout.test.profile == TestProfile::MassLine).then(|| {
        format!(
            "liquid and parts that swing by themselves below the band: they do not follow the hits, and what they weigh is \
             missing{effect}; fasten them, or fill up or empty the tank"
        )
    })
}

fn nonlinearity(layout: &HostLayout, by_rig: bool) -> Option<String> {
    let count = layout.sensors.len().max(1) as f64;
    let square: f64 = layout.sensors.iter().map(|s| s.uncertainty.gain.powi(2)).sum();
    let gain = 100.0 * (square / count).sqrt();
    Some(match layout.test.profile {
        TestProfile::MassLine => format!(
            "nonlinearity of the converter (INL): a wrong slope near the rest level of a channel is a wrong gain of \
             that channel, which the stated {gain:.2} % (1 sd) has to cover{}",
            if by_rig {
                "; `massline calibrate block` shows what differs between pushes from two sides"
            } else {
                ""
            }
        ),
        TestProfile::Suspension => format!(
            "nonlinearity of the converter (INL) that differs between channels: the budget has {:.2} % (1 sd, \
             converter_gain) for a wrong slope that all of them share; what one channel has more or less than the \
             others the {gain:.2} % of the sensors' gains have to cover",
            100.0 * layout.apparatus.converter_gain,
        ),
    })
}

/// Root mean square over the hits of the uncertainty of the marks: position, m, and direction, rad. Zero when it is
/// zero for one hit.
fn mark(layout: &HostLayout) -> (f64, f64) {
    let count = layout.hits.len().max(1) as f64;
    let sigma_of = |each: fn(&massline_shared::layout::HitUncertainty<f64>) -> f64| {
        let sigmas = || layout.hits.iter().map(|hit| each(&hit.uncertainty));
        let is_exact = sigmas().any(|sigma| sigma == 0.0);
        if is_exact {
            0.0
        } else {
            (sigmas().map(|sigma| sigma * sigma).sum::<f64>() / count).sqrt()
        }
    };
    (sigma_of(|u| u.node_position), sigma_of(|u| u.node_direction))
}

/// What a gram on each sensor changes.
struct Effect {
    /// kg.
    mass: f64,
    /// Distance by which the centre of mass moves, m.
    center: f64,
    /// Largest relative change of a moment of inertia.
    inertia: f64,
}

/// The answer against the same without a gram at each sensor.
fn effect_of_a_gram(layout: &HostLayout, body: &RigidBody<f64>) -> Option<Effect> {
    let points = glued(layout).map(|sensor| AttachedBody::point(GRAM, 0.0, sensor.position));
    let added =
        points.fold(SVector::<f64, 10>::zeros(), |sum, point| sum + SVector::from(point.phi));
    let without = RigidBody::from_phi(&(body.phi() - added))?;
    let moments = |tensor: &Matrix3<f64>| tensor.diagonal();
    let change = (moments(&body.inertia) - moments(&without.inertia))
        .component_div(&moments(&without.inertia));
    Some(Effect {
        mass: added[0],
        center: (body.center_of_mass - without.center_of_mass).norm(),
        inertia: change.amax(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::layout::{CalibratedGains, Hit, SensorUncertainty};
    use nalgebra::Vector3;

    fn layout() -> HostLayout {
        let mut layout = HostLayout::default();
        for (node, position) in [(1, [0.1, 0.0, 0.0]), (2, [-0.1, 0.0, 0.0])] {
            layout.sensors.push(Sensor {
                node,
                position,
                axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                senses_gravity: true,
                uncertainty: SensorUncertainty::default(),
                calibrated: CalibratedGains::default(),
            });
        }
        layout.hits.push(Hit::new("1:+X".parse().unwrap(), [0.0; 3], [1.0, 0.0, 0.0]));
        layout.apparatus.hammer_gain = 0.02;
        layout
    }

    fn sources(layout: &HostLayout) -> Vec<String> {
        cannot_see(layout, None, true).into_iter().map(|error| error.source).collect()
    }

    #[test]
    fn what_has_its_term_in_the_budget_is_not_listed() {
        let always =
            ["same_side_miss", "lateral_force_or_free_moment", "loose_parts", "nonlinearity"];
        let [miss, force, loose, converter] = always;
        let mut layout = layout();
        assert_eq!(sources(&layout), [miss, force, "sensor_mass", loose, converter]);
        layout.attached.push(AttachedBody::point(0.015, 0.1, [0.0; 3])).unwrap();
        assert_eq!(sources(&layout), always);
        layout.apparatus.hammer_gain = 0.0;
        assert_eq!(sources(&layout), ["hammer_gain", miss, force, loose, converter]);
        // Then the sensors are calibrated against the hammer, and their gains contain it.
        layout.calibrated_hammer = true;
        assert_eq!(sources(&layout), always);
        let text_of = |layout: &HostLayout| cannot_see_text(&cannot_see(layout, None, true));
        assert!(!text_of(&layout).contains("exact"));
        layout.hits[0].uncertainty.node_position = 0.0;
        assert!(
            text_of(&layout)
                .contains("covers 0.0 mm and 10 mrad (1 sd); node_position_m = 0 states")
        );
    }

    #[test]
    fn sensors_without_contact_have_no_mass() {
        let mut layout = layout();
        layout.sensors.iter_mut().for_each(|sensor| sensor.senses_gravity = false);
        assert!(!has_undeclared_mass(&layout));
        assert!(!sources(&layout).contains(&"sensor_mass".to_owned()));
    }

    #[test]
    fn the_effect_of_a_gram_is_that_of_the_object_without_it() {
        let body = RigidBody {
            mass: 2.0,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.01, 0.02, 0.02)),
        };
        let effect = effect_of_a_gram(&layout(), &body).unwrap();
        assert!((effect.mass - 0.002).abs() < 1e-15);
        // Both sensors are 0.1 m from the centre of mass, on opposite sides: it stays, and each adds 1e-5 kg m² to
        // the 0.02 kg m² about y and z.
        assert!(effect.center < 1e-12);
        assert!((effect.inertia - 2e-5 / (0.02 - 2e-5)).abs() < 1e-12, "{}", effect.inertia);
        let errors = cannot_see(&layout(), Some(&body), true);
        let message = &errors.iter().find(|error| error.source == "sensor_mass").unwrap().message;
        assert!(message.contains("adds 2.0 g to the mass (+0.10 %)"), "{message}");
    }

    #[test]
    fn what_swings_by_itself_is_missing_from_mass_lines() {
        let mut layout = layout();
        let body = RigidBody {
            mass: 2.0,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::from_diagonal_element(0.02),
        };
        let text = cannot_see_text(&cannot_see(&layout, Some(&body), true));
        // 1 % of 2 kg, 0.1 m away.
        assert!(text.contains("20 g, 1 % of the mass, at 100 mm"), "{text}");
        assert!(text.contains("move its centre by 1.00 mm"), "{text}");
        layout.test.profile = TestProfile::Suspension;
        assert!(!sources(&layout).contains(&"loose_parts".to_owned()));
    }

    #[test]
    fn the_term_of_the_converter_is_that_of_the_profile() {
        let mut layout = layout();
        let text_of = |layout: &HostLayout| cannot_see_text(&cannot_see(layout, None, true));
        assert!(text_of(&layout).contains("which the stated 1.00 % (1 sd) has to cover"));
        layout.test.profile = TestProfile::Suspension;
        layout.apparatus.converter_gain = 0.003;
        let text = text_of(&layout);
        assert!(text.contains("the budget has 0.30 % (1 sd, converter_gain)"), "{text}");
        assert!(text.contains("the 1.00 % of the sensors' gains"), "{text}");
        assert!(!text.contains("calibrate block"), "{text}");
    }

    #[test]
    fn the_text_has_the_figures_of_the_budget() {
        let text = cannot_see_text(&cannot_see(&layout(), None, true));
        assert!(text.starts_with("what this test cannot see:\n  "), "{text}");
        // 10 mrad and 1 mm are the defaults of a mark, 1 % that of a gain.
        assert!(text.contains("1.0 % of the force and 1.0 mm times it"), "{text}");
        assert!(text.contains("the stated 1.00 % (1 sd)"), "{text}");
        assert_eq!(cannot_see_text(&[]), "");
    }
}
