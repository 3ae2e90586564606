//! A response that a layout needs, and where a universal file has it.

use massline_shared::layout::{Axis, Dof, HostLayout};

use massline_files::uff::{Function, NodeDirection};

/// A sensor axis, by node, and a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) node: u16,
    pub(super) axis: Axis,
    pub(super) hit: Dof,
}

/// Node and unsigned direction of response and reference.
pub(super) type Key = [(i64, u64); 2];

impl Pair {
    /// The pairs of a layout: hit by hit, sensor by sensor, axis by axis.
    pub(super) fn all(layout: &HostLayout) -> impl Iterator<Item = Self> + '_ {
        layout.hits.iter().flat_map(|hit| {
            layout.sensors.iter().flat_map(|sensor| {
                Axis::ALL.map(|axis| Self { node: sensor.node, axis, hit: hit.dof })
            })
        })
    }

    /// Its name in messages.
    pub(super) fn name(&self) -> String {
        let Self { node, axis, hit } = self;
        format!("the sensor on node {node}, axis {axis:?}, due to the hit {hit}")
    }

    /// Where a function of it is.
    pub(super) fn key(&self) -> Key {
        let place = |node: u16, axis: Axis| (i64::from(node), axis.index() as u64 + 1);
        [place(self.node, self.axis), place(self.hit.node, self.hit.axis)]
    }
}

/// Where a function is.
pub(super) fn key_of(function: &Function) -> Key {
    let place = |at: NodeDirection| (at.node, at.direction.unsigned_abs());
    [place(function.response), place(function.reference)]
}
