//! What the bench measures must be real work: frames that are found where they were taken.

extern crate std;

use super::{ANOTHER_YEAR, Case, DOUBTED, FRAME, FRAME_PX, REACQUISITION, Refusal, run};
use crate::bench::poses::Pose;
use crate::bench::region::Stand;
use crate::bench::texture;
use core::fmt::Arguments;
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::pipeline::Buffers;
use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;

/// Keeps what is reported.
#[derive(Default)]
struct Listener(Vec<String>);

impl Stand for Listener {
    fn report(&mut self, line: Arguments<'_>) {
        self.0.push(line.to_string());
    }

    fn cycles(&mut self) -> Option<u32> {
        None
    }
}

/// Some of every tilt, of a camera that follows and of one that does not: the lines reported, and frames.
fn flown(case: &Case) -> (Vec<String>, usize) {
    let side = usize::from(case.tile_px);
    let mut tile = vec![0; side * side];
    texture::ground(&mut tile, side, 1);
    let (mut frame, mut memory) = (vec![0; FRAME_PX as usize * FRAME_PX as usize], vec![0; FRAME_MEMORY_BYTES]);
    let (mut listener, mut buffers, mut frames) = (Listener::default(), Buffers::new(), 0);
    for pose in Pose::all().step_by(7) {
        let (pictures, buffers_and_memory) =
            ((frame.as_mut_slice(), tile.as_slice()), (&mut buffers, memory.as_mut_slice()));
        let flown = run(case, &pose, &mut listener, pictures, buffers_and_memory).expect("no stage refuses");
        assert!(flown.is_found(), "{pose}: {:?}", flown.outcome);
        assert_eq!(flown.outcome.search_px, if case.doubt_px > 0.0 { 64 } else { 10 });
        assert_eq!(flown.outcome.fix == Err(Refusal::Contradicted), case.is_doubted, "{pose}: {:?}", flown.outcome.fix);
        let off_px = if case.is_changed { 0.5 } else { 0.25 };
        assert!(flown.error_px < off_px, "{pose}: {} px off", flown.error_px);
        frames += 1;
    }
    (listener.0, frames)
}

#[test]
fn frames_of_the_bench_are_matched_where_they_were_taken() {
    let (lines, frames) = flown(&FRAME);
    assert_eq!(lines[0], "region: frame | begin | heading 0 pitch 8 roll 10 beta followed");
    assert_eq!(lines.len(), 5 * frames);
}

#[test]
fn frames_of_another_year_are_matched_by_their_directions() {
    let (lines, frames) = flown(&ANOTHER_YEAR);
    assert_eq!(lines[0], "region: frame, another year | register | heading 0 pitch 8 roll 10 beta followed");
    assert_eq!(lines.len(), frames);
}

#[test]
fn frames_with_a_doubted_attitude_are_matched_and_have_no_fix() {
    let (lines, frames) = flown(&DOUBTED);
    assert_eq!(lines[0], "region: frame, attitude in doubt | register | heading 0 pitch 8 roll 10 beta followed");
    assert_eq!(lines.len(), frames);
}

#[test]
fn lost_positions_of_the_bench_are_found() {
    let (lines, frames) = flown(&REACQUISITION);
    assert_eq!(lines[0], "region: re-acquisition | register | heading 0 pitch 8 roll 10 beta followed");
    assert_eq!(lines.len(), frames);
}
