//! `massline solve`: from frequency responses in a universal file to the ten properties, offline.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::error::Result;
use crate::output::Output;
use crate::solve::{Options, ReferencePoint, solve_files};
use crate::uff::Quantity;

/// Arguments of `massline solve`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads UFF dataset 58, ASCII and binary: frequency responses of every hit DOF at every sensor of the
layout. Weights are equal; the band is that of [test], else 10 to 120 Hz.

Examples:
  massline solve frame.toml frame.uff
  massline solve frame.toml frame.uff --reference-point origin --json
  massline solve frame.toml frame.unv --quantity receptance")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    /// The universal file with the frequency responses.
    frfs: PathBuf,
    /// Point about which the equations are set up.
    #[arg(long, value_enum, default_value_t, value_name = "POINT")]
    reference_point: Point,
    /// What the responses are, where the file does not say.
    #[arg(long, value_enum, value_name = "QUANTITY")]
    quantity: Option<Response>,
}

/// A reference point as an argument.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Point {
    /// The centroid of the sensors: less scatter.
    #[default]
    Centroid,
    /// The origin of the body frame.
    Origin,
}

/// What a frequency response is, as an argument.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Response {
    /// Acceleration over force.
    Accelerance,
    /// Velocity over force.
    Mobility,
    /// Displacement over force.
    Receptance,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad, or the data cannot determine the answer.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let options = Options {
        reference_point: match args.reference_point {
            Point::Centroid => ReferencePoint::Centroid,
            Point::Origin => ReferencePoint::Origin,
        },
        quantity: args.quantity.map(|quantity| match quantity {
            Response::Accelerance => Quantity::Acceleration,
            Response::Mobility => Quantity::Velocity,
            Response::Receptance => Quantity::Displacement,
        }),
    };
    let solution = solve_files(&args.layout, &args.frfs, &options)?;
    output.answer(&solution.to_json(), |_| solution.to_text().trim_end().into())
}
