//! Checks that the types of the facts do not enforce: consistent sizes, and the facts that a board with a
//! chip must state.

use crate::board::Board;
use crate::error::Error;

/// Returns the first contradiction as an error.
///
/// # Errors
/// The error names the key.
pub fn check(board: &Board) -> Result<(), Error> {
    memories(board)?;
    store(board)?;
    image(board)?;
    chip(board)
}

/// Checks that no region exceeds the address space, so that sums of addresses and sizes do not overflow
/// later.
fn memories(board: &Board) -> Result<(), Error> {
    let too_large =
        |key| Err(Error::contradiction(key, "must end before the address 0xffff_ffff".into()));
    let bytes = board.flash.sectors.iter().try_fold(board.flash.origin, |end, sectors| {
        end.checked_add(sectors.count.checked_mul(sectors.bytes)?)
    });
    let store = board.flash.store.is_none_or(|s| s.origin.checked_add(s.bytes).is_some());
    match () {
        () if bytes.is_none() => too_large("flash.sectors"),
        () if !store => too_large("flash.store"),
        () if board.ram.origin.checked_add(board.ram.bytes).is_none() => too_large("ram"),
        () => Ok(()),
    }
}

/// Checks that the store consists of whole sectors, because the rig erases whole sectors.
fn store(board: &Board) -> Result<(), Error> {
    let Some(store) = board.flash.store.map(|store| store.range()) else { return Ok(()) };
    let starts = board.flash.each_sector().any(|sector| sector.start == store.start);
    let ends = board.flash.each_sector().any(|sector| sector.end == store.end);
    if store.is_empty() || !starts || !ends {
        let why = format!(
            "0x{:08x} to 0x{:08x} is not made of whole sectors of flash",
            store.start, store.end
        );
        return Err(Error::contradiction("flash.store", why));
    }
    Ok(())
}

fn image(board: &Board) -> Result<(), Error> {
    let (flash, ram) = (board.flash.bytes(), board.ram.bytes);
    within("image.flash_bytes", board.image.flash_bytes.into(), "the flash", flash.into())?;
    within("image.ram_bytes", board.image.ram_bytes.into(), "the RAM", ram.into())?;
    stack(board)?;
    if let Some(hole) = board.hole()
        && (hole.start == board.flash.origin || hole.end >= board.image_flash().end)
    {
        let why = format!(
            "the store, 0x{:08x} to 0x{:08x}, leaves no room for the vector table before it or the code behind it",
            hole.start, hole.end
        );
        return Err(Error::contradiction("image.flash_bytes", why));
    }
    Ok(())
}

/// Checks that the stack pointer starts within the image's RAM at a multiple of eight, as the core's calls require.
fn stack(board: &Board) -> Result<(), Error> {
    let (ram, stack) = (board.image.ram_bytes, board.image.stack_bytes);
    within("image.stack_bytes", stack.into(), "what the linker may fill", ram.into())?;
    if stack == 0 || !board.stack().end.is_multiple_of(8) {
        let why = format!("a stack of {stack} bytes does not end at a multiple of eight");
        return Err(Error::contradiction("image.stack_bytes", why));
    }
    Ok(())
}

fn within(key: &'static str, value: u64, whole: &str, limit: u64) -> Result<(), Error> {
    if value <= limit {
        return Ok(());
    }
    Err(Error::contradiction(key, format!("{value} bytes are more than {whole}, {limit} bytes")))
}

/// Checks the facts for flashing and for the schematic.
fn chip(board: &Board) -> Result<(), Error> {
    let missing = |key| Err(Error::contradiction(key, "a board with a chip must state it".into()));
    match board {
        Board { chip: None, .. } => Ok(()),
        Board { flash, .. } if flash.store.is_none() => missing("flash.store"),
        Board { wiring: None, .. } => missing("wiring"),
        Board { conversion: None, .. } => missing("conversion"),
        _ => Ok(()),
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::board::Region;

    const TEXT: &str = r#"
        title = "A Board"
        target = "thumbv7em-none-eabihf"
        chip = { name = "STM32F411CE", probe_rs = "STM32F411CEUx" }
        ram = { origin = 0x2000_0000, bytes = 0x2_0000 }
        image = { flash_bytes = 0x6_4000, ram_bytes = 0x2_0000, stack_bytes = 0x6000 }

        [flash]
        origin = 0x0800_0000
        sectors = [
            { count = 4, bytes = 0x4000 },
            { count = 1, bytes = 0x1_0000 },
            { count = 3, bytes = 0x2_0000 },
        ]
        store = { origin = 0x0800_4000, bytes = 0xC000 }

        [boot_loader]
        kind = "dfu"
        steps = "hold BOOT0"
        remedy = "pull PA10 down"
        usb = { vendor = 0x0483, product = 0xDF11 }

        [wiring]
        supply = "3V3"
        channels = ["PA0"]
        screen = { scl = "PB6", sda = "PB7" }
        buttons = { ok = "PB12", back = "PB13", next = "PB14" }
        buzzer = "PB8"
        light = "PC13"
        plug = []
        part = []
        power = { battery = "5V", regulator = "ME6206", notes = [] }

        [conversion]
        order = [[0, 1]]
    "#;

    /// The memories of an STM32F411CE.
    pub fn board() -> Board {
        Board::parse("a-board", TEXT).unwrap()
    }

    fn refused(change: impl FnOnce(&mut Board), key: &str) {
        let mut board = board();
        change(&mut board);
        let error = check(&board).unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }

    fn refused_text(from: &str, to: &str, words: &str) {
        assert!(TEXT.contains(from));
        let error = Board::parse("a-board", &TEXT.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }

    #[test]
    fn the_f411_has_eight_sectors_in_512_kib() {
        let flash = board().flash;
        assert_eq!(flash.each_sector().count(), 8);
        assert_eq!(flash.range(), 0x0800_0000..0x0808_0000);
        assert_eq!(flash.each_sector().nth(5), Some(0x0802_0000..0x0804_0000));
    }

    #[test]
    fn a_missing_an_unknown_and_a_wrong_value_are_named() {
        refused_text("ram = {", "rom = {", "unknown field `rom`");
        refused_text("title = \"A Board\"", "", "missing field `title`");
        refused_text("count = 4", "count = \"four\"", "invalid type: string \"four\"");
        refused_text("kind = \"dfu\"", "kind = \"tape\"", "unknown variant `tape`");
        refused_text("steps = \"hold BOOT0\"", "", "missing field `steps`");
    }

    #[test]
    fn the_store_is_made_of_whole_sectors() {
        refused(|board| board.flash.store.as_mut().unwrap().bytes = 0x8800, "flash.store");
        refused(|board| board.flash.store.as_mut().unwrap().bytes = 0, "flash.store");
        let outside = Region { origin: 0x0808_0000, bytes: 0x4000 };
        refused(|board| board.flash.store = Some(outside), "flash.store");
    }

    #[test]
    fn nothing_goes_beyond_the_last_address() {
        refused(|board| board.flash.sectors[0].count = u32::MAX, "flash.sectors");
        refused(|board| board.flash.store.as_mut().unwrap().bytes = u32::MAX, "flash.store");
        refused(|board| board.ram.bytes = u32::MAX, "ram");
    }

    #[test]
    fn the_image_fits_its_memories() {
        refused(|board| board.image.flash_bytes = 0x8_0001, "image.flash_bytes");
        refused(|board| board.image.ram_bytes = 0x2_0001, "image.ram_bytes");
        refused(|board| board.image.stack_bytes = 0x2_0008, "image.stack_bytes");
        refused(|board| board.image.stack_bytes = 0x6004, "image.stack_bytes");
        refused(|board| board.image.stack_bytes = 0, "image.stack_bytes");
    }

    #[test]
    fn a_store_leaves_room_for_vectors_and_code() {
        let first = Region { origin: 0x0800_0000, bytes: 0x4000 };
        refused(|board| board.flash.store = Some(first), "image.flash_bytes");
        refused(|board| board.image.flash_bytes = 0x1_0000, "image.flash_bytes");
    }

    #[test]
    fn a_board_with_a_chip_has_a_store_and_wires() {
        refused(|board| board.flash.store = None, "flash.store");
        refused(|board| board.wiring = None, "wiring");
        refused(|board| board.conversion = None, "conversion");
        let mut emulated = board();
        (emulated.chip, emulated.flash.store, emulated.wiring) = (None, None, None);
        check(&emulated).unwrap();
    }
}
