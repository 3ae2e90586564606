//! The six modes of a body on its suspension: from frequency responses to poles, residues and mass-normalised shapes.
//!
//! A body on soft cords has six modes in which it moves as a whole. Their shapes, normalised to a modal mass of one,
//! determine the mass matrix and with it the ten properties, whatever elastic modes lie above (theory, section 7).
//!
//! | module | subject |
//! | --- | --- |
//! | `origin_responses` | what the responses say about the motion of one point of the body |
//! | `force_mixing` | more than six forces as six, without a loss |
//! | `motions` | these motions, in full precision or in 16 bits |
//! | `vector_fitting` | poles that all responses share |
//! | `residues` | the residues at these poles |
//! | `identification` | the modes |
//! | `lines` | the lines about the modes |
//! | `order` | how many modes there are |
//! | `order_search` | the same with few fits, in steps |
//! | `shapes` | shapes from the residues of one or of all forces, and the Norm Indicator |

mod force_mixing;
mod identification;
mod lines;
mod motions;
mod order;
mod order_search;
mod origin_responses;
mod residues;
mod shapes;
mod vector_fitting;
mod where_to_hit;

pub use force_mixing::ForceMixing;
pub use identification::{Mode, Modes, identify_modes, modal_assurance};
pub use lines::{LINES_OF_A_SIDE, Lines, LinesPerSide, MOST_OF_A_SET, Peak, choose_lines};
pub use motions::{CompactMotions, Exponents, Motions};
pub use order::{Order, OrderFit, Orders};
pub use order_search::OrderSearch;
pub use origin_responses::{OriginResponses, Reduction, reduce_line};
pub(crate) use origin_responses::{reduce, reduce_determined};
pub use residues::{ResidueFit, Residues, fit_residues};
pub use shapes::{
    best_force, energy_shares, norm_indicator, norm_indicator_of_shape, shape_of_force,
    shape_of_forces,
};
pub use vector_fitting::{
    MOST_PAIRS, PoleSearch, Poles, SEARCH_MEMORY, SUSPENSION_MODES, VectorFit, find_poles,
    relocate_once,
};
pub use where_to_hit::{Shown, candidates};

/// Most forces. More are [mixed](ForceMixing) to this many without a loss.
pub const MOST_FORCES: usize = 6;
/// Most lines.
pub const MOST_LINES: usize = 128;

#[cfg(test)]
mod tests;
