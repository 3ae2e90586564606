//! Where to hit now: the name of the DOF in large letters, and the same in words.

use massline_shared::layout::TestProfile;
use massline_shared::measurement::campaign::Phase;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::widgets::{Paragraph, Wrap};

use crate::screen::Theme;
use crate::screen::guide::Guide;

/// Rows of the words, and of the words below the name in large letters.
pub(super) const WORDS: u16 = 2;
pub(super) const LARGE: u16 = 4 + WORDS;

/// The name of the DOF in hand, and what to do there; the words alone where there is no room for both.
pub(super) fn name(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let [large, below] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(WORDS)]).areas(area);
    if area.height >= LARGE {
        let name = guide.dof().map_or_else(String::new, |hit| hit.dof.to_string());
        super::large::draw(&name, frame, large, theme);
    }
    let words = Paragraph::new(words(guide)).style(theme.strong()).centered();
    frame.render_widget(words.wrap(Wrap { trim: true }), below);
}

/// What to do now, in words.
pub(super) fn words(guide: &Guide) -> String {
    let wanted = guide.layout.test.hits_per_dof;
    let here = guide.hits_here();
    let Some(hit) = guide.dof() else { return "waiting for the rig".into() };
    match guide.phase() {
        Some(Phase::Armed) => {
            let when = match guide.layout.test.profile {
                TestProfile::MassLine => format!("hit {} now", hit.dof),
                TestProfile::Suspension => format!("when it hangs still, hit {}", hit.dof),
            };
            format!("{when}: hit {} of {wanted}", here.saturating_add(1).min(wanted))
        }
        Some(Phase::Confirming) if guide.wanted.verdicts => {
            format!("{}: accept or reject the hit", hit.dof)
        }
        Some(Phase::Busy) if let Some(left) = guide.rings_s => {
            format!("ringing, {left} s left: do not touch it")
        }
        Some(Phase::Busy | Phase::Confirming) => format!("measuring at {}", hit.dof),
        Some(Phase::TargetReached) => "target reached".into(),
        Some(Phase::Solving) => "the rig is finishing the result".into(),
        Some(Phase::Paused) => "paused".into(),
        Some(Phase::Done) => "done".into(),
        Some(Phase::Idle) | None => "waiting for the rig".into(),
    }
}
