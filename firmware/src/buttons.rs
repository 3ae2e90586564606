//! Shows the rig's state on the panel and turns its buttons into commands.

use embassy_futures::select::{Either, select};
use massline_shared::protocol::message::{CampaignCommand, CommandRequest, Phase};

use crate::board::Panel;
use crate::panel::Button;
use crate::rig::Rig;

/// Shows what changes and turns buttons into commands, for ever.
pub(crate) async fn run(mut panel: impl Panel, rig: &Rig, store_full: impl AsyncFn() -> bool) -> ! {
    loop {
        panel.show(&rig.panel());
        if let Either::Second(button) = select(rig.show.wait(), panel.button()).await
            && let Some(command) = command_of(button, rig.panel().phase)
        {
            let request = CommandRequest {
                command: command as u8,
                confirm: false,
                force: false,
                block: false,
            };
            // A refused command changes nothing, and the panel goes on showing what is.
            let _ = rig.command(request, store_full().await);
        }
    }
}

/// What a button means in a phase of the campaign.
fn command_of(button: Button, phase: Phase) -> Option<CampaignCommand> {
    use CampaignCommand as C;
    match (button, phase) {
        (Button::Ok, Phase::Idle | Phase::Done) => Some(C::Start),
        (Button::Ok, Phase::Confirming) => Some(C::Accept),
        (Button::Ok, Phase::Paused) => Some(C::Resume),
        (Button::Back, Phase::Confirming) => Some(C::Reject),
        (Button::Back, Phase::Armed) => Some(C::Redo),
        (Button::Back, Phase::Paused) => Some(C::Abort),
        (Button::Next, Phase::Armed | Phase::Busy) => Some(C::Pause),
        (Button::Next, Phase::Paused) => Some(C::Skip),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ok_starts_accepts_and_goes_on() {
        let ok = |phase| command_of(Button::Ok, phase);
        assert_eq!(ok(Phase::Idle), Some(CampaignCommand::Start));
        assert_eq!(ok(Phase::Confirming), Some(CampaignCommand::Accept));
        assert_eq!(ok(Phase::Paused), Some(CampaignCommand::Resume));
        assert_eq!(ok(Phase::Solving), None);
    }
}
