//! The flight's log onto the card: a ring in SRAM1 to SRAM3 between the application and a task that nobody waits for.

use super::card::{MicroSd, Parts};
use super::memory::Buffer;
use super::{boot, random};
use crate::app::{App, Line};
use crate::log::block::BLOCK;
use crate::log::card::{NoArea, area};
use crate::log::journal::LogJournal;
use crate::log::writer::{LogEnd, write_out};
use crate::stores::{configuration, framing::extent, tiles};
use core::sync::atomic::AtomicBool;
use mavlink::dialects::common::MavSeverity;
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use static_cell::StaticCell;

/// Blocks that wait for the card at most, 128 KiB: a card may pause for a quarter of a second.
const BLOCKS: usize = 256;

/// The board's log.
pub type Log = LogJournal<'static, BLOCKS>;

#[unsafe(link_section = ".sram123.log_ring")]
static RING: Buffer<[[u8; BLOCK]; BLOCKS]> = Buffer::new();
static RING_TAKEN: AtomicBool = AtomicBool::new(false);
static LOG: StaticCell<Log> = StaticCell::new();

/// A log of what is about to boot from flash; none where flash holds no stores, or the ring is taken.
#[inline(never)]
pub fn log() -> Option<&'static Log> {
    let [configuration_region, tiles_region, ..] = boot::stores();
    let configuration = configuration_region.get(..extent(configuration::KIND, configuration_region)?)?;
    let tiles = tiles_region.get(..extent(tiles::KIND, tiles_region)?)?;
    let ring = RING.take(&RING_TAKEN)?;
    Some(LOG.uninit().write(LogJournal::new(random::number(), configuration, tiles, FRAME_MEMORY_BYTES, ring)))
}

/// Finds the card and an area on it, then writes for ever. What keeps it from that is reported once; the ring then fills up and
/// counts what it drops.
///
/// The watchdog does not ask for this task's life: a card that hangs would reset a board that flies well. It holds nobody
/// up either, since it sleeps wherever it waits for the card (see `card`).
#[embassy_executor::task]
pub async fn card_task(app: &'static App<'static>, log: &'static Log, parts: Parts) {
    let reason = match MicroSd::new(parts).await {
        Ok(mut card) => match area(&mut card).await {
            Ok(area) => match write_out(log, &mut card, area).await {
                LogEnd::Full => "log ended: the card is full",
                LogEnd::Broken => "log ended: the card fails",
            },
            Err(NoArea::Unreadable) => "no log: the card cannot be read",
            Err(NoArea::Foreign) => "no log: the card holds something else",
            Err(NoArea::Full) => "no log: the card is full",
        },
        Err(_) => "no log: no card",
    };
    app.say(MavSeverity::MAV_SEVERITY_NOTICE, Line::new(reason)).await;
}
