//! The stores that go beside the image: checked before anything is built, since the board would only refuse them.

use super::super::{Failure, places};
use super::dfu::crc;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a store's header begins with, and what to call it. The header's layout is in firmware/src/stores/framing.rs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    magic: [u8; 4],
    /// Of the format that the firmware reads.
    version: u32,
    name: &'static str,
    verb: &'static str,
}

/// Camera, calibration and settings.
pub const CONFIGURATION: Kind =
    Kind { magic: *b"PLBM", version: 7, name: "configuration store", verb: "plumbline configuration" };
/// The reference tile.
pub const TILES: Kind = Kind { magic: *b"PLBT", version: 1, name: "tile store", verb: "plumbline tiles" };

/// Where photos are to be taken.
pub const PLAN: Kind = Kind { magic: *b"PLBP", version: 1, name: "plan store", verb: "plumbline configuration --plan" };

/// What messages of the link are signed with.
pub const KEY: Kind =
    Kind { magic: *b"PLBK", version: 1, name: "key store", verb: "plumbline configuration --signing-key" };

/// Bytes of a header.
const HEADER: usize = 32;

/// A store that goes into flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blob {
    /// Where it begins.
    pub address: u32,
    /// Its file.
    pub path: PathBuf,
    /// The file's bytes.
    pub bytes: Vec<u8>,
}

/// The store of this `kind` in a file, for a `place` in flash.
///
/// # Errors
/// A file that cannot be read, is not such a store, is damaged, or is larger than the place.
pub fn read(path: &Path, kind: Kind, place: Range<u32>) -> Result<Blob, Failure> {
    let named = |why: String| format!("{}: {why}", path.display());
    let bytes = fs::read(path).map_err(|error| named(error.to_string()))?;
    check(&bytes, kind).map_err(named)?;
    if bytes.len() > place.len() {
        let Range { start, end } = place;
        return Err(named(format!(
            "{} bytes are more than the {} that can be written from {start:#010x} to {end:#010x}",
            bytes.len(),
            place.len()
        )));
    }
    Ok(Blob { address: place.start, path: path.to_owned(), bytes })
}

/// Blobs of one sector of 128 KiB as one blob from the first to the last, erased between; in the order of their addresses. What
/// is joined lies in a file of its own.
///
/// # Errors
/// The scratch folder cannot be written.
pub fn joined(mut blobs: Vec<Blob>) -> Result<Vec<Blob>, Failure> {
    blobs.sort_unstable_by_key(|blob| blob.address);
    let mut joined: Vec<Blob> = Vec::new();
    for blob in blobs {
        match joined.last_mut().filter(|last| last.address >> 17 == blob.address >> 17) {
            Some(last) => {
                last.bytes.resize((blob.address - last.address) as usize, 0xff);
                last.bytes.extend(&blob.bytes);
                last.path = places::scratch().join("configuration-and-others.bin");
                fs::create_dir_all(places::scratch())
                    .and_then(|()| fs::write(&last.path, &last.bytes))
                    .map_err(|error| format!("{}: {error}", last.path.display()))?;
            }
            None => joined.push(blob),
        }
    }
    Ok(joined)
}

/// Magic, both checksums, and that the file ends where the store does.
fn check(bytes: &[u8], kind: Kind) -> Result<(), Failure> {
    let Kind { magic, version, name, verb } = kind;
    let not_one = || format!("this is no {name}; `{verb}` makes one");
    let (header, payload) = bytes.split_at_checked(HEADER).ok_or_else(not_one)?;
    let word = |at: usize| header.get(at..).and_then(|b| b.first_chunk()).map_or(0, |&bytes| u32::from_le_bytes(bytes));
    let sum = |bytes: &[u8]| !crc(bytes);
    match () {
        () if !header.starts_with(&magic) => Err(not_one()),
        () if sum(&header[..HEADER - 4]) != word(HEADER - 4) => Err(format!("the header of this {name} is damaged")),
        () if word(4) != version => {
            Err(format!("this {name} has format {}, and the firmware reads {version}: `{verb}` makes one", word(4)))
        }
        () if payload.len() != word(8) as usize => {
            Err(format!("this {name} has {} bytes behind its header, which says {}", payload.len(), word(8)))
        }
        () if sum(payload) != word(12) => Err(format!("this {name} is damaged")),
        () => Ok(()),
    }
}

/// Whether a file is a camera file, from which a configuration store is made.
pub fn is_camera_file(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The configuration store that `plumbline configuration` makes of a camera file, in the scratch folder.
///
/// # Errors
/// The command's own sentence.
pub fn made(camera: &Path, settings: Option<&Path>) -> Result<PathBuf, Failure> {
    let out = places::scratch().join("configuration.bin");
    fs::create_dir_all(places::scratch()).map_err(|error| format!("{}: {error}", places::scratch().display()))?;
    let mut command = Command::new(places::plumbline());
    command.args(["configuration", "--camera"]).arg(camera).arg("--out").arg(&out);
    if let Some(settings) = settings {
        command.arg("--settings").arg(settings);
    }
    let done = command.output().map_err(|error| format!("plumbline could not be started: {error}"))?;
    match done.status.success() {
        true => Ok(out),
        false => Err(String::from_utf8_lossy(&done.stderr).trim().to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A store as `stores/framing.rs` of the firmware has it.
    fn store(magic: &[u8; 4], payload: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0; HEADER];
        bytes[..4].copy_from_slice(magic);
        bytes[4] = [CONFIGURATION, TILES, PLAN, KEY].iter().find(|kind| kind.magic == *magic).unwrap().version as u8;
        bytes[8..12].copy_from_slice(&(payload.len() as u32).to_le_bytes());
        bytes[12..16].copy_from_slice(&(!crc(payload)).to_le_bytes());
        let sum = !crc(&bytes[..28]);
        bytes[28..].copy_from_slice(&sum.to_le_bytes());
        bytes.extend(payload);
        bytes
    }

    #[test]
    fn the_checksum_is_that_of_zip() {
        // The catalogue's check value of CRC-32/ISO-HDLC.
        assert_eq!(!crc(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn a_whole_store_is_taken_and_any_changed_bit_is_not() {
        let good = store(b"PLBM", b"a camera");
        assert_eq!(check(&good, CONFIGURATION), Ok(()));
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(check(&bad, CONFIGURATION).is_err(), "bit {bit}");
        }
        for length in 0..good.len() {
            assert!(check(&good[..length], CONFIGURATION).is_err(), "{length} bytes");
        }
        assert!(check(&[&good[..], &[0]].concat(), CONFIGURATION).is_err(), "one byte too many");
    }

    /// The firmware's own figures, read from its source: this crate does not link it.
    #[test]
    fn formats_are_those_that_the_firmware_reads() {
        for (kind, file) in [(CONFIGURATION, "configuration"), (TILES, "tiles"), (PLAN, "plan"), (KEY, "key")] {
            let path = places::root().join(format!("firmware/src/stores/{file}.rs"));
            let text = fs::read_to_string(path).unwrap();
            let line = text.lines().find(|line| line.contains("pub const KIND")).unwrap();
            let magic = std::str::from_utf8(&kind.magic).unwrap();
            assert!(line.contains(magic) && line.contains(&format!("version: {} ", kind.version)), "{line}");
        }
        let old = [&b"PLBM"[..], &[2], &[0; 27]].concat();
        let sum = !crc(&old[..28]);
        let old = [&old[..28], &sum.to_le_bytes()].concat();
        assert!(check(&old, CONFIGURATION).unwrap_err().contains("format 2"));
    }

    #[test]
    fn stores_are_not_taken_for_each_other() {
        let said = check(&store(b"PLBT", b"tiles"), CONFIGURATION).unwrap_err();
        assert_eq!(said, "this is no configuration store; `plumbline configuration` makes one");
        assert!(check(&store(b"PLBM", b"configuration"), TILES).unwrap_err().contains("plumbline tiles"));
        assert!(check(&store(b"PLBM", b"mission"), PLAN).unwrap_err().contains("plumbline configuration --plan"));
        assert_eq!(
            check(b"000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n", KEY).unwrap_err(),
            "this is no key store; `plumbline configuration --signing-key` makes one"
        );
        assert!(check(&store(b"PLBK", b"a key"), PLAN).is_err() && check(&store(b"PLBM", b"a camera"), KEY).is_err());
        assert!(check(b"exposure_us = 2000\n", CONFIGURATION).is_err());
    }

    #[test]
    fn a_store_that_does_not_fit_its_place_is_refused() {
        let path = std::env::temp_dir().join(format!("plumbline-flash-{}", std::process::id()));
        fs::write(&path, store(b"PLBT", &[7; 17])).unwrap();
        assert_eq!(read(&path, TILES, 0x0812_0000..0x0812_0031).unwrap().address, 0x0812_0000);
        let said = read(&path, TILES, 0x0812_0000..0x0812_0030).unwrap_err();
        assert!(
            said.ends_with("49 bytes are more than the 48 that can be written from 0x08120000 to 0x08120030"),
            "{said}"
        );
        fs::remove_file(&path).unwrap();
        assert!(read(&path, TILES, 0..64).unwrap_err().contains("plumbline-flash"));
    }

    #[test]
    fn what_shares_a_sector_is_written_as_one() {
        let blob = |address: u32, byte: u8| Blob { address, path: PathBuf::new(), bytes: vec![byte; 3] };
        let one = joined(vec![blob(0x0812_0000, 3), blob(0x0811_0000, 2), blob(0x0810_0000, 1)]).unwrap();
        let [sector, tiles] = &one[..] else { panic!("{}", one.len()) };
        assert_eq!((sector.address, sector.bytes.len(), tiles.address), (0x0810_0000, 0x1_0003, 0x0812_0000));
        assert_eq!((&sector.bytes[..4], &sector.bytes[0xffff..]), (&[1, 1, 1, 0xff][..], &[0xff, 2, 2, 2][..]));
        assert_eq!(fs::read(&sector.path).unwrap(), sector.bytes);
    }

    #[test]
    fn camera_files_are_told_by_their_ending() {
        assert!(is_camera_file(Path::new("a/camera.toml")) && is_camera_file(Path::new("C.TOML")));
        assert!(!is_camera_file(Path::new("configuration.bin")) && !is_camera_file(Path::new("toml")));
    }
}
