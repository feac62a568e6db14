//! The comparison's own arithmetic: the exact average against brute force and a closed form, the matrix that others get
//! against the core's map, scores, and what is told of them. OpenCV itself is not needed.
use plumbline_core::image::Run;
use plumbline_sim::camera::still::runs_of;
use plumbline_survey::io::picture::Picture;
use plumbline_tests::compare::case::{Limits, Purpose};
use plumbline_tests::compare::front::{Candidate, Whose};
use plumbline_tests::compare::ours::{Kernel, Way};
use plumbline_tests::compare::run::{Comparison, Outcome, Row};
use plumbline_tests::compare::score::{Score, score, shift_px};
use plumbline_tests::compare::view::{Ground, Pose, View};
use plumbline_tests::compare::{Grey, drawing, front, matched, pictures, tell};

const TILTED: Pose = Pose { heading_deg: 30.0, pitch_deg: 8.0, roll_deg: 10.0, is_followed: false };
const GROUND: Ground = Ground { fov_deg: 40.0, height_m: 439.6, resolution_m: 5.0, cells: (64, 64) };

fn views() -> Vec<View> {
    let poses = [TILTED, Pose { is_followed: true, ..TILTED }, Pose { heading_deg: 137.0, ..TILTED }];
    let wide = Ground { fov_deg: 60.0, height_m: 150.0, resolution_m: 5.0, cells: (35, 31) };
    let grounds = [GROUND, wide];
    let views = poses.iter().flat_map(|&pose| grounds.map(|ground| View::new((512, 512), ground, pose)));
    views.collect::<Result<_, _>>().expect("views")
}

/// Frame position of a patch position by the matrix.
fn by_matrix(m: &[f64; 9], col: f64, row: f64) -> (f64, f64) {
    let line = |n: usize| m[n] * col + m[n + 1] * row + m[n + 2];
    (line(0) / line(6), line(3) / line(6))
}

/// Outline of a cell in the frame, in order.
fn outline(view: &View, cell: usize) -> [(f64, f64); 4] {
    let cols = usize::from(view.ground().cells.0);
    let (col, row) = ((cell % cols) as f64, (cell / cols) as f64);
    let matrix = view.frame_from_patch();
    [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(du, dv)| by_matrix(&matrix, col + du, row + dv))
}

/// Area and centroid.
fn moments(quad: &[(f64, f64); 4]) -> (f64, (f64, f64)) {
    let (mut area, mut x, mut y) = (0.0, 0.0, 0.0);
    let origin = quad[0];
    for (p, q) in quad.iter().zip(quad.iter().cycle().skip(1)) {
        let (p, q) = ((p.0 - origin.0, p.1 - origin.1), (q.0 - origin.0, q.1 - origin.1));
        let cross = p.0 * q.1 - q.0 * p.1;
        area += 0.5 * cross;
        x += (p.0 + q.0) * cross / 6.0;
        y += (p.1 + q.1) * cross / 6.0;
    }
    (area.abs(), (origin.0 + x / area, origin.1 + y / area))
}

/// Positions come from single precision: 6e-5 px at 512, a few roundings each.
#[test]
fn the_matrix_is_the_cores_map() {
    for view in views() {
        let (matrix, map) = (view.frame_from_patch(), view.map());
        let mut worst = 0.0f64;
        for (col, row) in
            (0..view.ground().cells.0).flat_map(|col| (0..view.ground().cells.1).map(move |row| (col, row)))
        {
            let (x, y) = map.frame_position(col.into(), row.into()).expect("in front");
            let (u, v) = by_matrix(&matrix, col.into(), row.into());
            worst = worst.max((f64::from(x) - u).hypot(f64::from(y) - v));
        }
        println!("matrix: at most {worst:.1e} px");
        assert!(worst < 1e-3, "{worst} px");
    }
}

/// Brute force: 16 x 16 points a frame pixel, those within the outline. Each of the n = 16 x perimeter points on the
/// outline is in or out for a part of its 1/256 px that is even between ±1/2, so of deviation 0.29: the mean is off by
/// 0.29 √n s / 256 area for greys of deviation s. Six times that.
#[test]
fn the_exact_average_is_that_of_many_points() {
    let frame = pictures::prototype();
    let mean = frame.pixels.iter().map(|&p| f64::from(p)).sum::<f64>() / frame.pixels.len() as f64;
    let s =
        (frame.pixels.iter().map(|&p| (f64::from(p) - mean).powi(2)).sum::<f64>() / frame.pixels.len() as f64).sqrt();
    for view in views() {
        let mut seen = 0;
        for (cell, exact) in view.exact(&frame).iter().enumerate().skip(3).step_by(41) {
            let Some(exact) = *exact else { continue };
            let quad = outline(&view, cell);
            let side = |p: (f64, f64), q: (f64, f64), x: f64, y: f64| (q.0 - p.0) * (y - p.1) - (q.1 - p.1) * (x - p.0);
            let bounds = |axis: fn(&(f64, f64)) -> f64| {
                let (low, high) = quad.iter().map(axis).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
                (low + 0.5).floor() as usize..=(high + 0.5).floor() as usize
            };
            let (mut sum, mut count) = (0.0, 0u32);
            for (row, col) in bounds(|p| p.1).flat_map(|row| bounds(|p| p.0).map(move |col| (row, col))) {
                for (v, u) in (0..16).flat_map(|v| (0..16).map(move |u| (v, u))) {
                    let at = |px: usize, n: i32| px as f64 - 0.5 + (f64::from(n) + 0.5) / 16.0;
                    let sides: [f64; 4] =
                        std::array::from_fn(|n| side(quad[n], quad[(n + 1) % 4], at(col, u), at(row, v)));
                    if sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0) {
                        sum += f64::from(frame.pixels[row * 512 + col]);
                        count += 1;
                    }
                }
            }
            let perimeter: f64 =
                (0..4).map(|n| (quad[n].0 - quad[(n + 1) % 4].0).hypot(quad[n].1 - quad[(n + 1) % 4].1)).sum();
            let tolerance = 6.0 * 0.29 * (16.0 * perimeter).sqrt() * s / 256.0 / moments(&quad).0;
            let off = (sum / f64::from(count) - exact).abs();
            assert!(off < tolerance, "cell {cell}: {off} grey levels from {exact}, {tolerance} allowed");
            seen += 1;
        }
        assert!(seen > 10, "only {seen} cells");
    }
}

/// A plane, grey = column: piecewise constant it differs from the column by a saw tooth, whose integral over any stretch is
/// between ±1/8. So the mean is the centroid's column to height / (8 area). Grey = row likewise.
#[test]
fn the_exact_average_of_a_plane_is_its_value_at_the_centroid() {
    let ground = Ground { fov_deg: 50.0, height_m: 100.0, resolution_m: 3.1, cells: (20, 24) };
    for is_row in [false, true] {
        let pixels = (0..200u8).flat_map(|row| (0..200u8).map(move |col| if is_row { row } else { col })).collect();
        let frame = Grey { pixels, size: (200, 200) };
        let view = View::new((200, 200), ground, TILTED).expect("a view");
        let mut seen = 0;
        for (cell, exact) in view.exact(&frame).iter().enumerate() {
            let Some(exact) = *exact else { continue };
            let quad = outline(&view, cell);
            let (area, centroid) = moments(&quad);
            let across = quad.map(|p| if is_row { p.0 } else { p.1 });
            let extent =
                across.iter().fold(f64::MIN, |a, &b| a.max(b)) - across.iter().fold(f64::MAX, |a, &b| a.min(b));
            let off = (exact - if is_row { centroid.1 } else { centroid.0 }).abs();
            assert!(off < extent / 8.0 / area + 1e-3, "cell {cell}: {off}");
            seen += 1;
        }
        assert!(seen > 100, "only {seen} cells");
    }
}

/// On the smooth picture every way to use the core gives what the exact average is, about; and where it is.
#[test]
fn the_cores_kernels_agree_on_a_smooth_picture() {
    let frame = pictures::smooth((512, 512));
    for view in views() {
        let exact = view.exact(&frame);
        for way in Way::ALL.into_iter().filter(|way| way.suits(&view)) {
            let mut kernel = Kernel::new(way, &view);
            kernel.rectify(&frame).expect("rectified");
            let patch = kernel.patch();
            let (of, shift) = (
                score(&patch.pixels, &exact, &patch.is_valid),
                shift_px(&patch.pixels, &exact, &patch.is_valid, &view),
            );
            assert!(of.cells > 500 && of.rms < 1.5, "{way:?}: {of:?}");
            assert!(shift.is_some_and(|px| px < 0.25), "{way:?}: shifted {shift:?} px");
        }
    }
}

/// The exact average is found where the frame was taken, to the matcher's own 0.03 cells; the places have no symmetry, so
/// an axis exchanged or turned round would show. A patch moved by a cell is found a cell further.
#[test]
fn known_ground_is_matched_where_it_was_taken() {
    let mut land = Picture { cols: 700, rows: 700, pixels: vec![0; 700 * 700] };
    plumbline_firmware::bench::texture::ground(&mut land.pixels, 700, 5);
    let ground = Ground { fov_deg: 40.0, height_m: 439.6, resolution_m: 10.0, cells: (32, 32) };
    let cases = matched::cases("ground", &land, (256, 256), ground, &[TILTED]).expect("frames");
    assert!(cases.len() > 3);
    for case in cases {
        let view = View::new((256, 256), ground, TILTED).expect("a view");
        let exact = view.exact(&case.frame);
        let cell = |pixel: Option<f64>| pixel.map_or(0, |grey| grey.round() as u8);
        let mask: Vec<u8> = exact.iter().map(|pixel| if pixel.is_some() { 255 } else { 0 }).collect();
        let runs = runs_of(&Picture { cols: 32, rows: 32, pixels: mask });
        let patch: Vec<u8> = exact.iter().copied().map(cell).collect();
        let reference = case.reference.expect("a reference");
        let error = reference.error_px(&patch, &runs, (32, 32));
        assert!(error < 0.05, "{error} cells");
        let moved: Vec<u8> = (0..patch.len()).map(|n| patch[n.saturating_sub(1)]).collect();
        let runs: Vec<_> = runs.into_iter().map(|run| Run { start: run.start + 1, ..run }).collect();
        let error = reference.error_px(&moved, &runs, (32, 32));
        assert!((error - 1.0).abs() < 0.1, "{error} cells");
        assert!(reference.error_px(&patch, &[], (32, 32)).is_nan(), "nothing to match");
    }
}

/// A patch moved by 0.3 and 0.4 cells is shifted by half a cell, 4 frame pixels.
#[test]
fn a_shift_is_found() {
    let view = View::new((512, 512), GROUND, TILTED).expect("a view");
    let wave =
        |col: f64, row: f64| 128.0 + 60.0 * (0.2 * col + 0.1 * row).sin() + 50.0 * (0.25 * row - 0.1 * col).sin();
    let cells = || (0..64).flat_map(|row| (0..64).map(move |col| (f64::from(col), f64::from(row))));
    let exact: Vec<Option<f64>> = cells().map(|(col, row)| Some(wave(col, row))).collect();
    let patch: Vec<u8> = cells().map(|(col, row)| wave(col + 0.3, row + 0.4).round() as u8).collect();
    let shift = shift_px(&patch, &exact, &[true; 64 * 64], &view).expect("slopes both ways");
    assert!((shift - 4.0).abs() < 0.15, "{shift} px");
    assert_eq!(shift_px(&patch, &vec![Some(7.0); 64 * 64], &[true; 64 * 64], &view), None, "no slopes");
}

#[test]
fn only_counted_cells_are_scored() {
    let exact = [Some(10.0), None, Some(20.0), Some(30.0)];
    let found = score(&[13, 99, 24, 99], &exact, &[true, true, true, false]);
    assert_eq!(found, Score { rms: 12.5f64.sqrt(), worst: 4.0, cells: 2 });
    assert_eq!(score(&[], &[], &[]), Score::default());
}

#[test]
fn impossible_views_are_refused() {
    for (ground, pose) in [
        (Ground { fov_deg: 180.0, ..GROUND }, TILTED),
        (Ground { height_m: 0.0, ..GROUND }, TILTED),
        (Ground { resolution_m: f64::NAN, ..GROUND }, TILTED),
        (Ground { cells: (0, 64), ..GROUND }, TILTED),
        (GROUND, Pose { pitch_deg: 95.0, ..TILTED }),
        (GROUND, Pose { pitch_deg: 85.0, ..TILTED }),
    ] {
        assert!(View::new((512, 512), ground, pose).is_err(), "{ground:?}, {pose}");
    }
}

/// A run with one view: ours of `rms` in `seconds`, the rival in a second.
fn comparison(rms: f64, seconds: f64) -> Comparison {
    let row = |kernel: &str, is_ours, rms, seconds| Row {
        kernel: kernel.into(),
        is_ours,
        score: Score { rms, worst: 3.0, cells: 9 },
        shift_px: None,
        match_px: None,
        seconds,
    };
    let outcome = Outcome {
        picture: "picture",
        frame: (512, 512),
        ground: GROUND,
        pose: TILTED,
        limits: Some(Limits { rms: (1.0, 0.6), time: (1.0, 0.33) }),
        purpose: Purpose::Timed,
        rows: vec![row("ours", true, rms, seconds), row("theirs", false, 0.3, 1.0)],
    };
    Comparison { version: "5".into(), area_is_linear: true, outcomes: vec![outcome] }
}

#[test]
fn limits_are_held_and_numbers_that_are_none_fail() {
    let held = |rms, seconds| tell::gates(&comparison(rms, seconds)).iter().map(tell::Gate::holds).collect::<Vec<_>>();
    assert_eq!(held(0.9, 0.5), [true, true]);
    assert_eq!(held(1.1, 1.5), [false, false]);
    assert_eq!(held(f64::NAN, f64::NAN), [false, false]);
    let mut smooth = comparison(0.5, 0.5);
    smooth.outcomes[0].purpose = Purpose::Smooth;
    smooth.outcomes[0].limits = None;
    assert_eq!(tell::gates(&smooth).len(), 1);
    assert!(!tell::gates(&smooth)[0].holds(), "no shift could be told");
    smooth.outcomes[0].rows.iter_mut().for_each(|row| row.shift_px = Some(0.1));
    assert!(tell::gates(&smooth)[0].holds());
}

#[test]
fn the_table_and_its_json_say_the_same() {
    let told = comparison(0.9, 0.5);
    let text = tell::table(&told);
    let line = text.lines().find(|line| line.starts_with("  ours")).expect("a line of ours");
    assert!(line.contains("0.90") && line.ends_with("0.50"), "{line}");
    assert!(text.lines().any(|line| line.contains("RMS") && line.ends_with("holds")), "{text}");
    let json: serde_json::Value = serde_json::from_str(&tell::json(&told, &["Vienna"])).expect("JSON");
    assert_eq!(json["rows"][0]["time_ratio"], 0.5);
    assert_eq!(json["rows"][1]["rms"], 0.3);
    assert_eq!(json["gates"][1]["holds"], true);
    assert_eq!(json["skipped"][0], "Vienna");
}

fn candidate(name: &str, whose: Whose, instructions: f64, rms: f64) -> Candidate {
    Candidate { name: name.into(), whose, instructions, rms, rms_vienna: None, bytes: Some(7) }
}

#[test]
fn the_front_is_what_nothing_else_beats() {
    let all = [
        candidate("cheap", Whose::Theirs, 1.0, 9.0),
        candidate("dear", Whose::Theirs, 2.0, 9.0),
        candidate("good", Whose::Ours, 2.0, 3.0),
        candidate("worse", Whose::Former, 5.0, 3.5),
        candidate("best", Whose::Ours, 7.0, 0.5),
    ];
    let front: Vec<_> = front::front(&all).map(|c| c.name.as_str()).collect();
    assert_eq!(front, ["cheap", "good", "best"]);
    let table = front::table(&all);
    assert!(table.contains("| worse | this core, formerly | 5.00 | 3.50 | not known | 7 | no |"), "{table}");
    let svg = drawing::svg(&all);
    assert!(all.iter().all(|c| svg.contains(&format!(">{} (", c.name))), "{svg}");
    // Two of a kind are told apart by their marks, one more of each in the legend.
    assert_eq!((svg.matches("<circle").count(), svg.matches("fill=\"#c2571a\"").count()), (5, 3));
}

/// Costs come from the table of exact counts; a workload that it lacks is named.
#[test]
fn candidates_have_the_counts_of_the_table() {
    let mut told = comparison(0.9, 0.5);
    let outcome = &mut told.outcomes[0];
    outcome.picture = "prototype texture";
    outcome.rows = Way::ALL.map(|way| Row { kernel: way.name(), ..outcome.rows[0].clone() }).to_vec();
    let mut counts = serde_json::json!({"instructions": {}});
    for (n, way) in (1u32..).zip(Way::ALL) {
        counts["instructions"][way.workload()] = (262_144 * n).into();
    }
    let all = front::candidates(&told, &counts).expect("all counts");
    let on_board = all.iter().find(|c| c.name == "boxes of 4 x 4, as on board").expect("what flies");
    assert_eq!((on_board.instructions, on_board.rms, on_board.bytes), (1.0, 0.9, Some(33_280)));
    assert!(all.windows(2).all(|pair| pair[0].instructions <= pair[1].instructions), "cheapest first");
    counts["instructions"].as_object_mut().expect("counts").remove(&Way::Boxes(2).workload());
    assert!(front::candidates(&told, &counts).is_err_and(|why| why.contains("boxes of 2x2")));
}
