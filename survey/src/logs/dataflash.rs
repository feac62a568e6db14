//! ArduPilot's DataFlash log: records of two sync bytes, a type, and the fields that a record FMT has announced for it.
//!
//! A reader of our own, since no kept crate reads it. The format is that of ArduPilot's `AP_Logger/LogStructure.h`; what a field means in
//! numbers is as pymavlink's DFReader has it: types c, C, e and E are hundredths, L degrees in units of 1e-7.

mod format;

use super::damage::Damage;
use super::series::{Gather, Instance, Source};
use format::Format;

/// Every record begins so.
const SYNC: [u8; 2] = [0xa3, 0x95];
/// Sync bytes and type.
const RECORD_HEAD: usize = 3;
/// The record that announces a type.
const FMT: u8 = 128;
/// Length of an FMT record.
const FMT_BYTES: usize = 89;
/// A record's length is announced in a byte.
const RECORD_BYTES_MAX: usize = 255;
/// A log begins with an FMT record; damage before it is at most a sector.
const BEGIN_BYTES: usize = 4096;

pub(super) fn is_log(bytes: &[u8]) -> bool {
    let begin = &bytes[..bytes.len().min(BEGIN_BYTES)];
    begin.starts_with(&[SYNC[0], SYNC[1], FMT]) || begin.windows(7).any(|at| at == b"\xa3\x95\x80\x80\x59FM")
}

/// Reads all records.
pub(super) fn read(bytes: &[u8], gather: &mut Gather<'_>) -> Damage {
    let mut reader = Reader { bytes, formats: (0..256).map(|_| None).collect() };
    reader.formats[usize::from(FMT)] = Some(Format::of_formats());
    let mut damage = Damage::default();
    let mut at = 0;
    while at < bytes.len() {
        let begin = at;
        if let Some(next) = reader.end_of(at) {
            reader.take(&bytes[at..next], gather);
            at = next;
            continue;
        }
        let next = (at + 1..bytes.len()).find(|&at| reader.end_of(at).is_some_and(|next| reader.follows(next)));
        at = next.unwrap_or(bytes.len());
        match next {
            Some(_) => damage.skip(at - begin),
            // Erased flash behind the last record is no damage.
            None if bytes[begin..].iter().all(|byte| [0, 0xff].contains(byte)) => {}
            None if at - begin <= RECORD_BYTES_MAX => damage.cut += at - begin,
            None => damage.skip(at - begin),
        }
    }
    damage
}

struct Reader<'a> {
    bytes: &'a [u8],
    /// By the record's type.
    formats: Vec<Option<Format>>,
}

impl Reader<'_> {
    /// Where the record at a place ends; `None` where there is none, or another one begins within it.
    fn end_of(&self, at: usize) -> Option<usize> {
        let end = self.framed(at)?;
        let is_within = |&at: &usize| self.framed(at).is_some_and(|next| self.begins(next));
        (self.follows(end) || !(at + 1..end).any(|at| is_within(&at))).then_some(end)
    }

    /// Where a record at a place would end by its type.
    fn framed(&self, at: usize) -> Option<usize> {
        let head = self.bytes.get(at..at + RECORD_HEAD)?;
        let format = self.formats[usize::from(head[2])].as_ref()?;
        let end = at + format.bytes;
        (head[..2] == SYNC && end <= self.bytes.len()).then_some(end)
    }

    /// Whether a place has the next record's sync bytes.
    fn begins(&self, at: usize) -> bool {
        self.bytes.get(at..at + 2) == Some(&SYNC)
    }

    /// Whether a record or the log may end at a place.
    fn follows(&self, at: usize) -> bool {
        at == self.bytes.len() || self.begins(at)
    }

    fn take(&mut self, record: &[u8], gather: &mut Gather<'_>) {
        let (kind, body) = (usize::from(record[2]), &record[RECORD_HEAD..]);
        if record[2] == FMT {
            if let Some((announced, format)) = Format::announced(body) {
                self.formats[usize::from(announced)] = Some(format);
            }
            return;
        }
        let units = self.formats[kind].as_ref().filter(|format| format.name == "FMTU").and_then(|f| f.unit_ids(body));
        if let Some((of, units)) = units
            && let Some(format) = &mut self.formats[usize::from(of)]
        {
            format.take_units(&units);
        }
        let Some(format) = self.formats[kind].as_ref().filter(|format| !format.columns.is_empty()) else { return };
        let values = format.numbers(body);
        let instance = format.instance.map_or(Instance::Only, |field| Instance::Number(values[field] as i64));
        let source = Source { message: format.name.clone(), instance };
        gather.degrees(&source, &format.degrees);
        gather.add(source, &format.columns, || (format.time_s(&values), values));
    }
}
