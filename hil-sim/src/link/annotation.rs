//! What the simulator adds to a log: the truth. Distinguished by their lengths; numbers little-endian.

/// Where the tile's centre lies on its grid and how large its pixels are, to the last bit: three f64.
pub fn scene(tile_centre: [f64; 2], resolution_m: f64) -> Vec<u8> {
    [tile_centre[0], tile_centre[1], resolution_m].map(f64::to_le_bytes).concat()
}

/// Where frame `frame` was really taken, grid metres: a u32 and two f64.
pub fn frame(frame: u32, place: [f64; 2]) -> Vec<u8> {
    let mut bytes = frame.to_le_bytes().to_vec();
    bytes.extend(place.map(f64::to_le_bytes).concat());
    bytes
}

/// Either.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Annotation {
    /// [`scene`].
    Scene([f64; 2], f64),
    /// [`frame`].
    Frame(u32, [f64; 2]),
}

impl Annotation {
    /// Any bytes may come.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let float = |at: usize| bytes.get(at..at + 8)?.first_chunk().map(|&b| f64::from_le_bytes(b));
        match bytes.len() {
            24 => Some(Annotation::Scene([float(0)?, float(8)?], float(16)?)),
            20 => Some(Annotation::Frame(u32::from_le_bytes(*bytes.first_chunk()?), [float(4)?, float(12)?])),
            _ => None,
        }
    }
}
