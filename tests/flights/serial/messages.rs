//! The boards' end of the line by itself: stale, repeated, foreign, oversized and mutated messages.

use plumbline_firmware::board::Writer;
use plumbline_firmware::serial::frame::{Receiver, Unframed, decode, encode};
use plumbline_firmware::serial::message::{Answer, Counts, Envelope, Event, Next, Refused, Request, Store};
use plumbline_firmware::serial::session::{Identity, Machine, Session};
use plumbline_firmware::serial::stores::{Stores, Uploaded};
use plumbline_firmware::serial::wires::{Port, Wires};
use plumbline_firmware::serial::{FRAME_MAX, PIECE_MAX, SENT_MAX, VERSION};
use plumbline_firmware::stores::framing::checksum;
use plumbline_sim::link::mutants::{NEXT_ID, device_bytes, host_bytes, step_bytes};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::cell::Cell;
use std::pin::Pin;
use std::rc::Rc;
use std::task::{Context, Waker};

/// A board whose application is a future.
struct Bench {
    runs: Rc<Cell<u32>>,
    application: fn(&'static Wires) -> Pin<Box<dyn Future<Output = ()>>>,
    running: Option<Pin<Box<dyn Future<Output = ()>>>>,
    uploaded: Rc<Cell<Option<Uploaded>>>,
}

impl Machine for Bench {
    fn identity(&self) -> Identity {
        Identity { board: "bench", boot: 42, core_clock_hz: 400_000_000, counts: Counts::Cycles }
    }

    fn boot(&mut self, uploaded: Uploaded, wires: &'static Wires) -> Result<(), [&'static str; 2]> {
        if uploaded.configuration == b"bad" {
            return Err(["configuration: ", "nothing there"]);
        }
        self.uploaded.set(Some(uploaded));
        self.running = Some((self.application)(wires));
        Ok(())
    }

    fn run(&mut self) {
        self.runs.set(self.runs.get() + 1);
        let Some(running) = &mut self.running else { return };
        if running.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_ready() {
            self.running = None;
        }
    }

    fn count(&self) -> u32 {
        // Wraps in mid-flight.
        u32::MAX.wrapping_sub(5).wrapping_add(7 * self.runs.get())
    }
}

struct Board {
    session: Session<Bench>,
    runs: Rc<Cell<u32>>,
    uploaded: Rc<Cell<Option<Uploaded>>>,
}

fn board(application: fn(&'static Wires) -> Pin<Box<dyn Future<Output = ()>>>) -> Board {
    let (runs, uploaded) = (Rc::new(Cell::new(0)), Rc::new(Cell::new(None)));
    let machine = Bench { runs: runs.clone(), application, running: None, uploaded: uploaded.clone() };
    let stores = Stores::new(vec![0; 100].leak(), vec![0; 3000].leak(), vec![0; 50].leak(), vec![0; 72].leak());
    Board { session: Session::new(machine, Box::leak(Box::default()), stores), runs, uploaded }
}

fn idle(_: &'static Wires) -> Pin<Box<dyn Future<Output = ()>>> {
    Box::pin(std::future::pending())
}

impl Board {
    /// What comes back for these bytes: session, id, whether it resets, and what `look` makes of the answer.
    fn hears<T>(&mut self, bytes: &[u8], look: impl Fn(Answer<'_>) -> T) -> Option<((u32, u32, bool), T)> {
        let mut heard = None;
        for &byte in bytes {
            let Some(reply) = self.session.take(byte) else { continue };
            assert!(heard.is_none(), "two answers");
            let mut receiver = Receiver::new();
            for &byte in reply.bytes {
                if let Unframed::Body(body) = receiver.take(byte) {
                    let envelope = decode::<Answer<'_>>(body).expect("an answer");
                    heard = Some(((envelope.session, envelope.id, reply.resets), look(envelope.message)));
                }
            }
        }
        heard
    }

    fn asked<T>(&mut self, session: u32, id: u32, message: Request<'_>, look: impl Fn(Answer<'_>) -> T) -> Option<T> {
        let mut buffer = [0; FRAME_MAX];
        let bytes = encode(&Envelope { session, id, message }, &mut buffer).expect("room").to_vec();
        self.hears(&bytes, look).map(|((theirs, their_id, _), looked)| {
            assert_eq!((theirs, their_id), (session, id));
            looked
        })
    }

    fn is(&mut self, session: u32, id: u32, message: Request<'_>, expected: Answer<'_>) {
        assert_eq!(self.asked(session, id, message, |answer| answer == expected), Some(true), "{message:?}");
    }

    /// Uploads and starts in session 1; the next id is 7.
    fn fly(&mut self) {
        self.load(b"configuration", b"tile");
        self.is(1, 6, Request::Start, Answer::Done);
    }

    fn load(&mut self, configuration: &[u8], tile: &[u8]) {
        self.is(1, 1, Request::Open, Answer::Done);
        for (n, (store, bytes)) in [(Store::Configuration, configuration), (Store::Tile, tile)].into_iter().enumerate()
        {
            let announce = Request::Announce { store, bytes: bytes.len() as u32, crc: checksum(bytes) };
            self.is(1, 2 + 2 * n as u32, announce, Answer::Done);
            self.is(1, 3 + 2 * n as u32, Request::Piece { store, offset: 0, bytes }, Answer::Done);
        }
    }
}

const STEP: Request<'_> = Request::Step { timer: 1, event: Event::Nothing };

fn stepped(answer: Answer<'_>) -> Option<(u32, Next, usize)> {
    match answer {
        Answer::Stepped { cost, next, sent, .. } => Some((cost, next, sent.len())),
        _ => None,
    }
}

#[test]
fn a_board_says_who_it_is_to_anybody_and_changes_nothing() {
    let mut board = board(idle);
    board.fly();
    for session in [1, 99] {
        let look = |answer: Answer<'_>| match answer {
            Answer::Welcome(welcome) => (welcome.version, welcome.boot, welcome.core_clock_hz, welcome.tile_capacity),
            other => panic!("{other:?}"),
        };
        // Of another version too.
        let welcome = board.asked(session, 1234, Request::Hello { version: 77 }, look);
        assert_eq!(welcome, Some((VERSION, 42, 400_000_000, 3000)));
    }
    assert_eq!(board.asked(1, 7, STEP, stepped), Some(Some((7, Next::Idle, 0))));
}

#[test]
fn a_request_is_done_once_however_often_it_comes() {
    let mut board = board(idle);
    board.fly();
    for _ in 0..3 {
        assert_eq!(board.asked(1, 7, STEP, stepped), Some(Some((7, Next::Idle, 0))));
    }
    assert_eq!(board.runs.get(), 1);
    assert_eq!(board.session.dropped().repeated, 2);
    // Older ones, later ones, and those of nobody's session.
    for id in [6, 5, 1, 0, 9, 8000, u32::MAX] {
        assert_eq!(board.asked(1, id, STEP, |_| ()), None, "{id}");
    }
    assert_eq!(board.session.dropped().stale, 7);
    board.is(2, 8, STEP, Answer::Stranger { boot: 42 });
    assert_eq!(board.runs.get(), 1);
    assert_eq!(board.asked(1, 8, STEP, stepped), Some(Some((7, Next::Idle, 0))));
    assert_eq!(board.runs.get(), 2);
}

#[test]
fn a_board_flies_once_between_two_resets() {
    let mut board = board(idle);
    board.fly();
    assert_eq!(
        board.uploaded.get().map(|uploaded| (uploaded.configuration, uploaded.tile, uploaded.plan)),
        Some((&b"configuration"[..], &b"tile"[..], &b""[..]))
    );
    board.is(2, 1, Request::Open, Answer::Refused(Refused::Busy));
    // The flight goes on.
    assert_eq!(board.asked(1, 7, STEP, stepped), Some(Some((7, Next::Idle, 0))));
    board.is(1, 8, Request::Bye, Answer::Done);
    board.is(1, 8, Request::Bye, Answer::Stranger { boot: 42 });
    board.is(2, 1, Request::Open, Answer::Refused(Refused::Busy));
    // A reset that was meant for an earlier boot is passed over.
    assert_eq!(board.asked(2, 1, Request::Reset { boot: 41 }, |_| ()), None);
    let bytes = step_bytes(1, Request::Reset { boot: 42 });
    assert_eq!(board.hears(&bytes, |answer| answer == Answer::Done), Some(((7, 1, true), true)));
}

#[test]
fn what_is_uploaded_is_what_was_announced_or_nothing() {
    let mut large = board(idle);
    large.is(1, 1, Request::Open, Answer::Done);
    let announce = |bytes| Request::Announce { store: Store::Tile, bytes, crc: 0 };
    large.is(1, 2, announce(3001), Answer::Refused(Refused::TooLarge { capacity: 3000 }));
    large.is(1, 3, announce(u32::MAX), Answer::Refused(Refused::TooLarge { capacity: 3000 }));
    large.is(1, 4, announce(2), Answer::Done);
    let piece = |offset, bytes| Request::Piece { store: Store::Tile, offset, bytes };
    large.is(1, 5, piece(1, b"a"), Answer::Refused(Refused::Order));
    large.is(1, 6, piece(0, b"abc"), Answer::Refused(Refused::Order));
    large.is(1, 7, piece(0, b"a"), Answer::Done);
    large.is(1, 8, Request::Start, Answer::Refused(Refused::Damaged(Store::Configuration)));
    large.is(1, 9, STEP, Answer::Refused(Refused::Order));
    // Whole, but another one than announced.
    let mut other = board(idle);
    other.load(b"configuration", b"tile");
    other.is(1, 6, Request::Announce { store: Store::Tile, bytes: 4, crc: checksum(b"tile") }, Answer::Done);
    other.is(1, 7, piece(0, b"tilt"), Answer::Done);
    other.is(1, 8, Request::Start, Answer::Refused(Refused::Damaged(Store::Tile)));
    assert!(other.uploaded.get().is_none());
    // A plan may be left out; one that was announced must come.
    let mut planned = board(idle);
    planned.load(b"configuration", b"tile");
    planned.is(1, 6, Request::Announce { store: Store::Plan, bytes: 4, crc: checksum(b"plan") }, Answer::Done);
    planned.is(1, 7, Request::Start, Answer::Refused(Refused::Damaged(Store::Plan)));
    planned.is(1, 8, Request::Piece { store: Store::Plan, offset: 0, bytes: b"plan" }, Answer::Done);
    planned.is(1, 9, Request::Start, Answer::Done);
    assert_eq!(planned.uploaded.get().map(|uploaded| uploaded.plan), Some(&b"plan"[..]));
    let mut refused = board(idle);
    refused.load(b"bad", b"tile");
    refused.is(1, 6, Request::Start, Answer::Refused(Refused::Boot(["configuration: ", "nothing there"])));
    refused.is(2, 1, Request::Open, Answer::Refused(Refused::Busy));
}

/// More than fits an answer, and more than fits the board: the writer waits, nothing is lost.
#[test]
fn what_the_application_sends_is_fetched_in_pieces() {
    const TOTAL: usize = 2 * SENT_MAX + 777;
    let mut board = board(|wires| {
        Box::pin(async move {
            let bytes: Vec<u8> = (0..TOTAL).map(|n| (n % 251) as u8).collect();
            for part in bytes.chunks(267) {
                Port(wires).write(part).await;
            }
        })
    });
    board.fly();
    let mut fetched = Vec::new();
    let (mut id, mut request) = (7, STEP);
    loop {
        let (next, sent) = board
            .asked(1, id, request, |answer| match answer {
                Answer::Stepped { next, sent, .. } => (next, sent.to_vec()),
                other => panic!("{other:?}"),
            })
            .expect("an answer");
        assert!(sent.len() <= PIECE_MAX);
        fetched.extend(sent);
        (id, request) = (id + 1, Request::Continue);
        if next == Next::Idle {
            break;
        }
    }
    assert_eq!(fetched.len(), TOTAL);
    assert!(fetched.iter().enumerate().all(|(n, &byte)| byte == (n % 251) as u8));
}

/// The largest messages there are fit, whatever is in them; one byte more is dropped and counted.
#[test]
fn the_largest_message_fits_and_a_larger_one_is_dropped() {
    for fill in [0x00, 0x01, 0xff] {
        let bytes = [fill; PIECE_MAX];
        let message = Request::Rows { sequence: u32::MAX, offset: u32::MAX, bytes: &bytes };
        let mut buffer = [0; FRAME_MAX];
        let framed = encode(&Envelope { session: u32::MAX, id: u32::MAX, message }, &mut buffer).expect("room");
        assert!(framed[1..framed.len() - 1].iter().all(|&byte| byte != 0) && framed.last() == Some(&0));
        let mut receiver = Receiver::new();
        let is_same = framed.iter().any(|&byte| match receiver.take(byte) {
            Unframed::Body(body) => decode(body) == Some(Envelope { session: u32::MAX, id: u32::MAX, message }),
            _ => false,
        });
        assert!(is_same);
    }
    let mut board = board(idle);
    let large = [7u8; 2 * FRAME_MAX];
    assert!(encode(&Envelope { session: 1, id: 1, message: &large[..] }, &mut [0; FRAME_MAX]).is_none());
    let mut buffer = [0; 3 * FRAME_MAX];
    let framed = encode(&Envelope { session: 1, id: 1, message: &large[..] }, &mut buffer).expect("room").to_vec();
    assert_eq!(board.hears(&framed, |_| ()), None);
    assert_eq!(board.session.dropped().bad, 1);
    board.is(1, 1, Request::Open, Answer::Done);
}

/// One message, mutated: bytes changed, dropped, put in, doubled, swapped, cut.
fn mutated(rng: &mut ChaCha12Rng, bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=rng.next_u32() % 4 {
        if bytes.is_empty() {
            break;
        }
        let mut below = |end: usize| rng.next_u32() as usize % end.max(1);
        let (at, other, byte) = (below(bytes.len()), below(bytes.len()), below(256) as u8);
        match below(7) {
            0 => bytes[at] = byte,
            1 => bytes[at] ^= 1 << (byte % 8),
            2 => drop(bytes.remove(at)),
            3 => bytes.insert(at, byte),
            4 => bytes.swap(at, other),
            5 => bytes.truncate(at),
            _ => bytes.extend_from_within(at.min(other)..at.max(other)),
        }
    }
    bytes
}

/// Whatever becomes of a message on the way, what reaches the application is what was sent, or nothing.
#[test]
fn mutated_messages_deliver_nothing_wrong() {
    const SEED: u64 = 11;
    let mut rng = ChaCha12Rng::seed_from_u64(SEED);
    let payload: Vec<u8> = (0..60).map(|n| [0, 0xff, n][usize::from(n) % 3]).collect();
    let request = step_bytes(NEXT_ID, Request::Step { timer: 9, event: Event::Bytes(&payload) });
    assert_eq!(device_bytes(&request), Some(payload.clone()), "unharmed it arrives");
    let mut buffer = [0; FRAME_MAX];
    let message = Answer::Stepped { cost: 5, next: Next::Idle, is_at_work: false, sent: &payload };
    let answer = encode(&Envelope { session: 7, id: 5, message }, &mut buffer).expect("room").to_vec();
    assert_eq!(host_bytes(&answer), 1);
    let mut arrived = 0;
    for _ in 0..20_000 {
        let bytes = mutated(&mut rng, &request);
        if let Some(received) = device_bytes(&bytes) {
            assert_eq!(received, payload, "seed {SEED}: {bytes:02x?}");
            arrived += 1;
        }
        host_bytes(&mutated(&mut rng, &answer));
    }
    for _ in 0..5_000 {
        let noise: Vec<u8> = (0..rng.next_u32() % 300).map(|_| (rng.next_u32() % 5 * 51) as u8).collect();
        assert_eq!(device_bytes(&noise), None);
        assert_eq!(host_bytes(&noise), 0);
    }
    // Some mutations undo each other or touch nothing but the zeros.
    println!("seed {SEED}: {arrived} of 20000 arrived");
    assert!(arrived > 0 && arrived < 2_000, "{arrived}");
}
