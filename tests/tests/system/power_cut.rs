//! The power is cut at every word of every write of whole campaigns, three times in a row, under the
//! rules of three kinds of flash: no accepted write is lost and no torn one is visible.

use embassy_futures::block_on;
use massline_firmware::store::{
    CampaignSize, LAYOUTS, MAX_DOF, MAX_LINES, MAX_LINES_HEAD, MAX_PROGRESS, MAX_RESULT,
    MAX_RESULT_HEAD, Store, StoreError,
};
use massline_protocol::message::EstimatedMass;
use massline_protocol::{LayoutHash, MAX_LAYOUT, crc32};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::{Axis, Dof, Hit, RigLayout, Sensor, Sign};
use massline_shared::signal::COMPACT_RESPONSE;
use massline_tests::long;
use massline_virtual::flash::{Chip, ChipFlash, Cut, F411, FlashMemory, G474, W25q};

/// DOFs of every campaign here.
const DOFS: usize = 4;

/// A write or a deletion in the store.
#[derive(Clone, Copy, Debug)]
enum Write {
    /// The layout of this number.
    Layout(u32),
    /// Takes a stored layout into use again.
    Use(u32),
    Calibration(u32),
    /// A finished DOF of a campaign, with this many bytes of lines.
    Dof {
        campaign: u32,
        index: u8,
        lines: usize,
    },
    /// A DOF with lines is open again.
    Reopen {
        index: u8,
    },
    Progress {
        campaign: u32,
        dofs: u8,
    },
    Result {
        campaign: u32,
        /// Bytes of the lines of each DOF.
        lines: usize,
    },
    Delete {
        number: u32,
    },
    Abort,
}

/// Bytes that depend on the seed, so that every stored item has different ones.
fn bytes_of(seed: u32, length: usize) -> Vec<u8> {
    (0..length as u32).map(|i| crc32(&(seed ^ (i << 8)).to_le_bytes()) as u8).collect()
}

/// The layout in use.
fn kept_layout<C: Chip>(store: &mut Store<ChipFlash<C>>) -> Option<RigLayout> {
    let mut room = [0; MAX_LAYOUT];
    block_on(store.layout(&mut room)).map(|bytes| postcard::from_bytes(bytes).unwrap())
}

fn layout(number: u32) -> RigLayout {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let dof = Dof { node: 4, sign: Sign::Plus, axis: Axis::X };
    let at = number as f32;
    RigLayout {
        title: format!("layout {number}").as_str().try_into().unwrap(),
        sensors: (0..3).map(|node| Sensor::new(node, [at, 0.1, 0.2], axes)).collect(),
        hits: (0..9).map(|_| Hit::new(dof, [0.1, 0.2, at], [1.0, 0.0, 0.0])).collect(),
        ..RigLayout::default()
    }
}

fn layout_bytes(number: u32) -> Vec<u8> {
    postcard::to_stdvec(&layout(number)).unwrap()
}

fn calibration(number: u32) -> CalibrationRecord {
    let mut record = CalibrationRecord::default();
    record.calibration.channels[3].sensitivity = number as f32;
    record
}

fn dof_bytes(campaign: u32, index: u8, lines: usize) -> Vec<u8> {
    let longest = if lines > 0 { MAX_LINES_HEAD + lines } else { MAX_DOF };
    bytes_of(campaign * 16 + u32::from(index), longest - usize::from(index))
}

fn progress_bytes(campaign: u32, dofs: u8) -> Vec<u8> {
    bytes_of(campaign * 100 + u32::from(dofs), 60 + usize::from(dofs) * (MAX_PROGRESS - 60) / 16)
}

/// Results of various lengths; with [`DOFS`] DOFs they are not the longest possible ones.
fn result_bytes(campaign: u32, lines: usize) -> Vec<u8> {
    let (longest, shorter) = match lines {
        0 => (MAX_RESULT - (12 - DOFS) * MAX_DOF, 700),
        _ => (MAX_RESULT_HEAD + DOFS * MAX_LINES_HEAD, 200),
    };
    bytes_of(campaign, longest - campaign as usize * 97 % shorter)
}

fn mass_of(campaign: u32) -> Option<EstimatedMass> {
    (!campaign.is_multiple_of(3))
        .then_some(EstimatedMass { value: campaign as f32, sigma: Some(0.01) })
}

#[derive(Clone, Debug, PartialEq)]
struct StoredResult {
    number: u32,
    layout: u32,
    mass: Option<EstimatedMass>,
    bytes: Vec<u8>,
    /// Its DOFs with lines, by their index.
    dofs: Vec<(u8, Vec<u8>)>,
}

/// The expected contents of a store.
#[derive(Clone, Debug, Default, PartialEq)]
struct Model {
    /// Numbers of the layouts; the one in use is `in_use`.
    layouts: Vec<u32>,
    in_use: Option<u32>,
    calibration: Option<u32>,
    results: Vec<StoredResult>,
    next_number: u32,
    progress: Option<Vec<u8>>,
    /// The DOFs of the campaign by their index, in the order of storing.
    dofs: Vec<(u8, Vec<u8>)>,
}

impl Model {
    /// The actual contents of a store; every byte is read.
    fn of<C: Chip>(store: &mut Store<ChipFlash<C>>) -> Self {
        let (known, in_use) = {
            let number = |title: &str| title["layout ".len()..].parse::<u32>().unwrap();
            let layouts = store.layouts();
            let in_use = layouts.iter().find(|kept| kept.in_use).map(|kept| number(&kept.title));
            (layouts.iter().map(|kept| number(&kept.title)).collect::<Vec<_>>(), in_use)
        };
        assert_eq!(kept_layout(store), in_use.map(layout), "the layout in use is whole");
        let calibrated = block_on(store.calibration());
        let results = store.results().to_vec();
        let results = results.iter().map(|kept| {
            let mut bytes = vec![0; kept.entry.length as usize];
            let read = block_on(store.read_result(kept, 0, &mut bytes));
            assert_eq!(read, Ok(bytes.len()));
            assert_eq!(crc32(&bytes), kept.crc);
            let (number, layout, mass) =
                (kept.entry.number, kept.entry.layout_hash, kept.entry.mass);
            let dofs = (0..DOFS as u8).filter_map(|index| {
                let stored = store.dof_of_result(number, index)?;
                let mut bytes = vec![0; stored.length()];
                assert_eq!(block_on(store.read_dof(&stored, 0, &mut bytes)), Ok(bytes.len()));
                Some((index, bytes))
            });
            let dofs = dofs.collect();
            StoredResult { number, layout, mass, bytes, dofs }
        });
        let mut model = Self {
            layouts: known,
            in_use,
            calibration: calibrated.map(|record| record.calibration.channels[3].sensitivity as u32),
            results: results.collect(),
            next_number: store.next_number(),
            progress: block_on(store.progress(&mut [0; MAX_PROGRESS])).map(<[u8]>::to_vec),
            dofs: Vec::new(),
        };
        let room = &mut [0; MAX_DOF + MAX_LINES];
        while let Some(dof) = block_on(store.dof(model.dofs.len(), room)) {
            let dof = dof.to_vec();
            let same = |&index: &u8| {
                let stored = store.dof_of_campaign(index);
                stored.is_some_and(|stored| stored.length() == dof.len())
            };
            // The lengths of the DOFs differ.
            let index = (0..DOFS as u8).find(same).expect("it has an index");
            model.dofs.push((index, dof));
        }
        model
    }

    /// The contents after a write.
    fn with(&self, write: Write) -> Self {
        let mut model = self.clone();
        match write {
            Write::Layout(number) | Write::Use(number) => {
                model.layouts.retain(|&known| known != number);
                if model.layouts.len() == LAYOUTS {
                    model.layouts.remove(0);
                }
                model.layouts.push(number);
                model.in_use = Some(number);
            }
            Write::Calibration(number) => model.calibration = Some(number),
            Write::Dof { campaign, index, lines } => {
                model.dofs.retain(|&(dof, _)| dof != index);
                model.dofs.push((index, dof_bytes(campaign, index, lines)));
            }
            Write::Reopen { index } => model.dofs.retain(|&(dof, _)| dof != index),
            Write::Progress { campaign, dofs } => {
                model.progress = Some(progress_bytes(campaign, dofs));
            }
            Write::Result { campaign, lines } => {
                let (number, bytes) = (model.next_number, result_bytes(campaign, lines));
                let mass = mass_of(campaign);
                let mut dofs = model.dofs.clone();
                dofs.retain(|(_, bytes)| bytes.len() > MAX_DOF);
                dofs.sort_unstable();
                model.results.push(StoredResult { number, layout: campaign, mass, bytes, dofs });
                model.next_number += 1;
                model.end_campaign();
            }
            Write::Delete { number } => model.results.retain(|kept| kept.number != number),
            Write::Abort => model.end_campaign(),
        }
        model
    }

    fn end_campaign(&mut self) {
        self.progress = None;
        self.dofs.clear();
    }

    /// The order of the layouts decides which one is dropped next, but is not visible in the list.
    fn visible_state(&self) -> Self {
        let mut shown = self.clone();
        shown.layouts.sort_unstable();
        shown
    }
}

fn open<C: Chip>(memory: &FlashMemory) -> Store<ChipFlash<C>> {
    let mut store = Store::new(ChipFlash::<C>::over(memory), || false);
    block_on(store.open());
    store
}

fn do_it<C: Chip>(store: &mut Store<ChipFlash<C>>, write: Write) -> Result<(), StoreError> {
    block_on(async {
        match write {
            Write::Layout(number) => store.put_layout(&layout_bytes(number)).await,
            Write::Use(number) => store.use_layout(layout(number).hash()).await,
            Write::Calibration(number) => {
                let bytes = postcard::to_stdvec(&calibration(number)).unwrap();
                store.put_calibration(&bytes).await
            }
            Write::Dof { campaign, index, lines } => {
                store.put_dof(index, &dof_bytes(campaign, index, lines)[..]).await
            }
            Write::Reopen { index } => store.reopen_dof(index).await,
            Write::Progress { campaign, dofs } => {
                store.put_progress(&progress_bytes(campaign, dofs)).await
            }
            Write::Result { campaign, lines } => {
                let bytes = result_bytes(campaign, lines);
                store.put_result(&bytes[..], campaign, mass_of(campaign)).await.map(|_| ())
            }
            Write::Delete { number } => store.delete_result(number).await,
            Write::Abort => store.clear_progress().await,
        }
    })
}

/// The writes of a campaign, which begins with the deletion of results; every fifth is aborted. In a campaign with
/// lines the first DOF is measured again.
fn campaign(number: u32, model: &Model, deleted: usize, lines: usize) -> Vec<Write> {
    let mut writes = Vec::new();
    let oldest = model.results.iter().take(deleted).map(|kept| kept.number);
    writes.extend(oldest.map(|number| Write::Delete { number }));
    match number % 4 {
        0 => writes.push(Write::Calibration(number)),
        1 => writes.extend(model.layouts.first().map(|&oldest| Write::Use(oldest))),
        _ => writes.push(Write::Layout(number)),
    }
    for index in 0..DOFS as u8 {
        writes.push(Write::Dof { campaign: number, index, lines });
        writes.push(Write::Progress { campaign: number, dofs: index + 1 });
        if index == 1 && lines > 0 {
            writes.push(Write::Progress { campaign: number, dofs: index });
            writes.push(Write::Reopen { index: 0 });
            writes.push(Write::Dof { campaign: number, index: 0, lines: lines + 1 });
        }
    }
    let end =
        if number % 5 == 4 { Write::Abort } else { Write::Result { campaign: number, lines } };
    writes.push(end);
    writes
}

/// A store in use, and its expected contents.
struct Life {
    memory: FlashMemory,
    model: Model,
    campaigns: u32,
    /// Results deleted to make room.
    deleted: u32,
    /// Bytes of lines of each DOF, by the number of the campaign.
    lines: fn(u32) -> usize,
}

impl Life {
    fn new<C: Chip>(lines: fn(u32) -> usize) -> Self {
        let memory = FlashMemory::of::<C>();
        Self {
            memory,
            model: Model { next_number: 1, ..Model::default() },
            campaigns: 0,
            deleted: 0,
            lines,
        }
    }

    /// Executes a campaign; calls `before` with every write before it is executed.
    fn campaign<C: Chip>(&mut self, mut before: impl FnMut(&FlashMemory, &Model, Write)) {
        let mut store = open::<C>(&self.memory);
        let lines = (self.lines)(self.campaigns);
        // The DOF that is measured again has one byte more.
        let size = CampaignSize { dofs: DOFS, lines: lines + usize::from(lines > 0) };
        let shortage = block_on(store.shortage(size));
        let deleted = shortage.map_or(0, |shortage| shortage.results.expect("there are results"));
        self.deleted += deleted as u32;
        for write in campaign(self.campaigns, &self.model, deleted, lines) {
            before(&self.memory, &self.model, write);
            do_it(&mut store, write).unwrap_or_else(|reason| panic!("{write:?}: {reason:?}"));
            self.model = self.model.with(write);
        }
        assert_eq!(Model::of(&mut store).visible_state(), self.model.visible_state());
        self.campaigns += 1;
    }
}

/// Counts of the cuts and of their outcomes.
#[derive(Debug, Default)]
struct Count {
    words: u64,
    cuts: u64,
    /// Cuts after which the store had the new state.
    done: u64,
    /// Writes that were still not complete after three cuts.
    triples: u64,
}

/// Cuts the power at every step of a write, or every second one and so on, and twice more at any step of its
/// repetitions.
fn cut_everywhere<C: Chip>(
    memory: &FlashMemory,
    model: &Model,
    write: Write,
    every: usize,
    count: &mut Count,
) {
    let (before, after) = (model.visible_state(), model.with(write).visible_state());
    let whole = memory.copied();
    do_it(&mut open::<C>(&whole), write).unwrap();
    let steps = whole.steps() - memory.steps();
    count.words += steps;
    for step in (0..steps).step_by(every) {
        let memory = memory.copied();
        let mut is_written = false;
        for cut in 0..3 {
            let seed = (step << 2 | cut) ^ count.cuts << 32;
            // The second and third cut come at a random step, more often an early one.
            let any = u64::from(crc32(&seed.to_le_bytes()));
            let at = if cut == 0 { step } else { any % (1 + (steps >> (any >> 32 & 3))) };
            let mut store = open::<C>(&memory);
            memory.cut_power(Cut { after: at, seed });
            let done = do_it(&mut store, write);
            // A repeated write may need fewer steps.
            assert_eq!(done.is_ok(), memory.has_power(), "{write:?}, step {step}, cut {cut}");
            count.cuts += u64::from(done.is_err());
            drop(store);
            let mut store = open::<C>(&memory);
            let shown = Model::of(&mut store).visible_state();
            assert_eq!(
                store.failures(),
                0,
                "{write:?}, step {step}, cut {cut}: something was torn"
            );
            is_written = shown == after;
            assert!(
                is_written || (done.is_err() && shown == before),
                "{write:?}, step {step}, cut {cut}: {shown:?}"
            );
            if is_written {
                count.done += 1;
                break;
            }
            count.triples += u64::from(cut == 2);
        }
        if !is_written {
            let mut store = open::<C>(&memory);
            assert_eq!(do_it(&mut store, write), Ok(()), "{write:?} after the cuts at step {step}");
            assert_eq!(
                store.failures(),
                0,
                "{write:?}, step {step}: wrote over what a cut had left"
            );
            drop(store);
            let shown = Model::of(&mut open::<C>(&memory)).visible_state();
            assert_eq!(shown, after, "{write:?}, step {step}");
        }
    }
}

/// Cuts the power at every step of whole campaigns: the first ones on erased flash, and later ones when
/// the store is full.
fn cut_campaigns<C: Chip>(chip: &str, cut_ones: &[u32], lines: fn(u32) -> usize) -> Count {
    cut_campaigns_every::<C>(chip, cut_ones, lines, 1)
}

/// The same at every second step of a write, every third, and so on.
fn cut_campaigns_every<C: Chip>(
    chip: &str,
    cut_ones: &[u32],
    lines: fn(u32) -> usize,
    every: usize,
) -> Count {
    let (mut life, mut count) = (Life::new::<C>(lines), Count::default());
    let mut opened = 0;
    for number in 0..=cut_ones[cut_ones.len() - 1] {
        if cut_ones.contains(&number) {
            let before: u32 = life.memory.erases().iter().sum();
            life.campaign::<C>(|memory, model, write| {
                cut_everywhere::<C>(memory, model, write, every, &mut count);
            });
            opened += life.memory.erases().iter().sum::<u32>() - before;
        } else {
            life.campaign::<C>(|_, _, _| {});
        }
    }
    assert!(life.deleted > 0, "the store was full");
    let Count { words, cuts, done, triples } = count;
    println!(
        "{chip}: {cuts} cuts at {words} words; {triples} times three in a row; after {done} the \
         new state was whole"
    );
    let erases = life.memory.erases();
    println!(
        "{chip}: {opened} pages opened meanwhile; {erases:?} erases in {} campaigns",
        life.campaigns
    );
    assert!(opened > 1, "pages were opened");
    let (least, most) = (erases.iter().min().unwrap(), erases.iter().max().unwrap());
    assert!(most - least <= 1, "all pages wear alike: {erases:?}");
    count
}

#[test]
fn no_cut_loses_or_tears_anything_in_flash_of_an_f411() {
    let count = cut_campaigns::<F411>("F411", &[0, 22], no_lines);
    assert!(count.cuts >= 10_000, "{count:?}");
}

#[test]
fn no_cut_loses_or_tears_anything_in_flash_of_a_g474() {
    let count = cut_campaigns::<G474>("G474", &[0, 34, 35, 36], no_lines);
    assert!(count.cuts >= 10_000, "{count:?}");
}

#[test]
fn no_cut_loses_or_tears_anything_in_flash_beside_an_rp2350() {
    // The largest flash takes the longest to open.
    let every = if long() { 1 } else { 7 };
    let count = cut_campaigns_every::<W25q>("W25Q", &[0, 40], no_lines, every);
    assert!(count.cuts >= 10_000 / every as u64, "{count:?}");
}

/// A campaign by mass lines stores no others.
fn no_lines(_: u32) -> usize {
    0
}

/// Campaigns with all the lines that a DOF can have, and campaigns without lines between them.
fn all_lines(campaign: u32) -> usize {
    if campaign % 3 == 1 { 0 } else { MAX_LINES - 1 }
}

/// The same with the lines of one response.
fn few_lines(campaign: u32) -> usize {
    if campaign % 3 == 1 { 0 } else { COMPACT_RESPONSE - 1 }
}

#[test]
fn no_cut_loses_or_tears_lines_in_flash_of_an_f411() {
    // There is room for one campaign with lines: the others begin with the deletion of its result, as the one that is
    // cut.
    let count = cut_campaigns::<F411>("F411 with lines", &[3], all_lines);
    assert!(count.cuts >= 10_000, "{count:?}");
}

#[test]
fn no_cut_loses_or_tears_lines_in_flash_of_a_g474() {
    let count = cut_campaigns::<G474>("G474 with lines", &[0, 17], few_lines);
    assert!(count.cuts >= 3_000, "{count:?}");
}
