//! How the frequency responses of a universal file are read: options of several commands.

use std::str::FromStr;

use clap::ValueEnum;
use massline_shared::identify::agreement::NOISE_DRAWS;

use super::number;
use crate::solve::Options;
use massline_files::uff::Quantity;

/// Number of changed data sets that are solved at least, for the progress bar.
pub const PERTURBATIONS: u64 = NOISE_DRAWS as u64;

/// Options about the responses of a file.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct ResponseArgs {
    /// Quantity of the responses, for a file that does not state it or states it wrongly; its units hold all the same.
    #[arg(long, value_enum, value_name = "QUANTITY")]
    quantity: Option<Response>,
    /// Decay rate σ of the exponential window that was applied to force and responses, 1/s; without the right
    /// value, noise and suspension are modelled wrongly [default: 0].
    #[arg(long, value_name = "1/S", value_parser = number::not_negative)]
    decay: Option<f64>,
    /// Band in which the suspension modes are looked for, Hz: from below the lowest to above the highest of them
    /// [default: 0.5:12.5; of an archive of the suspension profile that of its test, 0.5:12.4].
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true)]
    suspension_band: Option<Band>,
}

impl ResponseArgs {
    /// The options of the solver.
    pub fn options(&self) -> Options {
        let default = Options::default();
        Options {
            quantity: self.quantity.map(Quantity::from),
            decay: self.decay.unwrap_or(default.decay),
            suspension_band_hz: self.suspension_band.map(|band| band.0),
            ..default
        }
    }

    /// The options that were given.
    pub fn given(&self) -> impl Iterator<Item = &'static str> {
        let given = [
            ("--quantity", self.quantity.is_some()),
            ("--decay", self.decay.is_some()),
            ("--suspension-band", self.suspension_band.is_some()),
        ];
        given.into_iter().filter_map(|(name, is_given)| is_given.then_some(name))
    }
}

/// A band as an argument, Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Band([f64; 2]);

impl FromStr for Band {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let ends = text.split_once(':').and_then(|(low, high)| {
            Some([low.trim().parse::<f64>().ok()?, high.trim().parse().ok()?])
        });
        ends.filter(|[low, high]| *low > 0.0 && low < high && high.is_finite())
            .map(Self)
            .ok_or_else(|| {
                "give two frequencies in Hz, both above 0 and the lower one first, as in 0.5:12.5"
                    .into()
            })
    }
}

/// What a frequency response is, as an argument.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Response {
    /// Acceleration over force.
    Accelerance,
    /// Velocity over force.
    Mobility,
    /// Displacement over force.
    Receptance,
}

impl From<Response> for Quantity {
    fn from(response: Response) -> Self {
        match response {
            Response::Accelerance => Self::Acceleration,
            Response::Mobility => Self::Velocity,
            Response::Receptance => Self::Displacement,
        }
    }
}
