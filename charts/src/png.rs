//! PNG in memory, and as the address of a picture that a page holds within itself.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

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

/// A PNG file of `cols` x `rows` pixels of 8-bit samples, row-major; empty unless there are `cols * rows` pixels of them. The same
/// samples give the same bytes.
pub fn encode(cols: usize, rows: usize, colour: Colour, samples: &[u8]) -> Vec<u8> {
    let kind = match colour {
        Colour::Grey => ExtendedColorType::L8,
        Colour::GreyAlpha => ExtendedColorType::La8,
        Colour::Rgb => ExtendedColorType::Rgb8,
        Colour::Rgba => ExtendedColorType::Rgba8,
    };
    let mut png = Vec::new();
    if samples.is_empty() || samples.len() != cols * rows * colour as usize {
        return png;
    }
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Adaptive);
    // Writing to memory fails for sides beyond 32 bits alone.
    match encoder.write_image(samples, cols as u32, rows as u32, kind) {
        Ok(()) => png,
        Err(_) => Vec::new(),
    }
}

/// A PNG file as an address that a page holds within itself.
pub fn uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline_survey::io::picture::read_grey;

    #[test]
    fn what_was_written_is_read_again() {
        let (cols, rows) = (300, 301);
        let grey: Vec<u8> = (0..cols * rows).map(|index| (index * index / 7) as u8).collect();
        let repeated = |tail: &[u8], times: usize| -> Vec<u8> {
            grey.iter().flat_map(|&g| std::iter::repeat_n(g, times).chain(tail.iter().copied())).collect()
        };
        let path = std::env::temp_dir().join(format!("plumbline-report-png-{}.png", std::process::id()));
        let [alpha, rgb, rgba] = [repeated(&[255], 1), repeated(&[], 3), repeated(&[255], 3)];
        for (colour, samples) in
            [(Colour::Grey, &grey), (Colour::GreyAlpha, &alpha), (Colour::Rgb, &rgb), (Colour::Rgba, &rgba)]
        {
            std::fs::write(&path, encode(cols, rows, colour, samples)).expect("written");
            let read = read_grey(&path).expect("a PNG");
            assert_eq!((read.cols, read.rows), (cols, rows));
            assert_eq!(read.pixels, grey, "{colour:?}");
        }
        let _ = std::fs::remove_file(&path);
    }

    #[test]
    fn pixels_that_do_not_fill_the_picture_give_none() {
        assert!(encode(2, 2, Colour::Rgb, &[0; 11]).is_empty() && encode(0, 2, Colour::Grey, &[]).is_empty());
    }
}
