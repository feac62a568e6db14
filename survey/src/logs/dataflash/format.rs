//! What a type of record holds.

use super::{FMT_BYTES, RECORD_HEAD};

/// A type of record, as an FMT record announces it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Format {
    pub name: String,
    /// Length of a record with its head.
    pub bytes: usize,
    /// Names of the fields that are numbers.
    pub columns: Vec<String>,
    /// Which of them tells several of a kind apart.
    pub instance: Option<usize>,
    /// Columns that are angles in degrees, by the log's own units.
    pub degrees: Vec<String>,
    /// Every field: its name, its type, and where it begins behind the head.
    fields: Vec<(String, u8, usize)>,
}

/// Bytes of a field.
fn size(kind: u8) -> Option<usize> {
    Some(match kind {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' | b'g' => 2,
        b'i' | b'I' | b'e' | b'E' | b'L' | b'f' | b'n' => 4,
        b'd' | b'q' | b'Q' => 8,
        b'N' => 16,
        b'Z' | b'a' => 64,
        _ => return None,
    })
}

/// Whether a field is one number: not a text (n, N, Z), nor the array of 32 (a).
fn is_number(kind: u8) -> bool {
    !b"nNZa".contains(&kind)
}

/// A text that ends at the first zero.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.split(|byte| *byte == 0).next().unwrap_or(&[])).trim().to_owned()
}

impl Format {
    /// That of the records that announce the others, which is known beforehand. Its fields are none of a flight's.
    pub fn of_formats() -> Self {
        Format {
            name: "FMT".to_owned(),
            bytes: FMT_BYTES,
            columns: Vec::new(),
            instance: None,
            degrees: Vec::new(),
            fields: Vec::new(),
        }
    }

    /// The type that an FMT record's body (type, length, name, types, names) announces. `None`: a length that no record has.
    /// Where types, names and length do not agree, the fields are unknown and only the length is used.
    pub fn announced(body: &[u8]) -> Option<(u8, Self)> {
        let (&kind, &bytes) = (body.first()?, body.get(1)?);
        let (name, types, names) = (text(body.get(2..6)?), text(body.get(6..22)?), text(body.get(22..86)?));
        if usize::from(bytes) < RECORD_HEAD || kind == super::FMT {
            return None;
        }
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        let mut at = 0;
        let mut fields = Vec::new();
        for (kind, name) in types.bytes().zip(&names) {
            fields.push(((*name).to_owned(), kind, at));
            at += size(kind).unwrap_or(usize::MAX / 32);
        }
        let agree = types.len() == names.len() && at + RECORD_HEAD == usize::from(bytes);
        let fields = if agree { fields } else { Vec::new() };
        let columns = fields.iter().filter(|field| is_number(field.1)).map(|field| field.0.clone()).collect();
        Some((kind, Format { name, bytes: bytes.into(), columns, instance: None, degrees: Vec::new(), fields }))
    }

    /// The type that the body of an FMTU record, of this format, is about, and a letter for the unit of each of its fields.
    pub fn unit_ids(&self, body: &[u8]) -> Option<(u8, String)> {
        let field = |name: &str| self.fields.iter().find(|field| field.0 == name);
        let (_, _, kind) = field("FmtType")?;
        let (_, letters, from) = field("UnitIds")?;
        Some((*body.get(*kind)?, text(body.get(*from..from + size(*letters)?)?)))
    }

    /// Takes the letters of the fields' units: "#" is that of the field that tells several of a kind apart, "d" and "h" (of a heading) are
    /// degrees (ArduPilot, `AP_Logger/LogStructure.h`).
    pub fn take_units(&mut self, units: &str) {
        let name = self.fields.iter().zip(units.bytes()).find(|(_, unit)| *unit == b'#').map(|(field, _)| &field.0);
        self.instance = name.and_then(|name| self.columns.iter().position(|column| column == name));
        let degrees = self.fields.iter().zip(units.bytes()).filter(|(_, unit)| b"dh".contains(unit));
        self.degrees = degrees.map(|(field, _)| field.0.clone()).collect();
    }

    /// The numbers of a record's body, in the order of the columns.
    pub fn numbers(&self, body: &[u8]) -> Vec<f64> {
        let fields = self.fields.iter().filter(|field| is_number(field.1));
        fields.map(|(_, kind, at)| body.get(*at..).and_then(|at| number(*kind, at)).unwrap_or(f64::NAN)).collect()
    }

    /// Seconds of the autopilot's clock; 0 in a record without a time.
    pub fn time_s(&self, numbers: &[f64]) -> f64 {
        let by = |name: &str| self.columns.iter().position(|column| column == name).map(|at| numbers[at]);
        by("TimeUS").map(|us| us * 1e-6).or_else(|| by("TimeMS").map(|ms| ms * 1e-3)).unwrap_or(0.0)
    }
}

/// The number at the begin of some bytes.
fn number(kind: u8, at: &[u8]) -> Option<f64> {
    let two = || at.first_chunk().copied();
    let four = || at.first_chunk().copied();
    let eight = || at.first_chunk().copied();
    Some(match kind {
        b'b' => i8::from_le_bytes(*at.first_chunk()?).into(),
        b'B' | b'M' => (*at.first()?).into(),
        b'h' => i16::from_le_bytes(two()?).into(),
        b'H' => u16::from_le_bytes(two()?).into(),
        b'c' => f64::from(i16::from_le_bytes(two()?)) * 0.01,
        b'C' => f64::from(u16::from_le_bytes(two()?)) * 0.01,
        b'g' => half(u16::from_le_bytes(two()?)),
        b'i' => i32::from_le_bytes(four()?).into(),
        b'I' => u32::from_le_bytes(four()?).into(),
        b'e' => f64::from(i32::from_le_bytes(four()?)) * 0.01,
        b'E' => f64::from(u32::from_le_bytes(four()?)) * 0.01,
        b'L' => f64::from(i32::from_le_bytes(four()?)) * 1e-7,
        b'f' => f32::from_le_bytes(four()?).into(),
        b'd' => f64::from_le_bytes(eight()?),
        b'q' => i64::from_le_bytes(eight()?) as f64,
        b'Q' => u64::from_le_bytes(eight()?) as f64,
        _ => return None,
    })
}

/// IEEE 754's number of 16 bits.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    }
}
