//! The link over UART0, driven by interrupts, with back-pressure: while the buffer is full the interrupt is
//! masked, the UART holds one byte, and QEMU holds the rest.

use core::convert::Infallible;
use core::future::poll_fn;
use core::task::Poll;

use cortex_m::peripheral::NVIC;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::{Pipe, TryReadError};
use embassy_sync::waitqueue::AtomicWaker;
use embedded_io_async::{ErrorType, Read, Write};
use massline_firmware::board::Link;

use super::registers::{Interrupt, UART0};

const BUFFER: usize = 64;

static RECEIVED: Pipe<CriticalSectionRawMutex, BUFFER> = Pipe::new();
static TO_SEND: Pipe<CriticalSectionRawMutex, BUFFER> = Pipe::new();
static ALL_SENT: AtomicWaker = AtomicWaker::new();

/// Starts the UART.
pub fn start() -> UartLink {
    UART0.enable();
    // SAFETY: the interrupts' handlers are in the vector table.
    unsafe {
        NVIC::unmask(Interrupt::Uart0Rx);
        NVIC::unmask(Interrupt::Uart0Tx);
    }
    UartLink
}

/// A byte has arrived.
pub fn on_receive() {
    loop {
        if RECEIVED.is_full() {
            NVIC::mask(Interrupt::Uart0Rx);
            return;
        }
        let Some(byte) = UART0.take() else { return };
        // There is room: nothing else writes to the buffer.
        let _ = RECEIVED.try_write(&[byte]);
    }
}

/// A byte has been sent, or there is something to send.
pub fn on_sent() {
    UART0.clear_sent();
    while UART0.can_send() {
        let mut byte = [0];
        match TO_SEND.try_read(&mut byte) {
            Ok(_) => UART0.send(byte[0]),
            Err(TryReadError::Empty) => {
                ALL_SENT.wake();
                return;
            }
        }
    }
}

/// UART0.
#[derive(Debug)]
pub struct UartLink;

/// From the host.
#[derive(Debug)]
pub struct UartRx;

/// To the host.
#[derive(Debug)]
pub struct UartTx;

impl Link for UartLink {
    type Rx = UartRx;
    type Tx = UartTx;

    /// The ring can supply scans faster than a UART can send them.
    const STREAMS: bool = false;

    fn split(self) -> (UartRx, UartTx) {
        (UartRx, UartTx)
    }
}

impl ErrorType for UartRx {
    type Error = Infallible;
}

impl Read for UartRx {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let count = RECEIVED.read(bytes).await;
        // SAFETY: the interrupt's handler is in the vector table; a waiting byte raises the interrupt again.
        unsafe { NVIC::unmask(Interrupt::Uart0Rx) };
        Ok(count)
    }
}

impl ErrorType for UartTx {
    type Error = Infallible;
}

impl Write for UartTx {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let count = TO_SEND.write(bytes).await;
        NVIC::pend(Interrupt::Uart0Tx);
        Ok(count)
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        poll_fn(|context| {
            ALL_SENT.register(context.waker());
            if TO_SEND.is_empty() && UART0.can_send() { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
        Ok(())
    }
}
