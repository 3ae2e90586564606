//! A campaign on a full screen: what is read from the rig for it, and when.

use std::time::{Duration, Instant};

use crossterm::event::KeyCode;
use massline_protocol::event::HitEvent;
use massline_protocol::message::{Identity, Status};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{RigLayout, TestProfile};
use massline_shared::measurement::campaign::Phase;

use super::presenter::Presenter;
use crate::Result;
use crate::output::{Output, harmless};
use crate::screen::guide::{Guide, GuideOptions, HitReadings};
use crate::screen::{Screen, View};
use crate::support::keyboard::{Keyboard, no_terminal};
use massline_analysis::precision::PrecisionReport;
use massline_client::{Client, ClientError};
use massline_report::readings::Chain;
use massline_result::ModesSoFar;

/// Time between two requests for the levels.
const LEVELS: Duration = Duration::from_millis(200);
/// A record that takes longer than this keeps a person waiting: the next one is read at the next DOF.
const SLOW: Duration = Duration::from_secs(2);

/// Whether a campaign is followed on a full screen.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct ScreenArgs {
    /// Lines instead of a full screen, for a screen reader or a log.
    #[arg(long)]
    plain: bool,
}

impl ScreenArgs {
    /// True where there is a terminal for a full screen, and nobody wants lines.
    pub fn wants_screen(self, output: &Output) -> bool {
        output.has_screen() && !self.plain
    }
}

/// What the full screen needs to know of a campaign.
#[derive(Clone, Copy, Debug)]
pub struct DisplayedCampaign<'a> {
    /// `measurement` or `block test`.
    pub kind: &'static str,
    /// What is measured.
    pub title: &'a str,
    /// The rig.
    pub identity: &'a Identity,
    /// The calibration in force.
    pub calibration: &'a CalibrationRecord,
}

/// A campaign on a full screen.
pub(super) struct FullScreen {
    screen: Screen<Guide>,
    identity: Identity,
    calibration: CalibrationRecord,
    began: Instant,
    /// Records of the suspension profile, which a rig does not give.
    has_long_records: bool,
    /// When the levels were asked for.
    levels: Instant,
    /// The last hit whose record was asked for.
    record: u32,
    /// The DOF at which the link was slow.
    slow_at: Option<u8>,
    /// DOF and number of the hits whose spectra were asked for last.
    spectra: (u8, u8),
}

impl FullScreen {
    /// Takes the terminal.
    ///
    /// # Errors
    /// When the terminal cannot be taken.
    pub fn open(
        shown: DisplayedCampaign<'_>,
        layout: &RigLayout,
        wanted: GuideOptions,
        (keyboard, output): (&Keyboard, &Output),
    ) -> Result<Self> {
        let DisplayedCampaign { kind, title, identity, calibration } = shown;
        let guide = Guide::new(&harmless(title), kind, layout, identity.adc.bits, wanted);
        let screen = Screen::open(guide, keyboard.raw_mode(), output).map_err(no_terminal)?;
        Ok(Self {
            screen,
            identity: identity.clone(),
            calibration: calibration.clone(),
            began: Instant::now(),
            has_long_records: layout.test.profile == TestProfile::Suspension,
            levels: Instant::now(),
            record: 0,
            slow_at: None,
            spectra: (0, 0),
        })
    }

    /// True while nothing large is read, because that took long at this DOF.
    fn is_slow(&mut self, status: &Status) -> bool {
        let slow = self.slow_at == Some(status.dof);
        self.screen.update(|guide| guide.link_is_slow(slow));
        slow
    }

    fn read_levels(&mut self, client: &mut Client) -> Result<()> {
        if self.levels.elapsed() >= LEVELS {
            let levels = client.levels()?;
            self.screen.update(|guide| guide.levels(levels));
            self.levels = Instant::now();
        }
        Ok(())
    }

    /// Reads the record of the last hit, good or bad, which the rig has until the next one triggers.
    fn read_record(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        let number = status.last_hit;
        if self.has_long_records || self.record == number || self.is_slow(status) {
            return Ok(());
        }
        self.record = number;
        let began = Instant::now();
        let Some(codes) = unless_refused(client.hit_record(number))? else {
            return Ok(());
        };
        if began.elapsed() > SLOW {
            self.slow_at = Some(status.dof);
            self.line("the link is slow: hits and spectra are read again at the next DOF");
        }
        let Identity { adc, pre_trigger_scans, .. } = self.identity;
        let calibration = &self.calibration.calibration;
        let readings = Chain { calibration, adc, pre_trigger_scans }.readings(&codes);
        let scan_interval_s = 1.0 / f64::from(adc.rate.0);
        let pre_trigger_s = f64::from(pre_trigger_scans) * scan_interval_s;
        let readings = HitReadings { number, readings, scan_interval_s, pre_trigger_s };
        self.screen.update(|guide| guide.readings(readings));
        self.screen.draw();
        Ok(())
    }

    /// Reads the averages of the DOF in hand when they have changed.
    fn read_spectra(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        let hits = status.accepted.get(usize::from(status.dof)).copied().unwrap_or(0);
        if hits == 0 {
            // The next one is another first hit.
            self.spectra = (status.dof, 0);
        }
        if self.spectra == (status.dof, hits) || self.is_slow(status) {
            return Ok(());
        }
        self.spectra = (status.dof, hits);
        if let Some(spectra) = unless_refused(client.spectra(status.dof))? {
            self.screen.update(|guide| guide.spectra(spectra));
            self.screen.draw();
        }
        Ok(())
    }
}

/// What a rig refuses to send is not shown.
fn unless_refused<T>(answer: Result<T, ClientError>) -> Result<Option<T>> {
    match answer {
        Ok(value) => Ok(Some(value)),
        Err(e) if e.refusal().is_some() => Ok(None),
        Err(e) => Err(e.into()),
    }
}

impl Presenter for FullScreen {
    fn status(&mut self, status: &Status) {
        let at = self.began.elapsed();
        self.screen.update(|guide| guide.status(status, at));
        self.screen.draw();
    }

    fn hit(&mut self, hit: &HitEvent) {
        self.screen.update(|guide| guide.hit(hit));
        self.screen.draw();
    }

    fn precision(&mut self, report: &PrecisionReport<'_>) {
        self.screen.update(|guide| guide.precision(report));
        self.screen.draw();
    }

    fn modes(&mut self, report: &ModesSoFar) {
        self.screen.update(|guide| guide.modes(report));
        self.screen.draw();
    }

    fn reopened(&mut self, measured: usize) {
        self.screen.update(|guide| guide.reopened(measured));
    }

    fn ringing(&mut self, left_s: Option<u64>) {
        if self.screen.update(|guide| guide.rings(left_s)) {
            self.screen.draw();
        }
    }

    fn acted(&mut self) {
        self.screen.update(Guide::acted);
        self.screen.draw();
    }

    fn question(&mut self, text: &str) {
        self.screen.update(|guide| guide.question(text.into()));
        self.screen.draw();
    }

    fn line(&mut self, text: &str) {
        self.screen.update(|guide| guide.note(&harmless(text)));
        self.screen.draw();
    }

    fn look(&mut self, client: &mut Client, status: &Status) -> Result<()> {
        match Phase::try_from(status.phase).ok() {
            Some(Phase::Armed) => {
                self.read_record(client, status)?;
                self.read_spectra(client, status)?;
                self.read_levels(client)?;
            }
            Some(Phase::Confirming) => self.read_record(client, status)?,
            _ => {}
        }
        self.screen.refresh();
        Ok(())
    }

    fn key(&mut self, key: KeyCode) -> bool {
        let taken = self.screen.update(|guide| guide.key(key));
        if taken {
            self.screen.draw();
        }
        taken
    }
}
