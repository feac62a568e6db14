//! The reader of a flight's log.

use super::Target;
use super::stores::flash;
use plumbline_firmware::log::block::{BLOCK, MAGIC};
use plumbline_firmware::stores::framing::checksum;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, FrameEvent, Link};
use plumbline_sim::replay::read::{Item, read};

/// Blocks of a seed.
const BLOCKS: usize = 15;

pub struct Log {
    seeds: Vec<Vec<u8>>,
}

impl Log {
    pub fn new() -> Self {
        let mut link = InProcess::logged(&flash()).expect("it boots");
        let pixels = [128; 64 * 64];
        for n in 0..40u32 {
            let timer = 1000 * n;
            let event = match n % 5 {
                0 => Event::Bytes(&[0xfd, 3, 0, 0, 1, 1, 1, 0, 0, 0, 7, 8, 9, 0, 0]),
                1 => Event::Pulse(timer),
                2 => Event::Edge { tick: timer, rising: n % 2 == 0 },
                3 => Event::Nothing,
                _ => Event::Frame(FrameEvent { sequence: n / 5, arrival: timer, size: (64, 64), pixels: &pixels }),
            };
            link.step(timer, event).expect("a step in this process");
        }
        link.annotate(&[1, 2, 3]);
        let log = link.close_log();
        // The beginning, the end, and two logs behind each other.
        let head = log[..BLOCKS * BLOCK].to_vec();
        let tail = log[log.len() - BLOCKS * BLOCK..].to_vec();
        let two = [&log[..6 * BLOCK], &log[..6 * BLOCK]].concat();
        Log { seeds: vec![head, tail, two] }
    }
}

impl Target for Log {
    fn name(&self) -> &'static str {
        "log"
    }

    fn seeds(&self) -> Vec<Vec<u8>> {
        self.seeds.clone()
    }

    fn seal(&self, input: &mut Vec<u8>) {
        for block in input.as_chunks_mut::<BLOCK>().0 {
            if block.starts_with(&MAGIC) {
                let own = checksum(&block[..BLOCK - 4]).to_le_bytes();
                block[BLOCK - 4..].copy_from_slice(&own);
            }
        }
    }

    fn read(&mut self, input: &[u8]) -> Result<(), String> {
        let Ok(log) = read(input, None) else { return Ok(()) };
        let records: usize =
            log.items.iter().map(|item| if let Item::Record(bytes) = item { bytes.len() } else { 0 }).sum();
        let stores = log.configuration.len() + log.tiles.as_ref().map_or(0, Vec::len);
        if records + stores > input.len() || log.blocks * BLOCK > input.len() {
            return Err(format!("{} bytes hold {records} of records and {stores} of stores", input.len()));
        }
        Ok(())
    }
}
