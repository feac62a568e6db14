//! The elevation model behind the tile's pixels.

use super::{HEADER_BYTES, StoreError, TileHead, framed, tile_store, tiles};
use plumbline_core::elevation::Posts;
use plumbline_core::tile::{Geographic, Georeference, Local, TileError};
use plumbline_core::units::Radians;

/// 3 x 2 pixels of 20 m below 3 x 2 posts of 30 m.
const HEAD: TileHead = TileHead {
    size: (3, 2),
    resolution_m: 20.0,
    georeference: Georeference {
        epsg: 31256,
        centre: Geographic { lat_e7: 481_850_000, lon_e7: -5 },
        east: [1.0, 0.0, 0.0, 0.0, 0.0],
        north: [0.0, 2.0, 0.0, 0.0, 0.0],
        convergence: Radians(-0.25),
        point_scale: 1.0,
    },
    posts: Some(Posts { size: (3, 2), spacing_m: 30.0, step_m: 0.5, base_m: -1.0, vertical_epsg: 5773 }),
};
const PIXELS: [u8; 6] = [1, 2, 3, 4, 5, 6];
/// 2, 4, 6 in the north and 256, -2, 0 in the south.
const POSTS: [u8; 12] = [2, 0, 4, 0, 6, 0, 0, 1, 0xfe, 0xff, 0, 0];

/// The payload of `head` over those pixels and posts, put together here.
fn payload(head: &TileHead) -> Vec<u8> {
    [&head.encode()[..], &PIXELS, &[0, 0], &POSTS].concat()
}

#[test]
fn a_tile_store_with_an_elevation_model_is_these_bytes() {
    let store = tile_store(&HEAD, &PIXELS, &POSTS).expect("usable");
    // By hand from the table in `stores::tiles`.
    let mut tail = vec![3, 0, 2, 0, 0, 0, 0xf0, 0x41, 0, 0, 0, 0x3f, 0, 0, 0x80, 0xbf, 0x8d, 0x16, 0, 0];
    tail.extend([0; 8]);
    tail.extend([1, 2, 3, 4, 5, 6, 0, 0]);
    tail.extend(POSTS);
    assert_eq!(store[HEADER_BYTES + 68..], tail);
    assert_eq!(store, framed(b"PLBT", 1, &payload(&HEAD)));
    let tile = tiles::read(&store).expect("it is read");
    assert_eq!(tile.view().run(1, 0, 3), Some(&PIXELS[3..]));
    let elevation = tile.elevation().expect("it is there");
    assert_eq!(Some(*elevation.posts()), HEAD.posts);
    let height = |east_m: f32, north_m: f32| elevation.height_m(Local { east_m, north_m });
    assert_eq!((height(-30.0, 15.0), height(30.0, 15.0)), (Some(0.0), Some(2.0)));
    assert_eq!((height(-30.0, -15.0), height(30.0, -15.0)), (Some(127.0), Some(-1.0)));
    assert_eq!((height(0.0, 0.0), height(30.0, 0.0)), (Some(-0.5), Some(0.5)));
    assert_eq!(height(0.0, 15.1), None);
}

#[test]
fn posts_that_cannot_be_meant_are_refused() {
    let refused = |head: &TileHead| tiles::read(&framed(b"PLBT", 1, &payload(head))).expect_err("refused");
    let posts = HEAD.posts.expect("they are there");
    let with = |posts: Posts| TileHead { posts: Some(posts), ..HEAD };
    // Posts of another number than bytes.
    for size in [(4, 2), (3, 1), (0, 2), (3, 0)] {
        assert_eq!(refused(&with(Posts { size, ..posts })), StoreError::Encoding, "{size:?}");
    }
    assert_eq!(refused(&TileHead { posts: None, ..HEAD }), StoreError::Encoding);
    let unusable = StoreError::Reference(TileError::Elevation);
    for bad in [
        Posts { size: (1, 6), ..posts },
        Posts { spacing_m: f32::NAN, ..posts },
        Posts { spacing_m: -30.0, ..posts },
        Posts { step_m: 0.0, ..posts },
        Posts { base_m: f32::INFINITY, ..posts },
        // The tile's outermost pixels' centres lie 20 m to the east and 10 m to the north of its own.
        Posts { spacing_m: 19.9, ..posts },
    ] {
        assert_eq!(refused(&with(bad)), unusable, "{bad:?}");
        assert_eq!(tile_store(&with(bad), &PIXELS, &POSTS), Err(unusable), "{bad:?}");
    }
    assert!(tile_store(&with(Posts { spacing_m: 20.0, ..posts }), &PIXELS, &POSTS).is_ok());
    assert_eq!(tile_store(&HEAD, &PIXELS, &POSTS[2..]), Err(unusable));
    assert_eq!(tile_store(&TileHead { posts: None, ..HEAD }, &PIXELS, &POSTS), Err(unusable));
}
