//! Finds the nets of a drawing from its lines: what is joined by wires, dots and names.

use std::collections::BTreeMap;

use crate::circuit::Nets;

/// A place on a sheet.
pub type Point = (i32, i32);

/// What a drawing connects.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    pub wires: Vec<[Point; 2]>,
    joints: Vec<Point>,
    pins: Vec<(Point, String)>,
    names: Vec<(Point, String)>,
}

impl Trace {
    pub fn wire(&mut self, points: &[Point]) {
        self.wires.extend(points.windows(2).map(|ends| [ends[0], ends[1]]));
    }

    pub fn joint(&mut self, at: Point) {
        self.joints.push(at);
    }

    pub fn pin(&mut self, at: Point, name: String) {
        self.pins.push((at, name));
    }

    pub fn name(&mut self, at: Point, name: &str) {
        self.names.push((at, name.to_owned()));
    }

    /// The nets of some sheets together; the name of a net is the least of its pins.
    ///
    /// # Errors
    /// A wire that ends on another one without a dot, and a pin that is drawn twice.
    pub fn nets(sheets: &[&Self]) -> Result<Nets, String> {
        let mut groups = Groups::default();
        let mut seen = BTreeMap::new();
        for (number, sheet) in sheets.iter().enumerate() {
            sheet.join(number, &mut groups)?;
            for (at, pin) in &sheet.pins {
                if seen.insert(pin.clone(), (number, *at)).is_some() {
                    return Err(format!("{pin} is drawn twice"));
                }
            }
        }
        let mut by_root: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for (pin, (number, at)) in seen {
            let node = groups.node(Place::At(number, at));
            by_root.entry(groups.root(node)).or_default().push(pin);
        }
        let named = |pins: Vec<String>| (pins[0].clone(), pins.into_iter().collect());
        Ok(by_root.into_values().map(named).collect())
    }

    /// Joins what this sheet connects.
    fn join(&self, sheet: usize, groups: &mut Groups) -> Result<(), String> {
        let at = |point| Place::At(sheet, point);
        for [a, b] in &self.wires {
            groups.join(at(*a), at(*b));
        }
        for (point, name) in &self.names {
            groups.join(at(*point), Place::Name(name.clone()));
        }
        let ends = self.wires.iter().flatten().chain(self.pins.iter().map(|(point, _)| point));
        for point in ends.chain(&self.joints) {
            for wire in self.wires.iter().filter(|wire| passes(**wire, *point)) {
                if !self.joints.contains(point) {
                    return Err(format!("sheet {}: no dot at {point:?}", sheet + 1));
                }
                groups.join(at(*point), at(wire[0]));
            }
        }
        Ok(())
    }
}

/// Whether a wire passes through a point, which is not its end.
fn passes([a, b]: [Point; 2], p: Point) -> bool {
    let along = (b.0 - a.0) * (p.1 - a.1) == (b.1 - a.1) * (p.0 - a.0);
    let within = |low: i32, high: i32, v: i32| (low.min(high)..=low.max(high)).contains(&v);
    along && p != a && p != b && within(a.0, b.0, p.0) && within(a.1, b.1, p.1)
}

/// Something that belongs to a net.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    At(usize, Point),
    Name(String),
}

/// Places in groups that are connected.
#[derive(Default)]
struct Groups {
    nodes: BTreeMap<Place, usize>,
    parents: Vec<usize>,
}

impl Groups {
    fn node(&mut self, place: Place) -> usize {
        let next = self.parents.len();
        let node = *self.nodes.entry(place).or_insert(next);
        if node == next {
            self.parents.push(next);
        }
        node
    }

    fn root(&self, mut node: usize) -> usize {
        while self.parents[node] != node {
            node = self.parents[node];
        }
        node
    }

    fn join(&mut self, a: Place, b: Place) {
        let (a, b) = (self.node(a), self.node(b));
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a] = b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing() -> Trace {
        let mut trace = Trace::default();
        trace.wire(&[(0, 0), (10, 0), (10, 10)]);
        trace.wire(&[(5, 0), (5, 9)]);
        trace.joint((5, 0));
        for (at, pin) in [((0, 0), "R1.1"), ((10, 10), "R2.1"), ((5, 9), "R3.1"), ((7, 7), "R4.1")]
        {
            trace.pin(at, pin.to_owned());
        }
        trace.name((5, 9), "A");
        trace
    }

    #[test]
    fn wires_dots_and_names_join_and_nothing_else_does() {
        let mut other = Trace::default();
        other.name((3, 3), "A");
        other.pin((3, 3), "R5.1".to_owned());
        let nets = Trace::nets(&[&drawing(), &other]).unwrap();
        let pins: Vec<Vec<_>> = nets.into_values().map(|pins| pins.into_iter().collect()).collect();
        assert_eq!(pins, [vec!["R1.1", "R2.1", "R3.1", "R5.1"], vec!["R4.1"]]);
    }

    #[test]
    fn a_missing_dot_and_a_pin_drawn_twice_are_errors() {
        let mut bare = drawing();
        bare.joints.clear();
        assert!(Trace::nets(&[&bare]).unwrap_err().contains("no dot at (5, 0)"));
        let twice = Trace::nets(&[&drawing(), &drawing()]).unwrap_err();
        assert!(twice.contains("is drawn twice"), "{twice}");
    }
}
