//! Begins a self-test and goes on with it.

use embedded_storage_async::nor_flash::NorFlash;

use super::PanelController;
use crate::deadline::Deadline;
use crate::panel::menu::Screen;
use crate::panel::modal::ModalState;
use crate::panel::refused::RefusalReason;
use crate::panel::self_test::SelfTestRun;

impl<F: NorFlash> PanelController<'_, '_, F> {
    pub(in crate::panel) fn start_self_test(
        &mut self,
        knows_sensors: bool,
    ) -> Result<(), RefusalReason> {
        self.rig.take_reading()?;
        *self.modal = ModalState::SelfTest(SelfTestRun::Reading, knows_sensors);
        self.menu.open(Screen::SelfTest);
        Ok(())
    }

    /// Goes on with the self-test by one channel, and asks for the next turn: link and watchdog get on in between.
    /// Deadline: [`crate::deadline::DEADLINE`].
    pub(super) fn step_self_test(&mut self) {
        let ModalState::SelfTest(run, knows_sensors) = &mut *self.modal else { return };
        let _deadline = Deadline::begin(&self.rig.stats);
        let mut measurement = self.rig.measurement.borrow_mut();
        if run.step(&mut measurement, &self.rig.info, *knows_sensors) {
            self.rig.show.signal(());
        }
    }
}
