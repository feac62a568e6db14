//! A log as it lies on a card or in a file: damaged, cut or whole.

use crate::link::annotation::Annotation;
use plumbline_firmware::log::block::{BLOCK, BlockError, Head as BlockHead, NONE, VERSION, open};
use plumbline_firmware::log::record::{Head, Record};
use plumbline_firmware::stores::framing::checksum;
use std::ops::Range;

/// Unreadable blocks in a row that end a log.
const UNREADABLE_MAX: usize = 64;

/// Damaged blocks between two logs.
const DAMAGED_MAX: usize = 4;

/// Why bytes are no log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogError {
    /// Not one good block.
    NoLog,
    /// Blocks of a format that this program does not know.
    Version(u16),
    /// There are not so many.
    NoSuch(usize),
    /// The first block, which says what the application ran on, is lost.
    NoHead,
}

impl std::fmt::Display for LogError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            LogError::NoLog => f.write_str("it is no log"),
            LogError::Version(found) => write!(f, "it is a log of version {found}, and {VERSION} is what is read here"),
            LogError::NoSuch(count) => write!(f, "it holds {count} logs"),
            LogError::NoHead => f.write_str("the log's beginning is lost, and with it what the application ran on"),
        }
    }
}

/// What stands in a log, in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// Something the application took or came to, as it is stored.
    Record(Vec<u8>),
    /// Here something is missing.
    Hole,
}

/// A log, read as far as it goes.
#[derive(Clone, Debug)]
pub struct Log {
    /// What the application ran on.
    pub head: Head,
    /// The configuration store.
    pub configuration: Vec<u8>,
    /// The tile store, where all of it was logged.
    pub tiles: Option<Vec<u8>>,
    /// The flight.
    pub items: Vec<Item>,
    /// What the simulator added.
    pub annotations: Vec<Annotation>,
    /// Places where something is missing.
    pub gaps: usize,
    /// Records that the writer had no room for.
    pub lost_records: u64,
    /// Blocks that are damaged or missing.
    pub damaged_blocks: u64,
    /// Good blocks.
    pub blocks: usize,
    /// Whether it was closed.
    pub is_closed: bool,
}

/// Reads log number `which` of a file or card, from 0; the last unless given. Any bytes may come.
///
/// # Errors
/// [`LogError`].
pub fn read(bytes: &[u8], which: Option<usize>) -> Result<Log, LogError> {
    let logs = logs(bytes)?;
    let index = which.unwrap_or(logs.len() - 1);
    Assembly::default().read(bytes, logs.get(index).ok_or(LogError::NoSuch(logs.len()))?.clone())
}

fn block(bytes: &[u8], index: usize) -> Option<&[u8; BLOCK]> {
    bytes.get(index * BLOCK..)?.first_chunk()
}

/// The blocks of each log, damaged ones among them. Blocks behind each other belong to one log as long as their numbers
/// say so, and the next log begins where one ends; all else is of a card's earlier life.
fn logs(bytes: &[u8]) -> Result<Vec<(Range<usize>, u32)>, LogError> {
    let mut logs: Vec<(Range<usize>, u32)> = Vec::new();
    let mut version = None;
    for index in 0..bytes.len() / BLOCK {
        let head = match block(bytes, index).map(open) {
            Some(Ok((head, _))) => head,
            Some(Err(BlockError::Version(found))) => {
                version = version.or(Some(found));
                continue;
            }
            _ => continue,
        };
        let sequence = head.sequence as usize;
        match logs.last_mut() {
            Some((range, _)) if index - range.end > UNREADABLE_MAX => break,
            Some((range, number)) if *number == head.log && range.start + sequence == index => range.end = index + 1,
            _ if sequence > UNREADABLE_MAX || sequence > index => {}
            // Another log begins where this one ends, but for a few blocks that may be damaged.
            Some((range, _)) if !(range.end..=range.end + DAMAGED_MAX).contains(&(index - sequence)) => {}
            _ => logs.push((index - sequence..index + 1, head.log)),
        }
    }
    if logs.is_empty() {
        return Err(version.map_or(LogError::NoLog, LogError::Version));
    }
    Ok(logs)
}

/// Records out of blocks.
#[derive(Default)]
struct Assembly {
    /// A record that runs on into the next block.
    pending: Vec<u8>,
    head: Option<Head>,
    configuration: Option<Vec<u8>>,
    tiles: Vec<u8>,
    items: Vec<Item>,
    annotations: Vec<Annotation>,
    gaps: usize,
    lost_records: u64,
    damaged_blocks: u64,
    is_closed: bool,
}

impl Assembly {
    fn read(mut self, bytes: &[u8], (range, number): (Range<usize>, u32)) -> Result<Log, LogError> {
        let mut blocks = 0;
        let mut is_whole = true;
        for index in range.clone() {
            // A whole block of another log, or of another place in this one, is as good as a damaged one.
            let is_own = |head: &BlockHead| head.log == number && head.sequence as usize == index - range.start;
            let opened = block(bytes, index).and_then(|block| open(block).ok()).filter(|(head, _)| is_own(head));
            let Some((head, payload)) = opened else {
                self.damaged_blocks += 1;
                if std::mem::replace(&mut is_whole, false) {
                    self.hole();
                }
                continue;
            };
            blocks += 1;
            let from = if is_whole { 0 } else { usize::from(head.first) };
            if !is_whole && head.first == NONE {
                continue;
            }
            is_whole = true;
            self.pending.extend(payload.get(from..).unwrap_or(&[]));
            self.records();
        }
        let head = self.head.ok_or(LogError::NoHead)?;
        let is_complete = self.tiles.len() == head.tiles_bytes as usize && checksum(&self.tiles) == head.tiles_crc;
        Ok(Log {
            head,
            configuration: self.configuration.ok_or(LogError::NoHead)?,
            tiles: is_complete.then_some(self.tiles),
            items: self.items,
            annotations: self.annotations,
            gaps: self.gaps,
            lost_records: self.lost_records,
            damaged_blocks: self.damaged_blocks,
            blocks,
            is_closed: self.is_closed,
        })
    }

    fn hole(&mut self) {
        self.pending.clear();
        self.gaps += 1;
        self.items.push(Item::Hole);
    }

    /// Takes the whole records off the front of what is pending.
    fn records(&mut self) {
        let mut pending = std::mem::take(&mut self.pending);
        let mut at = 0;
        while let Some(length) = pending.get(at..).and_then(|rest| rest.first_chunk()) {
            let from = at + 2;
            let Some(bytes) = pending.get(from..from + usize::from(u16::from_le_bytes(*length))) else { break };
            at = from + bytes.len();
            self.record(bytes);
        }
        pending.drain(..at);
        self.pending = pending;
    }

    fn record(&mut self, bytes: &[u8]) {
        match Record::decode(bytes) {
            None => {
                self.gaps += 1;
                self.items.push(Item::Hole);
            }
            Some(Record::Gap(lost)) => {
                self.gaps += 1;
                self.lost_records += u64::from(lost);
                self.items.push(Item::Hole);
            }
            Some(Record::Head(head)) => self.head = self.head.or(Some(head)),
            Some(Record::Configuration(configuration)) => self.configuration = Some(configuration.0.to_vec()),
            // Pieces behind a missing one are of no use.
            Some(Record::Tiles(from, piece)) if from as usize == self.tiles.len() => self.tiles.extend(piece.0),
            Some(Record::Tiles(..)) => {}
            Some(Record::Annotation(bytes)) => self.annotations.extend(Annotation::decode(bytes.0)),
            Some(Record::Close) => self.is_closed = true,
            Some(_) => self.items.push(Item::Record(bytes.to_vec())),
        }
    }
}
