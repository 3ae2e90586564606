//! `massline solve`: computes the ten properties offline from the frequency responses in a universal file.

use std::path::PathBuf;

use clap::ValueEnum;
use massline_shared::identify::Method;

use super::{method, number};
use crate::error::Result;
use crate::output::Output;
use crate::solve::{Options, ReferencePoint, solve_files};
use crate::uff::Quantity;

/// Arguments of `massline solve`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads UFF dataset 58, ASCII and binary: frequency responses of every hit DOF at every sensor of
the layout. Weights are equal; band and terms are those of [test], else 10 to 120 Hz and A, B/s²,
C s². The errors of placement are averaged over test.hits_per_dof hits. The method global-fit,
which has to be asked for, fits body and suspension to all bins of the band: for objects whose
suspension modes are near the band.

Examples:
  massline solve frame.toml frame.uff
  massline solve frame.toml frame.uff --method ml
  massline solve wheel.toml wheel.uff --method global-fit
  massline solve frame.toml frame.uff --method irm --reference-point origin --json
  massline solve frame.toml frame.unv --quantity receptance
  massline solve frame.toml frame.uff --decay 10")]
pub struct Args {
    /// The layout file.
    layout: PathBuf,
    /// The universal file with the frequency responses.
    frfs: PathBuf,
    /// Point about which the equations are set up.
    #[arg(long, value_enum, default_value_t, value_name = "POINT")]
    reference_point: Point,
    /// Quantity of the responses, for a file that does not state it or states it wrongly.
    #[arg(long, value_enum, value_name = "QUANTITY")]
    quantity: Option<Response>,
    /// Decay rate σ of the exponential window that was applied to force and responses, 1/s; without the right
    /// value, noise and suspension are modelled wrongly.
    #[arg(long, value_name = "1/S", default_value = "0", value_parser = number::not_negative)]
    decay: f64,
    #[arg(
        long,
        value_name = "METHOD",
        value_parser = method::one_of(Method::ALL),
        help = method::help(Method::usual())
    )]
    method: Option<Method>,
}

/// A reference point as an argument.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Point {
    /// The centroid of the sensors, which gives less scatter.
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
        selection: method::selection(args.method),
        quantity: args.quantity.map(|quantity| match quantity {
            Response::Accelerance => Quantity::Acceleration,
            Response::Mobility => Quantity::Velocity,
            Response::Receptance => Quantity::Displacement,
        }),
        decay: args.decay,
    };
    let solution = solve_files(&args.layout, &args.frfs, &options)?;
    output.answer(&solution.to_json(), |_| solution.to_text().trim_end().into())
}
