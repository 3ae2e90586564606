//! The memory map for the linker.

use crate::board::Board;

/// `memory.x` for cortex-m-rt; `sections` is what the board's own script adds.
pub fn memory_map(board: &Board, sections: &str) -> String {
    let (flash, stack, ram) = (board.image_flash(), board.stack(), board.statics());
    let code = match board.hole() {
        Some(store) => format!("\n/* Behind the store. */\n_stext = {:#010x};\n", store.end),
        None => String::new(),
    };
    format!(
        "/* Made from boards/{}/board.toml. */\n\
         MEMORY\n\
         {{\n  \
           FLASH : ORIGIN = {:#010x}, LENGTH = {:#x}\n  \
           RAM   : ORIGIN = {:#010x}, LENGTH = {:#x}\n\
         }}\n\n\
         /* Below the statics, so that it leaves RAM when it overflows. */\n\
         _stack_end = {:#010x};\n\
         _stack_start = {:#010x};\n\
         {code}{sections}",
        board.name,
        flash.start,
        flash.end - flash.start,
        ram.start,
        ram.end - ram.start,
        stack.start,
        stack.end
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::tests::board;

    #[test]
    fn a_store_between_vectors_and_code_is_left_out() {
        let map = memory_map(&board(), "");
        assert!(map.contains("FLASH : ORIGIN = 0x08000000, LENGTH = 0x64000\n"), "{map}");
        assert!(map.ends_with("_stext = 0x08010000;\n"), "{map}");
    }

    #[test]
    fn the_stack_is_below_the_statics() {
        let map = memory_map(&board(), "");
        assert!(map.contains("_stack_end = 0x20000000;\n_stack_start = 0x20006000;\n"), "{map}");
        assert!(map.contains("RAM   : ORIGIN = 0x20006000, LENGTH = 0x1a000\n"), "{map}");
    }

    #[test]
    fn a_store_behind_the_image_needs_no_hole_and_the_boards_script_comes_last() {
        let mut board = board();
        board.image.flash_bytes = 0x4000;
        let map = memory_map(&board, "SECTIONS {}\n");
        assert!(!map.contains("_stext"), "{map}");
        assert!(map.ends_with("\nSECTIONS {}\n"), "{map}");
    }
}
