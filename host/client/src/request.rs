//! The requests to a rig, a method for each.

use massline_protocol::PROTOCOL_MAJOR;
use massline_protocol::message::{
    Battery, DeleteResult, EraseStore, GetBattery, GetCalibration, GetHardware, GetIdentity,
    GetLayout, GetLevels, GetMassLines, GetRestStatistics, GetStats, GetStatus, Hardware, Identity,
    LayoutAnswer, Levels, ListRequest, ListResults, PutCalibration, PutLayout, Reason, ResultEntry,
    SetBrownOut, SetStream, StartCampaign, StartRequest, Stats, Status, SteerCampaign, TakeReading,
};
use massline_protocol::object::DofResult;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::{Command, Start};
use massline_shared::signal::RestStatistics;

use crate::error::ClientError;
use crate::exchange::Client;

impl Client {
    /// Reads the identity of the rig and checks that both sides use compatible protocols.
    ///
    /// # Errors
    /// [`ClientError::OtherProtocol`], and as [`Client::ask`].
    pub fn identify(&mut self) -> Result<Identity, ClientError> {
        let identity = self.ask::<GetIdentity>(&())?;
        if identity.protocol_major == PROTOCOL_MAJOR {
            return Ok(identity);
        }
        Err(ClientError::OtherProtocol {
            port: self.port().into(),
            firmware: identity.firmware.as_str().into(),
            rig_major: identity.protocol_major,
            rig_minor: identity.protocol_minor,
            advice: if identity.protocol_major > PROTOCOL_MAJOR {
                "update this program"
            } else {
                "update the rig's firmware"
            },
        })
    }

    /// Reads the status.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn status(&mut self) -> Result<Status, ClientError> {
        self.ask::<GetStatus>(&())
    }

    /// Reads the rig's counters.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn stats(&mut self) -> Result<Stats, ClientError> {
        self.ask::<GetStats>(&())
    }

    /// Sends a layout.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn put_layout(&mut self, layout: &RigLayout) -> Result<LayoutAnswer, ClientError> {
        self.ask::<PutLayout>(layout)
    }

    /// The layout stored on the rig.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn layout(&mut self) -> Result<RigLayout, ClientError> {
        self.ask::<GetLayout>(&())
    }

    /// Sends a calibration.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn put_calibration(&mut self, calibration: &CalibrationRecord) -> Result<(), ClientError> {
        self.ask::<PutCalibration>(calibration)
    }

    /// The calibration stored on the rig.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn calibration(&mut self) -> Result<CalibrationRecord, ClientError> {
        self.ask::<GetCalibration>(&())
    }

    /// Sends a campaign command.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn command(&mut self, command: Command) -> Result<Status, ClientError> {
        self.ask::<SteerCampaign>(&command)
    }

    /// Starts a campaign; with `confirm` every hit waits for a verdict, with `force` the campaign starts
    /// although the layout has an error.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn start(&mut self, confirm: bool, force: bool) -> Result<Status, ClientError> {
        self.start_with(StartRequest { start: Start { confirm, ..Start::DEFAULT }, force })
    }

    /// Starts a campaign with all its options.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn start_with(&mut self, request: StartRequest) -> Result<Status, ClientError> {
        self.ask::<StartCampaign>(&request)
    }

    /// The mass lines of the DOF with this index in the layout; `None` before the DOF is closed.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn mass_lines(&mut self, index: u8) -> Result<Option<DofResult>, ClientError> {
        match self.ask::<GetMassLines>(&index) {
            Ok(dof) => Ok(Some(dof)),
            Err(e) if e.refusal() == Some(Reason::NotFound) => Ok(None),
            Err(e) => Err(e),
        }
    }

    /// The level of every channel while the rig waits for a hit.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn levels(&mut self) -> Result<Levels, ClientError> {
        self.ask::<GetLevels>(&())
    }

    /// Erases all that a rig in safe mode stores.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn erase_store(&mut self) -> Result<(), ClientError> {
        self.ask::<EraseStore>(&())
    }

    /// State of clock, supply and converter; `None` in safe mode.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn hardware(&mut self) -> Result<Option<Hardware>, ClientError> {
        unless_in_safe_mode(self.ask::<GetHardware>(&()))
    }

    /// Charge of the rig's battery; `None` without a gauge, and in safe mode.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn battery(&mut self) -> Result<Option<Battery>, ClientError> {
        Ok(unless_in_safe_mode(self.ask::<GetBattery>(&()))?.flatten())
    }

    /// Sets the level at which the chip resets itself to its highest.
    ///
    /// # Errors
    /// As [`Client::ask`]; refused with `UnknownMessage` by a board without such a level, and with
    /// `SupplyLow`.
    pub fn raise_brown_out(&mut self) -> Result<(), ClientError> {
        self.ask::<SetBrownOut>(&())
    }

    /// Statistics of the channels at the moment, without a hit.
    ///
    /// # Errors
    /// As [`Client::ask`]; refused with `SamplerStopped` when the ADC does not respond.
    pub fn rest_statistics(&mut self) -> Result<RestStatistics, ClientError> {
        self.ask::<TakeReading>(&())?;
        self.patiently(|client| client.ask::<GetRestStatistics>(&()))
    }

    /// The list of all results stored on the rig.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn results(&mut self) -> Result<Vec<ResultEntry>, ClientError> {
        let mut entries: Vec<ResultEntry> = Vec::new();
        let mut after = 0;
        loop {
            let page = self.ask::<ListResults>(&ListRequest { after })?;
            let last = page.entries.iter().map(|e| e.number).max().unwrap_or(after);
            entries.extend(page.entries.iter().copied());
            // Stops at a page without new entries, which would otherwise be requested forever.
            if !page.more || last <= after {
                return Ok(entries);
            }
            after = last;
        }
    }

    /// Deletes a result.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn delete_result(&mut self, number: u32) -> Result<(), ClientError> {
        self.ask::<DeleteResult>(&number)
    }

    /// Starts or stops the stream of scans.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn set_stream(&mut self, on: bool) -> Result<(), ClientError> {
        self.ask::<SetStream>(&on)
    }
}

/// `None` in place of the refusal of a rig in safe mode.
fn unless_in_safe_mode<T>(answer: Result<T, ClientError>) -> Result<Option<T>, ClientError> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(error) if error.refusal() == Some(Reason::SafeMode) => Ok(None),
        Err(error) => Err(error),
    }
}
