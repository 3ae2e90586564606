//! The store over the flash of the virtual board, which has true NOR rules.

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlash;
use massline_firmware::store::{MAX_RESULT, RESULTS, Store};
use massline_shared::layout::{Axis, Dof, Hit, RigLayout, Sign, TestSettings};
use massline_shared::protocol::message::Reason;
use massline_shared::signal::Calibration;
use massline_virtual::flash::{Flash, FlashBacking, PAGE_BYTES};

fn open(backing: &FlashBacking) -> Store<Flash> {
    let mut store = Store::new(Flash::open(backing).unwrap());
    block_on(store.open());
    store
}

fn layout(title: &str) -> RigLayout {
    let dof = Dof { node: 4, sign: Sign::Plus, axis: Axis::X };
    RigLayout {
        title: title.try_into().unwrap(),
        gravity: None,
        sensors: heapless::Vec::new(),
        hits: [Hit { dof, position: [0.1, 0.2, 0.3], direction: [1.0, 0.0, 0.0] }]
            .into_iter()
            .collect(),
        test: TestSettings::default(),
    }
}

/// A result's bytes that are its own and of its own length.
fn bytes_of(number: u32) -> Vec<u8> {
    let length = 300 + 531 * (number as usize % RESULTS);
    (0..length).map(|i| (i as u32 * 7 + number * 13) as u8).collect()
}

fn read_whole(store: &mut Store<Flash>, number: u32, piece: usize) -> Vec<u8> {
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
    let mut calibration = Calibration::default();
    calibration.channels[3].sensitivity *= 1.01;
    let mut store = open(&flash);
    block_on(async {
        store.put_layout(&layout("first")).await.unwrap();
        store.put_layout(&layout("second")).await.unwrap();
        store.put_calibration(&calibration).await.unwrap();
        store.put_result(&bytes_of(1), 77, 1.25).await.unwrap();
    });
    drop(store);
    let mut store = open(&flash);
    assert_eq!(block_on(store.layout()), Some(layout("second")));
    assert_eq!(block_on(store.calibration()), Some(calibration));
    let entry = store.find(1).unwrap().entry;
    assert_eq!((entry.layout_hash, entry.mass), (77, 1.25));
    for piece in [1, 100, 512, 1024, 4000] {
        assert_eq!(read_whole(&mut store, 1, piece), bytes_of(1), "pieces of {piece}");
    }
}

#[test]
fn a_full_store_says_so_and_has_room_again_after_a_deletion() {
    let flash = FlashBacking::default();
    let mut store = open(&flash);
    for number in 1..=RESULTS as u32 {
        assert_eq!(block_on(store.put_result(&bytes_of(number), 0, 1.0)), Ok(number));
    }
    assert!(store.is_full());
    assert_eq!(block_on(store.put_result(&[1], 0, 1.0)), Err(Reason::StoreFull));
    assert_eq!(block_on(store.delete_result(3)), Ok(()));
    assert_eq!(block_on(store.delete_result(3)), Err(Reason::NotFound));
    let next = RESULTS as u32 + 1;
    assert_eq!(block_on(store.put_result(&bytes_of(next), 0, 1.0)), Ok(next));
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
        let number = block_on(store.put_result(&bytes_of(round), 0, 1.0)).unwrap();
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
    assert_eq!(block_on(store.put_result(&bytes_of(1), 0, 1.0)), Ok(1));
    assert_eq!(read_whole(&mut open(&flash), 1, 1024), bytes_of(1));
}

#[test]
fn the_longest_result_is_kept_and_a_longer_one_refused() {
    let mut store = open(&FlashBacking::default());
    let bytes: Vec<u8> = (0..MAX_RESULT).map(|i| i as u8).collect();
    assert_eq!(block_on(store.put_result(&bytes, 0, 1.0)), Ok(1));
    assert_eq!(read_whole(&mut store, 1, 1024), bytes);
    let longer = vec![0; MAX_RESULT + 1];
    assert_eq!(block_on(store.put_result(&longer, 0, 1.0)), Err(Reason::StoreFull));
}

fn raw_capacity(flash: &Flash) -> usize {
    use embedded_storage_async::nor_flash::ReadNorFlash;
    flash.capacity()
}
