//! Feeds the scans of a source into the emulated rig's ring.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use massline_mps2_an386::ring::Writer;
use massline_physics::source::ScanSource;

use super::memory::Psram;

/// Polling interval of the ring; the rig cannot wake this process.
const POLL: Duration = Duration::from_micros(100);
/// Interval at which a source without scans is asked again.
const ASK_AGAIN: Duration = Duration::from_millis(5);

/// A thread that feeds the rig with scans. It ends when the feeder is dropped.
#[derive(Debug)]
pub struct Feeder {
    /// `None` only while the thread is being stopped.
    armings: Option<Sender<Arming>>,
    starved: Arc<AtomicU64>,
    thread: Option<JoinHandle<Box<dyn ScanSource>>>,
}

#[derive(Clone, Copy, Debug)]
struct Arming {
    number: u32,
    dof: usize,
}

impl Feeder {
    pub(super) fn start(psram: Arc<Psram>, source: Box<dyn ScanSource>) -> Self {
        let (armings, received) = channel();
        let starved = Arc::new(AtomicU64::new(0));
        let flag = Arc::clone(&starved);
        let thread = thread::spawn(move || {
            let mut source = source;
            serve(&psram, source.as_mut(), &received, &flag);
            source
        });
        Self { armings: Some(armings), starved, thread: Some(thread) }
    }

    /// Notifies the source that the rig waits for a hit at DOF `dof`; `arming` differs each time.
    ///
    /// The rig sees the scans that the source produces from now on in this arming.
    pub fn armed(&self, arming: u32, dof: usize) {
        if let Some(armings) = &self.armings {
            // The thread ends early only when its source panics; `finish` propagates the panic.
            let _ = armings.send(Arming { number: arming, dof });
        }
    }

    /// The number of the arming for which the source has no more scans, so that the rig waits for a hit that
    /// will not come. `None` while scans flow.
    pub fn starved(&self) -> Option<u32> {
        let starved = self.starved.load(Ordering::Acquire);
        (starved & STARVED != 0).then_some(starved as u32)
    }

    /// Stops the feeder and returns the source.
    pub fn finish(mut self) -> Box<dyn ScanSource> {
        self.armings = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(source)) => source,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => unreachable!("the thread is taken here and in drop only"),
        }
    }
}

impl Drop for Feeder {
    fn drop(&mut self) {
        self.armings = None;
        if let Some(thread) = self.thread.take() {
            // The thread has already printed a panic of the source.
            let _ = thread.join();
        }
    }
}

/// Bit set in `starved`, above the number of the arming.
const STARVED: u64 = 1 << 32;

fn serve(
    psram: &Psram,
    source: &mut dyn ScanSource,
    armings: &Receiver<Arming>,
    starved: &AtomicU64,
) {
    let mut writer = Writer::new(psram.ring());
    let Ok(mut arming) = armings.recv() else { return };
    loop {
        starved.store(0, Ordering::Release);
        source.armed(arming.number, arming.dof);
        writer.begin_run();
        arming = loop {
            let pause = if fill(&mut writer, source) {
                starved.store(0, Ordering::Release);
                POLL
            } else {
                starved.store(STARVED | u64::from(arming.number), Ordering::Release);
                ASK_AGAIN
            };
            match armings.recv_timeout(pause) {
                Ok(next) => break next,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
        };
    }
}

/// Writes as many scans as the rig wants; false when the source has fewer.
fn fill(writer: &mut Writer<'_>, source: &mut dyn ScanSource) -> bool {
    let mut enough = true;
    while enough && writer.requested_scans() > 0 {
        match source.next_scan() {
            Some(scan) => {
                writer.push(&scan);
            }
            None => enough = false,
        }
    }
    writer.publish();
    enough
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_mps2_an386::ring::Reader;
    use massline_shared::signal::{AdcProperties, CHANNELS, Scan};
    use massline_shared::units::{Hertz, Seconds, Volts};
    use std::time::Instant;

    const ADC: AdcProperties = AdcProperties {
        rate: Hertz(4000.0),
        channels: 10,
        bits: 12,
        reference: Volts(3.0),
        channel_delay: Seconds(1e-5),
    };

    /// A source with 100 scans per arming; a scan holds the arming, the DOF, and the number of scans before
    /// it.
    struct NumberedScans {
        scan: Scan,
    }

    impl ScanSource for NumberedScans {
        fn adc(&self) -> AdcProperties {
            ADC
        }

        fn armed(&mut self, arming: u32, dof: usize) {
            self.scan = [0; CHANNELS];
            self.scan[0] = arming as u16;
            self.scan[1] = dof as u16;
        }

        fn next_scan(&mut self) -> Option<Scan> {
            if self.scan[2] == 100 {
                return None;
            }
            self.scan[2] += 1;
            Some(self.scan)
        }
    }

    fn rig() -> (Arc<Psram>, Feeder) {
        let psram = Arc::new(Psram::create(&ADC).unwrap());
        let source = NumberedScans { scan: [0; CHANNELS] };
        let feeder = Feeder::start(Arc::clone(&psram), Box::new(source));
        (psram, feeder)
    }

    fn wait_for<T>(event: &str, mut ready: impl FnMut() -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(value) = ready() {
                return value;
            }
            assert!(start.elapsed() < Duration::from_secs(20), "{event} did not come");
            thread::yield_now();
        }
    }

    #[test]
    fn the_rig_reads_each_arming_from_its_first_scan() {
        let (psram, feeder) = rig();
        let mut reader = Reader::new(psram.ring());
        let mut block = [[0; CHANNELS]; 20];
        for arming in 1..5 {
            reader.start();
            feeder.armed(arming, 7);
            for nth in 0..3 {
                wait_for("the block", || reader.read(&mut block));
                assert_eq!(block[0][..3], [arming as u16, 7, nth * 20 + 1]);
            }
            reader.stop();
        }
    }

    #[test]
    fn a_rig_that_wants_more_than_the_source_has_is_starved() {
        let (psram, feeder) = rig();
        let mut reader = Reader::new(psram.ring());
        let mut block = [[0; CHANNELS]; 60];
        reader.start();
        feeder.armed(3, 0);
        wait_for("the first block", || reader.read(&mut block));
        assert_eq!(reader.read(&mut block), None);
        assert_eq!(wait_for("the famine", || feeder.starved()), 3);
        reader.start();
        feeder.armed(4, 0);
        wait_for("the next block", || reader.read(&mut block));
        wait_for("plenty", || feeder.starved().is_none().then_some(()));
    }

    #[test]
    fn a_feeder_that_ends_gives_its_source_back() {
        let (_psram, feeder) = rig();
        feeder.armed(1, 2);
        assert_eq!(feeder.finish().adc(), ADC);
    }
}
