//! The six modes of a body on its suspension: from frequency responses to poles, residues and mass-normalised shapes.
//!
//! A body on soft cords has six modes in which it moves as a whole. Their shapes, normalised to a modal mass of one,
//! determine the mass matrix and with it the ten properties, whatever elastic modes lie above (theory, section 7).
//!
//! | module | subject |
//! | --- | --- |
//! | `origin_responses` | what the responses say about the motion of one point of the body |
//! | `force_mixing` | more than six forces as six, without a loss |
//! | `vector_fitting` | poles that all responses share |
//! | `residues` | the residues at these poles |
//! | `identification` | the modes |
//! | `lines` | the lines about the modes |
//! | `order` | how many modes there are |
//! | `shapes` | shapes from the residues of one or of all forces, and the Norm Indicator |

mod force_mixing;
mod identification;
mod lines;
mod order;
mod origin_responses;
mod residues;
mod shapes;
mod vector_fitting;
mod where_to_hit;

pub use force_mixing::ForceMixing;
pub use identification::{Mode, Modes, identify_modes, modal_assurance};
pub use lines::{LINES_OF_A_SIDE, Lines, LinesPerSide, MOST_OF_A_SET, Peak, choose_lines};
pub use order::{Order, Orders};
pub use origin_responses::{OriginResponses, Reduction, reduce_line};
pub use residues::{Residues, fit_residues};
pub use shapes::{
    best_force, norm_indicator, norm_indicator_of_shape, shape_of_force, shape_of_forces,
};
pub use vector_fitting::{
    FIT_MEMORY, MOST_PAIRS, Poles, SUSPENSION_MODES, VectorFit, find_poles, relocate_once,
};
pub use where_to_hit::{ModeVisibility, candidates};

/// Most forces. More are [mixed](ForceMixing) to this many without a loss.
pub const MOST_FORCES: usize = 6;
/// Most lines.
pub const MOST_LINES: usize = 128;

#[cfg(test)]
mod tests;
