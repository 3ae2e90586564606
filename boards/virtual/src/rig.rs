//! A running rig: the application on its own thread, and the host's handle to it.

use std::convert::Infallible;
use std::fmt;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use massline_firmware::Memory;
use massline_firmware::board::{
    Board, BoardInfo, BootReason, Circuit, Clock, ConverterFault, NO_CONVERTER_FAULT, StackUse,
    Supply,
};
use massline_firmware::panel::{Button, PanelModel};

use crate::clock::Executor;
use crate::flash::{Flash, FlashBacking, FlashOpenError};
use crate::panel::{OperatorPanel, PanelView};
use crate::pipe::{DEFAULT_CAPACITY, HostEnd, PipeLink, pipe};
use crate::sampler::{SharedSource, SourceSampler, Timing};
use massline_physics::source::ScanSource;

/// Name of this board in the identity of a rig.
pub const BOARD: &str = "virtual";

/// The board that the application runs on here.
pub type VirtualBoard = Board<SourceSampler, PipeLink, Flash, OperatorPanel>;

/// Stack of a rig's thread. Without optimisation the futures of the application are moved around on it.
const STACK_BYTES: usize = 8 * 1024 * 1024;

/// The parts of a virtual rig.
pub struct VirtualRigOptions {
    /// Makes the scans: a bench or a tape.
    pub source: Box<dyn ScanSource>,
    /// Where results and layouts are stored.
    pub flash: FlashBacking,
    /// How the time of the scans relates to the wall clock.
    pub timing: Timing,
    /// Capacity of the link in each direction, bytes; a writer waits for room.
    pub link_capacity: usize,
    /// Why the rig starts.
    pub boot_reason: BootReason,
    /// Text of the panic before this start.
    pub last_panic: &'static str,
    /// What its clocks are derived from.
    pub clock: Clock,
    /// Its supply.
    pub supply: Supply,
    /// What is wrong with its external converter.
    pub converter_fault: fn() -> (ConverterFault, u8),
}

impl VirtualRigOptions {
    /// Erased flash in memory, simulated time, and a power-on start.
    pub fn new(source: Box<dyn ScanSource>) -> Self {
        Self {
            source,
            flash: FlashBacking::default(),
            timing: Timing::default(),
            link_capacity: DEFAULT_CAPACITY,
            boot_reason: BootReason::PowerOn,
            last_panic: "",
            clock: Clock::Unknown,
            supply: Supply::STEADY,
            converter_fault: NO_CONVERTER_FAULT,
        }
    }
}

/// Why a virtual rig could not be started.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Its flash could not be opened.
    #[error(transparent)]
    Flash(#[from] FlashOpenError),
    /// No thread could be started for it.
    #[error("cannot start a thread for the virtual rig: {0}")]
    Thread(#[from] io::Error),
}

/// The application has panicked, with this message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the virtual rig has panicked: {0}")]
pub struct RigPanicked(pub String);

/// A rig that runs in this process until it is stopped or dropped.
pub struct VirtualRig {
    link: HostEnd,
    panel: PanelView,
    source: SharedSource,
    executor: Executor,
    last_words: LastWords,
    thread: Option<JoinHandle<()>>,
}

#[derive(Clone, Debug, Default)]
struct LastWords(Arc<Mutex<Option<RigPanicked>>>);

impl LastWords {
    fn set(&self, words: RigPanicked) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(words);
    }

    fn get(&self) -> Option<RigPanicked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl VirtualRig {
    /// Starts the rig: the application of the hardware over a virtual board.
    ///
    /// # Errors
    /// When the flash cannot be opened or no thread can be started.
    pub fn start(options: VirtualRigOptions) -> Result<Self, StartError> {
        Self::start_application(options, async |board| {
            let mut memory = Box::new(Memory::new());
            massline_firmware::run(board, &mut memory).await
        })
    }

    /// Starts another `application` over a virtual board, on a thread of its own.
    ///
    /// # Errors
    /// When the flash cannot be opened or no thread can be started.
    pub fn start_application<A>(
        options: VirtualRigOptions,
        application: A,
    ) -> Result<Self, StartError>
    where
        A: AsyncFnOnce(VirtualBoard) -> Infallible + Send + 'static,
    {
        let flash = Flash::open(&options.flash)?;
        let info = board_info(&options);
        let source = SharedSource::new(options.source);
        let (link, host_end) = pipe(options.link_capacity);
        let panel = OperatorPanel::new(source.clone());
        let (executor, last_words) = (Executor::default(), LastWords::default());
        let mut rig = Self {
            link: host_end,
            panel: panel.view(),
            source: source.clone(),
            executor: executor.clone(),
            last_words: last_words.clone(),
            thread: None,
        };
        let timing = options.timing;
        let body = move || {
            // Whatever a panic leaves half-done is dropped together with the rig.
            let run = AssertUnwindSafe(|| {
                // Made on this thread, because its clock is this thread's.
                let sampler = SourceSampler::new(source, timing).waiting_for(link.backlog());
                let board = Board { info, sampler, link, flash, panel, feed_watchdog: || {} };
                executor.run(application(board));
            });
            if let Err(payload) = catch_unwind(run) {
                last_words.set(RigPanicked(text_of(&*payload)));
            }
        };
        let thread = thread::Builder::new()
            .name("virtual rig".into())
            .stack_size(STACK_BYTES)
            .spawn(body)?;
        rig.thread = Some(thread);
        Ok(rig)
    }

    /// The host's end of the link. Clones are the same end.
    pub fn link(&self) -> HostEnd {
        self.link.clone()
    }

    /// What the panel shows.
    pub fn panel(&self) -> PanelModel {
        self.panel.model()
    }

    /// Waits until the panel shows a model for which `wanted` is true; `None` when that does not happen
    /// within `timeout` of wall clock or the rig ends first.
    pub fn wait_for(
        &self,
        timeout: Duration,
        wanted: impl FnMut(&PanelModel) -> bool,
    ) -> Option<PanelModel> {
        self.panel.wait_for(timeout, wanted)
    }

    /// The host's end of the panel, for use by another thread or for more than the model.
    pub fn panel_view(&self) -> PanelView {
        self.panel.clone()
    }

    /// Presses a button.
    pub fn press(&self, button: Button) {
        self.panel.press(button);
    }

    /// Makes the rig ask the source for scans again after it had none, for example because the person has
    /// tapped.
    pub fn poke(&self) {
        self.source.poke();
    }

    /// A handle for [`poke`](Self::poke) from another thread.
    pub fn source(&self) -> SharedSource {
        self.source.clone()
    }

    /// The panic that ended the application, if there was one.
    pub fn panicked(&self) -> Option<RigPanicked> {
        self.last_words.get()
    }

    /// Ends the application at the point where it waits, as a power cut does, and joins its thread.
    ///
    /// # Errors
    /// When the application has panicked before.
    pub fn stop(mut self) -> Result<(), RigPanicked> {
        self.end();
        self.last_words.get().map_or(Ok(()), Err)
    }

    fn end(&mut self) {
        self.executor.stop();
        if let Some(thread) = self.thread.take() {
            // The panic of the thread has been caught inside it.
            let _ = thread.join();
        }
    }
}

impl Drop for VirtualRig {
    fn drop(&mut self) {
        self.end();
    }
}

fn board_info(options: &VirtualRigOptions) -> BoardInfo {
    BoardInfo {
        name: BOARD,
        firmware: env!("CARGO_PKG_VERSION"),
        git_hash: env!("MASSLINE_GIT_HASH"),
        git_dirty: env!("MASSLINE_GIT_DIRTY") == "true",
        boot_reason: options.boot_reason,
        last_panic: options.last_panic,
        clock: options.clock,
        supply: options.supply,
        circuit: Circuit::default(),
        converter_fault: options.converter_fault,
        stack: StackUse::default,
    }
}

fn text_of(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
        .to_owned()
}

impl fmt::Debug for VirtualRigOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("VirtualRigOptions")
            .field("flash", &self.flash)
            .field("timing", &self.timing)
            .finish_non_exhaustive()
    }
}

impl fmt::Debug for VirtualRig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("VirtualRig")
            .field("panel", &self.panel())
            .field("panicked", &self.panicked())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::select::{Either, select};
    use embassy_time::Timer;
    use embedded_io_async::{Read as _, Write as _};
    use embedded_storage_async::nor_flash::{NorFlash, ReadNorFlash};
    use massline_firmware::board::{Link, Panel, Sampler};
    use massline_shared::measurement::campaign::Phase;
    use massline_shared::signal::{AdcProperties, Scan};
    use massline_shared::units::{Hertz, Seconds, Volts};
    use std::io::{ErrorKind, Read, Write};

    /// A limit that is reached only when something hangs.
    const LATE: Duration = Duration::from_secs(60);

    /// A source whose scans are all the same.
    struct QuietSource;

    impl ScanSource for QuietSource {
        fn adc(&self) -> AdcProperties {
            AdcProperties {
                rate: Hertz(2000.0),
                channels: 10,
                bits: 12,
                reference: Volts(3.3),
                channel_delay: Seconds(0.0),
            }
        }

        fn armed(&mut self, _arming: u32, _dof: usize) {}

        fn next_scan(&mut self) -> Option<Scan> {
            Some([100; 10])
        }
    }

    fn options() -> VirtualRigOptions {
        VirtualRigOptions::new(Box::new(QuietSource))
    }

    /// Samples for ever, echoes what the host writes, shows `Done` when a button is pressed, and panics
    /// at "!".
    async fn echo(board: VirtualBoard) -> Infallible {
        let VirtualBoard { mut sampler, link, mut panel, .. } = board;
        let (mut rx, mut tx) = link.split();
        sampler.start().await.unwrap();
        let sampling = async {
            loop {
                sampler.read(&mut [[0; 10]; 32]).await.unwrap();
            }
        };
        let pressing = async {
            panel.button().await;
            panel.report(&PanelModel { phase: Phase::Done, ..PanelModel::START });
            Timer::after_secs(1_000_000).await;
        };
        let echoing = async {
            let mut buffer = [0; 64];
            loop {
                let count = rx.read(&mut buffer).await.unwrap();
                assert!(!buffer[..count].contains(&b'!'), "somebody shouted");
                tx.write_all(&buffer[..count]).await.unwrap();
            }
        };
        match select(select(sampling, echoing), pressing).await {
            Either::First(Either::First(never) | Either::Second(never)) => never,
            Either::Second(()) => panic!("the long sleep has ended"),
        }
    }

    #[test]
    fn a_rig_talks_while_it_samples_and_stops_on_command() {
        let rig = VirtualRig::start_application(options(), echo).unwrap();
        let mut link = rig.link();
        link.set_timeout(LATE);
        for _ in 0..100 {
            link.write_all(b"hello").unwrap();
            let mut answer = [0; 5];
            link.read_exact(&mut answer).unwrap();
            assert_eq!(&answer, b"hello");
        }
        assert_eq!(rig.panicked(), None);
        rig.stop().unwrap();
        assert_eq!(link.read(&mut [0; 5]).unwrap_err().kind(), ErrorKind::BrokenPipe);
    }

    #[test]
    fn a_button_reaches_the_rig_and_its_panel_the_host() {
        let rig = VirtualRig::start_application(options(), echo).unwrap();
        assert_eq!(rig.panel(), PanelModel::START);
        rig.press(Button::Ok);
        assert!(rig.wait_for(LATE, |model| model.phase == Phase::Done).is_some());
    }

    #[test]
    fn the_words_of_a_panic_reach_the_host() {
        let rig = VirtualRig::start_application(options(), echo).unwrap();
        let mut link = rig.link();
        link.set_timeout(LATE);
        link.write_all(b"!").unwrap();
        assert_eq!(link.read(&mut [0; 5]).unwrap_err().kind(), ErrorKind::BrokenPipe);
        assert_eq!(rig.wait_for(LATE, |_| false), None);
        assert_eq!(rig.stop(), Err(RigPanicked("somebody shouted".into())));
    }

    /// Counts its starts in flash, by clearing one word each time, and shows the number.
    async fn count_starts(board: VirtualBoard) -> Infallible {
        let VirtualBoard { mut flash, mut panel, .. } = board;
        let (mut word, mut starts) = ([0; 4], 0);
        loop {
            flash.read(starts * 4, &mut word).await.unwrap();
            if word == [0xFF; 4] {
                break;
            }
            starts += 1;
        }
        flash.write(starts * 4, &[0; 4]).await.unwrap();
        panel.report(&PanelModel { phase: Phase::Done, armings: starts + 1, ..PanelModel::START });
        std::future::pending().await
    }

    #[test]
    fn flash_survives_a_restart_of_the_rig() {
        let folder = tempfile::tempdir().unwrap();
        let file = FlashBacking::File(folder.path().join("flash.bin"));
        for flash in [FlashBacking::default(), file] {
            for start in 1..=3 {
                let options = VirtualRigOptions { flash: flash.clone(), ..options() };
                let rig = VirtualRig::start_application(options, count_starts).unwrap();
                let model = rig.wait_for(LATE, |model| model.phase == Phase::Done).unwrap();
                assert_eq!(model.armings, start, "{flash:?}");
                rig.stop().unwrap();
            }
        }
    }

    #[test]
    fn several_rigs_live_side_by_side() {
        let rigs: Vec<_> =
            (0..4).map(|_| VirtualRig::start_application(options(), echo).unwrap()).collect();
        for (rig, byte) in rigs.iter().zip(b'0'..) {
            let mut link = rig.link();
            link.set_timeout(LATE);
            link.write_all(&[byte]).unwrap();
            let mut answer = [0];
            link.read_exact(&mut answer).unwrap();
            assert_eq!(answer, [byte]);
        }
    }
}
