//! What is exported: a result in some frame and some units.

use massline_shared::body::RigidBody;
use massline_shared::layout::HostLayout;
use nalgebra::{SMatrix, SVector};

use super::frame::Placement;
use super::number::shortest;
use super::units::UnitSystem;
use crate::error::{Error, Result};
use crate::layout_file::{self, LayoutFile};
use crate::single_fault::NominalTest;
use crate::uff::Frf;

/// A covariance of the ten properties in the order [m, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz].
pub type Matrix10 = SMatrix<f64, 10, 10>;
/// The ten properties in the same order.
pub type Vector10 = SVector<f64, 10>;

/// A numbered point of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Its number.
    pub id: u16,
    /// Position in the body frame, m.
    pub position: [f64; 3],
    /// Local x, y and z axis, unit vectors of the body frame; `None` when they are not known.
    pub axes: Option<[[f64; 3]; 3]>,
}

impl From<&layout_file::Node> for Node {
    fn from(node: &layout_file::Node) -> Self {
        Self { id: node.id, position: node.position, axes: Some(node.axes) }
    }
}

/// The frequency responses of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// Accelerances: for each hit those of the sensors in the order of the layout, three for each, along its own axes.
    pub frfs: Vec<Frf>,
    /// The sensors and hits in the body frame.
    pub layout: HostLayout,
    /// Decay rate σ of the exponential window on force and responses, 1/s: the responses are those at `s = σ + iω`.
    pub decay_per_s: f64,
}

/// A result to be exported.
///
/// It is read in SI and in the body frame of the layout; [`Exported::in_frame`] and [`Exported::in_units`] change that
/// for the properties and their covariance, not for nodes and frequency responses.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// Name of the object: one line without control characters.
    pub title: String,
    /// Name of the method of the estimate.
    pub method: String,
    /// Where the result comes from: the name of a file, or a rig.
    pub source: String,
    /// The properties, the inertia about the centre of mass.
    pub body: RigidBody<f64>,
    /// Covariance of the properties; `None` when the method gives none.
    pub covariance: Option<Matrix10>,
    /// Half widths of the 95 % intervals; `None` without a covariance.
    pub half_widths: Option<Vector10>,
    /// Whether the result itself says that a body with these properties exists.
    pub stated_consistent: bool,
    /// The frame of the properties.
    pub placement: Placement,
    /// The units of the properties and of the placement.
    pub units: UnitSystem,
    /// The nodes of the layout; empty when they are not known.
    pub nodes: Vec<Node>,
    /// The frequency responses of the test; `None` when they are not known.
    pub responses: Option<Responses>,
    /// Hash of the layout of the test, when it is known.
    pub layout_hash: Option<u32>,
    /// What a person should know about how the result was read.
    pub notes: Vec<String>,
}

impl Exported {
    /// The ten properties.
    pub fn theta(&self) -> Vector10 {
        self.body.theta()
    }

    /// Standard deviations of the ten properties.
    pub fn sigma(&self) -> Option<Vector10> {
        self.covariance.map(|c| c.diagonal().map(|variance| variance.max(0.0).sqrt()))
    }

    /// Lower and upper ends of the 95 % intervals.
    pub fn interval(&self) -> Option<[Vector10; 2]> {
        let (theta, half) = (self.theta(), self.half_widths?);
        Some([theta - half, theta + half])
    }

    /// Takes title and nodes from the layout of the test; a layout with another hash is noted.
    pub fn with_layout(self, layout: &LayoutFile) -> Self {
        let mut with = self.titled(&layout.title);
        with.nodes = layout.nodes.iter().map(Node::from).collect();
        if let (Some(of_test), Some(given)) = (with.layout_hash, layout.hash())
            && of_test != given
        {
            with.notes.push(format!(
                "the layout differs from that of the test (hash {given:08x} instead of {of_test:08x}): make \
                 sure that its nodes are the same"
            ));
        }
        with
    }

    /// Takes title and nodes from the layout that the rig has kept, which does not have the axes of nodes.
    pub fn with_rig_layout(self, layout: HostLayout) -> Self {
        let NominalTest { layout, nodes } = NominalTest::of_layout(layout);
        let node = |(id, position)| Node { id, position, axes: None };
        let mut with = self.titled(layout.title.as_str());
        with.nodes = nodes.into_iter().map(node).collect();
        with
    }

    /// Takes another title, if it is not empty.
    pub fn titled(mut self, title: &str) -> Self {
        let title = one_line(title);
        if !title.is_empty() {
            self.title = title;
        }
        self
    }

    /// The condition of a real body that the properties violate, if there is one.
    pub fn violated_condition(&self) -> Option<String> {
        let unit = self.units;
        if self.body.mass <= 0.0 {
            let mass = shortest(self.body.mass);
            return Some(format!("the mass is {mass} {}, not positive", unit.mass_unit()));
        }
        let Some(principal) = self.body.principal() else {
            return Some("the inertia has no principal moments".into());
        };
        let [small, middle, large] = principal.moments.into();
        let inertia = unit.inertia_unit();
        if small <= 0.0 {
            let small = shortest(small);
            return Some(format!("a principal moment is {small} {inertia}, not positive"));
        }
        if !self.body.is_physically_consistent() {
            return Some(format!(
                "the largest principal moment, {large:.6e} {inertia}, is not below the sum of the other two, \
                 {middle:.6e} + {small:.6e}"
            ));
        }
        (!self.stated_consistent)
            .then(|| "the result says that it is not physically consistent".into())
    }

    /// Checks that the properties are numbers, and those of a real body unless `unphysical` is set.
    ///
    /// # Errors
    /// Exit 3; the message names the violated condition.
    pub fn check(&self, unphysical: bool) -> Result<()> {
        let covariance = self.covariance.iter().flat_map(|c| c.iter().copied());
        let interval =
            self.interval().into_iter().flatten().flat_map(|end| Vec::from(end.as_slice()));
        let origin = self.placement.origin.iter().copied();
        if !self.body.is_finite() || !covariance.chain(interval).chain(origin).all(f64::is_finite) {
            return Err(Error::undetermined(
                "not_finite",
                format!(
                    "{}: the answer by {} is too large for a number in {}; solve again",
                    self.source,
                    self.method,
                    self.units.name()
                ),
            ));
        }
        match self.violated_condition() {
            Some(condition) if !unphysical => Err(Error::undetermined(
                "unphysical_result",
                format!(
                    "{}: the answer by {} is not that of a physical body: {condition}. Simulators refuse it; \
                     measure again, choose another answer with --method, or write it all the same with \
                     --unphysical",
                    self.source, self.method
                ),
            )),
            _ => Ok(()),
        }
    }
}

/// The text in one line, without control characters and line separators.
pub(super) fn one_line(text: &str) -> String {
    let unfit =
        |c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{fffe}' | '\u{ffff}');
    let text: String = text.chars().map(|c| if unfit(c) { ' ' } else { c }).collect();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
