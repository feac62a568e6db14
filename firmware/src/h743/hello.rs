//! Recognises the simulator's hello in what comes over USB.

use crate::app::Armed;
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

/// Whether the board may leave the flight for the simulator: only where the autopilot has not been armed since power-on, or its
/// newest heartbeat says that it is not and was signed with our key. So nobody on the autopilot's link who merely says
/// "disarmed" opens it. One that has never said anything does not count as armed: on a bench there is none.
///
/// `was_armed`: since power-on, over resets; `newest`: the newest heartbeat.
pub fn may_leave(was_armed: bool, newest: Option<Armed>) -> bool {
    let is_surely_disarmed = newest.is_some_and(|newest| newest.is_signed && !newest.is_armed);
    !was_armed || is_surely_disarmed
}

#[cfg(test)]
mod tests {
    use super::{Armed, HELLO, Listener, may_leave};

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
    fn who_was_armed_keeps_the_board_until_it_says_otherwise_for_sure() {
        let says = |is_armed, is_signed| Some(Armed { is_armed, is_signed });
        // On a bench: no autopilot, or one that was never armed.
        assert!(may_leave(false, None) && may_leave(false, says(false, false)));
        // After arming nobody's "disarmed" counts that is not signed, nor silence after a reset.
        assert!(!may_leave(true, says(true, false)) && !may_leave(true, says(false, false)) && !may_leave(true, None));
        assert!(!may_leave(true, says(true, true)) && may_leave(true, says(false, true)));
    }
}
