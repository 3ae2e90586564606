use super::*;
use embassy_futures::block_on;

fn flash() -> Flash {
    Flash::open(&FlashBacking::default()).unwrap()
}

fn read(flash: &mut Flash, offset: u32) -> [u8; 8] {
    let mut bytes = [0; 8];
    block_on(flash.read(offset, &mut bytes)).unwrap();
    bytes
}

#[test]
fn new_flash_is_erased() {
    assert_eq!(read(&mut flash(), (FLASH_BYTES - 8) as u32), [0xFF; 8]);
}

#[test]
fn a_write_clears_bits_and_cannot_set_them() {
    let mut flash = flash();
    block_on(flash.write(8, &[0xF0; 4])).unwrap();
    block_on(flash.write(8, &[0x30; 4])).unwrap();
    assert_eq!(block_on(flash.write(8, &[0x31, 0x30, 0x30, 0x30])), Err(FlashError::NotErased));
    assert_eq!(read(&mut flash, 8), [0x30, 0x30, 0x30, 0x30, 0xFF, 0xFF, 0xFF, 0xFF]);
}

#[test]
fn an_erase_sets_its_pages_and_no_others() {
    let mut flash = flash();
    for page in 0..4 {
        block_on(flash.write(page * 4096, &[0; 4096])).unwrap();
    }
    block_on(flash.erase(4096, 3 * 4096)).unwrap();
    for (page, expected) in [(0, 0), (1, 0xFF), (2, 0xFF), (3, 0)] {
        assert_eq!(read(&mut flash, page * 4096), [expected; 8], "page {page}");
        assert_eq!(read(&mut flash, page * 4096 + 4088), [expected; 8], "page {page}");
    }
}

#[test]
fn what_is_not_aligned_or_beyond_the_end_is_refused() {
    let mut flash = flash();
    let end = FLASH_BYTES as u32;
    assert_eq!(block_on(flash.write(2, &[0; 4])), Err(FlashError::NotAligned));
    assert_eq!(block_on(flash.write(4, &[0; 3])), Err(FlashError::NotAligned));
    assert_eq!(block_on(flash.write(end, &[0; 4])), Err(FlashError::OutOfBounds));
    assert_eq!(block_on(flash.erase(0, 100)), Err(FlashError::NotAligned));
    assert_eq!(block_on(flash.erase(4096, 0)), Err(FlashError::OutOfBounds));
    assert_eq!(block_on(flash.erase(0, end + 4096)), Err(FlashError::OutOfBounds));
    assert_eq!(block_on(flash.read(end - 4, &mut [0; 8])), Err(FlashError::OutOfBounds));
}

#[test]
fn a_file_keeps_its_content_when_the_rig_starts_again() {
    let folder = tempfile::tempdir().unwrap();
    let backing = FlashBacking::File(folder.path().join("flash.bin"));
    let mut flash = Flash::open(&backing).unwrap();
    block_on(flash.write(4096, &[1, 2, 3, 4, 5, 6, 7, 8])).unwrap();
    block_on(flash.write(8192, &[0; 8])).unwrap();
    block_on(flash.erase(8192, 12288)).unwrap();
    drop(flash);
    let mut flash = Flash::open(&backing).unwrap();
    assert_eq!(read(&mut flash, 4096), [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(read(&mut flash, 8192), [0xFF; 8]);
}

#[test]
fn memory_keeps_its_content_when_the_rig_starts_again() {
    let backing = FlashBacking::default();
    block_on(Flash::open(&backing).unwrap().write(0, &[9; 8])).unwrap();
    assert_eq!(read(&mut Flash::open(&backing).unwrap(), 0), [9; 8]);
}

#[test]
fn a_copy_of_flash_goes_its_own_way() {
    let memory = FlashMemory::default();
    let copy = memory.copied();
    block_on(Flash::open(&FlashBacking::Memory(copy)).unwrap().write(0, &[9; 8])).unwrap();
    assert_eq!(read(&mut Flash::open(&FlashBacking::Memory(memory)).unwrap(), 0), [0xFF; 8]);
}

#[test]
fn a_file_serves_one_rig_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let backing = FlashBacking::File(folder.path().join("flash.bin"));
    let _first = Flash::open(&backing).unwrap();
    assert!(matches!(Flash::open(&backing), Err(FlashOpenError::InUse { .. })));
}

#[test]
fn a_file_of_another_length_is_refused_and_not_touched() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.txt");
    std::fs::write(&path, "not flash").unwrap();
    let error = Flash::open(&FlashBacking::File(path.clone())).unwrap_err();
    assert!(matches!(error, FlashOpenError::WrongLength { found: 9, .. }));
    assert_eq!(std::fs::read_to_string(path).unwrap(), "not flash");
}

/// What a chip's flash holds after a write of `new` over erased flash was cut, for many seeds.
fn torn_words<C: Chip>(new: &[u8]) -> Vec<Result<Vec<u8>, FlashError>> {
    let torn = |seed| {
        let memory = FlashMemory::of::<C>();
        let mut flash = ChipFlash::<C>::over(&memory);
        memory.cut_power(Cut { after: 1, seed });
        assert_eq!(block_on(flash.write(0, new)), Err(FlashError::PowerCut));
        assert_eq!(block_on(flash.read(0, &mut [0; 8])), Err(FlashError::PowerCut));
        assert!(!memory.has_power());
        let mut flash = ChipFlash::<C>::over(&memory);
        let mut word = vec![0; C::WORD];
        block_on(flash.read(0, &mut word)).unwrap();
        assert_eq!(word, new[..C::WORD], "the word before the cut");
        block_on(flash.read(2 * C::WORD as u32, &mut word)).unwrap();
        assert!(word.iter().all(|&byte| byte == 0xFF), "the word after the cut");
        block_on(flash.read(C::WORD as u32, &mut word)).map(|()| word)
    };
    (0..64).map(torn).collect()
}

#[test]
fn a_cut_write_leaves_any_of_the_bits_that_it_was_to_clear() {
    let left = torn_words::<F411>(&[0x5A; 12]);
    let words: Vec<_> = left.into_iter().map(|word| word.unwrap()).collect();
    assert!(words.iter().flatten().all(|byte| byte & 0x5A == 0x5A), "no other bit is cleared");
    assert!(words.contains(&vec![0xFF; 4]) && words.contains(&vec![0x5A; 4]));
    assert!(words.iter().any(|word| word[0] != 0xFF && word[0] != 0x5A));
}

#[test]
fn a_torn_double_word_cannot_be_read_until_its_page_is_erased() {
    let left = torn_words::<G474>(&[0x5A; 24]);
    assert!(left.contains(&Err(FlashError::Torn)));
    assert!(left.contains(&Ok(vec![0xFF; 8])) && left.contains(&Ok(vec![0x5A; 8])));
    let memory = FlashMemory::of::<G474>();
    let mut flash = ChipFlash::<G474>::over(&memory);
    let seed = left.iter().position(|word| word.is_err()).unwrap() as u64;
    memory.cut_power(Cut { after: 0, seed });
    block_on(flash.write(8, &[0x5A; 8])).unwrap_err();
    let mut flash = ChipFlash::<G474>::over(&memory);
    assert_eq!(block_on(flash.read(0, &mut [0; 64])), Err(FlashError::Torn));
    assert_eq!(block_on(flash.write(8, &[0; 8])), Err(FlashError::NotErased));
    block_on(flash.erase(0, G474::PAGE as u32)).unwrap();
    block_on(flash.read(0, &mut [0; 64])).unwrap();
    assert_eq!(memory.erases()[..2], [1, 0]);
}

#[test]
fn a_double_word_is_written_once_even_where_no_bit_changes() {
    let mut flash = ChipFlash::<G474>::over(&FlashMemory::of::<G474>());
    block_on(flash.write(0, &[0xFF; 8])).unwrap();
    assert_eq!(block_on(flash.write(0, &[0xFF; 8])), Err(FlashError::NotErased));
}

#[test]
fn a_cut_erase_touches_its_page_alone_and_counts_as_none() {
    let mut states = [false; 2];
    for seed in 0..32 {
        let memory = FlashMemory::of::<G474>();
        let mut flash = ChipFlash::<G474>::over(&memory);
        for page in 0..3 {
            block_on(flash.write(page * 2048, &[0; 2048])).unwrap();
        }
        memory.cut_power(Cut { after: 0, seed });
        assert_eq!(block_on(flash.erase(2048, 4096)), Err(FlashError::PowerCut));
        let mut flash = ChipFlash::<G474>::over(&memory);
        for page in [0, 2] {
            let mut bytes = [1; 2048];
            block_on(flash.read(page * 2048, &mut bytes)).unwrap();
            assert_eq!(bytes, [0; 2048]);
        }
        states[usize::from(block_on(flash.read(2048, &mut [0; 2048])).is_ok())] = true;
        assert_eq!(memory.erases()[1], 0);
    }
    assert_eq!(states, [true; 2], "readable and not");
}

#[test]
fn noted_steps_give_the_same_flash_again_and_can_be_cut() {
    let memory = FlashMemory::of::<F411>();
    let mut flash = ChipFlash::<F411>::over(&memory);
    block_on(flash.write(0, &[1; 8])).unwrap();
    let (before, begun) = (memory.copied(), memory.steps());
    memory.note_steps();
    block_on(flash.write(8, &[0x5A; 12])).unwrap();
    block_on(flash.erase(0, F411::PAGE as u32)).unwrap();
    block_on(flash.write(4, &[3; 4])).unwrap();
    let steps = memory.noted_steps();
    assert_eq!(steps.len() as u64, memory.steps() - begun);
    let content = |memory: &FlashMemory| memory.with(|cells| cells.bytes(0, F411::BYTES).to_vec());
    let again = before.copied();
    steps.iter().for_each(|step| again.repeat(step).unwrap());
    assert_eq!(content(&again), content(&memory));
    // As a write of the chip that is cut at its third word.
    let [noted, written] = [before.copied(), before.copied()];
    steps[..2].iter().for_each(|step| noted.repeat(step).unwrap());
    noted.cut_power(Cut { after: 0, seed: 7 });
    assert_eq!(noted.repeat(&steps[2]), Err(FlashError::PowerCut));
    let mut flash = ChipFlash::<F411>::over(&written);
    written.cut_power(Cut { after: 2, seed: 7 });
    assert_eq!(block_on(flash.write(8, &[0x5A; 12])), Err(FlashError::PowerCut));
    assert_eq!(content(&noted), content(&written));
    assert_eq!(noted.noted_steps(), []);
}
