//! The panel of the virtual rig: the host reads what it shows and presses its buttons, and the
//! source is told of every arming, as a person is who looks at it.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Poll, Waker};
use std::time::Duration;

use massline_firmware::board::Panel;
use massline_firmware::panel::{Button, PanelModel};
use massline_shared::protocol::message::Phase;

use crate::sampler::SharedSource;

/// The rig's end of the panel.
pub struct OperatorPanel {
    source: SharedSource,
    view: PanelView,
    told: Option<u32>,
}

/// The host's end of the panel. Clones are the same.
#[derive(Clone)]
pub struct PanelView(Arc<Shared>);

struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    model: PanelModel,
    ended: bool,
    pressed: VecDeque<Button>,
    waker: Option<Waker>,
}

impl OperatorPanel {
    /// A panel that tells `source` of armings.
    pub fn new(source: SharedSource) -> Self {
        let state =
            State { model: PanelModel::START, ended: false, pressed: VecDeque::new(), waker: None };
        let view =
            PanelView(Arc::new(Shared { state: Mutex::new(state), changed: Condvar::new() }));
        Self { source, view, told: None }
    }

    /// The host's end.
    pub fn view(&self) -> PanelView {
        self.view.clone()
    }
}

impl Panel for OperatorPanel {
    fn show(&mut self, model: &PanelModel) {
        self.view.lock().model = *model;
        self.view.0.changed.notify_all();
        if model.phase == Phase::Armed
            && let Some((dof, _)) = model.dof
            && self.told != Some(model.armings)
        {
            self.told = Some(model.armings);
            self.source.armed(model.armings, usize::from(dof));
        }
    }

    async fn button(&mut self) -> Button {
        poll_fn(|cx| {
            let mut state = self.view.lock();
            match state.pressed.pop_front() {
                Some(button) => Poll::Ready(button),
                None => {
                    state.waker = Some(cx.waker().clone());
                    Poll::Pending
                }
            }
        })
        .await
    }
}

impl Drop for OperatorPanel {
    fn drop(&mut self) {
        self.view.lock().ended = true;
        self.view.0.changed.notify_all();
    }
}

impl PanelView {
    /// What the panel shows.
    pub fn model(&self) -> PanelModel {
        self.lock().model
    }

    /// Waits until the panel shows something that `wanted` is true for; `None` when it does not
    /// within `timeout` or the rig ends before. A model that is replaced at once may be missed.
    pub fn wait_for(
        &self,
        timeout: Duration,
        mut wanted: impl FnMut(&PanelModel) -> bool,
    ) -> Option<PanelModel> {
        let (state, _) = self
            .0
            .changed
            .wait_timeout_while(self.lock(), timeout, |state| !state.ended && !wanted(&state.model))
            .unwrap_or_else(PoisonError::into_inner);
        let model = state.model;
        drop(state);
        wanted(&model).then_some(model)
    }

    /// Presses a button.
    pub fn press(&self, button: Button) {
        let mut state = self.lock();
        state.pressed.push_back(button);
        if let Some(waker) = state.waker.take() {
            waker.wake();
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::ScanSource;
    use embassy_futures::{block_on, poll_once};
    use massline_shared::layout::Dof;
    use massline_shared::signal::{AdcProperties, Scan};
    use massline_shared::units::{Hertz, Seconds, Volts};

    type Heard = Arc<Mutex<Vec<(u32, usize)>>>;

    struct Listener(Heard);

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

    fn panel() -> (OperatorPanel, Heard) {
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
        panel.show(&model(Phase::Idle, 0, 0));
        panel.show(&model(Phase::Armed, 1, 0));
        panel.show(&model(Phase::Armed, 1, 0));
        panel.show(&model(Phase::Busy, 2, 2));
        panel.show(&model(Phase::Armed, 2, 2));
        assert_eq!(*heard.lock().unwrap(), [(1, 0), (2, 2)]);
    }

    #[test]
    fn the_host_sees_what_is_shown() {
        let (mut panel, _) = panel();
        let view = panel.view();
        assert_eq!(view.model(), PanelModel::START);
        let waiter = std::thread::spawn(move || {
            view.wait_for(Duration::from_secs(60), |model| model.phase == Phase::Done)
        });
        panel.show(&model(Phase::Done, 4, 1));
        assert_eq!(waiter.join().unwrap(), Some(model(Phase::Done, 4, 1)));
    }

    #[test]
    fn nobody_waits_for_a_panel_that_is_gone() {
        let (panel, _) = panel();
        let view = panel.view();
        drop(panel);
        assert_eq!(view.wait_for(Duration::from_secs(3600), |_| false), None);
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
