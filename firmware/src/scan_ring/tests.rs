//! Tests the ring against a simulated converter with every fault that a chip can have: late interrupts,
//! overruns, a halt, a sequence out of step.

use proptest::prelude::*;

use std::vec::Vec;

use super::*;

const RANKS: usize = 11;
const SENTINEL: usize = 10;
/// Raw scans per half.
const HALF: usize = 4;
const LENGTH: usize = 2 * HALF * RANKS;
const RATIO: u16 = 3;
const CAPACITY: usize = 8;
const REFERENCE: u16 = 1500;
/// Raw scans in a row in which the rank before the sentinel may have a code of the sentinel.
const LONGEST: u16 = 250;
/// Raw scans have distinct codes modulo this number.
const NUMBERS: u64 = 4000;
const PATIENCE: u64 = 100;

type Ring = ScanRing<RANKS, CAPACITY>;

fn settings() -> RingSettings {
    RingSettings {
        decimation: Decimation { raw_bits: 12, raw_full: 4095, ratio: RATIO, fraction_bits: 2 },
        sentinel: SENTINEL,
        // Those of a typical chip's reference on 3.0 to 3.6 V.
        sentinel_codes: 1376..=1652,
        before_sentinel: Some((SENTINEL - 1, LONGEST)),
        skip: 0,
    }
}

/// A code that identifies its raw scan and rank, from 1 to 4000 + 9, so that it never clips.
fn code(raw_scan: u64, rank: usize) -> u16 {
    if rank == SENTINEL { REFERENCE } else { (1 + raw_scan % NUMBERS) as u16 + rank as u16 }
}

/// The converter, its transfer and its interrupt.
struct Chip {
    buffer: [u16; LENGTH],
    /// Values written so far.
    written: u64,
    /// Rank of the first value; nonzero when the sequence is out of step.
    shift: usize,
    flags: HalfFlags,
    halves: Halves,
}

impl Chip {
    fn new() -> Self {
        let flags = HalfFlags::default();
        Self { buffer: [0; LENGTH], written: 0, shift: 0, flags, halves: Halves::new() }
    }

    fn write(&mut self, values: usize) {
        for _ in 0..values {
            let at = (self.written % LENGTH as u64) as usize;
            let ranked = self.written + self.shift as u64;
            self.buffer[at] = code(ranked / RANKS as u64, (ranked % RANKS as u64) as usize);
            self.written += 1;
            self.flags.first |= at + 1 == LENGTH / 2;
            self.flags.second |= at + 1 == LENGTH;
        }
    }

    fn remaining(&self) -> u16 {
        LENGTH as u16 - (self.written % LENGTH as u64) as u16
    }

    /// Runs the interrupt handler. The transfer writes `before` values before the half is read, and
    /// `after` after it.
    fn interrupt(&mut self, ring: &mut Ring, before: usize, after: usize) {
        let flags = core::mem::take(&mut self.flags);
        let length = LENGTH as u16;
        let raw_scans = HALF as u32;
        match self.halves.finished(flags, self.remaining(), length) {
            Ok(None) => {}
            Ok(Some(half)) => {
                self.write(before);
                ring.feed(half.of(&self.buffer), |_, _| {});
                self.write(after);
                if let Err(overrun) =
                    self.halves.was_read(half, self.flags, self.remaining(), length)
                {
                    ring.overrun(overrun.halves * raw_scans);
                }
            }
            Err(overrun) => ring.overrun(overrun.halves * raw_scans),
        }
    }

    /// Transfers this many halves, each read in time.
    fn run(&mut self, ring: &mut Ring, halves: usize) {
        for _ in 0..halves {
            self.write(LENGTH / 2);
            self.interrupt(ring, 0, 0);
        }
    }
}

fn started() -> (Ring, Chip) {
    let mut ring = Ring::new();
    ring.start(settings(), 0);
    (ring, Chip::new())
}

/// The scan averaged from the raw scans from `first` on.
fn mean_of(first: u64) -> Scan {
    core::array::from_fn(|rank| {
        let sum: u32 = (0..u64::from(RATIO)).map(|k| u32::from(code(first + k, rank))).sum();
        (4.0 * f64::from(sum) / f64::from(RATIO)).round() as u16
    })
}

fn read<const N: usize>(ring: &mut Ring) -> Result<Option<(u64, [Scan; N])>, SampleError> {
    let mut block = [[0; CHANNELS]; N];
    Ok(ring.read(&mut block, 0, PATIENCE)?.map(|first| (first.0, block)))
}

#[test]
fn scans_are_means_of_consecutive_raw_scans_across_halves() {
    let (mut ring, mut chip) = started();
    let mut index = 0;
    for _ in 0..100 {
        chip.run(&mut ring, 1);
        while let Some((first, [scan])) = read::<1>(&mut ring).unwrap() {
            assert_eq!(first, index);
            assert_eq!(scan, mean_of(index * u64::from(RATIO)));
            index += 1;
        }
    }
    assert_eq!(index, 100 * HALF as u64 / u64::from(RATIO));
}

#[test]
fn a_block_comes_only_when_it_is_full() {
    let (mut ring, mut chip) = started();
    chip.run(&mut ring, 3);
    assert_eq!(read::<5>(&mut ring), Ok(None));
    let block: [Scan; 4] = core::array::from_fn(|k| mean_of(3 * k as u64));
    assert_eq!(read(&mut ring), Ok(Some((0, block))));
}

#[test]
fn scans_asked_for_by_no_timer_are_skipped() {
    let (mut ring, mut chip) = started();
    ring.start(RingSettings { skip: 1, ..settings() }, 0);
    chip.run(&mut ring, 1);
    assert_eq!(read(&mut ring), Ok(Some((0, [mean_of(1)]))));
}

#[test]
fn a_reader_that_is_late_by_one_scan_is_told_of_all_that_is_lost() {
    let (mut ring, mut chip) = started();
    chip.run(&mut ring, 6);
    assert_eq!(ring.written, CAPACITY as u64);
    assert!(read::<1>(&mut ring).unwrap().is_some());
    let (mut ring, mut chip) = started();
    chip.run(&mut ring, 7);
    assert_eq!(ring.written, CAPACITY as u64 + 1);
    assert_eq!(read::<1>(&mut ring), Err(SampleError::Overrun { lost: 9 }));
    assert_eq!(read::<1>(&mut ring), Ok(None));
    chip.run(&mut ring, 2);
    assert_eq!(read(&mut ring), Ok(Some((9, [mean_of(27)]))));
}

#[test]
fn an_interrupt_that_comes_a_whole_lap_late_is_an_overrun_at_every_phase() {
    for late in 0..=3 * LENGTH {
        let (mut ring, mut chip) = started();
        chip.write(LENGTH / 2 + late);
        chip.interrupt(&mut ring, 0, 0);
        // The first half is intact until the second is full.
        let whole = late < LENGTH / 2;
        assert_eq!(read::<1>(&mut ring).is_ok(), whole, "{late}");
        // Whatever was lost, reading continues in step.
        chip.flags = HalfFlags::default();
        chip.write(LENGTH - (chip.written % LENGTH as u64) as usize);
        chip.interrupt(&mut ring, 0, 0);
        while read::<1>(&mut ring).is_err() {}
        let before = ring.written;
        chip.run(&mut ring, 3);
        assert!(ring.written > before && ring.fault().is_none(), "{late}");
    }
}

#[test]
fn a_half_that_is_overwritten_while_it_is_read_is_never_given() {
    for during in 0..=2 * LENGTH {
        let (mut ring, mut chip) = started();
        chip.write(LENGTH / 2);
        chip.interrupt(&mut ring, during, 0);
        let whole = during < LENGTH / 2;
        let expected = if whole { Ok(Some((0, [mean_of(0)]))) } else { Err(()) };
        assert_eq!(read(&mut ring).map_err(|_| ()), expected, "{during}");
    }
}

#[test]
fn a_transfer_with_nothing_remaining_is_at_its_start_again() {
    let mut halves = Halves::new();
    let (first, second) = (true, true);
    let length = LENGTH as u16;
    let flags = HalfFlags { first, ..HalfFlags::default() };
    assert_eq!(halves.finished(flags, length / 2, length), Ok(Some(Half::First)));
    let flags = HalfFlags { second, ..HalfFlags::default() };
    assert_eq!(halves.finished(flags, 0, length), Ok(Some(Half::Second)));
    assert_eq!(halves.finished(HalfFlags::default(), 0, length), Ok(None));
}

#[test]
fn a_sequence_out_of_step_is_found_at_every_shift_and_goes_on_after_a_restart() {
    for shift in 1..RANKS {
        let (mut ring, mut chip) = started();
        chip.shift = shift;
        chip.run(&mut ring, 2);
        assert_eq!(ring.fault(), Some(Fault::Misaligned), "{shift}");
        assert_eq!(read::<1>(&mut ring), Err(SampleError::Overrun { lost: 1 }));
        assert_eq!(read::<1>(&mut ring), Ok(None));
        let mut chip = Chip::new();
        ring.restart(0);
        assert_eq!(ring.fault(), None);
        chip.run(&mut ring, 1);
        assert_eq!(read(&mut ring), Ok(Some((1, [mean_of(0)]))));
    }
}

/// Raw scans of a sequence whose transfer is `slip` values ahead, with a hammer that rests at `hammer` and
/// sensors at half of the range; the last sensor axis has the codes of `last`.
fn at_rest(slip: usize, hammer: u16, last: impl Iterator<Item = u16>) -> Vec<u16> {
    let mut values: Vec<u16> = last
        .flat_map(|last| {
            let sensors = [2048; RANKS - 3];
            [hammer].into_iter().chain(sensors).chain([last, REFERENCE])
        })
        .collect();
    values.rotate_left(slip);
    values
}

#[test]
fn a_slip_by_any_number_of_ranks_is_found_whatever_the_rest_level_of_the_hammer() {
    let rest = || core::iter::repeat_n(2048, 2 * usize::from(LONGEST));
    // 1.296 V of 3.3 V, the middle of a divider for pulses downward with its resistors swapped, is 1609; the
    // steps between are narrower than the range of the reference.
    for hammer in (0..=4095).step_by(91).chain([1450, 1609]) {
        let mut ring = Ring::new();
        ring.start(settings(), 0);
        ring.feed(&at_rest(0, hammer, rest()), |_, _| {});
        assert_eq!(ring.fault(), None, "hammer {hammer}");
        for slip in 1..RANKS {
            let mut ring = Ring::new();
            ring.start(settings(), 0);
            ring.feed(&at_rest(slip, hammer, rest()), |_, _| {});
            assert_eq!(ring.fault(), Some(Fault::Misaligned), "hammer {hammer}, slip {slip}");
        }
    }
}

#[test]
fn a_sensor_that_passes_the_code_of_the_reference_in_a_hit_is_no_slip() {
    // As long as allowed, again and again, with a code beside it in between.
    let pulse = core::iter::repeat_n(REFERENCE, LONGEST.into()).chain([2048]);
    let hits = pulse.cycle().take(20 * usize::from(LONGEST));
    let mut ring = Ring::new();
    ring.start(settings(), 0);
    ring.feed(&at_rest(0, 1500, hits), |_, _| {});
    assert_eq!(ring.fault(), None);
    ring.feed(
        &at_rest(0, 1500, core::iter::repeat_n(REFERENCE, usize::from(LONGEST) + 1)),
        |_, _| {},
    );
    assert_eq!(ring.fault(), Some(Fault::Misaligned));
}

#[test]
fn a_dead_sensor_axis_that_rests_at_the_code_of_the_reference_stops_no_run() {
    let mut ring = Ring::new();
    ring.start(settings(), 0);
    let dead = || at_rest(0, 500, core::iter::repeat_n(REFERENCE, usize::from(LONGEST) + 3));
    for _ in 0..SLIPS_TO_BELIEVE {
        ring.feed(&dead(), |_, _| {});
        assert_eq!(ring.fault(), Some(Fault::Misaligned), "it may be a slip");
        ring.restart(0);
    }
    for _ in 0..5 {
        ring.feed(&dead(), |_, _| {});
        assert_eq!(ring.fault(), None, "it is none");
    }
    // In the next run it may be one again.
    ring.start(settings(), 0);
    ring.feed(&dead(), |_, _| {});
    assert_eq!(ring.fault(), Some(Fault::Misaligned));
}

#[test]
fn a_step_lost_in_mid_run_ends_it_before_a_wrong_scan_is_read() {
    for values in 1..RANKS {
        let (mut ring, mut chip) = started();
        chip.run(&mut ring, 3);
        // The converter converts, but the transfer misses some values.
        chip.shift += values;
        chip.run(&mut ring, 1);
        assert_eq!(ring.fault(), Some(Fault::Misaligned), "{values}");
        assert!(read::<1>(&mut ring).is_err());
    }
}

#[test]
fn a_converter_that_is_never_in_step_is_given_up() {
    let (mut ring, _) = started();
    for _ in 0..FAULTS_TO_STOP - 1 {
        let mut chip = Chip { shift: 1, ..Chip::new() };
        chip.run(&mut ring, 1);
        assert!(matches!(read::<1>(&mut ring), Err(SampleError::Overrun { .. })));
        ring.restart(0);
    }
    ring.fail(Fault::ConverterOverrun);
    ring.restart(0);
    assert_eq!(read::<1>(&mut ring), Err(SampleError::Stopped));
    ring.start(settings(), 0);
    Chip::new().run(&mut ring, 1);
    assert!(read::<1>(&mut ring).unwrap().is_some());
}

#[test]
fn faults_between_which_blocks_are_read_do_not_add_up() {
    let (mut ring, _) = started();
    for _ in 0..10 {
        ring.fail(Fault::ConverterOverrun);
        assert!(matches!(read::<1>(&mut ring), Err(SampleError::Overrun { .. })));
        ring.restart(0);
        Chip::new().run(&mut ring, 1);
        assert!(read::<1>(&mut ring).unwrap().is_some());
    }
}

#[test]
fn a_converter_that_halts_is_told_after_the_patience_of_the_caller() {
    let (mut ring, mut chip) = started();
    let mut block = [[0; CHANNELS]; 2];
    assert_eq!(ring.read(&mut block, PATIENCE, PATIENCE), Ok(None));
    chip.run(&mut ring, 1);
    // The reader sees the new scans now, so its patience starts now.
    assert_eq!(ring.read(&mut block, 500, PATIENCE), Ok(None));
    assert_eq!(ring.read(&mut block, 500 + PATIENCE, PATIENCE), Ok(None));
    assert_eq!(ring.read(&mut block, 501 + PATIENCE, PATIENCE), Err(SampleError::Stopped));
    chip.run(&mut ring, 1);
    let first = ring.read(&mut block, 900, PATIENCE);
    assert_eq!(first, Ok(Some(ScanIndex(0))));
}

#[test]
fn nothing_is_read_without_a_start_or_with_settings_that_make_no_sense() {
    let mut ring = Ring::new();
    assert_eq!(read::<1>(&mut ring), Err(SampleError::Stopped));
    let decimation = Decimation { fraction_bits: 5, ..settings().decimation };
    let no_ratio = Decimation { ratio: 0, ..settings().decimation };
    for bad in [
        RingSettings { decimation, ..settings() },
        RingSettings { decimation: no_ratio, ..settings() },
        RingSettings { sentinel: RANKS, ..settings() },
    ] {
        ring.start(bad, 0);
        Chip::new().run(&mut ring, 2);
        assert_eq!(read::<1>(&mut ring), Err(SampleError::Stopped));
    }
    ring.start(settings(), 0);
    assert_eq!(read::<{ CAPACITY + 1 }>(&mut ring), Err(SampleError::Stopped));
    ring.stop();
    assert_eq!(read::<1>(&mut ring), Err(SampleError::Stopped));
}

#[test]
fn an_input_that_clipped_once_reads_as_clipped() {
    let mut ring = Ring::new();
    ring.start(settings(), 0);
    let mut raw = [[2000_u16; RANKS]; RATIO as usize];
    raw.iter_mut().for_each(|scan| scan[SENTINEL] = REFERENCE);
    raw[1][0] = 4095;
    raw[2][1] = 0;
    raw[0][2] = 0;
    raw[1][2] = 4095;
    raw[0][3] = 4094;
    ring.feed(raw.as_flattened(), |_, _| {});
    let (_, [scan]) = read::<1>(&mut ring).unwrap().unwrap();
    // 4 × (4094 + 2000 + 2000) / 3 = 10 792
    assert_eq!(scan[..5], [16383, 0, 16383, 10792, 8000]);
}

#[test]
fn a_converter_that_adds_up_itself_clips_below_its_bits() {
    // The converter sums four conversions of 12 bits.
    let decimation = Decimation { raw_bits: 14, raw_full: 16380, ratio: 1, fraction_bits: 2 };
    let mut sums = Sums::<3>::ZERO;
    assert_eq!(sums.add(&[16380, 16379, 0], &decimation), Some([65535, 65516, 0]));
}

#[test]
fn a_scan_may_be_corrected_by_what_its_sentinel_reads() {
    let mut ring = Ring::new();
    ring.start(settings(), 0);
    let mut chip = Chip::new();
    chip.write(LENGTH / 2);
    ring.feed(Half::First.of(&chip.buffer), |scan, sentinel| scan[0] = sentinel);
    let (_, [scan]) = read::<1>(&mut ring).unwrap().unwrap();
    assert_eq!((scan[0], scan[1]), (4 * REFERENCE, mean_of(0)[1]));
}

#[test]
fn codes_of_sixteen_bits_and_the_longest_mean_do_not_wrap() {
    let decimation = Decimation { raw_bits: 12, raw_full: 4095, ratio: u16::MAX, fraction_bits: 4 };
    let mut sums = Sums::<1>::ZERO;
    for _ in 1..u16::MAX {
        assert_eq!(sums.add(&[4094], &decimation), None);
    }
    assert_eq!(sums.add(&[4094], &decimation), Some([4094 * 16]));
}

/// An action of the converter, the interrupt or the reader.
#[derive(Clone, Debug)]
enum Event {
    Write(usize),
    Interrupt { before: usize, after: usize },
    Read,
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        4 => (0..LENGTH / 2).prop_map(Event::Write),
        1 => (0..3 * LENGTH).prop_map(Event::Write),
        4 => Just(Event::Interrupt { before: 0, after: 0 }),
        1 => (0..LENGTH, 0..LENGTH).prop_map(|(before, after)| Event::Interrupt { before, after }),
        3 => Just(Event::Read),
    ]
}

proptest! {
    // The oracle: a scan that is read is the mean of RATIO consecutive raw scans. As long as no overrun
    // is reported, the next scan is made from the raw scans right after them and has the next index.
    #[test]
    fn no_gap_is_silent_and_no_scan_is_torn(events in prop::collection::vec(event(), 1..200)) {
        let (mut ring, mut chip) = started();
        // Index and first raw scan of the next scan.
        let (mut index, mut raw) = (0, Some(0));
        for event in events {
            match event {
                Event::Write(values) => chip.write(values),
                Event::Interrupt { before, after } => chip.interrupt(&mut ring, before, after),
                Event::Read => match read::<2>(&mut ring) {
                    Ok(None) => {}
                    Ok(Some((first, block))) => {
                        prop_assert!(raw.is_none() && first >= index || first == index);
                        let begin = match raw {
                            Some(begin) => begin,
                            None => {
                                // After a gap, search the recent raw scans for the one that the block
                                // starts with.
                                let newest = chip.written / RANKS as u64;
                                let candidates = newest.saturating_sub(NUMBERS - 10)..=newest;
                                let start = candidates.rev().find(|&from| block[0] == mean_of(from));
                                prop_assert!(start.is_some(), "{:?}", block[0]);
                                start.unwrap_or_default()
                            }
                        };
                        prop_assert_eq!(block, [begin, begin + 3].map(mean_of));
                        (index, raw) = (first + 2, Some(begin + 6));
                    }
                    Err(SampleError::Overrun { lost }) => {
                        prop_assert!(lost > 0);
                        (index, raw) = (index + u64::from(lost), None);
                    }
                    Err(stopped) => prop_assert!(false, "{stopped}"),
                },
            }
        }
        prop_assert_eq!(ring.fault(), None);
    }
}
