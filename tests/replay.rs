//! A flight's log run again: the same fixes byte for byte, whatever went wrong in flight, however untidy the board, and as far
//! as the log goes.

#[path = "replay/cards.rs"]
mod cards;
#[path = "replay/flown.rs"]
mod flown;
#[path = "replay/order.rs"]
mod order;
#[path = "replay/power.rs"]
mod power;
#[path = "replay/reboot.rs"]
mod reboot;
#[path = "replay/untidy.rs"]
mod untidy;
