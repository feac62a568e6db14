//! `fly --export`: the flight for viewers of MCAP.

use crate::folder::{FLY, Folder};
use crate::refusals::Refusals;

/// Read again by the crate that wrote it, since no other reader is linked; the MCAP of other authors is `cargo xtask test`'s.
#[test]
fn a_flight_is_exported_with_the_same_bytes_each_time() {
    let folder = Folder::with_ground("export");
    for name in ["a.mcap", "b.mcap"] {
        folder.run(&format!("{FLY} --frames 12 --dump 2 --export {name}")).done();
    }
    let bytes = folder.read("a.mcap");
    assert!(bytes == folder.read("b.mcap"), "the same seed gives other bytes");
    assert!(bytes.starts_with(b"\x89MCAP0\r\n") && bytes.ends_with(b"\x89MCAP0\r\n"));
    // What a page shows is bounded, and so is this: a tile, and pictures of a few frames of 512 x 512 pixels.
    assert!(bytes.len() < 20_000_000, "{} bytes", bytes.len());
    folder.run(&format!("{FLY} --frames 12 --seed 2 --export c.mcap")).done();
    assert!(bytes != folder.read("c.mcap"));
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{FLY} --frames 1 --export flight.bag"), &["--export", "flight.bag", ".mcap"]);
    refusals.expect(&format!("{FLY} --frames 1 --export none/flight.mcap"), &["none/flight.mcap"]);
    refusals.expect(&format!("{FLY} --frames 1 --export ground.tif"), &["ground.tif"]);
    refusals.done();
}
