//! What a rig says about its clock and supply, and what it does while the supply is too low to write flash.

use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::time::Duration;

use massline_client::campaign::{CampaignOutcome, Observer, StartOptions, begin, follow};
use massline_client::interrupt::Interrupt;
use massline_client::{Client, ClientError};
use massline_firmware::board::{BrownOut, Clock, Supply};
use massline_protocol::message::{Battery, Hardware, Reason};
use massline_shared::diagnosis::Code;
use massline_tests::campaign::{connect, scans, steady_hand, three_bar};
use massline_tests::person::Person;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

/// The supply of the rig of a test, and whether it is low. A board reads it from registers, so it is static.
macro_rules! supply {
    () => {{
        static LOW: AtomicBool = AtomicBool::new(false);
        static LEVEL: AtomicU16 = AtomicU16::new(1700);
        let supply = Supply {
            is_low: || LOW.load(Ordering::Relaxed),
            brown_out: Some(BrownOut {
                read: || LEVEL.load(Ordering::Relaxed),
                raise: || LEVEL.store(2700, Ordering::Relaxed),
            }),
            battery: None,
        };
        (supply, &LOW)
    }};
}

fn start(clock: Clock, supply: Supply) -> VirtualRig {
    let source = scans(&steady_hand("default"), &three_bar(), 1);
    VirtualRig::start(VirtualRigOptions { clock, supply, ..VirtualRigOptions::new(source) })
        .expect("the rig starts")
}

fn refusal<T: std::fmt::Debug>(answer: Result<T, ClientError>) -> Option<Reason> {
    answer.unwrap_err().refusal()
}

#[test]
fn clock_and_supply_are_reported_and_the_brown_out_level_is_raised() {
    let (supply, is_low) = supply!();
    let rig = start(Clock::Internal, supply);
    let mut client = connect(&rig);
    let hardware = |brown_out_mv, supply_is_low| {
        let clock = Clock::Internal.into();
        Some(Hardware {
            clock,
            brown_out_mv: Some(brown_out_mv),
            supply_is_low,
            ..Hardware::default()
        })
    };
    assert_eq!(client.hardware().unwrap(), hardware(1700, false));
    is_low.store(true, Ordering::Relaxed);
    assert_eq!(refusal(client.raise_brown_out()), Some(Reason::SupplyLow));
    assert_eq!(client.hardware().unwrap(), hardware(1700, true));
    is_low.store(false, Ordering::Relaxed);
    client.raise_brown_out().unwrap();
    assert_eq!(client.hardware().unwrap(), hardware(2700, false));
}

#[test]
fn a_board_without_a_level_says_so() {
    let rig = start(Clock::Unknown, Supply::STEADY);
    let mut client = connect(&rig);
    assert_eq!(client.hardware().unwrap(), Some(Hardware::default()));
    assert_eq!(refusal(client.raise_brown_out()), Some(Reason::UnknownMessage));
}

#[test]
fn the_charge_of_a_battery_is_reported_and_shown_without_a_button() {
    static MILLIVOLTS: AtomicU16 = AtomicU16::new(3840);
    let battery = || match MILLIVOLTS.load(Ordering::Relaxed) {
        0 => None,
        millivolts => Some(Battery { millivolts, percent: 64 }),
    };
    let rig = start(Clock::Crystal, Supply { battery: Some(battery), ..Supply::STEADY });
    let mut client = connect(&rig);
    assert_eq!(client.battery().unwrap(), battery());
    let person = Person(rig.panel_view());
    person.sees(|model| model.battery.is_some_and(|battery| battery.millivolts == 3840));
    // A gauge that no longer answers.
    MILLIVOLTS.store(0, Ordering::Relaxed);
    assert_eq!(client.battery().unwrap(), None);
    person.sees(|model| model.battery.is_none());
    let without = start(Clock::Crystal, Supply::STEADY);
    assert_eq!(connect(&without).battery().unwrap(), None);
}

#[test]
fn with_too_little_supply_nothing_is_written_or_erased() {
    let (supply, is_low) = supply!();
    let rig = start(Clock::Crystal, supply);
    let mut client = connect(&rig);
    let layout = three_bar().rig_layout().unwrap();
    is_low.store(true, Ordering::Relaxed);
    for _ in 0..3 {
        assert_eq!(refusal(client.put_layout(&layout)), Some(Reason::SupplyLow));
    }
    let stats = client.stats().unwrap();
    assert_eq!((stats.flash_erases, stats.flash_bytes_written, stats.store_failures), (0, 0, 0));
    is_low.store(false, Ordering::Relaxed);
    client.put_layout(&layout).unwrap();
    assert!(client.stats().unwrap().flash_bytes_written > 0);
}

/// Takes the supply away when the second DOF is waited for.
struct FadingSupply(&'static AtomicBool);

impl Observer for FadingSupply {
    fn armed(&mut self, _: u32, dof: usize) -> massline::Result<()> {
        self.0.store(dof > 0, Ordering::Relaxed);
        Ok(())
    }
}

#[test]
fn a_campaign_on_a_fading_supply_goes_on_and_its_result_is_not_called_stored() {
    let (supply, is_low) = supply!();
    let rig = start(Clock::Crystal, supply);
    let client: &mut Client = &mut connect(&rig);
    client.put_layout(&three_bar().rig_layout().unwrap()).unwrap();
    begin(client, StartOptions::default()).unwrap();
    let late = Some(Duration::from_secs(60));
    let outcome = follow(client, &Interrupt::new(), late, &mut FadingSupply(is_low));
    // The first DOF is noted before the supply fades, so the rig stops where it would store the result.
    let Ok(CampaignOutcome::Stopped(status)) = outcome else { panic!("{outcome:?}") };
    assert_eq!(status.diagnostics[0].code, Code::ResultNotStored);
    assert!(client.results().unwrap().is_empty());
}
