//! A serial line over USB for the simulator: CDC-ACM on the full-speed port.
//!
//! In flight only its hello is listened to; see [`hello`](crate::h743::hello).

use crate::board::{Reader, Writer};
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_stm32::peripherals::{PA11, PA12, USB_OTG_FS};
use embassy_stm32::{Peri, bind_interrupts, usb};
use embassy_usb::class::cdc_acm::{CdcAcmClass, Receiver as Class, Sender as ClassSender, State};
use embassy_usb::{Builder, Config, UsbDevice};
use static_cell::ConstStaticCell;

bind_interrupts!(struct Irqs {
    OTG_FS => usb::InterruptHandler<USB_OTG_FS>;
});

/// Bytes of a packet at full speed.
pub const PACKET: usize = 64;
/// Identity for tests and private use: pid.codes' test product.
const VENDOR: u16 = 0x1209;
const PRODUCT: u16 = 0x0001;

type Driver = usb::Driver<'static, USB_OTG_FS>;

/// The device, which one task runs.
pub type Device = UsbDevice<'static, Driver>;

static OUT: ConstStaticCell<[u8; 256]> = ConstStaticCell::new([0; 256]);
static CONFIG: ConstStaticCell<[u8; 128]> = ConstStaticCell::new([0; 128]);
static BOS: ConstStaticCell<[u8; 32]> = ConstStaticCell::new([0; 32]);
static CONTROL: ConstStaticCell<[u8; 64]> = ConstStaticCell::new([0; 64]);
static STATE: static_cell::StaticCell<State<'static>> = static_cell::StaticCell::new();
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Device, receiving and sending side; `None` the second time.
pub fn start(
    port: Peri<'static, USB_OTG_FS>,
    plus: Peri<'static, PA12>,
    minus: Peri<'static, PA11>,
) -> Option<(Device, UsbReader, UsbWriter)> {
    if TAKEN.swap(true, Ordering::AcqRel) {
        return None;
    }
    let mut config = usb::Config::default();
    // The board powers the device; the camera may run from the vehicle's supply without a host.
    config.vbus_detection = false;
    let driver = Driver::new_fs(port, Irqs, plus, minus, OUT.take(), config);
    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("Plumbline");
    config.product = Some("Plumbline flight computer");
    config.composite_with_iads = true;
    let mut builder = Builder::new(driver, config, CONFIG.take(), BOS.take(), &mut [], CONTROL.take());
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET as u16);
    let (sender, receiver) = class.split();
    Some((builder.build(), UsbReader { class: receiver, packet: [0; PACKET], left: (0, 0) }, UsbWriter(sender)))
}

/// Receiving side. Bytes of a packet that the caller's buffer does not hold are kept for the next call.
#[allow(missing_debug_implementations, reason = "a driver")]
pub struct UsbReader {
    class: Class<'static, Driver>,
    packet: [u8; PACKET],
    left: (usize, usize),
}

impl Reader for UsbReader {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        while self.left.0 >= self.left.1 {
            match self.class.read_packet(&mut self.packet).await {
                Ok(count) => self.left = (0, count),
                // Unplugged: wait for the next time.
                Err(_) => self.class.wait_connection().await,
            }
        }
        let waiting = self.packet.get(self.left.0..self.left.1).unwrap_or(&[]);
        let count = waiting.len().min(buffer.len());
        buffer.iter_mut().zip(waiting).for_each(|(to, from)| *to = *from);
        self.left.0 += count;
        count
    }
}

/// Sending side. What is sent while nobody listens is lost.
#[allow(missing_debug_implementations, reason = "a driver")]
pub struct UsbWriter(ClassSender<'static, Driver>);

impl Writer for UsbWriter {
    async fn write(&mut self, bytes: &[u8]) {
        for piece in bytes.chunks(PACKET) {
            if self.0.write_packet(piece).await.is_err() {
                return;
            }
        }
        // A full last packet is followed by an empty one, or the host waits for more.
        if bytes.len().is_multiple_of(PACKET) {
            let _ = self.0.write_packet(&[]).await;
        }
    }
}
