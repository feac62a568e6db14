//! Arbitrary bytes at both ends of the line, and what must hold then. For tests and fuzzing: nothing here flies.
//!
//! What is a message is decided here by another way than there: whole chunks between zeros, COBS undone by its definition,
//! the CRC over all of it.

use plumbline_firmware::board::Reader;
use plumbline_firmware::serial::FRAME_MAX;
use plumbline_firmware::serial::frame::{Receiver, Unframed, decode, encode};
use plumbline_firmware::serial::message::{Answer, Counts, Envelope, Request, Store};
use plumbline_firmware::serial::session::{Identity, Machine, Session};
use plumbline_firmware::serial::stores::{Stores, Uploaded};
use plumbline_firmware::serial::wires::{Port, Wires};
use plumbline_firmware::stores::framing::checksum;
use std::cell::RefCell;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Session of [`step_bytes`].
const SESSION: u32 = 7;

/// A board without an application: keeps what reaches it.
struct Bench {
    wires: &'static Wires,
    /// How often it was run.
    runs: u64,
    /// What it received in its last run.
    received: Vec<u8>,
}

/// Handed to the session, which keeps it.
struct Handle(&'static RefCell<Bench>);

impl Machine for Handle {
    fn identity(&self) -> Identity {
        Identity { board: "bench", boot: 3, core_clock_hz: 0, counts: Counts::Nothing }
    }

    fn boot(&mut self, _: Uploaded, _: &'static Wires) -> Result<(), [&'static str; 2]> {
        Ok(())
    }

    fn run(&mut self) {
        let bench = &mut *self.0.borrow_mut();
        bench.runs += 1;
        bench.received.clear();
        let (mut port, mut buffer) = (Port(bench.wires), [0; FRAME_MAX]);
        let context = &mut Context::from_waker(Waker::noop());
        let read = pin!(port.read(&mut buffer)).poll(context);
        if let Poll::Ready(count) = read {
            bench.received.extend_from_slice(&buffer[..count]);
        }
    }

    fn count(&self) -> u32 {
        0
    }
}

/// A board in flight, request 4 done.
struct Flying {
    session: Session<Handle>,
    bench: &'static RefCell<Bench>,
    /// The next request.
    id: u32,
}

impl Flying {
    /// The first one, whose bench is never given back.
    fn first() -> Self {
        let wires: &'static Wires = Box::leak(Box::default());
        Flying::new(Box::leak(Box::new(RefCell::new(Bench { wires, runs: 0, received: Vec::new() }))))
    }

    /// Another one on the same bench, which has nothing to upload.
    fn new(bench: &'static RefCell<Bench>) -> Self {
        let (wires, stores) = (bench.borrow().wires, Stores::new(&mut [], &mut [], &mut [], &mut []));
        let mut flying = Flying { session: Session::new(Handle(bench), wires, stores), bench, id: 1 };
        let crc = checksum(&[]);
        let announce = |store| Request::Announce { store, bytes: 0, crc };
        for request in [Request::Open, announce(Store::Configuration), announce(Store::Tile), Request::Start] {
            assert!(flying.answers(&step_bytes(flying.id, request)).1 == 1, "the bench does not fly");
            flying.id += 1;
        }
        flying
    }

    /// Feeds bytes; how many answers came, each checked to be one, and how many of them to this session's requests.
    fn answers(&mut self, bytes: &[u8]) -> (usize, usize) {
        let (mut all, mut ours) = (0, 0);
        for &byte in bytes {
            if let Some(reply) = self.session.take(byte) {
                assert!(reply.bytes.len() <= FRAME_MAX && reply.bytes.first() == Some(&0), "no frame");
                let mut receiver = Receiver::new();
                let mut found = 0;
                for &byte in reply.bytes {
                    if let Unframed::Body(body) = receiver.take(byte) {
                        let answer = decode::<Answer<'_>>(body).expect("an answer that can be read");
                        found += 1;
                        ours += usize::from(answer.session == SESSION && !matches!(answer.message, Answer::Welcome(_)));
                    }
                }
                assert_eq!(found, 1, "one answer");
                all += 1;
            }
        }
        (all, ours)
    }
}

/// The bytes of a request of the bench's session, as a simulator sends them.
pub fn step_bytes(id: u32, message: Request<'_>) -> Vec<u8> {
    let mut buffer = [0; FRAME_MAX];
    encode(&Envelope { session: SESSION, id, message }, &mut buffer).expect("room for any request").to_vec()
}

/// Whether this chunk without zeros is a message: COBS by its definition, the CRC by the checksum of all of it.
fn is_message(chunk: &[u8]) -> bool {
    let (mut body, mut at) = (Vec::new(), 0);
    while let Some(&code) = chunk.get(at) {
        let Some(run) = chunk.get(at + 1..at + usize::from(code)) else { return false };
        body.extend_from_slice(run);
        at += usize::from(code);
        if code < 0xff && at < chunk.len() {
            body.push(0);
        }
    }
    body.split_last_chunk::<4>().is_some_and(|(body, crc)| checksum(body) == u32::from_le_bytes(*crc))
}

/// Messages among these bytes, the first one's leading zero not needed.
fn messages(bytes: &[u8]) -> u64 {
    let Some(end) = bytes.iter().rposition(|&byte| byte == 0) else { return 0 };
    bytes[..end].split(|&byte| byte == 0).filter(|chunk| is_message(chunk)).count() as u64
}

/// Any bytes on a board in flight: it never panics, answers in whole messages and only to messages, does no more work than
/// there are messages, and is there for the next request. What it received last, if it was run.
pub fn device_bytes(bytes: &[u8]) -> Option<Vec<u8>> {
    thread_local! {
        static FLYING: RefCell<Flying> = RefCell::new(Flying::first());
    }
    FLYING.with_borrow_mut(|flying| {
        // What an earlier call has left unfinished.
        flying.session.take(0);
        let before = flying.bench.borrow().runs;
        // The next message's first zero ends this one.
        let bytes = [bytes, &[0]].concat();
        let (answers, _) = flying.answers(&bytes);
        let found = messages(&bytes);
        let runs = flying.bench.borrow().runs - before;
        assert!(answers as u64 <= found && runs <= found, "{answers} answers, {runs} runs, {found} messages");
        let received = (runs > 0).then(|| flying.bench.borrow().received.clone());
        let hello = step_bytes(u32::MAX, Request::Hello { version: 1 });
        assert_eq!(flying.answers(&hello).0, 1, "it is deaf");
        if runs > 0 || found > 0 {
            // A message was one: a session of its own for the next call.
            *flying = Flying::new(flying.bench);
        }
        received
    })
}

/// The request that [`device_bytes`] is ready for.
pub const NEXT_ID: u32 = 5;

/// Any bytes on the simulator: it never panics and takes no more answers than there are messages; how many.
pub fn host_bytes(bytes: &[u8]) -> usize {
    let mut receiver = Receiver::new();
    let mut answers = 0;
    for &byte in bytes {
        if let Unframed::Body(body) = receiver.take(byte) {
            let _ = plumbline_firmware::serial::frame::version(body);
            answers += usize::from(decode::<Answer<'_>>(body).is_some());
        }
    }
    assert!(answers as u64 <= messages(bytes), "{answers} answers");
    answers
}
