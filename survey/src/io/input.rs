//! Input files: opened, measured and looked at before they are read.
//!
//! A device such as `/dev/zero` never ends, so what is no file is refused. Pipes end and are read, up to the same limits.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::shell::{files, names};
use crate::error::InputError;
use sha2::{Digest, Sha256};

/// Largest text that is read, bytes. The largest that are used, logs of hours at 1 kHz and tables of a million
/// observations, have some 10^8.
const TEXT_BYTES_MAX: u64 = 1 << 30;
/// Largest picture or raster that is read whole, bytes: [`super::tiff::SAMPLES_MAX`] of the largest samples.
const PICTURE_BYTES_MAX: u64 = 8 * super::tiff::SAMPLES_MAX;
/// Bytes that tell what a file is; the longest magic number in use has 8.
const MAGIC_BYTES: u64 = 16;

/// An open file and its length, 0 for a pipe.
///
/// # Errors
/// There is none, it cannot be read, or it is a folder or a device.
pub(crate) fn open(path: &Path) -> Result<(File, u64), InputError> {
    let file = File::open(path).map_err(|error| unreadable(path, error))?;
    let about = file.metadata().map_err(|error| unreadable(path, error))?;
    if !about.is_file() && !is_pipe(&about) {
        return Err(InputError::new(format!("cannot read {}: it is not a regular file", path.display())));
    }
    Ok((file, about.len()))
}

/// What some programs write before a text in UTF-8.
pub(crate) const BOM: &[u8] = b"\xEF\xBB\xBF";

/// Why a text in UTF-16 is not read, with what makes one in UTF-8; `None` for other bytes.
pub(crate) fn in_utf16(path: &Path, bytes: &[u8]) -> Option<InputError> {
    if !bytes.starts_with(b"\xFF\xFE") && !bytes.starts_with(b"\xFE\xFF") {
        return None;
    }
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    let made = path.with_extension(format!("utf8.{extension}"));
    Some(InputError::new(format!(
        "cannot read {}: it is text in UTF-16, and UTF-8 is read: iconv -f UTF-16 -t UTF-8 {}",
        path.display(),
        files([path, &made], " > ")
    )))
}

/// A whole text file, without a byte order mark.
///
/// # Errors
/// As of any file; nothing but white space, more than a gigabyte, or no UTF-8.
pub fn text(path: &Path) -> Result<String, InputError> {
    let (file, length) = open(path)?;
    let bytes = at_most(path, file, length, TEXT_BYTES_MAX)?;
    let refuse = |why: &str| InputError::new(format!("cannot read {}: it is {why}", path.display()));
    in_utf16(path, &bytes).map_or(Ok(()), Err)?;
    let mut text = String::from_utf8(bytes).map_err(|_| refuse("no text (UTF-8)"))?;
    if text.as_bytes().starts_with(BOM) {
        text.drain(..BOM.len());
    }
    if text.trim().is_empty() { Err(refuse("empty")) } else { Ok(text) }
}

/// A whole binary file.
///
/// # Errors
/// As of any file; more than 4 GiB.
pub fn bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    let (file, length) = open(path)?;
    at_most(path, file, length, PICTURE_BYTES_MAX)
}

/// A whole binary file that begins as `is_of_kind` wants; `what` it has to be is for the error's sentence.
///
/// # Errors
/// As of any file; another beginning, more than 4 GiB.
pub(crate) fn picture(path: &Path, what: &str, is_of_kind: fn(&[u8]) -> bool) -> Result<Vec<u8>, InputError> {
    let (mut file, length) = open(path)?;
    let mut magic = Vec::new();
    file.by_ref().take(MAGIC_BYTES).read_to_end(&mut magic).map_err(|error| unreadable(path, error))?;
    if !is_of_kind(&magic) {
        return Err(no_picture(path, what, &magic));
    }
    at_most(path, magic.as_slice().chain(file), length, PICTURE_BYTES_MAX)
}

/// Beginnings of what holds pictures or heights and is not read itself, but by GDAL: PNG, JPEG, JPEG 2000 as a file and as a stream, Erdas
/// Imagine, GDAL's own VRT, GeoPackage, netCDF, HDF5, and the ESRI ASCII grid, in capitals.
const BY_GDAL: [&[u8]; 10] = [
    b"\x89PNG",
    b"\xFF\xD8\xFF",
    b"\0\0\0\x0CJP  ",
    b"\xFF\x4F\xFF\x51",
    b"EHFA_HEADER_TAG",
    b"<VRTDATASET",
    b"SQLITE FORMAT 3",
    b"CDF\x01",
    b"\x89HDF",
    b"NCOLS",
];

/// Why a file is no picture of a kind, by its beginning, with the command that makes one where that is known.
fn no_picture(path: &Path, what: &str, magic: &[u8]) -> InputError {
    let name = path.display();
    if magic.is_empty() {
        return InputError::new(format!("cannot read {name}: it is empty"));
    }
    InputError::new(format!("cannot read {name}: it is not {what}{}", by_gdal(path, magic)))
}

/// What makes a GeoTIFF of a file that begins so, with a colon before it; nothing where that is not known.
pub(crate) fn by_gdal(path: &Path, magic: &[u8]) -> String {
    let start = magic.to_ascii_uppercase();
    let is_known = BY_GDAL.iter().any(|by_gdal| start.starts_with(&by_gdal.to_ascii_uppercase()));
    if is_known { format!(": gdal_translate {} makes one", names(path, "made")) } else { String::new() }
}

/// SHA-256 of a file's bytes, hexadecimal.
///
/// # Errors
/// As of any file.
pub fn sha256(path: &Path) -> Result<String, InputError> {
    let (mut file, _) = open(path)?;
    let mut hash = Sha256::new();
    std::io::copy(&mut file, &mut hash).map_err(|error| unreadable(path, error))?;
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

fn at_most(path: &Path, reader: impl Read, length: u64, most: u64) -> Result<Vec<u8>, InputError> {
    let mut bytes = Vec::new();
    if length <= most {
        bytes.reserve_exact(length as usize);
        reader.take(most + 1).read_to_end(&mut bytes).map_err(|error| unreadable(path, error))?;
    }
    if length.max(bytes.len() as u64) > most {
        return Err(InputError::new(format!("cannot read {}: it has more than {most} bytes", path.display())));
    }
    Ok(bytes)
}

/// Why a file is not read.
pub(crate) fn unreadable(path: &Path, error: impl std::error::Error + Send + Sync + 'static) -> InputError {
    InputError::because(format!("cannot read {}", path.display()), error)
}

#[cfg(unix)]
fn is_pipe(about: &std::fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&about.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &std::fs::Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::output::tests::scratch;

    #[test]
    fn text_is_read_whole_and_other_bytes_are_refused() {
        let folder = scratch("input");
        let path = folder.join("a.txt");
        std::fs::write(&path, "a,b\n").expect("written");
        assert_eq!(text(&path), Ok("a,b\n".to_owned()));
        std::fs::write(&path, "\u{feff}a,b\n").expect("written");
        assert_eq!(text(&path), Ok("a,b\n".to_owned()));
        std::fs::write(&path, [0xff, 0xfe]).expect("written");
        assert!(text(&path).expect_err("refused").to_string().contains("iconv -f UTF-16"));
        std::fs::write(&path, b"a\xFF").expect("written");
        let refusals = [text(&path), text(&folder), text(&folder.join("none"))];
        for refusal in refusals {
            let error = refusal.expect_err("refused");
            assert!(error.to_string().starts_with("cannot read ") && !error.is_failed_work(), "{error}");
        }
    }

    #[test]
    fn a_file_of_another_kind_or_too_long_is_not_read() {
        let path = scratch("input-kind").join("a.bin");
        std::fs::write(&path, "II and so on").expect("written");
        assert!(picture(&path, "a cat", |start| start.starts_with(b"II")).is_ok());
        let error = picture(&path, "a cat", |start| start.starts_with(b"MM")).expect_err("refused");
        assert!(error.to_string().ends_with("it is not a cat"), "{error}");
        // A pipe has no length: what it gives counts.
        assert!(at_most(&path, &[0; 10][..], 0, 10).is_ok() && at_most(&path, &[0; 11][..], 0, 10).is_err());
        assert!(at_most(&path, std::io::empty(), 11, 10).is_err());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_device_that_never_ends_is_refused_by_every_reader() {
        let zero = Path::new("/dev/zero");
        let refusals = [
            text(zero).map(drop),
            crate::Raster::read(zero).map(drop),
            crate::read_grey(zero).map(drop),
            crate::DemFile::open(zero).map(drop),
            crate::CameraFile::read(zero).map(drop),
        ];
        for refusal in refusals {
            let error = refusal.expect_err("refused").to_string();
            assert!(error.contains("/dev/zero: it is not a regular file"), "{error}");
        }
    }
}
