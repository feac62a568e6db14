//! What it costs to sign the longest message and to verify it.

use super::region::{Stand, region};
use crate::shared::Shared;
use crate::wire::decoder::Decoder;
use crate::wire::outgoing::{Encoder, picture_piece};
use crate::wire::signature::Key;
use crate::wire::signing::{Signing, Verdict};

/// Any key.
const KEY: Key = Key([0x5a; 32]);
const PIXELS: [u8; 253] = [0xa5; 253];

/// Signs a message and verifies it; whether it was taken. Encoding and decoding, with their checksums, are left out or in as they
/// are without a signature: signing is counted with the encoding, verifying alone.
pub fn run(stand: &mut impl Stand) -> bool {
    let (ours, mut theirs) = (Shared::new(Signing::new(KEY, 0)), Signing::new(KEY, 0));
    let (mut signed, mut plain) = (Encoder::new((1, 154), Some(&ours)), Encoder::new((1, 154), None));
    let message = picture_piece(7, &PIXELS);
    region(stand, ("longest message, not signed", "encode"), "any", || plain.encode(&message).len());
    let bytes = region(stand, ("longest message, signed", "encode"), "any", || signed.encode(&message));
    let mut decoder = Decoder::new();
    let mut is_taken = false;
    decoder.take(bytes, |packet| {
        let verdict = region(stand, ("longest message, verified", "verify"), "any", || theirs.judge(packet));
        is_taken = verdict == Verdict::Taken;
    });
    is_taken
}

#[cfg(test)]
mod tests {
    use super::{Stand, run};
    use core::fmt::Arguments;

    struct Nobody;

    impl Stand for Nobody {
        fn report(&mut self, _: Arguments<'_>) {}

        fn cycles(&mut self) -> Option<u32> {
            None
        }
    }

    #[test]
    fn what_was_signed_is_taken() {
        assert!(run(&mut Nobody));
    }
}
