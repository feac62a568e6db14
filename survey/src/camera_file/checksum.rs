//! The checksum line of a camera file.

use std::ops::Range;

use crc::{CRC_32_ISO_HDLC, Crc};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The checksum of a text that holds a checksum line, which does not count; `None` where there is no such line.
pub(super) fn of_text_with_line(text: &str) -> Option<u32> {
    let line = checksum_line(text)?;
    let mut digest = CRC.digest();
    digest.update(&text.as_bytes()[..line.start]);
    digest.update(&text.as_bytes()[line.end..]);
    Some(digest.finalize())
}

/// Puts a checksum line before a text that has none.
pub(super) fn with_checksum(text: &str) -> String {
    format!("crc32 = {:#010x}\n{text}", CRC.checksum(text.as_bytes()))
}

/// Bytes of the line `crc32 = ...` with its end, looked for before the first table.
fn checksum_line(text: &str) -> Option<Range<usize>> {
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let end = start + line.len();
        let content = line.trim_start();
        if content.starts_with('[') {
            return None;
        }
        if let Some(rest) = content.strip_prefix("crc32")
            && rest.trim_start().starts_with('=')
        {
            return Some(start..end);
        }
        start = end;
    }
    None
}
