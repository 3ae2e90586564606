//! The sampler of the virtual rig: hands out the scans that a [`ScanSource`] makes.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Poll, Waker};
use std::{fmt, future};

use embassy_time::{Duration, Instant, TICK_HZ, Timer, with_timeout};
use massline_firmware::board::{SampleError, Sampler};
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::ScanIndex;

use crate::clock;
use crate::pipe::Backlog;
use massline_physics::source::ScanSource;

/// How the time of scans relates to the wall clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// A block is returned when the wall clock reaches its end.
    RealTime,
    /// A block is returned as soon as it is computed, and the rig's time skips to its end. The sampler
    /// waits for a host that is slow to read, so that it loses nothing of a stream, but only for a
    /// limited time.
    #[default]
    Simulated,
}

/// A host that reads nothing for this long is no longer waited for until it has caught up.
const PATIENCE: Duration = Duration::from_secs(1);

/// The source of a rig, shared by its sampler, its panel and whoever pokes it. Clones refer to the same
/// source.
#[derive(Clone)]
pub struct SharedSource(Arc<Mutex<Inner>>);

struct Inner {
    source: Box<dyn ScanSource>,
    /// The sampler's task while it waits for the source to have scans again.
    waiting: Option<Waker>,
}

impl fmt::Debug for SharedSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SharedSource")
    }
}

impl SharedSource {
    /// Shares `source`.
    pub fn new(source: Box<dyn ScanSource>) -> Self {
        Self(Arc::new(Mutex::new(Inner { source, waiting: None })))
    }

    /// Makes a waiting sampler ask the source again, after an event to which the source responds with
    /// scans, such as a manual tap.
    pub fn poke(&self) {
        self.lock().poke();
    }

    /// Rate, resolution and delay of the source.
    pub fn adc(&self) -> AdcProperties {
        self.lock().source.adc()
    }

    /// Notifies the source that the rig waits for a hit, as the person reads it on the panel.
    pub fn armed(&self, arming: u32, dof: usize) {
        let mut inner = self.lock();
        inner.source.armed(arming, dof);
        inner.poke();
    }

    /// The lock survives a panic of the source: that panic ends the rig, which asks for no more scans.
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn poke(&mut self) {
        if let Some(waker) = self.waiting.take() {
            waker.wake();
        }
    }
}

/// A [`Sampler`] over a source. It never overruns: the source makes a scan when it is asked for one.
///
/// `read` yields to the other tasks of the rig once per block. While the source has no scans, `read`
/// waits, and no time is skipped.
#[derive(Debug)]
pub struct SourceSampler {
    source: SharedSource,
    adc: AdcProperties,
    timing: Timing,
    running: bool,
    /// Scans taken from the source since power-on.
    taken: u64,
    /// When scan number `paced_from` is due; reset after every wait.
    epoch: Instant,
    paced_from: u64,
    backlog: Option<Backlog>,
    /// The host did not read within `PATIENCE` and has not caught up since.
    host_is_away: bool,
}

impl SourceSampler {
    /// A sampler that has not been started.
    pub fn new(source: SharedSource, timing: Timing) -> Self {
        let adc = source.adc();
        let epoch = Instant::now();
        Self {
            source,
            adc,
            timing,
            running: false,
            taken: 0,
            epoch,
            paced_from: 0,
            backlog: None,
            host_is_away: false,
        }
    }

    /// The same sampler, but in simulated time it waits for a host that is slow to read.
    pub fn waiting_for(self, backlog: Backlog) -> Self {
        Self { backlog: Some(backlog), ..self }
    }

    fn pace_anew(&mut self) {
        self.epoch = Instant::now();
        self.paced_from = self.taken;
    }

    /// The time at which the last scan taken ends.
    fn due(&self) -> Instant {
        let seconds = (self.taken - self.paced_from) as f64 / f64::from(self.adc.rate.0);
        self.epoch + Duration::from_ticks((seconds * TICK_HZ as f64) as u64)
    }

    /// The next scan, as soon as the source has one.
    async fn next_scan(&mut self) -> Scan {
        let mut waited = false;
        let scan = future::poll_fn(|cx| {
            let mut inner = self.source.lock();
            if let Some(scan) = inner.source.next_scan() {
                return Poll::Ready(scan);
            }
            waited = true;
            inner.waiting = Some(cx.waker().clone());
            Poll::Pending
        })
        .await;
        if waited {
            self.pace_anew();
        }
        self.taken += 1;
        scan
    }

    async fn pace(&mut self) {
        match self.timing {
            Timing::RealTime => Timer::at(self.due()).await,
            Timing::Simulated => {
                self.wait_for_host().await;
                clock::advance_to(self.due());
                // Time lost because computing took longer than the scans is not made up.
                self.pace_anew();
            }
        }
        embassy_futures::yield_now().await;
    }

    async fn wait_for_host(&mut self) {
        let Some(backlog) = &self.backlog else { return };
        self.host_is_away = if self.host_is_away {
            !backlog.is_small()
        } else {
            with_timeout(PATIENCE, backlog.small()).await.is_err()
        };
    }
}

impl Sampler for SourceSampler {
    fn adc(&self) -> AdcProperties {
        self.adc
    }

    async fn start(&mut self) -> Result<(), SampleError> {
        self.running = true;
        self.source.lock().source.started();
        self.pace_anew();
        Ok(())
    }

    async fn read(&mut self, block: &mut [Scan]) -> Result<ScanIndex, SampleError> {
        if !self.running {
            return Err(SampleError::Stopped);
        }
        let first = ScanIndex(self.taken);
        for scan in block {
            *scan = self.next_scan().await;
        }
        self.pace().await;
        Ok(first)
    }

    fn stop(&mut self) {
        self.running = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Executor;
    use embassy_futures::join::join;
    use embassy_futures::poll_once;
    use embassy_futures::select::{Either, select};
    use embedded_io_async::Write as _;
    use massline_firmware::board::Link;
    use massline_shared::units::{Hertz, Seconds, Volts};
    use std::io::Read as _;
    use std::time::Instant as WallInstant;

    const ADC: AdcProperties = AdcProperties {
        rate: Hertz(2000.0),
        channels: 10,
        bits: 12,
        reference: Volts(3.3),
        channel_delay: Seconds(0.0),
    };

    /// Counts; each arming releases `grant` more scans.
    struct Counter {
        next: u16,
        allowed: u16,
        grant: u16,
    }

    impl ScanSource for Counter {
        fn adc(&self) -> AdcProperties {
            ADC
        }

        fn armed(&mut self, _arming: u32, _dof: usize) {
            self.allowed += self.grant;
        }

        fn next_scan(&mut self) -> Option<Scan> {
            (self.next < self.allowed).then(|| {
                self.next += 1;
                [self.next - 1; 10]
            })
        }
    }

    fn sampler(allowed: u16, timing: Timing) -> SourceSampler {
        let source = Counter { next: 0, allowed, grant: 100 };
        SourceSampler::new(SharedSource::new(Box::new(source)), timing)
    }

    fn run<T>(future: impl Future<Output = T>) -> T {
        Executor::default().run(future).unwrap()
    }

    #[test]
    fn scans_are_numbered_on_over_stop_and_start() {
        let mut sampler = sampler(100, Timing::Simulated);
        run(async {
            let mut block = [[0; 10]; 16];
            for expected in [0, 16] {
                sampler.start().await.unwrap();
                assert_eq!(sampler.read(&mut block).await, Ok(ScanIndex(expected)));
                assert_eq!(block[15], [expected as u16 + 15; 10]);
                sampler.stop();
            }
            assert_eq!(sampler.read(&mut block).await, Err(SampleError::Stopped));
        });
    }

    #[test]
    fn a_read_that_is_given_up_leaves_a_jump_in_the_numbers() {
        let mut sampler = sampler(10, Timing::Simulated);
        run(async {
            sampler.start().await.unwrap();
            let mut block = [[0; 10]; 16];
            assert!(poll_once(sampler.read(&mut block)).is_pending());
            sampler.source.armed(1, 0);
            assert_eq!(sampler.read(&mut block).await, Ok(ScanIndex(10)));
            assert_eq!(block[0], [10; 10]);
        });
    }

    #[test]
    fn simulated_time_is_the_time_of_the_scans() {
        let mut sampler = sampler(u16::MAX, Timing::Simulated);
        run(async {
            sampler.start().await.unwrap();
            let (begin, wall) = (Instant::now(), WallInstant::now());
            for _ in 0..100 {
                sampler.read(&mut [[0; 10]; 64]).await.unwrap();
            }
            // 6400 scans at 2 kHz; the rig's ticks are 1 µs, and rounding may lose one tick per block.
            let rig = begin.elapsed().as_micros() as f64;
            assert!(rig >= 3.2e6 - 100.0, "{rig}");
            assert!(rig <= 3.2e6 + wall.elapsed().as_micros() as f64, "{rig}");
        });
    }

    #[test]
    fn in_real_time_a_block_comes_when_the_wall_clock_has_reached_its_end() {
        let mut sampler = sampler(100, Timing::RealTime);
        run(async {
            let wall = WallInstant::now();
            sampler.start().await.unwrap();
            sampler.read(&mut [[0; 10]; 20]).await.unwrap();
            assert!(wall.elapsed() >= std::time::Duration::from_millis(10));
        });
    }

    #[test]
    fn an_arming_goes_on_with_a_block_that_waits_and_no_time_is_skipped() {
        let mut sampler = sampler(0, Timing::Simulated);
        let source = sampler.source.clone();
        run(async {
            sampler.start().await.unwrap();
            let (begin, wall) = (Instant::now(), WallInstant::now());
            let mut block = [[0; 10]; 64];
            let arming = async {
                Timer::after_millis(2).await;
                assert!(begin.elapsed().as_micros() <= wall.elapsed().as_micros() as u64 + 2);
                source.armed(1, 0);
            };
            let (first, ()) = join(sampler.read(&mut block), arming).await;
            assert_eq!(first, Ok(ScanIndex(0)));
        });
    }

    #[test]
    fn a_host_that_is_behind_is_waited_for_but_not_for_ever() {
        let (link, mut host) = crate::pipe::pipe(100);
        let mut sampler = sampler(u16::MAX, Timing::Simulated).waiting_for(link.backlog());
        let (_rx, mut tx) = link.split();
        run(async {
            sampler.start().await.unwrap();
            let mut block = [[0; 10]; 8];
            tx.write_all(&[0; 51]).await.unwrap();
            assert!(poll_once(sampler.read(&mut block)).is_pending());
            host.read_exact(&mut [0; 1]).unwrap();
            sampler.read(&mut block).await.unwrap();
            tx.write_all(&[0; 1]).await.unwrap();
            let begin = Instant::now();
            sampler.read(&mut block).await.unwrap();
            assert!(begin.elapsed() >= PATIENCE);
            // Once the sampler has given up, it does not wait again until the host has read.
            assert!(sampler.host_is_away);
            sampler.read(&mut block).await.unwrap();
            host.read_exact(&mut [0; 1]).unwrap();
            sampler.read(&mut block).await.unwrap();
            assert!(!sampler.host_is_away);
        });
    }

    #[test]
    fn a_reader_of_blocks_lets_the_others_live() {
        let mut sampler = sampler(u16::MAX, Timing::Simulated);
        run(async {
            sampler.start().await.unwrap();
            let reading = async {
                loop {
                    sampler.read(&mut [[0; 10]; 8]).await.unwrap();
                }
            };
            let counting = async {
                for _ in 0..50 {
                    embassy_futures::yield_now().await;
                }
            };
            let either: Either<(), ()> = select(reading, counting).await;
            assert!(matches!(either, Either::Second(())));
        });
        assert!(sampler.taken >= 8 * 50);
    }
}
