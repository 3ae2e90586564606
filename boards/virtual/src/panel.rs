//! The panel of the virtual rig: the host sees its screen, receives its cues and presses its buttons. The
//! source is notified of every arming, as a person who looks at the panel would be.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Poll, Waker};
use std::time::Duration;

use massline_firmware::board::Panel;
use massline_firmware::panel::{Button, Cue, PanelModel};
use massline_shared::measurement::campaign::Phase;

use crate::framebuffer::Framebuffer;
use crate::sampler::SharedSource;

/// Number of cues that are stored; older ones are dropped.
const CUES: usize = 1024;

/// The rig's end of the panel.
pub struct OperatorPanel {
    source: SharedSource,
    view: PanelView,
    reported: Option<u32>,
    framebuffer: Framebuffer,
}

/// The host's end of the panel. Clones refer to the same panel.
#[derive(Clone)]
pub struct PanelView(Arc<SharedPanel>);

struct SharedPanel {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    model: PanelModel,
    /// The framebuffer on the screen, and the model that it was drawn from.
    shown: (PanelModel, Framebuffer),
    cues: VecDeque<Cue>,
    ended: bool,
    waiting: VecDeque<Button>,
    /// Number of presses: all, those that the rig has taken, and those before the picture now on the
    /// screen.
    pressed: u64,
    taken: u64,
    answered: u64,
    waker: Option<Waker>,
}

impl OperatorPanel {
    /// A panel that notifies `source` of armings.
    pub fn new(source: SharedSource) -> Self {
        let state = State {
            model: PanelModel::START,
            shown: (PanelModel::START, Framebuffer::default()),
            cues: VecDeque::new(),
            ended: false,
            waiting: VecDeque::new(),
            pressed: 0,
            taken: 0,
            answered: 0,
            waker: None,
        };
        let view =
            PanelView(Arc::new(SharedPanel { state: Mutex::new(state), changed: Condvar::new() }));
        Self { source, view, reported: None, framebuffer: Framebuffer::default() }
    }

    /// The host's end.
    pub fn view(&self) -> PanelView {
        self.view.clone()
    }
}

impl Panel for OperatorPanel {
    type Screen = Framebuffer;

    fn screen(&mut self) -> &mut Framebuffer {
        &mut self.framebuffer
    }

    async fn flush(&mut self) {
        let mut state = self.view.lock();
        state.shown = (state.model, self.framebuffer.clone());
        state.answered = state.taken;
        drop(state);
        self.view.0.changed.notify_all();
    }

    async fn button(&mut self) -> Button {
        poll_fn(|cx| {
            let mut state = self.view.lock();
            match state.waiting.pop_front() {
                Some(button) => {
                    state.taken += 1;
                    Poll::Ready(button)
                }
                None => {
                    state.waker = Some(cx.waker().clone());
                    Poll::Pending
                }
            }
        })
        .await
    }

    fn cue(&mut self, cue: Cue) {
        let mut state = self.view.lock();
        if state.cues.len() == CUES {
            state.cues.pop_front();
        }
        state.cues.push_back(cue);
    }

    fn report(&mut self, model: &PanelModel) {
        self.view.lock().model = *model;
        self.view.0.changed.notify_all();
        if model.phase == Phase::Armed
            && let Some((dof, _)) = model.dof
            && self.reported != Some(model.armings)
        {
            self.reported = Some(model.armings);
            self.source.armed(model.armings, usize::from(dof));
        }
    }
}

impl Drop for OperatorPanel {
    fn drop(&mut self) {
        self.view.lock().ended = true;
        self.view.0.changed.notify_all();
    }
}

impl PanelView {
    /// What the panel shows or is about to show.
    pub fn model(&self) -> PanelModel {
        self.lock().model
    }

    /// The pixels on the screen.
    pub fn framebuffer(&self) -> Framebuffer {
        self.lock().shown.1.clone()
    }

    /// The cues since the last call, in order.
    pub fn cues(&self) -> Vec<Cue> {
        self.lock().cues.drain(..).collect()
    }

    /// Waits until the panel shows a model for which `wanted` is true; `None` when that does not happen
    /// within `timeout` or the rig ends first. A model that is replaced at once may be missed.
    pub fn wait_for(
        &self,
        timeout: Duration,
        mut wanted: impl FnMut(&PanelModel) -> bool,
    ) -> Option<PanelModel> {
        let state = self.wait_until(timeout, |state| wanted(&state.model));
        let model = state.model;
        drop(state);
        wanted(&model).then_some(model)
    }

    /// Like [`Self::wait_for`], but waits until the picture of the model is on the screen.
    pub fn wait_for_picture(
        &self,
        timeout: Duration,
        mut wanted: impl FnMut(&PanelModel) -> bool,
    ) -> Option<(PanelModel, Framebuffer)> {
        let state = self.wait_until(timeout, |state| wanted(&state.shown.0));
        let shown = state.shown.clone();
        drop(state);
        wanted(&shown.0).then_some(shown)
    }

    /// Presses a button.
    pub fn press(&self, button: Button) {
        let mut state = self.lock();
        state.waiting.push_back(button);
        state.pressed += 1;
        if let Some(waker) = state.waker.take() {
            waker.wake();
        }
    }

    /// Presses a button and returns the screen once the rig has acted on the button; `None` when it does
    /// not within `timeout` or ends first.
    pub fn press_and_look(&self, timeout: Duration, button: Button) -> Option<Framebuffer> {
        self.press(button);
        let mine = self.lock().pressed;
        let state = self.wait_until(timeout, |state| state.answered >= mine);
        (state.answered >= mine).then(|| state.shown.1.clone())
    }

    fn wait_until(
        &self,
        timeout: Duration,
        mut wanted: impl FnMut(&State) -> bool,
    ) -> MutexGuard<'_, State> {
        let (state, _) = self
            .0
            .changed
            .wait_timeout_while(self.lock(), timeout, |state| !state.ended && !wanted(state))
            .unwrap_or_else(PoisonError::into_inner);
        state
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::{block_on, poll_once};
    use embedded_graphics::pixelcolor::BinaryColor;
    use embedded_graphics::prelude::DrawTarget;
    use massline_physics::source::ScanSource;
    use massline_shared::layout::Dof;
    use massline_shared::signal::{AdcProperties, Scan};
    use massline_shared::units::{Hertz, Seconds, Volts};

    /// Never reached unless something hangs.
    const LATE: Duration = Duration::from_secs(60);

    type ArmingLog = Arc<Mutex<Vec<(u32, usize)>>>;

    struct Listener(ArmingLog);

    impl ScanSource for Listener {
        fn adc(&self) -> AdcProperties {
            AdcProperties {
                rate: Hertz(2000.0),
                channels: 10,
                bits: 12,
                reference: Volts(3.3),
                channel_delay: Seconds(0.0),
            }
        }

        fn armed(&mut self, arming: u32, dof: usize) {
            self.0.lock().unwrap().push((arming, dof));
        }

        fn next_scan(&mut self) -> Option<Scan> {
            None
        }
    }

    fn panel() -> (OperatorPanel, ArmingLog) {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let source = SharedSource::new(Box::new(Listener(heard.clone())));
        (OperatorPanel::new(source), heard)
    }

    fn model(phase: Phase, armings: u32, dof: u8) -> PanelModel {
        let name: Dof = "1:+Y".parse().unwrap();
        PanelModel { phase, armings, dof: Some((dof, name)), ..PanelModel::START }
    }

    #[test]
    fn the_operator_hears_of_each_arming_once() {
        let (mut panel, heard) = panel();
        panel.report(&model(Phase::Idle, 0, 0));
        panel.report(&model(Phase::Armed, 1, 0));
        panel.report(&model(Phase::Armed, 1, 0));
        panel.report(&model(Phase::Busy, 2, 2));
        panel.report(&model(Phase::Armed, 2, 2));
        assert_eq!(*heard.lock().unwrap(), [(1, 0), (2, 2)]);
    }

    #[test]
    fn the_host_sees_what_is_shown() {
        let (mut panel, _) = panel();
        let view = panel.view();
        assert_eq!(view.model(), PanelModel::START);
        let waiter =
            std::thread::spawn(move || view.wait_for(LATE, |model| model.phase == Phase::Done));
        panel.report(&model(Phase::Done, 4, 1));
        assert_eq!(waiter.join().unwrap(), Some(model(Phase::Done, 4, 1)));
    }

    #[test]
    fn a_picture_is_seen_once_it_has_been_flushed() {
        let (mut panel, _) = panel();
        let view = panel.view();
        panel.report(&model(Phase::Done, 4, 1));
        panel.screen().clear(BinaryColor::On).unwrap();
        assert_eq!(view.framebuffer(), Framebuffer::default());
        block_on(panel.flush());
        let (_, framebuffer) = view.wait_for_picture(LATE, |model| model.armings == 4).unwrap();
        assert!(framebuffer.is_bright(0, 0) && framebuffer.is_bright(127, 63));
    }

    #[test]
    fn cues_are_heard_once() {
        let (mut panel, _) = panel();
        let view = panel.view();
        panel.cue(Cue::Armed);
        panel.cue(Cue::Accepted);
        assert_eq!(view.cues(), [Cue::Armed, Cue::Accepted]);
        assert_eq!(view.cues(), []);
    }

    #[test]
    fn nobody_waits_for_a_panel_that_is_gone() {
        let (panel, _) = panel();
        let view = panel.view();
        drop(panel);
        assert_eq!(view.wait_for(Duration::from_secs(3600), |_| false), None);
        assert_eq!(view.press_and_look(Duration::from_secs(3600), Button::Ok), None);
    }

    #[test]
    fn buttons_come_in_the_order_in_which_they_were_pressed() {
        let (mut panel, _) = panel();
        let view = panel.view();
        assert!(poll_once(panel.button()).is_pending());
        view.press(Button::Next);
        view.press(Button::Ok);
        assert_eq!(block_on(panel.button()), Button::Next);
        assert_eq!(block_on(panel.button()), Button::Ok);
    }
}
