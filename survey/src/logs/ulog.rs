//! PX4's ULog (<https://docs.px4.io/main/en/dev_log/ulog_file_format.html>): 16 bytes of header, then records of a size (u16),
//! a type (u8) and so many bytes.
//!
//! The crate px4-ulog takes definitions and data apart. It stops at the first bad record, so the records are found here
//! and handed to it one by one: behind a bad one the log goes on where records follow each other again.

use super::damage::Damage;
use super::series::{Gather, Instance, Source};
use px4_ulog::stream_parser::model::{FlattenedField, FlattenedFieldType, FlattenedFormat};
use px4_ulog::stream_parser::{DataMessage, LittleEndianParser, LogParser};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::Range;

const MAGIC: &[u8] = b"ULog\x01\x12\x35";
const HEADER: usize = 16;
/// Size and type.
const RECORD_HEAD: usize = 3;
/// Every type of record that the format knows.
const TYPES: &[u8] = b"FBDIMPARSOLCQ";
/// So many records must follow each other before a place counts as one where they do: by chance, a type is one of
/// [`TYPES`] in 20, and 8 of them in 3e10.
const CHAIN: usize = 8;
/// The payload of the record of flags, which logs before 2017 do not have.
const NO_FLAGS: [u8; RECORD_HEAD + 40] = {
    let mut record = [0; RECORD_HEAD + 40];
    record[0] = 40;
    record[2] = b'B';
    record
};

pub(super) fn is_log(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads the log, its appended sections as well.
///
/// # Errors
/// Why nothing of it can be read.
pub(super) fn read(bytes: &[u8], gather: &mut Gather<'_>) -> Result<Damage, String> {
    let gather = RefCell::new(gather);
    let mut take = |message: &DataMessage<'_>| sample(message, &mut gather.borrow_mut());
    let mut parser = LogParser::default();
    parser.set_data_message_callback(&mut take);
    let header = bytes.get(..HEADER).ok_or("the ULog ends within its header")?;
    let mut walk = Walk { bytes, damage: Damage::default(), subscribed: BTreeSet::new() };
    parser.consume_bytes(header).map_err(|error| error.description)?;
    if bytes.get(HEADER + 2) != Some(&b'B') {
        parser.consume_bytes(&NO_FLAGS).map_err(|error| error.description)?;
    }
    let first = walk.record(HEADER, bytes.len()).map_or(HEADER, |record| record.end);
    walk.section(HEADER..first, &mut parser)?;
    // What was rescued from a crash is appended behind the log, and the flags say where.
    let is_behind = |offset: &usize| (first..bytes.len()).contains(offset);
    let mut from: Vec<usize> =
        parser.appended_offsets().iter().map(|offset| *offset as usize).filter(is_behind).collect();
    from.sort_unstable();
    from.insert(0, first);
    for (index, &start) in from.iter().enumerate() {
        walk.section(start..from.get(index + 1).copied().unwrap_or(bytes.len()), &mut parser)?;
    }
    Ok(walk.damage)
}

/// The way through the records.
struct Walk<'a> {
    bytes: &'a [u8],
    damage: Damage,
    /// Numbers of the subscriptions, which the parser takes amiss when they come twice.
    subscribed: BTreeSet<[u8; 2]>,
}

impl Walk<'_> {
    /// The record at a place, with its head, if there can be one before `end`.
    fn record(&self, at: usize, end: usize) -> Option<Range<usize>> {
        let head = self.bytes.get(at..at + RECORD_HEAD)?;
        let record = at..at + RECORD_HEAD + usize::from(u16::from_le_bytes([head[0], head[1]]));
        (TYPES.contains(&head[2]) && record.end <= end).then_some(record)
    }

    /// Whether records follow each other from a place on, as far as the end.
    fn is_chain(&self, mut at: usize, end: usize) -> bool {
        for _ in 0..CHAIN {
            match self.record(at, end) {
                Some(record) => at = record.end,
                None => return at + RECORD_HEAD > end,
            }
        }
        true
    }

    /// Hands the records of a section to the parser.
    fn section(&mut self, section: Range<usize>, parser: &mut LogParser<'_>) -> Result<(), String> {
        let (mut at, end) = (section.start, section.end);
        while at < end {
            let begin = at;
            let next = self.record(at, end).map(|record| self.take(record, parser)).transpose()?.flatten();
            let is_followed = |&at: &usize| self.is_chain(at, end);
            at = match next.or_else(|| (at + 1..end.saturating_sub(RECORD_HEAD)).find(is_followed)) {
                Some(at) => at,
                None => end,
            };
            match next {
                Some(_) => {}
                None if at < end => self.damage.skip(at - begin),
                None => self.damage.cut += end - begin,
            }
        }
        Ok(())
    }

    /// Hands a record to the parser. `None`: it is none, and neither is what follows.
    ///
    /// # Errors
    /// Definitions by which nothing can be read.
    fn take(&mut self, record: Range<usize>, parser: &mut LogParser<'_>) -> Result<Option<usize>, String> {
        let next = record.end;
        let whole = &self.bytes[record];
        let (kind, payload) = (whole[2], &whole[RECORD_HEAD..]);
        let is_for_parser = match (kind, payload) {
            (b'B' | b'F' | b'D', _) => true,
            (b'A', &[_, low, high, ..]) => self.subscribed.insert([low, high]),
            (b'O', &[low, high]) => {
                self.damage.dropouts += 1;
                self.damage.dropped_ms += u64::from(u16::from_le_bytes([low, high]));
                false
            }
            _ => false,
        };
        if !is_for_parser {
            return Ok(Some(next));
        }
        match parser.consume_bytes(whole) {
            Ok(()) => Ok(Some(next)),
            Err(error) if !parser.in_data() && [b'B', b'A'].contains(&kind) => {
                Err(format!("the ULog's definitions cannot be read: {}", error.description))
            }
            Err(_) if self.is_chain(next, self.bytes.len()) => {
                self.damage.skip(whole.len());
                Ok(Some(next))
            }
            Err(_) => Ok(None),
        }
    }
}

/// Hands a sample on.
fn sample(message: &DataMessage<'_>, gather: &mut Gather<'_>) {
    let format: &FlattenedFormat = message.flattened_format;
    let instance = Instance::Number(i64::from(message.multi_id.value()));
    let source = Source { message: format.message_name.clone(), instance };
    if !gather.wants(&source.message) {
        return gather.count(source);
    }
    let fields = || format.fields.iter().filter(|field| is_number(field));
    let columns: Vec<String> = fields().map(|field| field.flattened_field_name.clone()).collect();
    let time_us = format.timestamp_field.as_ref().map_or(0, |field| field.parse_timestamp(message.data));
    gather.add(source, &columns, || {
        (
            time_us as f64 * 1e-6,
            fields().map(|field| number(field, &message.data[usize::from(field.offset)..])).collect(),
        )
    });
}

fn is_number(field: &FlattenedField) -> bool {
    field.field_type != FlattenedFieldType::Char && !field.flattened_field_name.contains("_padding")
}

/// A field's value. The parser has checked that the data are as long as their format.
fn number(field: &FlattenedField, at: &[u8]) -> f64 {
    match field.field_type {
        FlattenedFieldType::Int8 => i8::parse(at).into(),
        FlattenedFieldType::UInt8 => u8::parse(at).into(),
        FlattenedFieldType::Int16 => i16::parse(at).into(),
        FlattenedFieldType::UInt16 => u16::parse(at).into(),
        FlattenedFieldType::Int32 => i32::parse(at).into(),
        FlattenedFieldType::UInt32 => u32::parse(at).into(),
        FlattenedFieldType::Int64 => i64::parse(at) as f64,
        FlattenedFieldType::UInt64 => u64::parse(at) as f64,
        FlattenedFieldType::Float => f32::parse(at).into(),
        FlattenedFieldType::Double => f64::parse(at),
        FlattenedFieldType::Bool => bool::parse(at).into(),
        FlattenedFieldType::Char => f64::NAN,
    }
}
