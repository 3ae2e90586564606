//! Candidate places for sensors and candidate DOFs for hits: the nodes of the layout file and their
//! restrictions.

use massline_shared::layout::{Axis, Dof, Hit, HostLayout, Sensor, Sign};

use massline_files::layout_file::{LayoutFile, Node};

/// Every place for a sensor and every DOF for a hit. Of the two signs of an axis only one is included: a push
/// and a pull along one line carry the same information.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// Sensors, with the settings of the file for those that it already has.
    pub sensors: Vec<Sensor<f64>>,
    /// Hits, with the settings of the file for those that it already has.
    pub hits: Vec<Hit<f64>>,
}

impl Candidates {
    /// All candidates that the nodes of a file allow.
    pub fn of(file: &LayoutFile) -> Self {
        let carriers = file.nodes.iter().filter(|node| node.can_carry_sensor);
        Self {
            sensors: carriers.map(|node| sensor_on(node, file)).collect(),
            hits: file.nodes.iter().flat_map(|node| hits_on(node, file)).collect(),
        }
    }

    /// The candidates that a layout does not use yet.
    pub fn beyond(&self, layout: &HostLayout) -> Self {
        let mut more = self.clone();
        more.sensors.retain(|sensor| layout.sensors.iter().all(|s| s.node != sensor.node));
        more.hits.retain(|hit| !layout.hits.iter().any(|h| along_one_line(&h.dof, &hit.dof)));
        more
    }
}

fn sensor_on(node: &Node, file: &LayoutFile) -> Sensor<f64> {
    let present = file.layout.sensors.iter().find(|sensor| sensor.node == node.id).copied();
    present.unwrap_or(Sensor {
        uncertainty: file.uncertainty.sensor,
        ..Sensor::new(node.id, node.position, node.axes)
    })
}

fn hits_on(node: &Node, file: &LayoutFile) -> Vec<Hit<f64>> {
    Axis::ALL.into_iter().filter_map(|axis| hit_on(node, axis, file)).collect()
}

/// The hit of the file along this axis, else a hit in the first allowed direction, positive before negative.
fn hit_on(node: &Node, axis: Axis, file: &LayoutFile) -> Option<Hit<f64>> {
    let allowed = |dof: &Dof| node.can_hit.contains(dof);
    let line = Dof { node: node.id, sign: Sign::Plus, axis };
    let mut present = file.layout.hits.iter();
    let present = present.find(|hit| along_one_line(&hit.dof, &line) && allowed(&hit.dof));
    present.copied().or_else(|| {
        let signs = [Sign::Plus, Sign::Minus];
        let dof = signs.map(|sign| Dof { sign, ..line }).into_iter().find(allowed)?;
        // Avoids −0, because directions are compared and printed.
        let direction = node.axes[axis.index()].map(|v| v * dof.sign.factor() + 0.0);
        Some(Hit { uncertainty: file.uncertainty.hit, ..Hit::new(dof, node.position, direction) })
    })
}

fn along_one_line(a: &Dof, b: &Dof) -> bool {
    (a.node, a.axis) == (b.node, b.axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"
        sensors = [{ node = 1, uncertainty = { gain = 0.5 } }, 2, 3]
        hits = ["1:-Y", "2:+Z", "3:+X"]
        node = [
            { id = 1, position_m = [0.0, 0.0, 0.0] },
            { id = 2, position_m = [0.2, 0.0, 0.0], can_carry_sensor = false },
            { id = 3, position_m = [0.0, 0.2, 0.0], can_hit = ["-X", "+Z", "-Z"] },
            { id = 4, position_m = [0.0, 0.2, 0.1], can_hit = [] },
        ]
    "#;

    #[test]
    fn nodes_say_what_they_allow() {
        let file = LayoutFile::parse(FILE, "l").unwrap();
        let candidates = Candidates::of(&file);
        assert!(candidates.sensors.iter().map(|s| s.node).eq([1, 3, 4]));
        assert_eq!(candidates.sensors[0].uncertainty.gain, 0.5);
        assert_eq!(candidates.sensors[1].uncertainty.gain, 0.01);
        let names: Vec<String> = candidates.hits.iter().map(|h| h.dof.to_string()).collect();
        assert_eq!(names, ["1:+X", "1:-Y", "1:+Z", "2:+X", "2:+Y", "2:+Z", "3:-X", "3:+Z"]);
        assert_eq!(candidates.hits[1].direction, [0.0, -1.0, 0.0]);
        let more = candidates.beyond(&file.layout);
        assert!(more.sensors.iter().map(|s| s.node).eq([4]));
        let names: Vec<String> = more.hits.iter().map(|h| h.dof.to_string()).collect();
        assert_eq!(names, ["1:+X", "1:+Z", "2:+X", "2:+Y", "3:+Z"]);
    }
}
