//! The ring of scans between the host and the emulated rig.
//!
//! The rig states up to which scan it wants to read, and the host writes scans up to there. No scan is lost
//! or made unnecessarily, and the speeds of the emulator and the host do not matter. Time is the index of a
//! scan.
//!
//! A *run* is what the rig reads between two starts of its sampler. The rig counts its runs. The host
//! answers a new run, once it knows for which hit the rig is armed, with the index of the run's first scan.
//! Scans that the host wrote before that, for an earlier run, are never read.
//!
//! Each word of the header is written by one side only. Indices count scans modulo 2³².

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};

use massline_shared::signal::{AdcProperties, CHANNELS, Scan};
use massline_shared::units::{Hertz, ScanIndex, Seconds, Volts};

/// Scans that the ring holds, which is also the most that can be read at once.
pub const CAPACITY: u32 = 4096;
const _: () = assert!(CAPACITY.is_power_of_two());

const MAGIC: u32 = u32::from_le_bytes(*b"mlsc");
const VERSION: u32 = 1;

/// The ring in the PSRAM. All zeros is a ring that no host has opened.
#[repr(C, align(64))]
#[derive(Debug)]
pub struct Ring {
    host: HostWords,
    rig: RigWords,
    scans: [[AtomicU16; CHANNELS]; CAPACITY as usize],
}

/// Words that only the host writes.
#[repr(C, align(64))]
#[derive(Debug, Default)]
struct HostWords {
    magic: AtomicU32,
    version: AtomicU32,
    capacity: AtomicU32,
    rate_hz: AtomicU32,
    channels: AtomicU32,
    bits: AtomicU32,
    reference_v: AtomicU32,
    channel_delay_s: AtomicU32,
    written: AtomicU32,
    run: AtomicU32,
    run_start: AtomicU32,
}

/// Words that only the rig writes.
#[repr(C, align(64))]
#[derive(Debug, Default)]
struct RigWords {
    read: AtomicU32,
    wanted: AtomicU32,
    run: AtomicU32,
}

impl Ring {
    /// A ring that no host has opened.
    pub fn new() -> Self {
        Self {
            host: HostWords::default(),
            rig: RigWords::default(),
            scans: core::array::from_fn(|_| Default::default()),
        }
    }

    /// Opens the ring before the rig starts, and states the properties of the scans.
    pub fn open(&self, adc: &AdcProperties) {
        let host = &self.host;
        for (word, value) in [
            (&host.version, VERSION),
            (&host.capacity, CAPACITY),
            (&host.rate_hz, adc.rate.0.to_bits()),
            (&host.channels, u32::from(adc.channels)),
            (&host.bits, u32::from(adc.bits)),
            (&host.reference_v, adc.reference.0.to_bits()),
            (&host.channel_delay_s, adc.channel_delay.0.to_bits()),
        ] {
            word.store(value, Ordering::Relaxed);
        }
        host.magic.store(MAGIC, Ordering::Release);
    }

    /// Properties of the scans; `None` when no host has opened the ring or its words are invalid.
    pub fn adc(&self) -> Option<AdcProperties> {
        let host = &self.host;
        let word = |word: &AtomicU32| word.load(Ordering::Relaxed);
        let real = |at: &AtomicU32| Some(f32::from_bits(word(at))).filter(|x| x.is_finite());
        if host.magic.load(Ordering::Acquire) != MAGIC
            || word(&host.version) != VERSION
            || word(&host.capacity) != CAPACITY
        {
            return None;
        }
        Some(AdcProperties {
            rate: Hertz(real(&host.rate_hz).filter(|&rate| rate > 0.0)?),
            channels: u8::try_from(word(&host.channels))
                .ok()
                .filter(|&n| (1..=CHANNELS).contains(&usize::from(n)))?,
            bits: u8::try_from(word(&host.bits)).ok().filter(|n| (1..=16).contains(n))?,
            reference: Volts(real(&host.reference_v).filter(|&volts| volts > 0.0)?),
            channel_delay: Seconds(real(&host.channel_delay_s).filter(|&delay| delay >= 0.0)?),
        })
    }
}

impl Default for Ring {
    fn default() -> Self {
        Self::new()
    }
}

/// The host's side of the ring. There must be only one.
#[derive(Debug)]
pub struct Writer<'a> {
    ring: &'a Ring,
    written: u32,
}

impl<'a> Writer<'a> {
    /// A writer that continues where a previous one stopped.
    pub fn new(ring: &'a Ring) -> Self {
        Self { ring, written: ring.host.written.load(Ordering::Relaxed) }
    }

    /// Answers the rig's run: its first scan is the next one pushed.
    pub fn begin_run(&mut self) {
        let run = self.ring.rig.run.load(Ordering::Acquire);
        self.publish();
        self.ring.host.run_start.store(self.written, Ordering::Relaxed);
        self.ring.host.run.store(run, Ordering::Release);
    }

    /// Number of scans that the rig waits for.
    pub fn requested_scans(&self) -> u32 {
        let missing = self.ring.rig.wanted.load(Ordering::Acquire).wrapping_sub(self.written);
        // The index that an old run wanted may be before the start of the new run.
        if missing <= CAPACITY { missing } else { 0 }
    }

    /// Writes one scan, which the rig can read after [`Self::publish`]; returns false when the rig does
    /// not want it.
    pub fn push(&mut self, scan: &Scan) -> bool {
        if self.requested_scans() == 0 {
            return false;
        }
        for (place, &code) in self.ring.place(self.written).iter().zip(scan) {
            place.store(code, Ordering::Relaxed);
        }
        self.written = self.written.wrapping_add(1);
        true
    }

    /// Makes everything that was pushed readable for the rig.
    pub fn publish(&self) {
        self.ring.host.written.store(self.written, Ordering::Release);
    }
}

/// The rig's side of the ring. There must be only one.
#[derive(Debug)]
pub struct Reader<'a> {
    ring: &'a Ring,
    read: u32,
    run: u32,
    /// Upper bits that extend `read` to the count since power-on.
    index: u64,
    running: bool,
    in_run: bool,
}

impl<'a> Reader<'a> {
    /// A reader that is not running.
    pub fn new(ring: &'a Ring) -> Self {
        Self {
            ring,
            read: ring.rig.read.load(Ordering::Relaxed),
            run: ring.rig.run.load(Ordering::Relaxed),
            index: 0,
            running: false,
            in_run: false,
        }
    }

    /// Starts a run. Nothing can be read until the host has answered it.
    pub fn start(&mut self) {
        self.run = self.run.wrapping_add(1);
        self.in_run = false;
        self.running = true;
        self.ring.rig.run.store(self.run, Ordering::Release);
    }

    /// Ends the run.
    pub fn stop(&mut self) {
        self.running = false;
    }

    /// True between start and stop.
    pub fn running(&self) -> bool {
        self.running
    }

    /// Fills `block` and returns the index of its first scan. If the scans are not available yet,
    /// requests them and leaves `block` unchanged; also when it is longer than [`CAPACITY`].
    pub fn read(&mut self, block: &mut [Scan]) -> Option<ScanIndex> {
        if !self.running || !self.enter_run() {
            return None;
        }
        let wanted = u32::try_from(block.len()).ok().filter(|&count| count <= CAPACITY)?;
        self.ring.rig.wanted.store(self.read.wrapping_add(wanted), Ordering::Release);
        let written = self.ring.host.written.load(Ordering::Acquire);
        if written.wrapping_sub(self.read) < wanted {
            return None;
        }
        let first = self.index;
        for (offset, scan) in (0..).zip(block) {
            let place = self.ring.place(self.read.wrapping_add(offset));
            for (code, place) in scan.iter_mut().zip(place) {
                *code = place.load(Ordering::Relaxed);
            }
        }
        self.advance(wanted);
        Some(ScanIndex(first))
    }

    fn enter_run(&mut self) -> bool {
        if !self.in_run && self.ring.host.run.load(Ordering::Acquire) == self.run {
            let start = self.ring.host.run_start.load(Ordering::Relaxed);
            self.advance(start.wrapping_sub(self.read));
            self.ring.rig.wanted.store(start, Ordering::Release);
            self.in_run = true;
        }
        self.in_run
    }

    fn advance(&mut self, scans: u32) {
        self.read = self.read.wrapping_add(scans);
        self.index += u64::from(scans);
        self.ring.rig.read.store(self.read, Ordering::Release);
    }
}

impl Ring {
    fn place(&self, index: u32) -> &[AtomicU16; CHANNELS] {
        &self.scans[(index % CAPACITY) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADC: AdcProperties = AdcProperties {
        rate: Hertz(4000.0),
        channels: 10,
        bits: 12,
        reference: Volts(3.3),
        channel_delay: Seconds(1e-6),
    };

    fn scan(n: u32) -> Scan {
        core::array::from_fn(|channel| (n as u16).wrapping_mul(10).wrapping_add(channel as u16))
    }

    /// Pushes scans from number `next` on while the rig wants them; returns the number after the last.
    fn serve(writer: &mut Writer<'_>, mut next: u32) -> u32 {
        while writer.push(&scan(next)) {
            next += 1;
        }
        writer.publish();
        next
    }

    #[test]
    fn the_rig_reads_what_the_host_states_of_the_converter() {
        let ring = Ring::new();
        assert_eq!(ring.adc(), None);
        ring.open(&ADC);
        assert_eq!(ring.adc(), Some(ADC));
    }

    #[test]
    fn words_that_make_no_sense_are_no_converter() {
        for spoil in [
            (|ring| ring.host.version.store(2, Ordering::Relaxed)) as fn(&Ring),
            |ring| ring.host.channels.store(11, Ordering::Relaxed),
            |ring| ring.host.bits.store(0, Ordering::Relaxed),
            |ring| ring.host.rate_hz.store(f32::NAN.to_bits(), Ordering::Relaxed),
            |ring| ring.host.reference_v.store(0, Ordering::Relaxed),
        ] {
            let ring = Ring::new();
            ring.open(&ADC);
            spoil(&ring);
            assert_eq!(ring.adc(), None);
        }
    }

    #[test]
    fn scans_come_out_as_they_went_in_over_many_laps() {
        let ring = Ring::new();
        let (mut writer, mut reader) = (Writer::new(&ring), Reader::new(&ring));
        reader.start();
        writer.begin_run();
        let mut block = [[0; CHANNELS]; 100];
        let (mut pushed, mut seen) = (0, 0);
        while seen < 5 * CAPACITY {
            let Some(index) = reader.read(&mut block) else {
                pushed = serve(&mut writer, pushed);
                continue;
            };
            assert_eq!(index.0, u64::from(seen));
            for got in &block {
                assert_eq!(*got, scan(seen));
                seen += 1;
            }
        }
    }

    #[test]
    fn the_host_writes_no_more_than_the_rig_asks_for() {
        let ring = Ring::new();
        let (mut writer, mut reader) = (Writer::new(&ring), Reader::new(&ring));
        assert_eq!(serve(&mut writer, 0), 0);
        reader.start();
        writer.begin_run();
        assert_eq!(serve(&mut writer, 0), 0);
        let mut block = [[0; CHANNELS]; 20];
        assert_eq!(reader.read(&mut block), None);
        assert_eq!(serve(&mut writer, 0), 20);
        assert_eq!(reader.read(&mut block), Some(ScanIndex(0)));
        assert_eq!(serve(&mut writer, 20), 20);
    }

    #[test]
    fn a_block_longer_than_the_ring_never_comes() {
        let ring = Ring::new();
        let (mut writer, mut reader) = (Writer::new(&ring), Reader::new(&ring));
        reader.start();
        writer.begin_run();
        let mut block = vec![[0; CHANNELS]; CAPACITY as usize + 1];
        assert_eq!(reader.read(&mut block), None);
        assert_eq!(serve(&mut writer, 0), 0);
        assert_eq!(reader.read(&mut block[1..]), None);
        assert_eq!(serve(&mut writer, 0), CAPACITY);
        assert_eq!(reader.read(&mut block[1..]), Some(ScanIndex(0)));
    }

    #[test]
    fn a_run_sees_nothing_of_the_run_before_however_late_it_came() {
        let ring = Ring::new();
        let (mut writer, mut reader) = (Writer::new(&ring), Reader::new(&ring));
        let mut block = [[0; CHANNELS]; 8];
        reader.start();
        writer.begin_run();
        assert_eq!(reader.read(&mut block), None);
        reader.stop();
        reader.start();
        // The host has not seen the new run yet.
        assert_eq!(serve(&mut writer, 100), 108);
        assert_eq!(reader.read(&mut block), None);
        writer.begin_run();
        assert_eq!(reader.read(&mut block), None);
        assert_eq!(serve(&mut writer, 1000), 1008);
        assert_eq!(reader.read(&mut block), Some(ScanIndex(8)));
        assert_eq!(block[0], scan(1000));
    }

    #[test]
    fn a_rig_that_restarts_goes_on_with_the_same_ring() {
        let ring = Ring::new();
        let mut writer = Writer::new(&ring);
        let mut block = [[0; CHANNELS]; 4];
        for first in [0, 10] {
            let mut reader = Reader::new(&ring);
            reader.start();
            assert_eq!(reader.read(&mut block), None);
            writer.begin_run();
            assert_eq!(reader.read(&mut block), None);
            assert_eq!(serve(&mut writer, first), first + 4);
            assert_eq!(reader.read(&mut block), Some(ScanIndex(0)));
            assert_eq!(block[0], scan(first));
        }
    }
}
