//! What the board keeps: the time in signatures, in flash and in the backup SRAM, and there whether the autopilot was armed.

use super::boot::stores;
use super::flash::Sector;
use crate::app::App;
use crate::boot::{self, BootError};
use crate::h743::resume::{WORDS, armed_words, resumed, stamp_of, stamp_words, was_armed};
use crate::stores::bounds::Bounds;
use crate::wire::signing::{Keeper, Signing};
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;

#[unsafe(link_section = ".backup.stamp")]
static mut STAMP: [u32; WORDS] = [0; WORDS];
#[unsafe(link_section = ".backup.armed")]
static mut ARMED: [u32; 2] = [0; 2];

/// How far the time is reserved in flash; nothing before the flash has been read.
static BOUNDS: Mutex<CriticalSectionRawMutex, Cell<Option<Bounds>>> = Mutex::new(Cell::new(None));
static IS_FULL: AtomicBool = AtomicBool::new(false);

/// Flash as what keeps the time.
#[derive(Debug)]
struct Flash;

impl Keeper for Flash {
    fn reserve(&self, stamp: u64) -> u64 {
        // There is one thread: nobody else reserves meanwhile, and interrupts go on while flash is written.
        let mut bounds = BOUNDS.lock(Cell::get).unwrap_or_else(|| Bounds::read(&Sector));
        let is_reserved = bounds.reserve(&mut Sector, stamp);
        BOUNDS.lock(|cell| cell.set(Some(bounds)));
        if is_reserved {
            return bounds.bound();
        }
        // Signing goes on; from now on a lost power takes the time back to the last bound.
        IS_FULL.store(true, Ordering::Relaxed);
        u64::MAX
    }
}

/// Whether flash takes no more.
pub fn is_full() -> bool {
    IS_FULL.load(Ordering::Relaxed)
}

/// Begins to sign, where there is a key. To be called once.
///
/// # Errors
/// [`BootError::Key`].
#[inline(never)]
pub fn signing() -> Result<Option<Signing>, BootError> {
    let [.., key] = stores();
    // Without a key nothing is read or written here.
    if boot::signing(key, 0)?.is_none() {
        return Ok(None);
    }
    let bounds = Bounds::read(&Sector);
    BOUNDS.lock(|cell| cell.set(Some(bounds)));
    // SAFETY: volatile accesses to words of our own, which may hold anything.
    let kept = unsafe { (&raw const STAMP).read_volatile() };
    // Until a flight has written them anew, the bound in flash holds.
    put_stamp([0; WORDS]);
    let signing = boot::signing(key, resumed(stamp_of(&kept), bounds.bound()))?;
    Ok(signing.map(|signing| signing.kept(&Flash)))
}

fn put_stamp(words: [u32; WORDS]) {
    // SAFETY: a volatile write to words of our own.
    unsafe { (&raw mut STAMP).write_volatile(words) };
}

fn put_armed(words: [u32; 2]) {
    // SAFETY: a volatile write to words of our own.
    unsafe { (&raw mut ARMED).write_volatile(words) };
}

/// Forgets that the autopilot was armed, after a power-on.
pub fn begin(is_power_on: bool) {
    if is_power_on {
        put_armed(armed_words(false));
    }
}

/// Keeps what a flight has come to. To be called much more often than [`MARGIN`](crate::h743::resume::MARGIN) is long.
pub fn keep(app: &App<'_>) {
    if let Some(stamp) = app.stamp() {
        put_stamp(stamp_words(stamp));
    }
    if app.was_armed() {
        put_armed(armed_words(true));
    }
}

/// Whether the autopilot was armed since power-on, in this run or in an earlier one.
pub fn has_been_armed(app: Option<&App<'_>>) -> bool {
    // SAFETY: a volatile read of words of our own, which may hold anything.
    let words = unsafe { (&raw const ARMED).read_volatile() };
    app.is_some_and(App::was_armed) || was_armed(words)
}
