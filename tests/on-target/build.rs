//! Links the programs for the whole emulated machine: the golden cases in double precision are larger than
//! a rig.

use std::path::Path;

fn main() {
    massline_boards::build::whole_machine(Path::new("../../boards/mps2-an386"), &["link.x"]);
}
