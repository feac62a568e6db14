//! PNG in memory, without compression: the page's pictures are small, and stored blocks need no code to speak of.
//! PNG, second edition (ISO/IEC 15948), sections 5 and 10; RFC 1950 and 1951 for the stream inside.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use crc::{CRC_32_ISO_HDLC, Crc};

/// Samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Grey.
    Grey = 1,
    /// Grey, opacity.
    GreyAlpha = 2,
    /// Red, green, blue.
    Rgb = 3,
    /// Red, green, blue, opacity.
    Rgba = 4,
}

/// Of each chunk's kind and data (ISO/IEC 15948, 5.5).
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// Longest stored block, bytes: its length has 16 bits (RFC 1951, 3.2.4).
const BLOCK_MAX: usize = 65_535;

/// A PNG file of `cols` x `rows` pixels of 8-bit samples, row-major. Missing samples are left out, which no decoder
/// takes: the caller gives `cols * rows` pixels.
pub fn encode(cols: usize, rows: usize, colour: Colour, samples: &[u8]) -> Vec<u8> {
    let row_bytes = cols * colour as usize;
    // Each row begins with its filter: none.
    let lines: Vec<u8> = samples
        .chunks(row_bytes.max(1))
        .take(rows)
        .flat_map(|row| std::iter::once(0).chain(row.iter().copied()))
        .collect();
    let colour_type = match colour {
        Colour::Grey => 0,
        Colour::Rgb => 2,
        Colour::GreyAlpha => 4,
        Colour::Rgba => 6,
    };
    let mut header = Vec::with_capacity(13);
    header.extend((cols as u32).to_be_bytes());
    header.extend((rows as u32).to_be_bytes());
    // 8 bits, colour type, deflate, adaptive filters, not interlaced.
    header.extend([8, colour_type, 0, 0, 0]);
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut png, b"IHDR", &header);
    chunk(&mut png, b"IDAT", &stored(&lines));
    chunk(&mut png, b"IEND", &[]);
    png
}

/// A PNG file as an address that a page holds within itself.
pub fn uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// A zlib stream of stored blocks.
fn stored(data: &[u8]) -> Vec<u8> {
    let mut stream = vec![0x78, 0x01];
    let count = data.len().div_ceil(BLOCK_MAX);
    for (index, block) in data.chunks(BLOCK_MAX).enumerate() {
        stream.push(u8::from(index + 1 == count));
        let length = block.len() as u16;
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend(block);
    }
    stream.extend(adler32(data).to_be_bytes());
    stream
}

fn chunk(png: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    png.extend((data.len() as u32).to_be_bytes());
    let summed = png.len();
    png.extend(kind);
    png.extend(data);
    png.extend(CRC.checksum(&png[summed..]).to_be_bytes());
}

fn adler32(data: &[u8]) -> u32 {
    let (low, high) = data.iter().fold((1u32, 0u32), |(low, high), &byte| {
        let low = (low + u32::from(byte)) % 65_521;
        (low, (high + low) % 65_521)
    });
    (high << 16) | low
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline_survey::io::picture::read_grey;

    /// Another library reads back what was written, the chunks' checksums included; 300 x 301 needs two blocks.
    #[test]
    fn another_decoder_reads_the_same_pixels() {
        let (cols, rows) = (300, 301);
        let grey: Vec<u8> = (0..cols * rows).map(|index| (index * index / 7) as u8).collect();
        let doubled: Vec<u8> = grey.iter().flat_map(|&g| [g, 255]).collect();
        let tripled: Vec<u8> = grey.iter().flat_map(|&g| [g; 3]).collect();
        let path = std::env::temp_dir().join(format!("plumbline-report-png-{}.png", std::process::id()));
        let fourfold: Vec<u8> = grey.iter().flat_map(|&g| [g, g, g, 255]).collect();
        for (colour, samples) in
            [(Colour::Grey, &grey), (Colour::GreyAlpha, &doubled), (Colour::Rgb, &tripled), (Colour::Rgba, &fourfold)]
        {
            std::fs::write(&path, encode(cols, rows, colour, samples)).expect("written");
            let read = read_grey(&path).expect("a PNG");
            assert_eq!((read.cols, read.rows), (cols, rows));
            assert_eq!(read.pixels, grey, "{colour:?}");
        }
        let _ = std::fs::remove_file(&path);
    }

    /// Decoders do not look at the stream's own checksum, so it has a test of its own: the textbook value, and a block
    /// of full bytes, whose sums pass 65521.
    #[test]
    fn the_stream_has_its_checksum() {
        assert_eq!(adler32(b""), 1);
        assert_eq!(adler32(b"Wikipedia"), 0x11E6_0398);
        let zlib_of_a_thousand_255s = 0xE6E9_E446;
        assert_eq!(adler32(&[255; 1000]), zlib_of_a_thousand_255s);
    }
}
