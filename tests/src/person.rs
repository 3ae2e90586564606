//! A person who has only the rig's buttons, its screen and its cues.

use embassy_futures::block_on;
use massline_firmware::panel::{Button, PanelModel};
use massline_firmware::store::Store;
use massline_physics::source::ScanSource;
use massline_shared::layout::RigLayout;
use massline_virtual::flash::{Flash, FlashBacking};
use massline_virtual::framebuffer::Framebuffer;
use massline_virtual::panel::PanelView;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

use crate::campaign::LATE;

/// Flash in which these layouts were stored before a power cut; the last one is in use.
pub fn provisioned_with(layouts: &[&RigLayout]) -> FlashBacking {
    let backing = FlashBacking::default();
    let mut store = Store::new(Flash::open(&backing).expect("memory"), || false);
    block_on(store.open());
    for layout in layouts {
        let layout = postcard::to_stdvec(layout).expect("a layout is encoded");
        block_on(store.put_layout(&layout)).expect("there is room");
    }
    backing
}

/// Starts a rig on this flash with these scans, and someone in front of it.
pub fn power_on(flash: &FlashBacking, source: Box<dyn ScanSource>) -> (VirtualRig, Person) {
    let options = VirtualRigOptions { flash: flash.clone(), ..VirtualRigOptions::new(source) };
    let rig = VirtualRig::start(options).expect("the rig starts");
    let person = Person(rig.panel_view());
    (rig, person)
}

/// Looks at the screen, presses buttons and hears cues.
pub struct Person(pub PanelView);

impl Person {
    /// Presses a button; the screen after it.
    #[track_caller]
    pub fn press(&self, button: Button) -> Framebuffer {
        self.0.press_and_look(LATE, button).expect("the rig answers a press")
    }

    /// Presses these buttons; the screen after them.
    #[track_caller]
    pub fn presses(&self, buttons: &[Button]) -> Framebuffer {
        buttons.iter().fold(self.0.framebuffer(), |_, &button| self.press(button))
    }

    /// Waits for a picture of a model for which `wanted` is true.
    #[track_caller]
    pub fn sees(&self, wanted: impl FnMut(&PanelModel) -> bool) -> (PanelModel, Framebuffer) {
        self.0.wait_for_picture(LATE, wanted).expect("the rig gets there")
    }
}
