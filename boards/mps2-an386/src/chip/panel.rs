//! There is no panel: the machine has neither screen nor buttons that a test could see.

use core::future::pending;

use massline_firmware::board::Panel;
use massline_firmware::panel::{Button, PanelModel};

/// Shows nothing; no button ever comes.
#[derive(Debug)]
pub struct NoPanel;

impl Panel for NoPanel {
    fn show(&mut self, _model: &PanelModel) {}

    async fn button(&mut self) -> Button {
        pending().await
    }
}
