//! A bus that gives up a transfer which does not end.
//!
//! Between two polls of a transfer a step of the computation may pass, so time says little about it: what counts is how
//! often it was polled in vain.

use core::pin::{Pin, pin};

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Timer};
use embedded_hal_async::i2c::{Error, ErrorKind, ErrorType, I2c, Operation};

/// Interval at which a transfer is polled at least.
const TICK: Duration = Duration::from_millis(1);
/// Ticks after which a transfer is given up. The longest takes 3 ms at 400 kHz, or eight polls that are late.
const TICKS: u32 = 20;
/// Looks at a peripheral that is still ending the transfer before: 10 µs or more, of which its stop takes 4.
const LOOKS: u32 = 200;

/// A bus with patience.
pub struct PatientBus<I> {
    bus: I,
    /// False while the peripheral would wait for the bus without letting anything else run.
    is_free: fn() -> bool,
}

impl<I: I2c> PatientBus<I> {
    /// A bus whose peripheral waits for it unless `is_free`.
    pub fn new(bus: I, is_free: fn() -> bool) -> Self {
        Self { bus, is_free }
    }

    /// Waits until the bus is free.
    async fn free(&self) -> Result<(), ErrorKind> {
        for _ in 0..TICKS {
            if (0..LOOKS).any(|_| (self.is_free)()) {
                return Ok(());
            }
            Timer::after(TICK).await;
        }
        Err(ErrorKind::Other)
    }
}

/// Carries a transfer out, or gives it up. A tick counts once, however late it is seen.
async fn patiently<E: Error>(
    mut transfer: Pin<&mut dyn Future<Output = Result<(), E>>>,
) -> Result<(), ErrorKind> {
    for _ in 0..TICKS {
        if let Either::First(done) = select(transfer.as_mut(), Timer::after(TICK)).await {
            return done.map_err(|error| error.kind());
        }
    }
    Err(ErrorKind::Other)
}

impl<I> ErrorType for PatientBus<I> {
    type Error = ErrorKind;
}

impl<I: I2c> I2c for PatientBus<I> {
    async fn write(&mut self, address: u8, bytes: &[u8]) -> Result<(), ErrorKind> {
        self.free().await?;
        patiently(pin!(self.bus.write(address, bytes))).await
    }

    async fn write_read(
        &mut self,
        address: u8,
        bytes: &[u8],
        read: &mut [u8],
    ) -> Result<(), ErrorKind> {
        self.free().await?;
        patiently(pin!(self.bus.write_read(address, bytes, read))).await
    }

    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        self.free().await?;
        patiently(pin!(self.bus.transaction(address, operations))).await
    }
}
