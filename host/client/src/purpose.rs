//! What each request asks the rig for, in words for people.

use massline_protocol::Endpoint;
use massline_protocol::message::{
    DeleteResult, EraseStore, GetBattery, GetCalibration, GetHardware, GetIdentity, GetLayout,
    GetLevels, GetMassLines, GetObjectInfo, GetRestStatistics, GetStats, GetStatus, ListResults,
    PutCalibration, PutLayout, ReadObject, SetBrownOut, SetStream, StartCampaign, SteerCampaign,
    TakeReading,
};

/// What the start of a campaign asks for.
pub(super) const START: &str = "start a campaign";

/// What a request asks for, as in "the rig was asked to …".
pub(super) fn purpose(kind: u16) -> &'static str {
    match kind {
        GetIdentity::KIND => "say what it is",
        GetStatus::KIND => "say what it is doing",
        GetStats::KIND => "send its counters",
        PutLayout::KIND => "store a layout",
        GetLayout::KIND => "send its layout",
        PutCalibration::KIND => "store a calibration",
        GetCalibration::KIND => "send its calibration",
        StartCampaign::KIND => START,
        SteerCampaign::KIND => "change or end a campaign",
        GetObjectInfo::KIND => "find a stored object",
        ReadObject::KIND => "send a stored object",
        ListResults::KIND => "list its results",
        DeleteResult::KIND => "delete a result",
        SetStream::KIND => "start or stop the stream of scans",
        TakeReading::KIND => "take a reading at rest",
        GetRestStatistics::KIND => "send its reading at rest",
        GetLevels::KIND => "send the levels of its channels",
        GetMassLines::KIND => "send the mass lines of a DOF",
        EraseStore::KIND => "erase its store",
        GetHardware::KIND => "say how its clock and supply are",
        GetBattery::KIND => "report the charge of its battery",
        SetBrownOut::KIND => "raise the level at which it resets itself",
        _ => UNKNOWN,
    }
}

const UNKNOWN: &str = "answer a request";

#[cfg(test)]
mod tests {
    use massline_protocol::message::ENDPOINTS;

    use super::*;

    #[test]
    fn every_request_is_named_in_words() {
        let unnamed: Vec<_> =
            ENDPOINTS.iter().filter(|endpoint| purpose(endpoint.0) == UNKNOWN).collect();
        assert!(unnamed.is_empty(), "{unnamed:?}");
    }
}
