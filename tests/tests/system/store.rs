//! The store on the flash of the virtual board, which follows the rules of NOR flash.

use std::path::Path;

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use massline_firmware::store::{
    CampaignSize, LAYOUTS, MAX_DOF, MAX_PROGRESS, MAX_RESULT, RESULTS, Store, StoreError,
};
use massline_protocol::message::EstimatedMass;
use massline_protocol::{LayoutHash, MAX_LAYOUT, crc32};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{Axis, Dof, Hit, RIG_HITS, RIG_SENSORS, RigLayout, Sensor, Sign};
use massline_virtual::flash::{
    Chip, ChipFlash, F411, Flash, FlashBacking, FlashError, FlashMemory, G474, PAGE_BYTES, W25q,
};
use serde::Serialize;

fn open(backing: &FlashBacking) -> Store<Flash> {
    open_over(Flash::open(backing).unwrap())
}

fn open_over<F: NorFlash>(flash: F) -> Store<F> {
    let mut store = Store::new(flash, || false);
    block_on(store.open());
    store
}

const MASS: EstimatedMass = EstimatedMass { value: 1.25, sigma: Some(0.01) };

fn encoded<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).unwrap()
}

fn layout(title: &str) -> RigLayout {
    let dof = Dof { node: 4, sign: Sign::Plus, axis: Axis::X };
    RigLayout {
        title: title.try_into().unwrap(),
        hits: [Hit::new(dof, [0.1, 0.2, 0.3], [1.0, 0.0, 0.0])].into_iter().collect(),
        ..RigLayout::default()
    }
}

/// A campaign by mass lines, which stores no other lines.
fn mass_lines(dofs: usize) -> CampaignSize {
    CampaignSize { dofs, lines: 0 }
}

/// The bytes of a result; length and content depend on its number.
fn bytes_of(number: u32) -> Vec<u8> {
    let length = 300 + 531 * (number as usize % 8);
    (0..length).map(|i| (i as u32 * 7 + number * 13) as u8).collect()
}

fn read_whole<F: NorFlash>(store: &mut Store<F>, number: u32, piece: usize) -> Vec<u8> {
    let kept = store.find(number).expect("kept");
    let mut bytes = Vec::new();
    let mut chunk = vec![0; piece];
    while bytes.len() < kept.entry.length as usize {
        let read = block_on(store.read_result(&kept, bytes.len(), &mut chunk)).unwrap();
        bytes.extend_from_slice(&chunk[..read]);
    }
    bytes
}

/// The layout in use.
fn kept_layout<F: NorFlash>(store: &mut Store<F>) -> Option<RigLayout> {
    let mut room = [0; MAX_LAYOUT];
    block_on(store.layout(&mut room)).map(|bytes| postcard::from_bytes(bytes).unwrap())
}

#[test]
fn bytes_that_are_more_than_a_layout_are_not_kept() {
    let flash = FlashBacking::default();
    let mut store = open(&flash);
    let mut bytes = encoded(&layout("whole"));
    bytes.push(0);
    assert_eq!(block_on(store.put_layout(&bytes)), Err(StoreError::Malformed));
    assert_eq!(block_on(store.put_layout(&bytes[..9])), Err(StoreError::Malformed));
    assert_eq!((kept_layout(&mut store), store.layouts().len()), (None, 0));
}

#[test]
fn layout_calibration_and_results_survive_a_restart() {
    let flash = FlashBacking::default();
    let mut calibration = CalibrationRecord::default();
    calibration.calibration.channels[3].sensitivity *= 1.01;
    calibration.date = "2026-03-14".try_into().unwrap();
    let mut store = open(&flash);
    block_on(async {
        store.put_layout(&encoded(&layout("first"))).await.unwrap();
        store.put_layout(&encoded(&layout("second"))).await.unwrap();
        store.put_calibration(&encoded(&calibration)).await.unwrap();
        store.put_result(&bytes_of(1)[..], 77, Some(MASS)).await.unwrap();
    });
    drop(store);
    let mut store = open(&flash);
    assert_eq!(kept_layout(&mut store), Some(layout("second")));
    assert_eq!(block_on(store.calibration()), Some(calibration));
    let entry = store.find(1).unwrap().entry;
    assert_eq!((entry.layout_hash, entry.mass), (77, Some(MASS)));
    for piece in [1, 100, 512, 1024, 4000] {
        assert_eq!(read_whole(&mut store, 1, piece), bytes_of(1), "pieces of {piece}");
    }
}

#[test]
fn a_full_store_says_so_and_has_room_again_after_a_deletion() {
    let flash = FlashBacking::default();
    let mut store = open(&flash);
    for number in 1..=RESULTS as u32 {
        assert_eq!(block_on(store.put_result(&bytes_of(number)[..], 0, None)), Ok(number));
    }
    assert!(block_on(store.is_full(mass_lines(1))));
    assert_eq!(block_on(store.put_result(&[1][..], 0, None)), Err(StoreError::Full));
    assert_eq!(block_on(store.delete_result(3)), Ok(()));
    assert_eq!(block_on(store.delete_result(3)), Err(StoreError::NotFound));
    let next = RESULTS as u32 + 1;
    assert_eq!(block_on(store.put_result(&bytes_of(next)[..], 0, None)), Ok(next));
    let mut store = open(&flash);
    for number in (1..=next).filter(|&number| number != 3) {
        assert_eq!(read_whole(&mut store, number, 700), bytes_of(number));
    }
}

#[test]
fn a_number_is_never_given_twice() {
    let flash = FlashBacking::default();
    for round in 1..=40 {
        let mut store = open(&flash);
        let number = block_on(store.put_result(&bytes_of(round)[..], 0, None)).unwrap();
        assert_eq!(number, round);
        block_on(store.delete_result(number)).unwrap();
    }
}

#[test]
fn flash_that_holds_something_else_becomes_an_empty_store() {
    let flash = FlashBacking::default();
    let mut raw = Flash::open(&flash).unwrap();
    let page: Vec<u8> = (0..PAGE_BYTES).map(|i| (i * i % 251) as u8).collect();
    for at in (0..raw_capacity(&raw)).step_by(PAGE_BYTES) {
        block_on(raw.write(at as u32, &page)).unwrap();
    }
    drop(raw);
    let mut store = open(&flash);
    assert!(store.results().is_empty());
    assert_eq!(kept_layout(&mut store), None);
    assert_eq!(block_on(store.put_result(&bytes_of(1)[..], 0, None)), Ok(1));
    assert_eq!(read_whole(&mut open(&flash), 1, 1024), bytes_of(1));
}

/// Flash on a bus on which operations fail.
struct FailingFlash {
    flash: Flash,
    /// Number of operations before the one that fails.
    reads: Option<usize>,
    writes: Option<usize>,
    /// Bytes of a failing write that reach the flash.
    torn: usize,
    /// Number of writes that fail after a failed one.
    worn: usize,
    /// Every read fails.
    dead: bool,
}

impl FailingFlash {
    fn over(backing: &FlashBacking) -> Self {
        Self {
            flash: Flash::open(backing).unwrap(),
            reads: None,
            writes: None,
            torn: 0,
            worn: 0,
            dead: false,
        }
    }
}

/// Counts down; true when this operation is the one that fails.
fn due(left: &mut Option<usize>) -> bool {
    let now = *left == Some(0);
    *left = left.and_then(|left| left.checked_sub(1));
    now
}

impl ErrorType for FailingFlash {
    type Error = FlashError;
}

impl ReadNorFlash for FailingFlash {
    const READ_SIZE: usize = Flash::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        if self.dead || due(&mut self.reads) {
            return Err(FlashError::File);
        }
        self.flash.read(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl NorFlash for FailingFlash {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.flash.erase(from, to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        if due(&mut self.writes) {
            self.flash.write(offset, &bytes[..self.torn.min(bytes.len())]).await?;
            if self.worn > 0 {
                (self.worn, self.writes) = (self.worn - 1, Some(0));
            }
            return Err(FlashError::File);
        }
        self.flash.write(offset, bytes).await
    }
}

#[test]
fn flash_that_does_not_answer_at_the_start_keeps_its_content_and_takes_no_writes() {
    let flash = FlashBacking::default();
    let mut store = open(&flash);
    block_on(store.put_layout(&encoded(&layout("kept")))).unwrap();
    block_on(store.put_result(&bytes_of(1)[..], 77, None)).unwrap();
    drop(store);
    let mut store = open_over(FailingFlash { dead: true, ..FailingFlash::over(&flash) });
    assert!(store.results().is_empty());
    assert_eq!(store.failures(), 1);
    assert_eq!(block_on(store.put_result(&[1][..], 0, None)), Err(StoreError::Failed));
    assert_eq!(block_on(store.put_layout(&encoded(&layout("lost")))), Err(StoreError::Failed));
    drop(store);
    let mut store = open(&flash);
    assert_eq!(kept_layout(&mut store), Some(layout("kept")));
    assert_eq!(read_whole(&mut store, 1, 1024), bytes_of(1));
    assert_eq!(store.next_number(), 2);
}

#[test]
fn a_read_that_fails_once_is_done_again() {
    let flash = FlashBacking::default();
    block_on(open(&flash).put_result(&bytes_of(1)[..], 77, None)).unwrap();
    for read in 0..200 {
        let mut store = open_over(FailingFlash { reads: Some(read), ..FailingFlash::over(&flash) });
        assert_eq!(read_whole(&mut store, 1, 1024), bytes_of(1), "read {read}");
        assert_eq!((store.failures(), store.next_number()), (0, 2), "read {read}");
    }
}

#[test]
fn a_write_that_fails_is_done_again_and_shows_no_half_of_a_result() {
    let mut disturbed = 0;
    for (write, torn) in (0..30).flat_map(|write| [(write, 0), (write, 4), (write, 64)]) {
        let flash = FlashBacking::default();
        block_on(open(&flash).put_result(&bytes_of(1)[..], 0, None)).unwrap();
        let mut store =
            open_over(FailingFlash { writes: Some(write), torn, ..FailingFlash::over(&flash) });
        let stored = block_on(store.put_result(&bytes_of(2)[..], 0, None));
        assert_eq!(stored, Ok(2), "write {write}, {torn} bytes of it");
        disturbed += usize::from(store.failures() > 0);
        for store in [&mut store, &mut open_over(FailingFlash::over(&flash))] {
            assert_eq!(store.results().len(), 2);
            for number in [1, 2] {
                assert_eq!(read_whole(store, number, 1024), bytes_of(number), "write {write}");
            }
        }
    }
    // The data and its update take one write per 64 bytes.
    assert!(disturbed >= 60, "{disturbed}");
}

#[test]
fn flash_that_takes_no_more_writes_leaves_the_list_of_results_as_it_was() {
    let flash = FlashBacking::default();
    block_on(open(&flash).put_result(&bytes_of(1)[..], 0, None)).unwrap();
    for write in 0..25 {
        let worn = |write| FailingFlash {
            writes: Some(write),
            worn: usize::MAX,
            ..FailingFlash::over(&flash)
        };
        let mut store = open_over(worn(write));
        let stored = block_on(store.put_result(&bytes_of(2)[..], 0, None));
        assert_eq!(stored, Err(StoreError::Failed), "write {write}");
        assert_eq!((store.results().len(), store.next_number()), (1, 2), "write {write}");
        let mut store = open_over(worn(0));
        let before = store.results().to_vec();
        assert_eq!(block_on(store.delete_result(1)), Err(StoreError::Failed));
        assert_eq!(store.results(), before);
        assert_eq!(read_whole(&mut store, 1, 1024), bytes_of(1), "write {write}");
    }
}

/// The first record of page 0 as written by a store of this format.
fn first_record(format: u32) -> Vec<u8> {
    let pages = (Flash::open(&FlashBacking::default()).unwrap().capacity() / PAGE_BYTES) as u32;
    let payload = [format, PAGE_BYTES as u32, pages].map(u32::to_le_bytes).concat();
    let front = [1, 0, payload.len() as u8, 0, 0, 0, 0, 0, 0, 0];
    let crc = crc32(&payload).to_le_bytes();
    let check = crc32(&[&front[..], &crc, &[0; 4]].concat()) as u16;
    [&front[..], &check.to_le_bytes(), &crc, &payload].concat()
}

#[test]
fn a_store_of_another_format_is_passed_over() {
    const FORMAT: u32 = 1;
    for (format, kept) in [(FORMAT, 1), (FORMAT - 1, 0), (FORMAT + 1, 0)] {
        let flash = FlashBacking::default();
        block_on(open(&flash).put_result(&bytes_of(1)[..], 0, None)).unwrap();
        // The same page with the number of another format.
        let mut raw = Flash::open(&flash).unwrap();
        let mut page = vec![0; PAGE_BYTES];
        block_on(raw.read(0, &mut page)).unwrap();
        let first = first_record(format);
        page[..first.len()].copy_from_slice(&first);
        block_on(raw.erase(0, PAGE_BYTES as u32)).unwrap();
        block_on(raw.write(0, &page)).unwrap();
        drop(raw);
        let mut store = open(&flash);
        assert_eq!((store.results().len(), store.failures()), (kept, 0), "format {format}");
        let number = block_on(store.put_result(&bytes_of(2)[..], 0, None)).unwrap();
        assert_eq!(number, kept as u32 + 1);
        assert_eq!(read_whole(&mut open(&flash), number, 1024), bytes_of(2));
    }
}

#[test]
fn a_new_layout_replaces_the_one_used_longest_ago() {
    let flash = FlashBacking::default();
    let mut store = open(&flash);
    let titles = ["a", "b", "c", "d", "e"];
    let hash = |title: &str| layout(title).hash();
    for title in &titles[..LAYOUTS] {
        block_on(store.put_layout(&encoded(&layout(title)))).unwrap();
    }
    block_on(store.use_layout(hash("a"))).unwrap();
    let mut store = open(&flash);
    assert_eq!(kept_layout(&mut store), Some(layout("a")));
    block_on(store.put_layout(&encoded(&layout("e")))).unwrap();
    assert_eq!(block_on(store.use_layout(hash("b"))), Err(StoreError::NotFound), "it gave way");
    // A layout that is already stored is only taken into use.
    block_on(store.put_layout(&encoded(&layout("c")))).unwrap();
    for mut store in [store, open(&flash)] {
        let mut kept: Vec<_> = store.layouts().to_vec();
        kept.sort_by_key(|kept| kept.title.clone());
        let shown: Vec<_> =
            kept.iter().map(|kept| (kept.title.as_str(), kept.hash, kept.in_use)).collect();
        let expected = ["a", "c", "d", "e"].map(|title| (title, hash(title), title == "c"));
        assert_eq!(shown, expected);
        assert_eq!(kept_layout(&mut store), Some(layout("c")));
    }
}

#[test]
fn the_progress_of_a_campaign_is_kept_until_its_result() {
    let flash = FlashBacking::default();
    let mut store = open(&flash);
    let mut room = [0; MAX_DOF];
    assert!(!store.has_progress());
    for (place, index) in [4, 0, 2].into_iter().enumerate() {
        block_on(store.put_dof(index, &[index; 300][..])).unwrap();
        block_on(store.put_progress(&[place as u8; 70][..])).unwrap();
    }
    let mut store = open(&flash);
    assert!(store.has_progress());
    assert_eq!(block_on(store.progress(&mut room)), Some(&[2; 70][..]));
    for (place, index) in [4, 0, 2].into_iter().enumerate() {
        let dof = block_on(store.dof(place, &mut room));
        assert_eq!(dof, Some(&[index; 300][..]), "in the order of their closing");
    }
    assert_eq!(block_on(store.dof(3, &mut room)), None);
    block_on(store.put_result(&bytes_of(1)[..], 0, None)).unwrap();
    block_on(store.put_dof(1, &[9; 10][..])).unwrap();
    let mut store = open(&flash);
    // There is a DOF of the next campaign, whose progress is not stored yet.
    assert_eq!(block_on(store.progress(&mut room)), None);
    assert_eq!(block_on(store.dof(0, &mut room)), Some(&[9; 10][..]));
    assert_eq!(block_on(store.dof(1, &mut room)), None);
    block_on(store.clear_progress()).unwrap();
    assert!(!store.has_progress() && !open(&flash).has_progress());
}

/// A layout with the largest number of sensors and hits that the rig supports.
fn full_layout(title: &str) -> RigLayout {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let hit = layout(title).hits[0];
    RigLayout {
        sensors: (0..RIG_SENSORS as u16).map(|node| Sensor::new(node, [0.1; 3], axes)).collect(),
        hits: (0..RIG_HITS).map(|_| hit).collect(),
        ..layout(title)
    }
}

/// Stores campaigns with the longest DOFs and results until the store reports that it is full; returns
/// the number of results in it.
fn fill<C: Chip>(dofs: usize) -> usize {
    let memory = FlashMemory::of::<C>();
    let mut store = open_over(ChipFlash::<C>::over(&memory));
    for title in ["a", "b", "c", "d"] {
        block_on(store.put_layout(&encoded(&full_layout(title)))).unwrap();
    }
    let longest = MAX_RESULT - (RIG_HITS - dofs) * MAX_DOF;
    while !block_on(store.is_full(mass_lines(dofs))) {
        for dof in 0..dofs as u8 {
            block_on(store.put_dof(dof, &[dof; MAX_DOF][..])).unwrap();
            block_on(store.put_progress(&[dof; MAX_PROGRESS][..])).unwrap();
        }
        block_on(store.put_result(&vec![7; longest][..], 0, None)).unwrap();
    }
    let results = store.results().len();
    // A full store can still switch the layout in use and delete a result.
    for round in 0..20 {
        block_on(store.use_layout(full_layout(["a", "b"][round % 2]).hash())).unwrap();
    }
    block_on(store.delete_result(1)).unwrap();
    assert_eq!(store.failures(), 0);
    assert_eq!(open_over(ChipFlash::<C>::over(&memory)).results().len(), results - 1);
    println!("{results} results of {longest} bytes");
    results
}

#[test]
fn a_campaign_that_may_begin_has_room_for_its_result() {
    // 48 KiB and 50 KiB, of which one page is free: 32 KiB and 48 KiB remain, minus the waste at the end of
    // each page. On the second there is room for more short results than the list has.
    for (dofs, f411, g474) in [(1, 17, RESULTS), (5, 7, 11), (RIG_HITS, 3, 4)] {
        let results = (fill::<F411>(dofs), fill::<G474>(dofs));
        assert!(results.0 >= f411 && results.1 >= g474, "{dofs} DOFs: {results:?}");
    }
}

#[test]
fn the_flash_of_the_tests_is_that_of_the_boards() {
    fn check<C: Chip>(name: &str, boards: &[massline_boards::Board]) {
        let board = boards.iter().find(|board| board.name == name).expect("the board exists");
        let store = board.flash.store.expect("it has a store").range();
        let pages =
            board.flash.each_sector().filter(|s| store.start <= s.start && s.end <= store.end);
        let pages: Vec<_> = pages.map(|sector| (sector.end - sector.start) as usize).collect();
        assert_eq!(pages, vec![C::PAGE; C::BYTES / C::PAGE], "{name}");
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let boards = massline_boards::boards(&root).unwrap();
    check::<F411>("blackpill-f411", &boards);
    check::<G474>("nucleo-g474re", &boards);
    check::<W25q>("pico2", &boards);
}

#[test]
fn the_longest_result_is_kept_and_a_longer_one_refused() {
    let mut store = open(&FlashBacking::default());
    let bytes: Vec<u8> = (0..MAX_RESULT).map(|i| i as u8).collect();
    assert_eq!(block_on(store.put_result(&bytes[..], 0, None)), Ok(1));
    assert_eq!(read_whole(&mut store, 1, 1024), bytes);
    let longer = vec![0; MAX_RESULT + 1];
    assert_eq!(block_on(store.put_result(&longer[..], 0, None)), Err(StoreError::Full));
}

fn raw_capacity(flash: &Flash) -> usize {
    flash.capacity()
}

#[test]
fn a_campaign_whose_end_the_flash_refused_does_not_mix_with_the_next() {
    let mut recovered = 0;
    for refused in 0..30 {
        let flash = FlashBacking::default();
        let mut store = open(&flash);
        block_on(store.put_dof(0, &[7; 10][..])).unwrap();
        block_on(store.put_progress(&[7; 10][..])).unwrap();
        drop(store);
        let flaky = FailingFlash { writes: Some(0), worn: refused, ..FailingFlash::over(&flash) };
        let mut store = open_over(flaky);
        if block_on(store.clear_progress()).is_ok() {
            continue;
        }
        assert!(!store.has_progress(), "the rig has ended it");
        // The end of the campaign was not stored: after a restart its progress is found again.
        assert!(open(&flash).has_progress());
        let kept = block_on(store.put_dof(3, &[8; 10][..])).is_ok()
            && block_on(store.put_progress(&[8; 10][..])).is_ok();
        if kept {
            recovered += 1;
            let (mut store, mut room) = (open(&flash), [0; MAX_DOF]);
            assert_eq!(block_on(store.dof(0, &mut room)), Some(&[8; 10][..]), "{refused} refused");
            assert_eq!(block_on(store.dof(1, &mut room)), None, "{refused} refused");
        }
    }
    assert!(recovered > 0, "no flash recovered in time");
}
