//! The autopilot's link: USART3 at 921600 baud, received by DMA into a ring, sent by DMA.
//!
//! DMA1 does not reach DTCM, where the application's buffers are, so both ways have buffers of their own in SRAM1.

use super::memory::Buffer;
use crate::board::{Reader, Writer};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use embassy_stm32::gpio::Pull;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH1, PB10, PB11, USART3};
use embassy_stm32::usart::{Config, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::{Peri, bind_interrupts, dma, usart};

/// Bits a second.
pub const BAUD: u32 = 921_600;
/// Bytes of the ring: 22 ms of the line.
const RECEIVED: usize = 2048;
/// Bytes of the longest MAVLink message.
const SENT: usize = 280;

bind_interrupts!(struct Irqs {
    USART3 => usart::InterruptHandler<USART3>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
    DMA1_STREAM1 => dma::InterruptHandler<DMA1_CH1>;
});

#[unsafe(link_section = ".sram123.link_received")]
static RECEIVE: Buffer<[u8; RECEIVED]> = Buffer::new();
static RECEIVE_TAKEN: AtomicBool = AtomicBool::new(false);
#[unsafe(link_section = ".sram123.link_sent")]
static SEND: Buffer<[u8; SENT]> = Buffer::new();
static SEND_TAKEN: AtomicBool = AtomicBool::new(false);

/// Times that the ring overflowed or the line was disturbed.
static DISTURBED: AtomicU32 = AtomicU32::new(0);

/// What the link is made of.
#[allow(missing_debug_implementations, reason = "pins")]
pub struct Parts {
    /// The port.
    pub usart: Peri<'static, USART3>,
    /// Received.
    pub rx: Peri<'static, PB11>,
    /// Sent.
    pub tx: Peri<'static, PB10>,
    /// Moves what is received.
    pub rx_dma: Peri<'static, DMA1_CH0>,
    /// Moves what is sent.
    pub tx_dma: Peri<'static, DMA1_CH1>,
}

/// Receiving and sending side; `None` where they were taken before.
pub fn start(parts: Parts) -> Option<(LinkReader, LinkWriter)> {
    let mut config = Config::default();
    config.baudrate = BAUD;
    // A line that nobody drives is quiet.
    config.rx_pull = Pull::Up;
    let Parts { usart, rx, tx, rx_dma, tx_dma } = parts;
    let uart = Uart::new(usart, rx, tx, tx_dma, rx_dma, Irqs, config).ok()?;
    let (tx, rx) = uart.split();
    let ring = RECEIVE.take(&RECEIVE_TAKEN)?;
    let buffer = SEND.take(&SEND_TAKEN)?;
    Some((LinkReader(rx.into_ring_buffered(ring)), LinkWriter { tx, buffer }))
}

/// Times that bytes were lost on the way in.
pub fn disturbed() -> u32 {
    DISTURBED.load(Ordering::Relaxed)
}

/// Receiving side.
#[allow(missing_debug_implementations, reason = "a driver")]
pub struct LinkReader(RingBufferedUartRx<'static>);

impl Reader for LinkReader {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        loop {
            match self.0.read(buffer).await {
                Ok(count) if count > 0 => return count,
                Ok(_) => {}
                // The driver starts anew by itself; the decoder finds the next message.
                Err(_) => {
                    DISTURBED.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }
}

/// Sending side.
#[allow(missing_debug_implementations, reason = "a driver")]
pub struct LinkWriter {
    tx: UartTx<'static, Async>,
    buffer: &'static mut [u8; SENT],
}

impl Writer for LinkWriter {
    async fn write(&mut self, bytes: &[u8]) {
        for piece in bytes.chunks(SENT) {
            let Some(buffer) = self.buffer.get_mut(..piece.len()) else { return };
            buffer.copy_from_slice(piece);
            // A line that cannot be written to loses the message, as the air would.
            let _ = self.tx.write(buffer).await;
        }
    }
}
