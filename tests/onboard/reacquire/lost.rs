//! When the pipeline searches far: a level camera of 128 x 128 pixels above ground at rest, with a position that is off.

use super::{Random, at};
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::camera::Camera;
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::mount::Mount;
use plumbline_core::navigation::Navigation;
use plumbline_core::pipeline::{
    Buffers, FollowUpMode, LOST_AFTER, Latencies, Memory, Motions, Outcome, Pipeline, PositionSample, Refusal,
    Settings, SettingsError, Sigmas,
};
use plumbline_core::pose::Wait;
use plumbline_core::tile::{Geographic, Georeference, Tile};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Metres, Micros, Radians};
use plumbline_tests::textures::{Ground, Placement};

const FRAME: u16 = 128;
const FOV_DEG: f32 = 60.0;
const HEIGHT_M: f32 = 150.0;
const RESOLUTION_M: f32 = 5.0;
const TILE: u16 = 220;
/// Metres of 1e-2 degrees of latitude and at 48 degrees of longitude.
const NORTH_M: f32 = 1111.9;
const EAST_M: f32 = 744.0;
const CENTRE: Geographic = Geographic { lat_e7: 480_000_000, lon_e7: 160_000_000 };

fn settings(search_px: u16) -> Settings {
    let fov = Radians::from_degrees(FOV_DEG);
    Settings {
        camera: Camera::new((FRAME, FRAME), (fov, fov), (0.0, 0.0), None).expect("a camera"),
        follow_up: FollowUpMode::Fixed,
        sigmas: Sigmas {
            tilt_white_rad: 0.002,
            tilt_drift_rad: 0.002,
            heading_drift_rad: 0.005,
            range_m: 0.3,
            ..Sigmas::default()
        },
        mount: Mount::default(),
        motions: Motions::default(),
        latencies: Latencies::default(),
        readout_us: 0,
        lag: 0,
        gap_us: 20_000,
        range_gap_us: 100_000,
        position_age_us: 1_000_000,
        patience_us: 100_000,
        search_px,
        accept: AcceptRule::default(),
    }
}

/// What becomes of frames: each of a ground, with the position off by so many pixels (east, south).
fn flown(search_px: u16, frames: impl Iterator<Item = (u64, (f32, f32))>) -> Vec<Result<Outcome, Refusal>> {
    let mut random = Random::new(90);
    let tile = Ground::new(91, 40.0, 5.0).picture((TILE, TILE), Placement::default(), 3.0, &mut random);
    let georeference = Georeference {
        epsg: 0,
        centre: CENTRE,
        east: [EAST_M, 0.0, 0.0, 0.0, 0.0],
        north: [0.0, NORTH_M, 0.0, 0.0, 0.0],
        convergence: Radians(0.0),
        point_scale: 1.0,
    };
    let tile = Tile::new(&tile.pixels, (TILE, TILE), Metres(RESOLUTION_M), georeference).expect("a tile");
    let (mut buffers, mut navigation, mut frame) = (Buffers::new(), Navigation::new(), vec![0; FRAME_MEMORY_BYTES]);
    let memory = Memory { buffers: &mut buffers, navigation: &mut navigation, frame: &mut frame };
    let mut pipeline = Pipeline::new(settings(search_px), tile, memory).expect("settings");
    // Tile pixels of a frame's pixel.
    let side_px = f64::from(2.0 * HEIGHT_M * (0.5 * FOV_DEG).to_radians().tan() / RESOLUTION_M);
    let placement = Placement { scale: side_px / f64::from(FRAME) - 1.0, ..at((0.0, 0.0)) };
    let mut outcomes = Vec::new();
    for (number, (seed, off)) in (1u64..).zip(frames) {
        let frame = Ground::new(seed, 40.0, 5.0).picture((FRAME, FRAME), placement, 2.0, &mut random);
        let mid = Micros(number * 1_000_000);
        let attitude = Attitude { heading: Radians(0.0), pitch: Radians(0.0), roll: Radians(0.0) };
        for after_us in [-15_000i64, -5_000, 5_000] {
            let sampled_at = Micros((mid.0 as i64 + after_us) as u64);
            pipeline.streams.attitude(sampled_at, attitude).expect("in time");
            pipeline.streams.slant(sampled_at, Metres(HEIGHT_M)).expect("in time");
        }
        let degrees = |px: f32, metres: f32| (px * RESOLUTION_M / metres * 1e5) as i32;
        let position = Geographic {
            lat_e7: CENTRE.lat_e7 - degrees(off.1, NORTH_M),
            lon_e7: CENTRE.lon_e7 + degrees(off.0, EAST_M),
        };
        let sample = PositionSample::standing(position);
        pipeline.position(mid, sample).expect("in time");
        pipeline.begin_frame().expect("a range");
        pipeline.rows(&frame.pixels).expect("rows");
        let situation = pipeline.situate((mid, 0.0), Wait::For(1)).expect("samples").expect("around it");
        pipeline.rectify(&situation).expect("a footprint");
        outcomes.push(pipeline.register(&situation));
    }
    outcomes
}

const SAME: u64 = 91;
const OTHER: u64 = 92;

/// Radius, and whether a fix was made.
fn told(outcomes: &[Result<Outcome, Refusal>]) -> Vec<(u16, bool)> {
    outcomes.iter().map(|o| o.as_ref().map(|o| (o.search_px, o.fix.is_ok())).expect("a match was tried")).collect()
}

/// No fix is off, and each is told against the navigation's own prediction.
fn assert_right(outcomes: &[Result<Outcome, Refusal>], offs: impl Iterator<Item = (f32, f32)>) {
    for (outcome, off) in outcomes.iter().zip(offs) {
        let Ok(Outcome { d_col, d_row, fix: Ok(fix), .. }) = outcome else { continue };
        let off_px = (d_col + off.0).hypot(d_row + off.1);
        let off_m = fix.local.east_m.hypot(fix.local.north_m);
        // A tenth of a pixel by noise, and half of one across 1e-7 degrees and the height's rounding do not add up to this.
        assert!(off_px < 0.3 && off_m < 0.3 * RESOLUTION_M, "{outcome:?}");
    }
}

const LOST: [(u16, bool); LOST_AFTER as usize] = [(10, false); LOST_AFTER as usize];

/// The navigation's position jumps by 40 pixels, 200 metres, stays there, and jumps back: frames are searched where the matches
/// know the vehicle to be.
#[test]
fn a_position_that_jumps_loses_no_frame() {
    let jumped = (32.0, -24.0);
    let offs = [(1.0, 2.0); 3].into_iter().chain([jumped; 7]).chain([(0.5, -1.0); 2]);
    let outcomes = flown(10, offs.clone().map(|off| (SAME, off)));
    assert_eq!(told(&outcomes), [(10, true); 12]);
    assert_right(&outcomes, offs);
}

/// The position is off, and the navigation believes no fix for six frames: the far search has found where it is, and the frames
/// after it are searched there, also over ground that shows nothing for a while. Then the navigation comes, in a jump.
#[test]
fn what_was_found_is_where_the_next_frames_are_searched() {
    let offs = [(32.0, -24.0); 10].into_iter().chain([(0.5, -1.0); 3]);
    let seeds = (0..13).map(|frame| if frame == 6 { OTHER } else { SAME });
    let outcomes = flown(10, seeds.zip(offs.clone()));
    let found = [(64, false), (10, true), (10, true), (10, false), (10, true), (10, true), (10, true)];
    assert_eq!(told(&outcomes), [LOST.as_slice(), &found, &[(10, true); 3]].concat());
    assert_right(&outcomes, offs);
}

/// What was found is known while it cannot be far off: 33 s at 1.5 m/s, and frames are a second apart. Behind that it is looked for
/// around the navigation's position.
#[test]
fn what_was_found_long_ago_is_forgotten() {
    let off = (32.0, -24.0);
    let flown = |others: usize| {
        let seeds = (0..60).map(|frame| if (7..7 + others).contains(&frame) { OTHER } else { SAME });
        flown(10, seeds.map(|seed| (seed, off)))
    };
    let first = |outcomes: &[Result<Outcome, Refusal>], others: usize| {
        let fixed = |outcome: &Result<Outcome, Refusal>| outcome.as_ref().is_ok_and(|outcome| outcome.fix.is_ok());
        outcomes[7 + others..].iter().position(fixed).expect("found again")
    };
    assert_eq!(first(&flown(4), 4), 0);
    assert_eq!(first(&flown(30), 30), 0);
    let long_after = flown(40);
    // One frame finds it far off and the next confirms it; a third where the far search was elsewhere just then.
    assert!((1..=2).contains(&first(&long_after, 40)));
    assert_right(&long_after, [off; 60].into_iter());
}

/// Where the next two frames do not find it, it was none.
#[test]
fn what_is_not_found_again_is_no_fix() {
    let seeds = (0..8).map(|frame| if frame == 3 { SAME } else { OTHER });
    let outcomes = flown(10, seeds.map(|seed| (seed, (32.0, -24.0))));
    assert!(outcomes.iter().flatten().all(|outcome| outcome.fix.is_err()), "{outcomes:?}");
    assert_eq!(outcomes[3].as_ref().map(|outcome| outcome.fix), Ok(Err(Refusal::Unconfirmed)));
    let radii: Vec<_> = outcomes.iter().map(|outcome| outcome.as_ref().map(|outcome| outcome.search_px)).collect();
    // Two where it was found, and then far again.
    assert_eq!(radii, [10, 10, 10, 64, 10, 10, 64, 64].map(Ok));
}

/// A position further off than one far search reaches: after three around it they go round.
#[test]
fn far_searches_go_round_the_prediction() {
    let off = (80.0, 0.0);
    let outcomes = flown(10, [(SAME, off); 10].into_iter());
    let fixed: Vec<bool> = outcomes.iter().map(|outcome| outcome.as_ref().is_ok_and(|o| o.fix.is_ok())).collect();
    assert_eq!(fixed, [[false; 9].as_slice(), &[true]].concat());
    assert_eq!(outcomes[8].as_ref().map(|outcome| outcome.fix), Ok(Err(Refusal::Unconfirmed)));
    assert_right(&outcomes, [off; 10].into_iter());
}

/// Frames of other ground are never found: from the fourth on each is searched far as well.
#[test]
fn a_search_in_vain_is_made_again_elsewhere() {
    let outcomes = flown(10, (0..18).map(|_| (OTHER, (0.0, 0.0))));
    assert!(outcomes.iter().flatten().all(|outcome| outcome.fix.is_err()));
    let is_near = |outcome: &Result<Outcome, Refusal>| outcome.as_ref().is_ok_and(|outcome| outcome.search_px == 10);
    let near: Vec<bool> = outcomes.iter().map(is_near).collect();
    assert_eq!(near, [[true; 3].as_slice(), &[false; 15]].concat());
    // One that is accepted ends the row.
    let seeds = [OTHER, SAME, OTHER, OTHER, OTHER, OTHER];
    let outcomes = flown(10, seeds.into_iter().map(|seed| (seed, (0.0, 0.0))));
    let radii: Vec<u16> = told(&outcomes).iter().map(|told| told.0).collect();
    assert_eq!(radii, [10, 10, 10, 10, 10, 64]);
}

/// Where four were in vain the first one that is found is as well a wrong one: another must find it, too.
#[test]
fn the_first_match_after_many_in_vain_is_confirmed() {
    let seeds = [OTHER, OTHER, OTHER, OTHER, SAME, OTHER, SAME, SAME];
    let outcomes = flown(10, seeds.into_iter().map(|seed| (seed, (1.0, 0.0))));
    let fixes = outcomes.iter().map(|outcome| outcome.as_ref().expect("a match was tried").fix.is_ok());
    assert_eq!(fixes.collect::<Vec<_>>(), [false, false, false, false, false, false, true, true]);
    assert_eq!(outcomes[4].as_ref().map(|outcome| outcome.fix), Ok(Err(Refusal::Unconfirmed)));
}

/// A position as far off as the search reaches: the next one is made around what lies on the border, and another frame must find it,
/// too.
#[test]
fn what_lies_on_the_border_is_followed() {
    let off = (-10.0, 4.0);
    let outcomes = flown(10, [(SAME, off); 4].into_iter());
    assert_eq!(told(&outcomes), [(10, false), (10, false), (10, true), (10, true)]);
    let reasons = [0, 1].map(|frame| outcomes[frame].as_ref().map(|outcome| outcome.fix));
    assert_eq!(reasons, [Ok(Err(Refusal::OnBorder)), Ok(Err(Refusal::Unconfirmed))]);
    assert_right(&outcomes, [off; 4].into_iter());
}

/// A wider search can be asked for; the widest is the one for a lost position.
#[test]
fn a_wide_search_is_made_where_it_is_asked_for() {
    let outcomes = flown(48, [(SAME, (-44.0, 41.0)), (SAME, (0.0, 3.0))].into_iter());
    assert_eq!(told(&outcomes), [(48, true); 2]);
    for (search_px, allowed) in [(0, false), (1, true), (64, true), (65, false)] {
        let expected = if allowed { Ok(()) } else { Err(SettingsError::Search) };
        assert_eq!(settings(search_px).check(), expected, "{search_px}");
    }
}

/// Near the tile's border the far search ends with it; where not even the near one fits, nothing is tried.
#[test]
fn a_lost_position_near_the_border_is_searched_as_far_as_the_tile_reaches() {
    // Half the tile is 110 pixels, the near window 27.
    let outcomes = flown(10, [(60.0, -50.0); 4].map(|off| (SAME, off)).into_iter());
    assert_eq!(outcomes[3].as_ref().map(|outcome| outcome.fix), Ok(Err(Refusal::Unconfirmed)));
    let outcomes = flown(10, [(SAME, (84.0, 0.0))].into_iter());
    assert_eq!(outcomes[0].as_ref().map(|_| ()), Err(&Refusal::OutsideReference));
}
