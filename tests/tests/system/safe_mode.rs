//! A rig whose last starts have all failed: it reads nothing of its store, says what the failure was, and erases the
//! store when it is told to, over the link or by its buttons.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::pictures;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use massline_client::{Client, ClientError};
use massline_firmware::Memory;
use massline_firmware::board::{Board, BootReason};
use massline_firmware::panel::{Button, Cue};
use massline_physics::BenchSource;
use massline_protocol::message::Reason;
use massline_shared::measurement::campaign::Phase;
use massline_tests::campaign::{connect, scans, steady_hand, three_bar};
use massline_tests::person::{Person, power_on, provisioned_with};
use massline_virtual::flash::{Flash, FlashBacking};
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

fn bench() -> Box<BenchSource> {
    scans(&steady_hand("default"), &three_bar(), 1)
}

/// Flash whose content ends every run that reads it.
struct PoisonedFlash(Flash, Arc<AtomicU32>);

impl ErrorType for PoisonedFlash {
    type Error = <Flash as ErrorType>::Error;
}

impl ReadNorFlash for PoisonedFlash {
    const READ_SIZE: usize = Flash::READ_SIZE;

    async fn read(&mut self, _: u32, _: &mut [u8]) -> Result<(), Self::Error> {
        panic!("the store cannot be read");
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for PoisonedFlash {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.1.fetch_add((to - from) / Self::ERASE_SIZE as u32, Ordering::Relaxed);
        self.0.erase(from, to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.0.write(offset, bytes).await
    }
}

/// A rig in which a layout is stored.
struct FailingRig {
    backing: FlashBacking,
    erased: Arc<AtomicU32>,
}

impl FailingRig {
    fn new() -> Self {
        let layout = three_bar().rig_layout().unwrap();
        Self { backing: provisioned_with(&[&layout]), erased: Arc::default() }
    }

    /// Starts it, for this reason.
    fn start(&self, boot_reason: BootReason) -> VirtualRig {
        let options = VirtualRigOptions {
            flash: self.backing.clone(),
            boot_reason,
            last_panic: "store/reading.rs:71: the store cannot be read, at 0x1A0 of page 3",
            ..VirtualRigOptions::new(bench())
        };
        let erased = self.erased.clone();
        VirtualRig::start_application(options, async |board| {
            let Board { info, sampler, link, flash, panel, feed_watchdog } = board;
            let flash = PoisonedFlash(flash, erased);
            let board = Board { info, sampler, link, flash, panel, feed_watchdog };
            let mut memory = Box::new(Memory::new());
            massline_firmware::run(board, &mut memory).await
        })
        .expect("the rig starts")
    }

    fn pages_erased(&self) -> u32 {
        self.erased.load(Ordering::Relaxed)
    }

    /// The rig after its reset, with flash that can be read again, has no layout.
    fn is_empty_after_a_reset(&self) {
        let (rig, person) = power_on(&self.backing, bench());
        person.sees(|model| model.phase == Phase::Idle);
        let refusal = connect(&rig).layout().unwrap_err().refusal();
        assert_eq!(refusal, Some(Reason::NoLayout));
    }
}

fn refusal<T: std::fmt::Debug>(answer: Result<T, ClientError>) -> Option<Reason> {
    answer.unwrap_err().refusal()
}

#[test]
fn any_other_start_ends_in_the_failure() {
    let rig = FailingRig::new().start(BootReason::Panic);
    let client: &mut Client = &mut connect(&rig);
    assert!(client.identify().is_err());
}

#[test]
fn the_host_hears_of_the_failure_and_erases_the_store_once() {
    let failing = FailingRig::new();
    let rig = failing.start(BootReason::SafeMode);
    let mut client = connect(&rig);
    let identity = client.identify().unwrap();
    assert_eq!(BootReason::from(identity.boot_reason), BootReason::SafeMode);
    assert!(identity.last_panic.contains("cannot be read"), "{}", identity.last_panic);
    assert_eq!(refusal(client.status()), Some(Reason::SafeMode));
    assert_eq!(refusal(client.results()), Some(Reason::SafeMode));
    assert_eq!(failing.pages_erased(), 0, "nobody has asked");
    client.erase_store().unwrap();
    client.erase_store().unwrap();
    let pages = Flash::open(&failing.backing).unwrap().capacity() / Flash::ERASE_SIZE;
    assert_eq!(failing.pages_erased() as usize, pages);
    drop((client, rig));
    failing.is_empty_after_a_reset();
}

#[test]
fn a_person_reads_the_failure_and_erases_the_store_by_buttons() {
    let failing = FailingRig::new();
    let rig = failing.start(BootReason::SafeMode);
    let person = Person(rig.panel_view());
    pictures::check("safe-mode-1-failure", &person.press(Button::Next), &[]);
    assert_eq!(person.0.cues(), [Cue::Failed]);
    pictures::check("safe-mode-2-sure", &person.press(Button::Ok), &[]);
    pictures::check("safe-mode-1-failure", &person.press(Button::Back), &[]);
    assert_eq!(failing.pages_erased(), 0, "kept");
    person.presses(&[Button::Ok, Button::Ok]);
    pictures::check("safe-mode-3-erased", &person.press(Button::Next), &[]);
    drop(rig);
    failing.is_empty_after_a_reset();
}
