//! What is wrong with clock, supply and converter.

use massline_shared::diagnosis::{Code, Diagnostic, Severity};

use crate::message::Hardware;
use crate::{Clock, ConverterFault};

impl Hardware {
    /// What is wrong with clock and supply.
    pub fn findings(self) -> impl Iterator<Item = Diagnostic> {
        let checks = [
            (Clock::from(self.clock) == Clock::Internal, Code::CrystalDead),
            (self.supply_is_low, Code::SupplyTooLow),
        ];
        let wrong = checks.into_iter().filter(|(applies, _)| *applies);
        wrong.map(|(_, code)| Diagnostic::whole(code, Severity::Error, 0.0))
    }

    /// Why the converter does not answer.
    pub fn converter_finding(self) -> Diagnostic {
        let (code, value) = match ConverterFault::from(self.converter) {
            ConverterFault::None => (Code::SamplerStopped, 0.0),
            ConverterFault::LineHigh => (Code::ConverterLineHigh, 0.0),
            ConverterFault::LineLow => (Code::ConverterLineLow, 0.0),
            ConverterFault::NoCommands => (Code::ConverterWithoutCommands, 0.0),
            ConverterFault::WrongTag => (Code::ConverterWrongTag, f32::from(self.wrong_tag)),
        };
        Diagnostic::whole(code, Severity::Error, value)
    }
}
