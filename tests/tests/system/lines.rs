//! Finished DOFs with lines: in the store of each board, and from there to the host.

use embassy_futures::block_on;
use massline_client::{Client, ClientError};
use massline_firmware::board::ScreenSetting;
use massline_firmware::store::{
    CampaignSize, DOFS, DofWithLines, LAYOUTS, MAX_DOF, MAX_LINES, MAX_LINES_HEAD, MAX_PROGRESS,
    MAX_RESULT_HEAD, RESULTS, Shortage, Source, Store, StoreError,
};
use massline_physics::Bench;
use massline_protocol::LayoutHash;
use massline_protocol::crc32;
use massline_protocol::lines::{CURRENT_CAMPAIGN, LinesId, split_dof};
use massline_protocol::message::{GetObjectInfo, ReadObject, Reason};
use massline_protocol::object::{
    ChunkRequest, DofResult, MAX_CHUNK, ObjectId, ObjectKind, SCATTER, StoredTrend,
};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{
    AttachedBody, Axis, Dof, Hit, MAX_ATTACHED, Prior, RIG_HITS, RIG_SENSORS, RigLayout, Sensor,
    Sign, Target,
};
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::nalgebra::Complex;
use massline_shared::signal::{CompactLines, RESPONSES, expand_response};
use massline_tests::campaign::{phase, scans, start, three_bar, wait_for};
use massline_virtual::flash::{
    Chip, ChipFlash, Cut, F411, FlashBacking, FlashMemory, G474, VirtualChip, W25q,
};
use massline_virtual::{VirtualRig, VirtualRigOptions};

type ChipStore<C> = Store<ChipFlash<C>>;

fn open<C: Chip>(memory: &FlashMemory) -> ChipStore<C> {
    let mut store = Store::new(ChipFlash::<C>::over(memory), || false);
    block_on(store.open());
    store
}

/// The head of a DOF with everything that a DOF can say.
fn head(index: u8) -> DofResult {
    DofResult {
        dof: Dof { node: u16::MAX, sign: Sign::Minus, axis: Axis::Z },
        index,
        hits: 5,
        band_hz: [0.5, 12.5],
        accelerance: [0.5; RESPONSES],
        noise: [0.001; RESPONSES],
        scatter: (0..SCATTER).map(|_| 1e-6).collect(),
        coherence: Some([0.999; RESPONSES]),
        trend: StoredTrend { mean: 400.0, squares: 1e5, products: [0.1; RESPONSES] },
        band_shift: [1e-4; RESPONSES],
    }
}

/// A line of a response; every one is different.
fn line(index: u8, response: usize, line: usize) -> Complex<f32> {
    let phase = 0.03 * (line * (response + 1)) as f32 + f32::from(index);
    Complex::from_polar(0.1 + line as f32, phase)
}

/// Stores a DOF of the campaign with the lines of all responses; returns its bytes.
fn put_dof<C: Chip>(store: &mut ChipStore<C>, index: u8) -> Result<Vec<u8>, StoreError> {
    let head = postcard::to_stdvec(&head(index)).unwrap();
    let lines = CompactLines::new(RESPONSES, |response, l| line(index, response, l)).unwrap();
    let dof = DofWithLines { head: &head, lines: &lines };
    let mut bytes = vec![0; dof.length()];
    dof.read(0, &mut bytes);
    assert_eq!(dof.checksum(), crc32(&bytes));
    block_on(store.put_dof(index, &dof)).map(|()| bytes)
}

fn read_dof<C: Chip>(store: &mut ChipStore<C>, number: u32, index: u8, piece: usize) -> Vec<u8> {
    let stored = store.dof_of_result(number, index).expect("stored");
    let mut bytes = Vec::new();
    let mut room = vec![0; piece];
    while bytes.len() < stored.length() {
        let read = block_on(store.read_dof(&stored, bytes.len(), &mut room)).unwrap();
        bytes.extend_from_slice(&room[..read]);
    }
    bytes
}

#[test]
fn the_lines_of_a_dof_are_read_until_its_result_is_deleted() {
    let memory = FlashMemory::default();
    let mut store = open::<VirtualChip>(&memory);
    let mut bytes = Vec::new();
    for index in [2, 0] {
        bytes.push(put_dof(&mut store, index).unwrap());
        block_on(store.put_progress(&[1; 70])).unwrap();
    }
    let mut store = open::<VirtualChip>(&memory);
    for (place, index) in [2, 0].into_iter().enumerate() {
        // A resumed campaign needs the head alone.
        let mut room = [0; MAX_DOF];
        let read = block_on(store.dof(place, &mut room)).unwrap();
        assert_eq!(postcard::from_bytes::<DofResult>(read).unwrap(), head(index));
        assert!(store.dof_of_campaign(index).unwrap().has_lines());
    }
    assert_eq!(store.dof_of_campaign(1), None);
    block_on(store.put_result(&[7; 300][..], 0, None)).unwrap();
    // Another campaign, without lines.
    block_on(store.put_dof(0, &[9; 300][..])).unwrap();
    block_on(store.put_progress(&[2; 70])).unwrap();
    block_on(store.put_result(&[8; 300][..], 0, None)).unwrap();
    for mut store in [store, open::<VirtualChip>(&memory)] {
        for (index, bytes) in [2, 0].into_iter().zip(&bytes) {
            for piece in [1, 100, 513, 1024, 6000] {
                assert_eq!(&read_dof(&mut store, 1, index, piece), bytes, "pieces of {piece}");
            }
            let (stored, responses) = split_dof::<DofResult>(bytes).unwrap();
            assert_eq!((stored, responses.len()), (head(index), RESPONSES));
            for (response, block) in responses.iter().enumerate() {
                let lines = expand_response::<f32>(block).unwrap();
                for (l, value) in lines.iter().enumerate() {
                    // Half a unit of the largest line, 127.1: 2^-8 of exponent -8.
                    let error = value - line(index, response, l);
                    assert!(
                        error.re.abs().max(error.im.abs()) <= 2_f32.powi(-9),
                        "{response}, {l}"
                    );
                }
            }
        }
        assert_eq!((store.dof_of_result(1, 1), store.dof_of_result(2, 0)), (None, None));
        assert_eq!((store.dof_of_campaign(0), store.has_progress()), (None, false));
    }
    let mut store = open::<VirtualChip>(&memory);
    let gone = store.dof_of_result(1, 2).unwrap();
    block_on(store.delete_result(1)).unwrap();
    for store in [&store, &open::<VirtualChip>(&memory)] {
        assert_eq!(store.dof_of_result(1, 2), None);
        assert!(store.find(2).is_some() && !store.has_progress());
    }
    // Its bytes are still in the flash until their page is opened again, but never wrong ones.
    let mut room = [0; MAX_CHUNK];
    let read = block_on(store.read_dof(&gone, 0, &mut room));
    assert!(
        read == Ok(MAX_CHUNK) && room == bytes[0][..MAX_CHUNK] || read == Err(StoreError::Failed)
    );
}

#[test]
fn a_dof_that_is_open_again_gives_its_room_to_the_next() {
    let memory = FlashMemory::of::<F411>();
    let mut store = open::<F411>(&memory);
    for round in 0..20 {
        block_on(store.reopen_dof(0)).unwrap();
        assert_eq!(store.dof_of_campaign(0), None, "{round}");
        for index in 0..5 {
            put_dof(&mut store, index).unwrap();
        }
        block_on(store.put_progress(&[round; 70])).unwrap();
        for index in 1..5 {
            block_on(store.reopen_dof(index)).unwrap();
        }
        assert!(open::<F411>(&memory).dof_of_campaign(0).is_some());
        assert!((1..5).all(|index| open::<F411>(&memory).dof_of_campaign(index).is_none()));
    }
    // A DOF without lines stays until it is replaced.
    block_on(store.put_dof(1, &[3; 300][..])).unwrap();
    block_on(store.reopen_dof(1)).unwrap();
    assert!(store.dof_of_campaign(1).is_some());
}

/// The longest layout with this number of hits and all sensors.
fn layout(dofs: usize) -> RigLayout {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let dof = Dof { node: u16::MAX, sign: Sign::Plus, axis: Axis::X };
    let hit = Hit::new(dof, [0.1, 0.2, 0.3], [1.0, 0.0, 0.0]);
    RigLayout {
        title: "a wheel on three springs, with a title of forty-".try_into().unwrap(),
        gravity: Some([0.0, 0.0, -9.80665]),
        sensors: (0..RIG_SENSORS).map(|_| Sensor::new(u16::MAX, [0.1; 3], axes)).collect(),
        hits: (0..dofs).map(|_| hit).collect(),
        target: Target { mass: Some(0.01), center: Some(0.001), inertia: Some(0.02) },
        priors: (0..10).map(|property| Prior { property, value: 1.5, sigma: 0.25 }).collect(),
        attached: (0..MAX_ATTACHED)
            .map(|_| AttachedBody::point(0.5, 0.125, [1.0, 2.0, -1.0]))
            .collect(),
        ..RigLayout::default()
    }
}

/// A store with a calibration and the layout that is measured.
fn prepared<C: Chip>(dofs: usize) -> (FlashMemory, ChipStore<C>) {
    let memory = FlashMemory::of::<C>();
    let mut store = open::<C>(&memory);
    let calibration = CalibrationRecord {
        date: "2026-03-14".try_into().unwrap(),
        hammer: "hammer 12345".try_into().unwrap(),
        sensors: ["sensor 12345"; 3].map(|id| id.try_into().unwrap()),
        temperature: Some(21.5),
        ..CalibrationRecord::default()
    };
    block_on(store.put_calibration(&postcard::to_stdvec(&calibration).unwrap())).unwrap();
    block_on(store.put_screen(ScreenSetting::Sh1106)).unwrap();
    block_on(store.put_layout(&postcard::to_stdvec(&layout(dofs)).unwrap())).unwrap();
    (memory, store)
}

/// Most bytes of a DOF with lines.
const LONGEST: usize = MAX_LINES_HEAD + MAX_LINES;

/// Most bytes of the result of so many DOFs.
fn longest_result(dofs: usize) -> usize {
    MAX_RESULT_HEAD + dofs * MAX_LINES_HEAD
}

/// Stores a whole campaign with lines, everything as long as it can be, and every DOF measured twice.
fn store_campaign<C: Chip>(store: &mut ChipStore<C>, dofs: usize) {
    let longest = vec![0x5A; LONGEST];
    for index in 0..dofs as u8 {
        for _ in 0..2 {
            block_on(store.put_progress(&[index; MAX_PROGRESS])).unwrap();
            block_on(store.reopen_dof(index)).unwrap();
            block_on(store.put_dof(index, &longest[..])).unwrap();
        }
    }
    block_on(store.put_progress(&[0xFF; MAX_PROGRESS])).unwrap();
    block_on(store.put_result(&vec![7; longest_result(dofs)][..], 0, None)).unwrap();
}

fn with_lines(dofs: usize) -> CampaignSize {
    CampaignSize { dofs, lines: MAX_LINES }
}

/// The largest number of DOFs with the lines of nine responses in one campaign, and how many campaigns of five DOFs
/// fit.
fn capacity<C: Chip>(board: &str) -> (usize, usize) {
    let mut most = 0;
    for dofs in 1..=RIG_HITS {
        let (memory, mut store) = prepared::<C>(dofs);
        if block_on(store.is_full(with_lines(dofs))) {
            break;
        }
        store_campaign(&mut store, dofs);
        assert_eq!(store.failures(), 0);
        let store = open::<C>(&memory);
        assert!((0..dofs as u8).all(|index| store.dof_of_result(1, index).is_some()));
        most = dofs;
    }
    let (_, mut store) = prepared::<C>(5);
    let mut of_five = 0;
    while !block_on(store.is_full(with_lines(5))) {
        store_campaign(&mut store, 5);
        of_five += 1;
    }
    println!("{board}: {most} DOFs with lines in one campaign, {of_five} campaigns of five");
    (most, of_five)
}

#[test]
fn every_board_has_room_for_a_campaign_of_six_dofs_with_lines() {
    // 32, 48 and 60 KiB are left of the flash beside the page that is opened next and what is lost at the ends of
    // pages.
    let (f411, g474, pico2) =
        (capacity::<F411>("F411"), capacity::<G474>("G474"), capacity::<W25q>("Pico 2"));
    assert!(f411.0 >= 6 && f411.1 >= 1, "{f411:?}");
    assert!(g474.0 >= 6 && g474.1 >= 1, "{g474:?}");
    assert!(pico2.0 >= 7 && pico2.1 >= 1, "{pico2:?}");
}

#[test]
fn a_store_without_room_says_how_many_results_to_delete() {
    let (_, mut store) = prepared::<G474>(5);
    assert_eq!(block_on(store.shortage(with_lines(5))), None);
    // Four results without lines, and one with lines.
    for _ in 0..4 {
        block_on(store.put_result(&[1; 2000][..], 0, None)).unwrap();
    }
    store_campaign(&mut store, 5);
    let shortage = block_on(store.shortage(with_lines(5))).unwrap();
    let deleted = shortage.results.expect("there is room without results");
    assert!(shortage.bytes > 0 && (1..=5).contains(&deleted), "{shortage:?}");
    for number in 1..=deleted as u32 {
        assert!(block_on(store.is_full(with_lines(5))), "{number} of {deleted}");
        block_on(store.delete_result(number)).unwrap();
    }
    assert!(!block_on(store.is_full(with_lines(5))));
    // More than the flash holds.
    let (_, mut store) = prepared::<F411>(12);
    let shortage = block_on(store.shortage(with_lines(12))).unwrap();
    assert!(shortage.bytes > 20_000 && shortage.results.is_none(), "{shortage:?}");
}

/// The flash of an F411 that is full of layouts, and its contents: a campaign of five DOFs with lines.
fn full_of_layouts() -> FlashMemory {
    let (memory, mut store) = prepared::<F411>(6);
    for dofs in [10, 11, 12, 6] {
        block_on(store.put_layout(&postcard::to_stdvec(&layout(dofs)).unwrap())).unwrap();
    }
    assert_eq!(store.layouts().len(), LAYOUTS);
    assert_eq!(block_on(store.shortage(with_lines(6))), None, "the layouts give way");
    for index in 0..5 {
        block_on(store.put_dof(index, &vec![index; LONGEST][..])).unwrap();
        block_on(store.put_progress(&[index; MAX_PROGRESS])).unwrap();
    }
    memory
}

/// Hash of the layout in use.
fn in_use<C: Chip>(store: &ChipStore<C>) -> Option<u32> {
    store.layouts().iter().find(|layout| layout.in_use).map(|layout| layout.hash)
}

#[test]
fn layouts_that_are_not_in_use_give_way_to_a_campaign_with_lines_at_any_cut_of_power() {
    let memory = full_of_layouts();
    let last = vec![5; LONGEST];
    let finish = |store: &mut ChipStore<F411>| {
        block_on(async {
            store.reopen_dof(5).await?;
            store.put_dof(5, &last[..]).await?;
            store.put_progress(&[5; MAX_PROGRESS]).await?;
            store.put_result(&vec![7; longest_result(6)][..], 0, None).await
        })
    };
    let whole = memory.copied();
    let mut store = open::<F411>(&whole);
    assert_eq!(finish(&mut store), Ok(1));
    assert!(store.layouts().len() < LAYOUTS);
    let expected = (Some(layout(6).hash()), 0);
    assert_eq!((in_use(&store), store.failures()), expected);
    // Every twentieth step: `power_cut` cuts at every one of such writes.
    for step in (0..whole.steps() - memory.steps()).step_by(20) {
        let memory = memory.copied();
        let mut store = open::<F411>(&memory);
        memory.cut_power(Cut { after: step, seed: step });
        assert!(finish(&mut store).is_err(), "step {step}");
        drop(store);
        let mut store = open::<F411>(&memory);
        assert_eq!((in_use(&store), store.failures()), expected, "step {step}");
        for index in 0..5 {
            let bytes = vec![index; LONGEST];
            let mut room = vec![0; bytes.len()];
            let stored = store.dof_of_campaign(index).expect("no cut removes it");
            assert_eq!(block_on(store.read_dof(&stored, 0, &mut room)), Ok(bytes.len()));
            assert!(room == bytes, "DOF {index}, step {step}");
        }
        assert_eq!(finish(&mut store), Ok(1), "step {step}");
    }
}

#[test]
fn the_current_campaign_takes_no_room_from_the_next() {
    let (_, mut store) = prepared::<F411>(6);
    for index in 0..5 {
        put_dof(&mut store, index).unwrap();
        block_on(store.put_progress(&[index; MAX_PROGRESS])).unwrap();
    }
    // It is discarded when the next one starts.
    assert!(!block_on(store.is_full(with_lines(6))));
    block_on(store.clear_progress()).unwrap();
    store_campaign(&mut store, 6);
}

#[test]
fn a_list_full_of_dofs_or_results_is_a_shortage_without_bytes() {
    let mut store = open::<VirtualChip>(&FlashMemory::default());
    for _ in 0..DOFS / 6 {
        for index in 0..6 {
            put_dof(&mut store, index).unwrap();
        }
        block_on(store.put_result(&[1; 300][..], 0, None)).unwrap();
    }
    let one = Shortage { bytes: 0, results: Some(1) };
    assert_eq!(block_on(store.shortage(with_lines(6))), Some(one));
    assert_eq!(block_on(store.put_dof(0, &[1; 300][..])), Err(StoreError::Full));
    block_on(store.delete_result(1)).unwrap();
    assert_eq!(block_on(store.shortage(with_lines(6))), None);
    assert_eq!(block_on(store.shortage(with_lines(7))), Some(one));
    while store.results().len() < RESULTS {
        block_on(store.put_result(&[1; 300][..], 0, None)).unwrap();
    }
    assert_eq!(block_on(store.shortage(CampaignSize { dofs: 1, lines: 0 })), Some(one));
}

/// A rig on this flash.
fn power_on(memory: &FlashMemory) -> (VirtualRig, Client) {
    let source = scans(&Bench::named("ideal").unwrap(), &three_bar(), 1);
    let flash = FlashBacking::Memory(memory.clone());
    start(VirtualRigOptions { flash, ..VirtualRigOptions::new(source) })
}

fn download(client: &mut Client, id: LinesId) -> Result<Vec<u8>, ClientError> {
    client.download(id.object().unwrap(), |_, _| ())
}

fn refusal<T>(answer: Result<T, ClientError>) -> Option<Reason> {
    answer.err().and_then(|error| error.refusal())
}

#[test]
fn the_host_downloads_the_lines_of_a_result() {
    let memory = FlashMemory::default();
    let mut store = open::<VirtualChip>(&memory);
    let bytes: Vec<_> = (0..3).map(|index| put_dof(&mut store, index).unwrap()).collect();
    block_on(store.put_result(&[7; 300][..], 0, None)).unwrap();
    drop(store);
    let (rig, mut client) = power_on(&memory);
    for (dof, bytes) in (0..).zip(&bytes) {
        assert_eq!(&download(&mut client, LinesId { result: 1, dof }).unwrap(), bytes);
    }
    for (result, dof) in [(1, 3), (2, 0), (CURRENT_CAMPAIGN, 0), (u32::MAX / 16, 15)] {
        let refused = refusal(download(&mut client, LinesId { result, dof }));
        assert_eq!(refused, Some(Reason::NotFound), "DOF {dof} of {result}");
    }
    let object = LinesId { result: 1, dof: 0 }.object().unwrap();
    let length = bytes[0].len() as u32;
    for (offset, wanted, expected) in
        [(length - 1, 9, Ok(1)), (length, 1, Err(Reason::OutOfRange)), (7, u16::MAX, Ok(MAX_CHUNK))]
    {
        let chunk = client.ask::<ReadObject>(&ChunkRequest { object, offset, length: wanted });
        let chunk = chunk.map(|chunk| chunk.bytes.len()).map_err(|error| error.refusal().unwrap());
        assert_eq!(chunk, expected, "from {offset}");
    }
    client.ask::<massline_protocol::message::DeleteResult>(&1).unwrap();
    let refused = refusal(download(&mut client, LinesId { result: 1, dof: 0 }));
    assert_eq!(refused, Some(Reason::NotFound));
    rig.stop().unwrap();
}

#[test]
fn any_number_of_lines_is_answered_or_refused_by_name() {
    let memory = FlashMemory::default();
    put_dof(&mut open::<VirtualChip>(&memory), 0).unwrap();
    let (rig, mut client) = power_on(&memory);
    for number in (0..40).chain((0..32).map(|bit| 1 << bit)).chain([u32::MAX]) {
        let object = ObjectId { kind: ObjectKind::Lines as u8, number };
        let refused = refusal(client.ask::<GetObjectInfo>(&object));
        assert_eq!(refused, Some(Reason::NotFound), "{number}");
        let request = ChunkRequest { object, offset: number, length: number as u16 };
        assert_eq!(refusal(client.ask::<ReadObject>(&request)), Some(Reason::NotFound), "{number}");
    }
    rig.stop().unwrap();
}

#[test]
fn the_host_downloads_the_lines_of_a_campaign_in_progress() {
    let memory = FlashMemory::default();
    let (rig, mut client) = power_on(&memory);
    client.put_layout(&three_bar().rig_layout().unwrap()).unwrap();
    client.start(false, false).unwrap();
    wait_for(&mut client, |status| status.dof > 0);
    client.command(Command::Pause).unwrap();
    wait_for(&mut client, |status| phase(status) == Some(Phase::Paused));
    // The first DOF is in the flash as soon as the rig rests.
    let first = LinesId { result: CURRENT_CAMPAIGN, dof: 0 };
    assert_eq!(refusal(download(&mut client, first)), Some(Reason::NotFound), "it has no lines");
    rig.stop().unwrap();
    let mut store = open::<VirtualChip>(&memory);
    assert!(store.has_progress());
    let bytes = put_dof(&mut store, 1).unwrap();
    drop(store);
    let (rig, mut client) = power_on(&memory);
    assert_eq!(phase(&client.status().unwrap()), Some(Phase::Paused));
    let second = LinesId { result: CURRENT_CAMPAIGN, dof: 1 };
    assert_eq!(download(&mut client, second).unwrap(), bytes);
    client.command(Command::Abort).unwrap();
    wait_for(&mut client, |_| open::<VirtualChip>(&memory.copied()).dof_of_campaign(1).is_none());
    assert_eq!(refusal(download(&mut client, second)), Some(Reason::NotFound));
    rig.stop().unwrap();
}
