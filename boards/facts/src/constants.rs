//! The board's facts as constants for the firmware.

use crate::board::Board;
use crate::wiring::Wiring;

/// The constants as Rust source.
pub fn constants(board: &Board) -> String {
    let Board { name, target, flash, .. } = board;
    let mut text = format!(
        "/// The folder under `boards/`.\n\
         pub const NAME: &str = {name:?};\n\
         /// What the firmware is built for.\n\
         pub const TARGET: &str = {target:?};\n\
         /// Bytes of flash.\n\
         pub const FLASH_BYTES: u32 = {:#x};\n",
        flash.bytes()
    );
    let select = board.wiring.as_ref().and_then(Wiring::flash_select_channel);
    text += &format!(
        "/// The channel on which some of these boards have the select pin of a flash chip.\n\
         pub const FLASH_SELECT: Option<u8> = {select:?};\n"
    );
    if let Some(conversion) = &board.conversion {
        let orders: Vec<String> =
            conversion.order.iter().map(|order| format!("&{order:?}")).collect();
        text += &format!(
            "/// The channels in the order of their conversion, for each converter.\n\
             pub const CONVERSION_ORDER: &[&[u8]] = &[{}];\n",
            orders.join(", ")
        );
    }
    if let Some(store) = flash.store {
        let start = store.origin - flash.origin;
        text += &format!(
            "/// The store, in bytes from the start of flash.\n\
             pub const STORE: core::ops::Range<u32> = {start:#x}..{:#x};\n",
            start + store.bytes
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Conversion;
    use crate::check::tests::board;

    #[test]
    fn the_store_is_counted_from_the_start_of_flash() {
        let text = constants(&board());
        assert!(text.contains("NAME: &str = \"a-board\";"), "{text}");
        assert!(text.contains("FLASH_BYTES: u32 = 0x80000;"), "{text}");
        assert!(text.contains("STORE: core::ops::Range<u32> = 0x4000..0x10000;"), "{text}");
    }

    #[test]
    fn each_converter_has_its_order() {
        let mut board = board();
        board.conversion = Some(Conversion { order: vec![vec![0, 2], vec![1, 3]] });
        let text = constants(&board);
        assert!(text.contains("CONVERSION_ORDER: &[&[u8]] = &[&[0, 2], &[1, 3]];"), "{text}");
    }

    #[test]
    fn a_board_without_a_store_of_its_own_has_no_constant_for_it() {
        let mut board = board();
        board.flash.store = None;
        assert!(!constants(&board).contains("STORE"));
    }
}
