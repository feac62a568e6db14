//! The front end as the application sees it: it asks the simulator for a frame's rows piece by piece, as the application
//! wants them, and keeps none that were used.

use super::PIECE_MAX;
use super::wires::Wires;
use crate::board::{FrameStart, FrontEnd, Rows};

/// The front end. Its buffer holds the rows of a row of boxes and a piece; how many rows make a row of boxes depends on
/// height and camera, so a frame whose rows do not fit is an overrun.
#[allow(missing_debug_implementations, reason = "holds wires")]
pub struct LineFrontEnd {
    wires: &'static Wires,
    buffer: &'static mut [u8],
    /// The frame's number and its row's pixels.
    frame: (u32, usize),
    /// Pixels of the frame not yet asked for.
    missing: usize,
    /// Pixels of the frame asked for.
    asked: u32,
    /// The part of the buffer that holds rows not yet used.
    held: core::ops::Range<usize>,
}

impl LineFrontEnd {
    /// `buffer`: more than [`PIECE_MAX`] bytes; what is beyond is for rows.
    pub fn new(wires: &'static Wires, buffer: &'static mut [u8]) -> Self {
        LineFrontEnd { wires, buffer, frame: (0, 0), missing: 0, asked: 0, held: 0..0 }
    }

    /// Moves what is held to the front and waits for a piece behind it; `false` when a newer frame has begun.
    async fn fetch(&mut self) -> bool {
        self.buffer.copy_within(self.held.clone(), 0);
        self.held = 0..self.held.len();
        self.wires.wanted.set(Some((self.frame.0, self.asked)));
        let (end, missing) = (self.held.end, self.missing);
        let free = self.buffer.get_mut(end..).unwrap_or(&mut []);
        let most = free.len().min(missing);
        let free = free.get_mut(..most).unwrap_or(&mut []);
        let count = self
            .wires
            .wait(|wires| {
                let count = wires.rows.borrow_mut().take(free);
                (count > 0 || wires.frame.get().is_some()).then_some(count)
            })
            .await;
        self.wires.wanted.set(None);
        self.held.end += count;
        self.asked += count as u32;
        self.missing -= count.min(missing);
        count > 0
    }
}

impl FrontEnd for LineFrontEnd {
    async fn frame(&mut self) -> FrameStart {
        self.wires.is_at_work.set(false);
        let start = self.wires.wait(|wires| wires.frame.take()).await;
        self.wires.is_at_work.set(true);
        // Rows of another frame, had the simulator sent more than there are.
        self.wires.rows.borrow_mut().fill(&[]);
        let (cols, rows) = (usize::from(start.size.0), usize::from(start.size.1));
        (self.frame, self.missing, self.asked, self.held) = ((start.sequence, cols), cols * rows, 0, 0..0);
        start
    }

    async fn rows(&mut self, count: u16) -> Rows<'_> {
        let wanted = usize::from(count) * self.frame.1;
        if wanted == 0 || wanted > self.held.len() + self.missing {
            return Rows::End;
        }
        if wanted + PIECE_MAX > self.buffer.len() {
            self.wires.overruns.set(self.wires.overruns.get().saturating_add(1));
            return Rows::Overrun;
        }
        while self.held.len() < wanted {
            if !self.fetch().await {
                self.wires.overruns.set(self.wires.overruns.get().saturating_add(1));
                return Rows::Overrun;
            }
        }
        let from = self.held.start;
        self.held.start += wanted;
        self.buffer.get(from..from + wanted).map_or(Rows::End, Rows::Pixels)
    }

    /// The simulator takes the exposure from the telemetry.
    fn expose(&mut self, us: u32) -> Option<u32> {
        Some(us)
    }
}
