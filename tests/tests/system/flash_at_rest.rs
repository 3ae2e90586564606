//! Flash is written and erased only while the sampler is stopped: on most chips it stops the core, and scans would be
//! lost.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex};

use embassy_futures::yield_now;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use massline_client::Client;
use massline_client::campaign::{StartOptions, begin};
use massline_firmware::Memory;
use massline_firmware::board::{Board, SampleError, Sampler};
use massline_firmware::panel::{Button, PanelModel};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::measurement::campaign::{Command, Phase};
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::ScanIndex;
use massline_tests::campaign::{LATE, connect, scans, steady_hand, three_bar};
use massline_virtual::flash::Flash;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

/// What sampler and flash do.
#[derive(Default)]
struct Activity {
    samples: AtomicBool,
    starts: AtomicU32,
    erases: AtomicU32,
    writes: AtomicU32,
    /// Of them those while the sampler ran.
    during_samples: AtomicU32,
    /// Writes are held until this is false again, and the next one says so.
    held: AtomicBool,
    holds: Mutex<Option<Sender<()>>>,
}

impl Activity {
    fn changes_flash(&self, count: &AtomicU32) {
        count.fetch_add(1, Ordering::Relaxed);
        let samples = self.samples.load(Ordering::Relaxed);
        self.during_samples.fetch_add(samples.into(), Ordering::Relaxed);
    }
}

impl Activity {
    /// Waits while writes are held, and some rounds of all tasks more.
    async fn hold(&self) {
        let holds = self.holds.lock().unwrap().take();
        if let Some(holds) = holds {
            holds.send(()).unwrap();
            while self.held.load(Ordering::Acquire) {
                yield_now().await;
            }
            for _ in 0..ROUNDS {
                yield_now().await;
            }
        }
    }
}

/// Rounds of the rig's tasks in which a pressed button has its effect.
const ROUNDS: u32 = 100;

struct SeenSampler<S>(S, Arc<Activity>);

impl<S: Sampler> Sampler for SeenSampler<S> {
    fn adc(&self) -> AdcProperties {
        self.0.adc()
    }

    async fn start(&mut self) -> Result<(), SampleError> {
        self.1.samples.store(true, Ordering::Relaxed);
        self.1.starts.fetch_add(1, Ordering::Relaxed);
        self.0.start().await
    }

    async fn read(&mut self, block: &mut [Scan]) -> Result<ScanIndex, SampleError> {
        self.0.read(block).await
    }

    fn stop(&mut self) {
        self.0.stop();
        self.1.samples.store(false, Ordering::Relaxed);
    }
}

struct SeenFlash(Flash, Arc<Activity>);

impl ErrorType for SeenFlash {
    type Error = <Flash as ErrorType>::Error;
}

impl ReadNorFlash for SeenFlash {
    const READ_SIZE: usize = Flash::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.0.read(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for SeenFlash {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.1.changes_flash(&self.1.erases);
        self.0.erase(from, to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.1.hold().await;
        self.1.changes_flash(&self.1.writes);
        self.0.write(offset, bytes).await
    }
}

fn start(seen: &Arc<Activity>) -> VirtualRig {
    let seen = seen.clone();
    let options = VirtualRigOptions::new(scans(&steady_hand("default"), &three_bar(), 1));
    VirtualRig::start_application(options, async move |board| {
        let Board { info, sampler, link, flash, panel, feed_watchdog } = board;
        let (sampler, flash) = (SeenSampler(sampler, seen.clone()), SeenFlash(flash, seen));
        let board = Board { info, sampler, link, flash, panel, feed_watchdog };
        let mut memory = Box::new(Memory::new());
        massline_firmware::run(board, &mut memory).await
    })
    .expect("the rig starts")
}

/// A campaign during which the host asks to store a calibration again and again; the number of its result, and how
/// often that was refused.
fn insistent_campaign(client: &mut Client) -> (u32, u32) {
    begin(client, StartOptions::default()).unwrap();
    let mut refused = 0;
    loop {
        let status = client.status().unwrap();
        match Phase::try_from(status.phase) {
            Ok(Phase::Done) => return (status.result, refused),
            // The campaign may end before the request arrives.
            Ok(_) => {
                refused +=
                    u32::from(client.put_calibration(&CalibrationRecord::default()).is_err());
            }
            Err(_) => panic!("{status:?}"),
        }
    }
}

#[test]
fn flash_is_changed_only_while_the_sampler_is_stopped() {
    let seen = Arc::new(Activity::default());
    let rig = start(&seen);
    let client = &mut connect(&rig);
    client.put_layout(&three_bar().rig_layout().unwrap()).unwrap();
    let erased = || seen.erases.load(Ordering::Relaxed);
    let at_start = erased();
    // Until the store has had to make room several times.
    while erased() < at_start + 5 {
        let (number, refused) = insistent_campaign(client);
        assert!(refused > 0);
        client.delete_result(number).unwrap();
    }
    assert!(seen.starts.load(Ordering::Relaxed) > 15 && seen.writes.load(Ordering::Relaxed) > 15);
    assert_eq!(seen.during_samples.load(Ordering::Relaxed), 0);
}

/// A person goes on with a paused campaign while a result is being deleted.
#[test]
fn nothing_is_resumed_while_a_result_is_deleted() {
    let seen = Arc::new(Activity::default());
    let rig = start(&seen);
    let client = &mut connect(&rig);
    client.put_layout(&three_bar().rig_layout().unwrap()).unwrap();
    let (number, _) = insistent_campaign(client);
    // It waits with its first hit until it is paused.
    begin(client, StartOptions { confirm: true, ..StartOptions::default() }).unwrap();
    client.command(Command::Pause).unwrap();
    let paused = |model: &PanelModel| model.phase == Phase::Paused;
    rig.wait_for(LATE, paused).expect("it is paused");
    let (holds, held) = mpsc::channel();
    seen.held.store(true, Ordering::Release);
    *seen.holds.lock().unwrap() = Some(holds);
    std::thread::scope(|scope| {
        let deleting = scope.spawn(|| client.delete_result(number));
        held.recv().expect("the deletion is written");
        // "Go on".
        rig.press(Button::Ok);
        seen.held.store(false, Ordering::Release);
        deleting.join().unwrap().expect("it is deleted");
    });
    // The press is refused. Where the panel had to wait for the store with a picture, it counts after the deletion.
    assert_eq!(seen.during_samples.load(Ordering::Relaxed), 0);
}
