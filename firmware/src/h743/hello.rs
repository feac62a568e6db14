//! Recognises the simulator's hello in what comes over USB.

use crate::serial::GREETING as HELLO;

/// Looks for the hello in a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Listener {
    matched: usize,
}

impl Listener {
    /// Takes bytes; whether a hello ended in them.
    pub fn hear(&mut self, bytes: &[u8]) -> bool {
        let mut heard = false;
        for &byte in bytes {
            // Its first byte occurs again in it, but no beginning of it is also an end of a longer one: see the test.
            self.matched = match () {
                () if HELLO.get(self.matched) == Some(&byte) => self.matched + 1,
                () if HELLO.first() == Some(&byte) => 1,
                () => 0,
            };
            if self.matched == HELLO.len() {
                (heard, self.matched) = (true, 0);
            }
        }
        heard
    }
}

/// Whether the board may leave the flight for the simulator: not while the autopilot is armed. One that has never said
/// whether it is does not count as armed: on a bench there is none.
pub fn may_leave(armed: Option<bool>) -> bool {
    armed != Some(true)
}

#[cfg(test)]
mod tests {
    use super::{HELLO, Listener, may_leave};

    #[test]
    fn a_hello_is_heard_wherever_it_is_cut() {
        for cut in 0..HELLO.len() {
            let mut listener = Listener::default();
            assert!(!listener.hear(b"noise plumb"));
            assert!(!listener.hear(&HELLO[..cut]));
            assert!(listener.hear(&HELLO[cut..]), "{cut}");
            assert!(!listener.hear(b"\n"));
        }
    }

    #[test]
    fn no_beginning_of_the_hello_is_the_end_of_a_longer_one() {
        // Else falling back to the first byte could miss one.
        for long in 2..HELLO.len() {
            assert!((2..long).all(|n| !HELLO[..long].ends_with(&HELLO[..n])), "{long}");
        }
    }

    #[test]
    fn an_armed_autopilot_keeps_the_board() {
        assert!(may_leave(None) && may_leave(Some(false)) && !may_leave(Some(true)));
    }
}
