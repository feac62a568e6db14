//! A flight's log run again: the same fixes byte for byte, whatever went wrong in flight, however untidy the board, and as far
//! as the log goes.

mod cards;
pub mod flown;
mod order;
mod power;
mod reboot;
mod untidy;
