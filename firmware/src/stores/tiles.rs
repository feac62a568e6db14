//! The tile store: the reference, where it lies, and how high its ground is.
//!
//! Its payload, little-endian: 96 bytes of head, then the pixels, row-major, row 0 grid north. Behind the store's header
//! the pixels begin at byte 128. Where there is an elevation model its posts follow from the next multiple of four bytes on,
//! zeros between: i16, row-major, row 0 grid north, the middle of their grid over that of the tile.
//!
//! | bytes | |
//! |---|---|
//! | 0..2, 2..4 | columns, rows |
//! | 4..8 | f32: grid metres a pixel |
//! | 8..12 | u32: the grid's EPSG code |
//! | 12..16, 16..20 | i32: latitude and longitude of the centre, 1e-7 degrees |
//! | 20..40, 40..60 | five f32 each: polynomials to east and north, see [`Georeference`] |
//! | 60..64 | f32: grid convergence, radians |
//! | 64..68 | f32: grid metres in a metre on the ground |
//! | 68..70, 70..72 | columns, rows of posts; zeros, as all that follows, without an elevation model |
//! | 72..76 | f32: grid metres from post to post |
//! | 76..80 | f32: metres a step of a post |
//! | 80..84 | f32: height of a post of 0, metres |
//! | 84..88 | u32: EPSG code of the vertical datum; 0 where it is not known |
//! | 88..96 | zeros |

use super::StoreError;
use super::framing::{HEADER_BYTES, Kind, header, open};
use plumbline_core::elevation::{Elevation, Posts};
use plumbline_core::tile::{Geographic, Georeference, Tile, TileError};
use plumbline_core::units::{Metres, Radians};

/// This store's magic and version.
pub const KIND: Kind = Kind { magic: *b"PLBT", version: 1 };
/// Bytes of the payload before the pixels.
pub const HEAD_BYTES: usize = 96;
/// Bytes of the store before the pixels.
pub const BEFORE_PIXELS: usize = HEADER_BYTES + HEAD_BYTES;
/// Bytes of flash that the flight computer has for this store: six sectors of 128 KiB, all of which the
/// camera's bootloader writes.
pub const BOARD_BYTES: usize = 6 * 128 * 1024;

/// What posts are aligned to, bytes.
const POSTS_ALIGN: usize = 4;

/// What the store says beside the pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileHead {
    /// (cols, rows).
    pub size: (u16, u16),
    /// Grid metres a pixel.
    pub resolution_m: f32,
    /// Where it lies.
    pub georeference: Georeference,
    /// The posts of its elevation model, if it has one.
    pub posts: Option<Posts>,
}

impl TileHead {
    /// As it is stored.
    pub fn encode(&self) -> [u8; HEAD_BYTES] {
        let g = &self.georeference;
        let words = [
            u32::from(self.size.0) | u32::from(self.size.1) << 16,
            self.resolution_m.to_bits(),
            g.epsg,
            g.centre.lat_e7 as u32,
            g.centre.lon_e7 as u32,
        ];
        let posts = self.posts.map_or([0; 5], |posts| {
            [
                u32::from(posts.size.0) | u32::from(posts.size.1) << 16,
                posts.spacing_m.to_bits(),
                posts.step_m.to_bits(),
                posts.base_m.to_bits(),
                posts.vertical_epsg,
            ]
        });
        let floats = g.east.iter().chain(&g.north).chain([&g.convergence.0, &g.point_scale]).map(|f| f.to_bits());
        let mut bytes = [0; HEAD_BYTES];
        for (to, word) in bytes.chunks_exact_mut(4).zip(words.into_iter().chain(floats).chain(posts)) {
            to.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    fn decode(bytes: &[u8; HEAD_BYTES]) -> Self {
        let word = |index: usize| {
            bytes.get(4 * index..).and_then(|b| b.first_chunk()).map_or(0, |&bytes| u32::from_le_bytes(bytes))
        };
        let float = |index: usize| f32::from_bits(word(index));
        let five = |from: usize| core::array::from_fn(|k| float(from + k));
        TileHead {
            size: (word(0) as u16, (word(0) >> 16) as u16),
            resolution_m: float(1),
            georeference: Georeference {
                epsg: word(2),
                centre: Geographic { lat_e7: word(3) as i32, lon_e7: word(4) as i32 },
                east: five(5),
                north: five(10),
                convergence: Radians(float(15)),
                point_scale: float(16),
            },
            // Without a column or a row there is no model; what else is not usable is refused with it.
            posts: (word(17) != 0).then(|| Posts {
                size: (word(17) as u16, (word(17) >> 16) as u16),
                spacing_m: float(18),
                step_m: float(19),
                base_m: float(20),
                vertical_epsg: word(21),
            }),
        }
    }

    /// Pixels of the size.
    fn area(&self) -> usize {
        self.size.0 as usize * self.size.1 as usize
    }

    /// Zeros between pixels and posts.
    fn gap(&self) -> &'static [u8] {
        let gap = self.posts.map_or(0, |_| self.area().wrapping_neg() % POSTS_ALIGN);
        [0; POSTS_ALIGN].get(..gap).unwrap_or(&[])
    }

    /// The store's parts in their order: header and head, then pixels, zeros and posts.
    ///
    /// # Errors
    /// [`StoreError::Reference`] for pixels or posts of another number, and what [`Tile::new`] and [`Tile::with_elevation`] refuse.
    pub fn before(&self, pixels: &[u8], posts: &[u8]) -> Result<([u8; BEFORE_PIXELS], &'static [u8]), StoreError> {
        self.tile(pixels, posts)?;
        let head = self.encode();
        let mut bytes = [0; BEFORE_PIXELS];
        let (to_header, to_head) = bytes.split_at_mut(HEADER_BYTES);
        to_header.copy_from_slice(&header(KIND, &[&head, pixels, self.gap(), posts]));
        to_head.copy_from_slice(&head);
        Ok((bytes, self.gap()))
    }

    /// The tile of this head over `pixels`, with the elevation model of `posts`, which are none without one.
    ///
    /// # Errors
    /// [`StoreError::Reference`].
    pub fn tile<'p>(&self, pixels: &'p [u8], posts: &'p [u8]) -> Result<Tile<'p>, StoreError> {
        if pixels.len() != self.area() {
            return Err(StoreError::Reference(TileError::Size));
        }
        let tile = Tile::new(pixels, self.size, Metres(self.resolution_m), self.georeference);
        let tile = match self.posts {
            None if posts.is_empty() => tile,
            None => Err(TileError::Elevation),
            Some(all) => {
                let elevation = Elevation::new(posts, all).ok_or(TileError::Elevation);
                tile.and_then(|tile| tile.with_elevation(elevation?))
            }
        };
        tile.map_err(StoreError::Reference)
    }
}

/// The tile in the store that `region` begins with; its pixels and posts stay where they are. Any bytes may come.
///
/// # Errors
/// [`StoreError`].
// Inlined, its copies of head and tile would lie on boot's stack below all that boot calls.
#[inline(never)]
pub fn read(region: &[u8]) -> Result<Tile<'_>, StoreError> {
    let (head, rest) = open(KIND, region)?.split_first_chunk::<HEAD_BYTES>().ok_or(StoreError::Encoding)?;
    let head = TileHead::decode(head);
    let (pixels, rest) = rest.split_at_checked(head.area()).ok_or(StoreError::Encoding)?;
    let posts = rest.get(head.gap().len()..).ok_or(StoreError::Encoding)?;
    if posts.len() != head.posts.map_or(0, |posts| posts.bytes()) {
        return Err(StoreError::Encoding);
    }
    head.tile(pixels, posts)
}
