//! Simulated flights: against the truth, replayed from their logs, over the serial line, along a plan.

mod aborted;
mod built_in;
mod companion;
mod exposure;
mod faults;
mod grounds;
mod kept;
mod live;
mod planned;
mod reboot;
mod recorded;
mod replay;
mod serial;
mod signing;
mod slopes;
mod stamps;
mod strangers;
mod truth;
mod years;
