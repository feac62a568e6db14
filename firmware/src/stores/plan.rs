//! The plan store: where photos are to be taken.
//!
//! Its payload, little-endian: 16 bytes of head, then the strips in the order of flight, then the photos in theirs. It is
//! read in place; nothing of it is copied.
//!
//! | bytes | |
//! |---|---|
//! | 0..4 | u32: least time between two exposures, microseconds |
//! | 4..8 | f32: farthest from a strip's line that is exposed, metres |
//! | 8..12, 12..16 | u32: strips, photos |
//! | 8 a strip | u32: number of its first photo; f32: direction of flight from true north, radians |
//! | 8 a photo | i32: latitude and longitude, 1e-7 degrees |

use super::StoreError;
use super::framing::{HEADER_BYTES, Kind, header, open};
use plumbline_core::exposure::{Limits, Planned, Strip};
use plumbline_core::tile::{Geographic, Georeference, Local};
use plumbline_core::units::Radians;

/// This store's magic and version.
pub const KIND: Kind = Kind { magic: *b"PLBP", version: 1 };
/// Bytes of the payload before the strips.
const HEAD_BYTES: usize = 16;
/// Bytes of a strip, and of a photo.
const ENTRY_BYTES: usize = 8;
/// Longest least time between two exposures, microseconds.
const INTERVAL_MAX_US: u32 = 600_000_000;
/// Farthest off the line, metres.
const ACROSS_MAX_M: f32 = 10_000.0;

/// A plan where it lies in flash, checked.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'f> {
    limits: Limits,
    strips: &'f [[u8; ENTRY_BYTES]],
    photos: &'f [[u8; ENTRY_BYTES]],
}

/// The two words of an entry.
fn words(entry: [u8; ENTRY_BYTES]) -> (u32, u32) {
    let both = u64::from_le_bytes(entry);
    (both as u32, (both >> 32) as u32)
}

/// The plan in the store that `region` begins with; `None` where nothing is there: no region, erased flash, zeros. Any bytes
/// may come.
///
/// # Errors
/// [`StoreError`].
pub fn read(region: &[u8]) -> Result<Option<Plan<'_>>, StoreError> {
    let is_all = |byte: u8| region.iter().take(HEADER_BYTES).all(|&b| b == byte);
    if is_all(0xff) || is_all(0) {
        return Ok(None);
    }
    let (head, entries) = open(KIND, region)?.split_first_chunk::<HEAD_BYTES>().ok_or(StoreError::Encoding)?;
    let both = u128::from_le_bytes(*head);
    let word = |index: u32| (both >> (32 * index)) as u32;
    let (entries, rest) = entries.as_chunks::<ENTRY_BYTES>();
    let (strips, photos) = entries.split_at_checked(word(2) as usize).ok_or(StoreError::Encoding)?;
    if photos.len() != word(3) as usize || !rest.is_empty() {
        return Err(StoreError::Encoding);
    }
    let limits = Limits { interval_us: word(0), across_m: f32::from_bits(word(1)) };
    let plan = Plan { limits, strips, photos };
    if plan.is_sound() { Ok(Some(plan)) } else { Err(StoreError::Plan) }
}

impl<'f> Plan<'f> {
    /// Whether it can be flown: strips that follow each other, none empty, points and figures that can be meant.
    fn is_sound(&self) -> bool {
        let mut end = 0;
        let is_strip = |(index, &entry): (usize, &[u8; ENTRY_BYTES])| {
            let (first, course) = words(entry);
            let follows = if index == 0 { first == 0 } else { first > end };
            end = first;
            follows && f32::from_bits(course).abs() <= 7.0
        };
        let is_place = |&entry: &[u8; ENTRY_BYTES]| {
            let (lat_e7, lon_e7) = words(entry);
            Geographic { lat_e7: lat_e7 as i32, lon_e7: lon_e7 as i32 }.is_possible()
        };
        self.limits.interval_us <= INTERVAL_MAX_US
            && (0.0..=ACROSS_MAX_M).contains(&self.limits.across_m)
            && (1..=u16::MAX as usize).contains(&self.strips.len())
            && self.strips.iter().enumerate().all(is_strip)
            && (end as usize) < self.photos.len()
            && self.photos.iter().all(is_place)
    }

    /// What it asks of its exposures.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// Photos of all strips.
    pub fn photos(&self) -> u32 {
        self.photos.len() as u32
    }

    /// The plan on the grid of a tile.
    pub fn on(self, georeference: &Georeference) -> OnGrid<'f, '_> {
        OnGrid { plan: self, georeference }
    }
}

/// A plan on a tile's grid.
#[derive(Clone, Copy, Debug)]
pub struct OnGrid<'f, 'g> {
    plan: Plan<'f>,
    georeference: &'g Georeference,
}

impl OnGrid<'_, '_> {
    /// Whether the grid reaches to all its photos.
    pub fn is_within(&self) -> bool {
        (0..self.plan.photos()).all(|number| self.point(number).is_some())
    }
}

impl Planned for OnGrid<'_, '_> {
    fn strip(&self, number: u16) -> Option<Strip> {
        let mut strips = self.plan.strips.iter().skip(number as usize);
        let (first, course) = words(*strips.next()?);
        let end = strips.next().map_or(self.plan.photos(), |&next| words(next).0);
        let course = Radians(f32::from_bits(course) - self.georeference.convergence.0);
        Some(Strip { first, end, course })
    }

    fn point(&self, number: u32) -> Option<Local> {
        let (lat_e7, lon_e7) = words(*self.plan.photos.get(number as usize)?);
        self.georeference.local(Geographic { lat_e7: lat_e7 as i32, lon_e7: lon_e7 as i32 })
    }
}

/// The head of a store that lists `strips` and `photos`, and the header of the whole, whose other parts follow: bytes made
/// by [`entry`] of each strip and each photo.
pub fn before(limits: Limits, strips: &[u8], photos: &[u8]) -> [u8; HEADER_BYTES + HEAD_BYTES] {
    let count = |bytes: &[u8]| (bytes.len() / ENTRY_BYTES) as u32;
    let mut bytes = [0; HEADER_BYTES + HEAD_BYTES];
    let (to_header, to_head) = bytes.split_at_mut(HEADER_BYTES);
    let words = [limits.interval_us, limits.across_m.to_bits(), count(strips), count(photos)];
    to_head.copy_from_slice(words.map(u32::to_le_bytes).as_flattened());
    to_header.copy_from_slice(&header(KIND, &[to_head, strips, photos]));
    bytes
}

/// A strip's or a photo's entry of two words.
pub fn entry(first: u32, second: u32) -> [u8; ENTRY_BYTES] {
    (u64::from(second) << 32 | u64::from(first)).to_le_bytes()
}
