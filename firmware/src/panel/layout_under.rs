//! The layout in use, under another profile.

use heapless::String;
use massline_shared::layout::{RigLayout, TestProfile};

use crate::encoded::{self, Bytes};
use crate::rig::Rig;
use crate::store::Source;

/// The layout in use with the settings of another profile, as the bytes that are stored: it takes no memory while the
/// flash is written.
pub(super) struct LayoutUnder<'a, 'm> {
    pub(super) rig: &'a Rig<'m>,
    pub(super) profile: TestProfile,
}

impl LayoutUnder<'_, '_> {
    /// The layout; an empty one when there is none, which no campaign accepts.
    fn layout(&self) -> RigLayout {
        let mut layout = self.rig.measurement.borrow().stated_layout().unwrap_or_default();
        layout.test = layout.test.under(self.profile);
        layout
    }

    fn put(&self, bytes: &mut Bytes<'_>) {
        bytes.put(&self.layout());
    }

    pub(super) fn title(&self) -> String<48> {
        let measurement = self.rig.measurement.borrow();
        measurement.layout().map_or_else(String::new, |layout| layout.title.clone())
    }

    /// Puts it into use.
    pub(super) fn put_into_use(&self) {
        let (layout, hash) = (self.layout(), self.checksum());
        self.rig.use_decoded(layout, hash);
    }
}

impl Source for LayoutUnder<'_, '_> {
    fn length(&self) -> usize {
        encoded::measured(&|bytes| self.put(bytes)).0
    }

    fn checksum(&self) -> u32 {
        encoded::measured(&|bytes| self.put(bytes)).1
    }

    fn read(&self, offset: usize, out: &mut [u8]) {
        encoded::read(&|bytes| self.put(bytes), offset, out);
    }
}
