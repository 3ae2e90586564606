//! The sampler: reads scans from the ring in PSRAM.

use embassy_time::{Duration, Timer};
use massline_firmware::board::{SampleError, Sampler};
use massline_mps2_an386::ring::{CAPACITY, Reader, Ring};
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::{Hertz, ScanIndex, Seconds, Volts};

/// Properties that the rig states while no host has opened the ring.
const UNOPENED: AdcProperties = AdcProperties {
    rate: Hertz(4000.0),
    channels: massline_shared::signal::CHANNELS as u8,
    bits: 12,
    reference: Volts(3.0),
    channel_delay: Seconds(10e-6),
};

/// Interval at which the ring is polled, because the host cannot raise an interrupt.
const POLL: Duration = Duration::from_micros(100);

/// Reads the ring. No scan is ever lost, because the host writes only requested scans.
#[derive(Debug)]
pub struct RingSampler {
    ring: &'static Ring,
    reader: Reader<'static>,
}

impl RingSampler {
    /// A sampler for the ring in the state in which the host left it.
    pub fn new(ring: &'static Ring) -> Self {
        Self { ring, reader: Reader::new(ring) }
    }
}

impl Sampler for RingSampler {
    fn adc(&self) -> AdcProperties {
        self.ring.adc().unwrap_or(UNOPENED)
    }

    async fn start(&mut self) -> Result<(), SampleError> {
        self.ring.adc().ok_or(SampleError::Stopped)?;
        self.reader.start();
        Ok(())
    }

    async fn read(&mut self, block: &mut [Scan]) -> Result<ScanIndex, SampleError> {
        if !self.reader.running() || block.len() > CAPACITY as usize {
            return Err(SampleError::Stopped);
        }
        loop {
            if let Some(first) = self.reader.read(block) {
                return Ok(first);
            }
            Timer::after(POLL).await;
        }
    }

    fn stop(&mut self) {
        self.reader.stop();
    }
}
