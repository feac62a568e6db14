//! The key that messages are signed with, from a file of 64 hexadecimal digits.

use plumbline_firmware::stores::key::Stored;
use plumbline_firmware::wire::signature::Key;
use plumbline_survey::error::InputError;
use plumbline_survey::io::input;
use std::path::Path;

/// Hexadecimal digits of a key.
const DIGITS: usize = 64;

/// The key in a file: 64 hexadecimal digits, and white space around them.
///
/// # Errors
/// One sentence for a file that is missing or holds anything else; it does not repeat what the file holds.
pub fn key_of_file(path: &Path) -> Result<Key, InputError> {
    let text = input::text(path)?;
    let digits: Option<Vec<u8>> = text.trim().chars().map(|c| c.to_digit(16).map(|digit| digit as u8)).collect();
    let refused = |why: &str| InputError::new(format!("{}: {why}", path.display()));
    let digits = digits
        .filter(|digits| digits.len() == DIGITS)
        .ok_or_else(|| refused("a signing key is 64 hexadecimal digits, which this file does not hold"))?;
    let mut key = [0; DIGITS / 2];
    key.iter_mut().zip(digits.chunks_exact(2)).for_each(|(byte, pair)| *byte = pair[0] << 4 | pair[1]);
    if key == [0; DIGITS / 2] { Err(refused("a signing key of zeros is none")) } else { Ok(Key(key)) }
}

/// The store of a key that is used from the time `first` on, units of 10 us since 2015.
pub fn store_of(key: Key, first: u64) -> Vec<u8> {
    plumbline_firmware::stores::key::store(&Stored { key, first }).to_vec()
}
