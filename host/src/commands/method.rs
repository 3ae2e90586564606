//! `--method`: which methods answer.

use clap::ValueEnum;
use massline_shared::identify::Method;

use crate::identification::Selection;

/// Which methods answer.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct MethodArgs {
    /// One method alone; default: both, maximum likelihood first.
    #[arg(long, value_enum, value_name = "METHOD")]
    method: Option<MethodArg>,
}

/// A method as an argument.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodArg {
    /// Inertia restraint: linear, of the literature.
    Irm,
    /// Maximum likelihood with the complete error budget.
    Ml,
}

impl MethodArgs {
    /// The methods.
    pub fn selection(self) -> Selection {
        match self.method {
            None => Selection::All,
            Some(MethodArg::Irm) => Selection::Only(Method::InertiaRestraint),
            Some(MethodArg::Ml) => Selection::Only(Method::MaximumLikelihood),
        }
    }
}
