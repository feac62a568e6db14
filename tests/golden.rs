//! The core and the simulator against golden values of the papers, oracles and other libraries. One target, since each is
//! linked with all of the simulator.

#[path = "golden/flights.rs"]
mod flights;
#[path = "golden/heads.rs"]
mod heads;
#[path = "golden/kernels.rs"]
mod kernels;
#[path = "golden/matching.rs"]
mod matching;
#[path = "golden/motion.rs"]
mod motion;
#[path = "golden/mount.rs"]
mod mount;
#[path = "golden/mutants.rs"]
mod mutants;
#[path = "golden/oracle.rs"]
mod oracle;
#[path = "golden/pose.rs"]
mod pose;
#[path = "golden/reacquire.rs"]
mod reacquire;
#[path = "golden/core.rs"]
mod rectification;
#[path = "golden/rolling.rs"]
mod rolling;
#[path = "golden/scene.rs"]
mod scene;
#[path = "golden/seeded.rs"]
mod seeded;
#[path = "golden/smooth.rs"]
mod smooth;
#[path = "golden/stamping.rs"]
mod stamping;
#[path = "golden/stamps.rs"]
mod stamps;
#[path = "golden/textures.rs"]
mod textures;
#[path = "golden/vectors.rs"]
mod vectors;
