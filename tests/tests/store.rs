//! The store over the flash of the virtual board, which has true NOR rules.

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use massline_firmware::store::{MAX_RESULT, RESULTS, Store};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{Axis, Dof, Hit, RigLayout, Sign};
use massline_shared::protocol::message::{Measured, Reason};
use massline_virtual::flash::{Flash, FlashBacking, FlashError, PAGE_BYTES};
use sequential_storage::cache::Cache;
use sequential_storage::map::{MapConfig, MapStorage};
use serde::Serialize;

fn open(backing: &FlashBacking) -> Store<Flash> {
    open_over(Flash::open(backing).unwrap())
}

fn open_over<F: NorFlash>(flash: F) -> Store<F> {
    let mut store = Store::new(flash);
    block_on(store.open());
    store
}

const MASS: Measured = Measured { value: 1.25, sigma: Some(0.01) };

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

/// A result's bytes that are its own and of its own length.
fn bytes_of(number: u32) -> Vec<u8> {
    let length = 300 + 531 * (number as usize % RESULTS);
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
        store.put_result(&bytes_of(1), 77, Some(MASS)).await.unwrap();
    });
    drop(store);
    let mut store = open(&flash);
    assert_eq!(block_on(store.layout()), Some(layout("second")));
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
        assert_eq!(block_on(store.put_result(&bytes_of(number), 0, None)), Ok(number));
    }
    assert!(store.is_full());
    assert_eq!(block_on(store.put_result(&[1], 0, None)), Err(Reason::StoreFull));
    assert_eq!(block_on(store.delete_result(3)), Ok(()));
    assert_eq!(block_on(store.delete_result(3)), Err(Reason::NotFound));
    let next = RESULTS as u32 + 1;
    assert_eq!(block_on(store.put_result(&bytes_of(next), 0, None)), Ok(next));
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
        let number = block_on(store.put_result(&bytes_of(round), 0, None)).unwrap();
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
    assert_eq!(block_on(store.layout()), None);
    assert_eq!(block_on(store.put_result(&bytes_of(1), 0, None)), Ok(1));
    assert_eq!(read_whole(&mut open(&flash), 1, 1024), bytes_of(1));
}

/// Flash on a bus that fails once in a while.
struct Failing {
    flash: Flash,
    /// Operations until the one that fails, counted down.
    reads: Option<usize>,
    writes: Option<usize>,
    /// Of a write that fails, this many bytes have reached the flash.
    torn: usize,
    /// After a write that failed all others fail.
    worn: bool,
}

impl Failing {
    fn over(backing: &FlashBacking) -> Self {
        Self {
            flash: Flash::open(backing).unwrap(),
            reads: None,
            writes: None,
            torn: 0,
            worn: false,
        }
    }
}

/// True when it is this operation that fails.
fn due(left: &mut Option<usize>) -> bool {
    let now = *left == Some(0);
    *left = left.and_then(|left| left.checked_sub(1));
    now
}

impl ErrorType for Failing {
    type Error = FlashError;
}

impl ReadNorFlash for Failing {
    const READ_SIZE: usize = Flash::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        if due(&mut self.reads) {
            return Err(FlashError::File);
        }
        self.flash.read(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl NorFlash for Failing {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.flash.erase(from, to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        if due(&mut self.writes) {
            self.flash.write(offset, &bytes[..self.torn.min(bytes.len())]).await?;
            if self.worn {
                self.writes = Some(0);
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
    block_on(store.put_result(&bytes_of(1), 77, None)).unwrap();
    drop(store);
    // The first read, and some of those that follow until the index is found.
    for read in [0, 1, 2, 5] {
        let mut store = open_over(Failing { reads: Some(read), ..Failing::over(&flash) });
        assert!(store.results().is_empty(), "read {read}");
        assert_eq!(store.failures(), 1, "read {read}");
        assert_eq!(block_on(store.put_result(&[1], 0, None)), Err(Reason::StoreFailed));
        assert_eq!(block_on(store.put_layout(&encoded(&layout("lost")))), Err(Reason::StoreFailed));
        drop(store);
        let mut store = open(&flash);
        assert_eq!(block_on(store.layout()), Some(layout("kept")), "read {read}");
        assert_eq!(read_whole(&mut store, 1, 1024), bytes_of(1), "read {read}");
        assert_eq!(store.next_number(), 2);
    }
}

#[test]
fn a_write_that_fails_is_done_again_and_shows_no_half_of_a_result() {
    let mut disturbed = 0;
    for (write, torn) in (0..12).flat_map(|write| [(write, 0), (write, 4), (write, 64)]) {
        let flash = FlashBacking::default();
        block_on(open(&flash).put_result(&bytes_of(1), 0, None)).unwrap();
        let mut store = open_over(Failing { writes: Some(write), torn, ..Failing::over(&flash) });
        let stored = block_on(store.put_result(&bytes_of(2), 0, None));
        assert_eq!(stored, Ok(2), "write {write}, {torn} bytes of it");
        disturbed += usize::from(store.failures() > 0);
        for store in [&mut store, &mut open_over(Failing::over(&flash))] {
            assert_eq!(store.results().len(), 2);
            for number in [1, 2] {
                assert_eq!(read_whole(store, number, 1024), bytes_of(number), "write {write}");
            }
        }
    }
    // Three chunks and the index take at least two writes each.
    assert!(disturbed >= 16, "{disturbed}");
}

#[test]
fn flash_that_takes_no_more_writes_leaves_the_list_of_results_as_it_was() {
    let flash = FlashBacking::default();
    block_on(open(&flash).put_result(&bytes_of(1), 0, None)).unwrap();
    // Three chunks and the index take at least two writes each.
    for write in 0..8 {
        let worn = |write| Failing { writes: Some(write), worn: true, ..Failing::over(&flash) };
        let mut store = open_over(worn(write));
        let stored = block_on(store.put_result(&bytes_of(2), 0, None));
        assert_eq!(stored, Err(Reason::StoreFailed), "write {write}");
        assert_eq!((store.results().len(), store.next_number()), (1, 2), "write {write}");
        let mut store = open_over(worn(0));
        let before = store.results().to_vec();
        assert_eq!(block_on(store.delete_result(1)), Err(Reason::StoreFailed));
        assert_eq!(store.results(), before);
        assert_eq!(read_whole(&mut store, 1, 1024), bytes_of(1), "write {write}");
    }
}

/// Writes an item straight into the map of the store.
fn put_raw(backing: &FlashBacking, key: u16, bytes: &[u8]) {
    let flash = Flash::open(backing).unwrap();
    let config = MapConfig::new(0..flash.capacity() as u32);
    let mut map = MapStorage::<u16, _, _>::new(flash, config, Cache::new_uncached());
    block_on(map.store_item(&mut [0; 256], &key, &bytes)).unwrap();
}

#[test]
fn an_index_of_other_firmware_is_passed_over() {
    const INDEX: u16 = 3;
    let flash = FlashBacking::default();
    put_raw(&flash, INDEX, &[0xEE, 1, 2, 3]);
    let mut store = open(&flash);
    assert_eq!((store.results().len(), store.failures()), (0, 0));
    assert_eq!(block_on(store.put_result(&bytes_of(1), 0, None)), Ok(1));
    assert_eq!(read_whole(&mut open(&flash), 1, 1024), bytes_of(1));
}

#[test]
fn an_index_that_cannot_be_read_does_not_begin_another_one_over_the_old_chunks() {
    const INDEX: u16 = 3;
    const FORMAT: u8 = 3;
    let flash = FlashBacking::default();
    let mut store = open(&flash);
    block_on(store.put_result(&bytes_of(1), 0, None)).unwrap();
    block_on(store.put_layout(&encoded(&layout("old")))).unwrap();
    drop(store);
    // A last number that never ends.
    put_raw(&flash, INDEX, &[FORMAT, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]);
    let mut store = open(&flash);
    assert_eq!((store.results().len(), store.failures()), (0, 1));
    assert_eq!(block_on(store.layout()), None, "the region is erased");
    assert_eq!(block_on(store.put_result(&bytes_of(5), 0, None)), Ok(1));
    assert_eq!(read_whole(&mut open(&flash), 1, 1024).len(), bytes_of(5).len());
}

#[test]
fn the_longest_result_is_kept_and_a_longer_one_refused() {
    let mut store = open(&FlashBacking::default());
    let bytes: Vec<u8> = (0..MAX_RESULT).map(|i| i as u8).collect();
    assert_eq!(block_on(store.put_result(&bytes, 0, None)), Ok(1));
    assert_eq!(read_whole(&mut store, 1, 1024), bytes);
    let longer = vec![0; MAX_RESULT + 1];
    assert_eq!(block_on(store.put_result(&longer, 0, None)), Err(Reason::StoreFull));
}

fn raw_capacity(flash: &Flash) -> usize {
    flash.capacity()
}
