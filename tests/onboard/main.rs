//! What runs on board, core and firmware: golden values of the papers, independent arithmetic, damaged inputs.

mod auto_exposure;
mod banked;
mod directions;
mod fuzz;
mod kernels;
mod matching;
mod motion;
mod mount;
mod oracle;
mod pose;
mod reacquire;
mod rectification;
mod rolling;
mod slope;
mod stamping;
mod stamps;
mod stores;
mod wire;
