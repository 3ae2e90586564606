//! The link: LPUART1 on PA2 and PA3, which the board's ST-LINK presents to the host as a serial port.
//!
//! The ST-LINK accepts everything that is sent, and does not report whether a host reads it.

use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH2, DMA1_CH3, LPUART1, PA2, PA3};
use embassy_stm32::usart::{
    Config, ConfigError, Error, InterruptHandler, RingBufferedUartRx, Uart, UartTx,
};
use embassy_stm32::{Peri, bind_interrupts, dma};
use embedded_io_async::{ErrorType, Read, Write};
use massline_firmware::board::Link;
use static_cell::StaticCell;

bind_interrupts!(struct Interrupts {
    LPUART1 => InterruptHandler<LPUART1>;
    DMA1_CHANNEL2 => dma::InterruptHandler<DMA1_CH2>;
    DMA1_CHANNEL3 => dma::InterruptHandler<DMA1_CH3>;
});

/// Baud rate with which the host opens the port.
const BAUD: u32 = 921_600;
/// Buffer for the longest request, which may arrive while a page of flash is erased, 22 ms.
const RECEIVE_BUFFER: usize = 1280;

/// Peripherals for the exclusive use of the link.
pub struct Parts {
    pub uart: Peri<'static, LPUART1>,
    pub tx: Peri<'static, PA2>,
    pub rx: Peri<'static, PA3>,
    pub tx_dma: Peri<'static, DMA1_CH2>,
    pub rx_dma: Peri<'static, DMA1_CH3>,
}

/// The serial port.
pub struct SerialLink {
    rx: SerialRx,
    tx: SerialTx,
}

/// From the host.
pub struct SerialRx(RingBufferedUartRx<'static>);

/// To the host.
pub struct SerialTx(UartTx<'static, Async>);

/// Opens the port.
///
/// # Errors
/// When the clocks do not permit this baud rate.
pub fn open(parts: Parts) -> Result<SerialLink, ConfigError> {
    static RECEIVED: StaticCell<[u8; RECEIVE_BUFFER]> = StaticCell::new();
    let mut config = Config::default();
    config.baudrate = BAUD;
    let Parts { uart, tx, rx, tx_dma, rx_dma } = parts;
    let uart = Uart::new(uart, rx, tx, tx_dma, rx_dma, Interrupts, config)?;
    let (tx, rx) = uart.split();
    let rx = rx.into_ring_buffered(RECEIVED.init([0; RECEIVE_BUFFER]));
    Ok(SerialLink { rx: SerialRx(rx), tx: SerialTx(tx) })
}

impl Link for SerialLink {
    type Rx = SerialRx;
    type Tx = SerialTx;

    /// The port carries 92 kB per second; 80 kB of scans and their framing would leave no room for
    /// anything else.
    const STREAMS: bool = false;

    fn split(self) -> (SerialRx, SerialTx) {
        (self.rx, self.tx)
    }
}

impl ErrorType for SerialRx {
    type Error = Error;
}

impl Read for SerialRx {
    /// After an error, such as from a disconnected line, the next call starts afresh.
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Error> {
        self.0.read(bytes).await
    }
}

impl ErrorType for SerialTx {
    type Error = Error;
}

impl Write for SerialTx {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        self.0.write(bytes).await?;
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Error> {
        self.0.flush().await
    }
}
