//! What the bench measures must be real work: frames that are found where they were taken.

extern crate std;

use super::{FRAME_PX, TILE_PX, run};
use crate::bench::poses::Pose;
use crate::bench::region::Stand;
use crate::bench::texture;
use core::fmt::Arguments;
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::pipeline::Buffers;
use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;

/// Keeps what it is told.
#[derive(Default)]
struct Listener(Vec<String>);

impl Stand for Listener {
    fn tell(&mut self, line: Arguments<'_>) {
        self.0.push(line.to_string());
    }

    fn cycles(&mut self) -> Option<u32> {
        None
    }
}

#[test]
fn frames_of_the_bench_are_matched_where_they_were_taken() {
    let mut tile = vec![0; TILE_PX as usize * TILE_PX as usize];
    texture::ground(&mut tile, TILE_PX as usize, 1);
    let mut frame = vec![0; FRAME_PX as usize * FRAME_PX as usize];
    let (mut listener, mut buffers) = (Listener::default(), Buffers::new());
    let mut memory = vec![0; FRAME_MEMORY_BYTES];
    // Some of every tilt, of a camera that follows and of one that does not.
    for pose in Pose::all().step_by(7) {
        let flown =
            run(&pose, &mut listener, (&mut frame, &tile), (&mut buffers, &mut memory)).expect("no stage refuses");
        assert!(flown.outcome.fix.is_ok(), "{pose}: {:?}", flown.outcome);
        assert!(flown.error_px < 0.25, "{pose}: {} px off", flown.error_px);
    }
    assert_eq!(listener.0[0], "region: frame | begin | heading 0 pitch 8 roll 10 beta followed");
    assert_eq!(listener.0.len(), 5 * Pose::all().step_by(7).count());
}
