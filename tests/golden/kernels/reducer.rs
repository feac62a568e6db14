//! Box averages: exact, and only of what is a frame.

use plumbline_core::reduce::{ReduceError, Reducer, Reduction};

fn reduction(frame: (u16, u16), factor: u16) -> Reduction {
    let reduction = Reduction::choose(frame, 4.0 * f32::from(factor), usize::MAX).expect("it fits");
    assert_eq!(reduction.factor(), factor);
    reduction
}

/// Every sum that a box can have, at every factor: the mean rounded to nearest.
#[test]
fn means_are_rounded_to_nearest() {
    for factor in 1..=16u16 {
        let area = u32::from(factor) * u32::from(factor);
        let boxes = 512;
        let (cols, size) = (boxes * factor, (boxes * factor, 2 * factor));
        let mut first = 0;
        while first <= 255 * area {
            // Two rows of boxes; box b of them holds the sum first + b, as evenly as whole grey levels allow.
            let mut reducer = Reducer::new(reduction(size, factor), size);
            let (mut sums, mut reduced) = (vec![0; boxes.into()], vec![0; 2 * usize::from(boxes)]);
            let sum_of = |b: u32| (first + b).min(255 * area);
            for row in 0..size.1 {
                let line = |col: u16| {
                    let b = u32::from(col / factor) + u32::from(boxes) * u32::from(row / factor);
                    let place = u32::from(row % factor) * u32::from(factor) + u32::from(col % factor);
                    (sum_of(b) / area + u32::from(place < sum_of(b) % area)) as u8
                };
                let pixels: Vec<u8> = (0..cols).map(line).collect();
                reducer.take(&pixels, &mut sums, &mut reduced).expect("a row of the frame");
            }
            for (b, &mean) in reduced.iter().enumerate() {
                let twice_off = 2 * i64::from(mean) * i64::from(area) - 2 * i64::from(sum_of(b as u32));
                assert!(twice_off.abs() <= i64::from(area), "{mean} for {} / {area}", sum_of(b as u32));
            }
            first += 2 * u32::from(boxes);
        }
    }
}

/// Boxes count from the frame's first row and column; what no whole box covers is left out.
#[test]
fn boxes_lie_where_reduced_says() {
    let (size, factor) = ((23u16, 17u16), 4);
    let mut reducer = Reducer::new(reduction(size, factor), size);
    let (mut sums, mut reduced) = (vec![0; 5], vec![0; 20]);
    for row in 0..17u16 {
        let pixels: Vec<u8> = (0..23u16).map(|col| (5 * col + 7 * row) as u8).collect();
        reducer.take(&pixels, &mut sums, &mut reduced).expect("a row of the frame");
    }
    assert!(reducer.is_complete());
    let reduction = reducer.reduction();
    assert_eq!(reduction.size(), (5, 4));
    // A plane's mean over a box is its value at the box's centre.
    for (i, &mean) in reduced.iter().enumerate() {
        let centre = |at: usize| 4.0 * at as f32 + 1.5;
        let (x, y) = (centre(i % 5), centre(i / 5));
        assert!((f32::from(mean) - (5.0 * x + 7.0 * y)).abs() <= 0.5, "box {i}: {mean}");
        assert!((reduction.reduced(x) - (i % 5) as f32).abs() < 1e-6);
    }
}

#[test]
fn rows_that_are_not_the_frames_are_refused() {
    let size = (64, 8);
    let mut reducer = Reducer::new(reduction(size, 4), size);
    let (mut sums, mut reduced) = (vec![0; 16], vec![0; 32]);
    for bad in [0, 63, 65, 128] {
        assert_eq!(reducer.take(&vec![1; bad], &mut sums, &mut reduced), Err(ReduceError::Size), "{bad} pixels");
    }
    assert_eq!(reducer.rows_taken(), 0);
    for _ in 0..8 {
        assert!(!reducer.is_complete());
        assert_eq!(reducer.take(&[9; 64], &mut sums, &mut reduced), Ok(()));
    }
    assert!(reducer.is_complete());
    assert_eq!(reducer.take(&[1; 64], &mut sums, &mut reduced), Err(ReduceError::Size), "one row too many");
    assert!(reduced.iter().all(|&mean| mean == 9));
    let mut reducer = Reducer::new(reduction(size, 4), size);
    assert_eq!(reducer.take(&[9; 64], &mut sums[..15], &mut reduced), Err(ReduceError::Capacity));
    let mut reducer = Reducer::new(reduction(size, 4), size);
    assert_eq!(reducer.take(&[9; 64], &mut sums, &mut reduced[..15]), Err(ReduceError::Capacity));
}

#[test]
fn the_largest_factor_that_the_patch_allows_and_the_memory_asks_for() {
    let factor = |frame, ratio, capacity| Reduction::choose(frame, ratio, capacity).map(|r| r.factor());
    // Four boxes a patch pixel; never less than one frame pixel.
    for (ratio, wanted) in [(0.2, 1), (7.9, 1), (8.0, 2), (14.8, 3), (64.0, 16), (900.0, 16), (f32::NAN, 1)] {
        assert_eq!(factor((512, 512), ratio, usize::MAX), Ok(wanted), "ratio {ratio}");
    }
    // 512 x 512 into 10404 pixels: 102 x 102 by boxes of 5.
    assert_eq!(factor((512, 512), 8.0, 10_404), Ok(5));
    assert_eq!(factor((512, 512), 8.0, 1023), Err(ReduceError::Capacity));
    assert_eq!(factor((30, 512), 64.0, usize::MAX), Err(ReduceError::Capacity), "not two boxes across");
}
