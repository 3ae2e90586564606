//! Commands that need a rig without a campaign.

use massline_protocol::message::Status;
use massline_shared::diagnosis::Code;
use massline_shared::measurement::campaign::{Command, Phase};

use crate::{Error, Result};
use massline_client::Client;
use massline_client::campaign::phase_name;

/// Ensures that no campaign is running or interrupted on the rig; with `restart` it is aborted.
///
/// # Errors
/// `another_campaign`, and when the rig cannot be reached.
pub fn without_campaign(client: &mut Client, restart: bool) -> Result<()> {
    let status = client.status()?;
    if !has_campaign(&status)? {
        return Ok(());
    }
    if !restart {
        return Err(Error::device(
            "another_campaign",
            format!(
                "the rig is {} in {}; finish it with that command, or discard its hits with `massline device abort`",
                phase_name(status.phase),
                begun(&status),
            ),
        ));
    }
    client.command(Command::Abort)?;
    Ok(())
}

/// What kind of campaign the rig has, with the command that goes on with it.
pub fn begun(status: &Status) -> &'static str {
    if status.diagnostics.iter().any(|diagnostic| diagnostic.code == Code::BlockTest) {
        "a block test of `massline calibrate block` or `verify`"
    } else {
        "a campaign of `massline measure`"
    }
}

/// Whether the rig has a campaign that can be aborted.
///
/// # Errors
/// `rig_solving` while it computes a result: that is not interrupted, and takes seconds.
pub fn has_campaign(status: &Status) -> Result<bool> {
    match Phase::try_from(status.phase).ok() {
        Some(Phase::Idle | Phase::Done) => Ok(false),
        Some(Phase::Solving) => Err(Error::device(
            "rig_solving",
            "the rig is finishing the result of a complete campaign, which takes a few seconds; then `massline results \
             list` shows it, and the rig is free",
        )),
        _ => Ok(true),
    }
}

#[cfg(test)]
mod tests {
    use massline_shared::diagnosis::{Diagnostic, Severity};

    use super::*;

    fn status(phase: Phase) -> Status {
        Status {
            phase: phase as u8,
            dof: 0,
            accepted: Default::default(),
            rejected: 0,
            armings: 0,
            last_hit: 0,
            hits_per_dof: 5,
            layout_hash: 1,
            started_unix_s: 0,
            result: 0,
            diagnostics: Default::default(),
        }
    }

    #[test]
    fn a_block_test_is_named_as_one() {
        let mut status = status(Phase::Paused);
        assert!(begun(&status).contains("`massline measure`"));
        let block = Diagnostic::whole(Code::BlockTest, Severity::Note, 0.0);
        status.diagnostics.push(block).unwrap();
        assert!(begun(&status).contains("calibrate block"));
    }

    #[test]
    fn a_campaign_that_is_being_solved_is_not_aborted_but_waited_for() {
        assert!(!has_campaign(&status(Phase::Idle)).unwrap());
        assert!(!has_campaign(&status(Phase::Done)).unwrap());
        assert!(has_campaign(&status(Phase::Paused)).unwrap());
        let refused = has_campaign(&status(Phase::Solving)).unwrap_err();
        assert_eq!((refused.code(), refused.exit_code()), ("rig_solving", 4));
    }
}
