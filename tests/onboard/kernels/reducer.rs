//! Sums of boxes: what they are, where they lie, and only of what is a frame.

use plumbline_core::reduce::{ReduceError, Reducer, Reduction};
use plumbline_tests::seeded::Random;

/// Powers of two up to the largest.
const FACTORS: [u16; 7] = [1, 2, 4, 8, 16, 32, 64];

fn reduction(frame: (u16, u16), factor: u16) -> Reduction {
    let reduction = Reduction::choose(frame, 3.0 * f32::from(factor), usize::MAX).expect("it fits");
    assert!(reduction.is_boxes());
    assert_eq!(reduction.factor(), factor);
    reduction
}

/// Takes `rows`, `at_once` rows of boxes at a time, from a buffer whose first pixel lies at `offset` of a word.
fn kept(rows: &[u8], frame: (u16, u16), factor: u16, (at_once, offset): (usize, usize)) -> Vec<u8> {
    let mut reducer = Reducer::new(reduction(frame, factor), frame);
    let mut kept = vec![0xAA; reducer.reduction().bytes()];
    let mut padded = vec![0u8; rows.len() + 8];
    let first = padded.as_ptr().align_offset(4) + offset;
    padded[first..first + rows.len()].copy_from_slice(rows);
    let mut rest = &padded[first..first + rows.len()];
    while !rest.is_empty() {
        let taken = (at_once * usize::from(frame.0) * usize::from(factor)).min(rest.len());
        reducer.take(&rest[..taken], &mut kept).expect("rows of the frame");
        rest = &rest[taken..];
    }
    assert!(reducer.is_complete());
    assert_eq!((reducer.rows_taken(), reducer.rows_wanted()), (frame.1, 0));
    kept
}

/// Entry `border` of row `row`: the sum of the boxes left of that border.
fn entry(kept: &[u8], reduction: &Reduction, row: usize, border: usize) -> i16 {
    let at = row * reduction.stride() + 2 * (border + 1);
    i16::from_le_bytes([kept[at], kept[at + 1]])
}

/// The sum of whole pixels, less 128 each, in the box.
fn box_sum(frame: &[u8], cols: usize, factor: usize, (col, row): (usize, usize)) -> i64 {
    let pixels = (0..factor * factor).map(|i| (row * factor + i / factor) * cols + col * factor + i % factor);
    pixels.map(|at| i64::from(frame[at]) - 128).sum()
}

/// Sums of means of pairs: down the columns rounded down, then along the row rounded up.
fn pair_mean(frame: &[u8], cols: usize, (col, row): (usize, usize)) -> i64 {
    let pixel = |right: usize, down: usize| i64::from(frame[(2 * row + down) * cols + 2 * col + right]);
    let column = |right: usize| (pixel(right, 0) + pixel(right, 1)).div_euclid(2);
    (column(0) + column(1) + 1).div_euclid(2) - 128
}

/// Every factor, with rows of up to 256 boxes and of more, of sizes that are no multiple of anything; black, white and
/// noise; all at once and row by row; from any address.
#[test]
fn sums_are_those_of_all_boxes_to_the_left() {
    let mut random = Random::new(11);
    for factor in FACTORS {
        for (boxes, shift) in [(2, 0), (3, 0), (37, 0), (250, 0), (256, 0), (257, 1), (300, 1), (513, 2), (1023, 2)] {
            let frame = (boxes * factor + (factor - 1).min(3), 2 * factor + factor / 2);
            let (cols, rows) = (usize::from(frame.0), usize::from(frame.1));
            let noise: Vec<u8> = (0..cols * rows).map(|_| random.byte()).collect();
            for image in [noise, vec![0; cols * rows], vec![255; cols * rows]] {
                let reduction = reduction(frame, factor);
                assert_eq!((reduction.size(), reduction.shift()), ((boxes, 2), shift));
                assert_eq!(reduction.bytes(), 2 * 2 * (usize::from(boxes) + 2));
                let sums = kept(&image, frame, factor, (1, 0));
                assert_eq!(sums, kept(&image, frame, factor, (9, 0)), "at once, {boxes} boxes of {factor}");
                assert_eq!(sums, kept(&image, frame, factor, (1, 3)), "from an odd address, {boxes} boxes of {factor}");
                for row in 0..2 {
                    assert_eq!(entry(&sums, &reduction, row, 0), 0, "nothing lies left of the first border");
                    let mut total = 0;
                    for col in 0..usize::from(boxes) {
                        // Sums of pairs are rounded box by box, as two instructions do it, in whole fours; others as a
                        // whole.
                        let is_pair = factor == 2 && shift == 0 && col < usize::from(boxes) & !3;
                        total += match is_pair {
                            true => 4 * pair_mean(&image, cols, (col, row)),
                            false => box_sum(&image, cols, factor.into(), (col, row)),
                        };
                        let area = (i64::from(factor) * i64::from(factor)) << shift;
                        let found = i64::from(entry(&sums, &reduction, row, col + 1));
                        assert_eq!(found, total.div_euclid(area), "box {col} of {boxes} of {factor}");
                    }
                }
            }
        }
    }
}

/// Rounded down and up, means of pairs are on the whole neither: over all four pixels of four grey levels in a row the
/// mean rounding is 0, and no box is off by more than half a grey level.
#[test]
fn pairs_are_not_rounded_to_one_side() {
    let mut twice = 0;
    for i in 0..256usize {
        let level = |place: usize| 100 + (i >> (2 * place) & 3) as u8;
        // Four boxes a row: fewer are not paired.
        let row = |left: u8, right: u8| [left, right, 9, 9, 9, 9, 9, 9];
        let image = [row(level(0), level(1)), row(level(2), level(3)), [9; 8], [9; 8]].concat();
        let sums = kept(&image, (8, 4), 2, (1, 0));
        let mean = i64::from(i16::from_le_bytes([sums[4], sums[5]])) + 128;
        let exact = (0..4).map(|place| i64::from(level(place))).sum::<i64>();
        assert!((4 * mean - exact).abs() <= 2, "{image:?}: {mean}");
        twice += 4 * mean - exact;
    }
    assert_eq!(twice, 0, "quarters of a grey level in 256 boxes");
}

/// Below two frame pixels a patch pixel the frame itself is kept.
#[test]
fn a_frame_that_is_kept_is_the_frame() {
    let image: Vec<u8> = (0..7 * 5).map(|i| (37 * i % 251) as u8).collect();
    let mut reducer = Reducer::new(Reduction::none((7, 5)), (7, 5));
    let mut kept = vec![0; 35];
    for row in image.chunks_exact(7) {
        assert_eq!(reducer.rows_wanted(), 1);
        reducer.take(row, &mut kept).expect("a row");
    }
    assert_eq!(kept, image);
    assert!(reducer.is_complete());
}

#[test]
fn rows_that_are_not_the_frames_are_refused() {
    let size = (64, 10);
    let mut reducer = Reducer::new(reduction(size, 4), size);
    let mut sums = vec![0; reducer.reduction().bytes()];
    // No pixel, less or more than whole rows, and whole rows that are no row of boxes.
    for bad in [0, 63, 64, 65, 3 * 64, 4 * 64 - 1] {
        assert_eq!(reducer.take(&vec![1; bad], &mut sums), Err(ReduceError::Size), "{bad} pixels");
        assert_eq!(reducer.rows_taken(), 0);
    }
    assert_eq!(reducer.rows_wanted(), 4);
    assert_eq!(reducer.take(&[137; 4 * 64], &mut sums), Ok(()));
    // What was taken before stays taken.
    assert_eq!(reducer.take(&[137; 5 * 64], &mut sums), Err(ReduceError::Size));
    assert_eq!((reducer.rows_taken(), reducer.rows_wanted(), reducer.is_complete()), (8, 2, false));
    // The rest of the frame, of which no whole box is left.
    assert_eq!(reducer.take(&[200; 3 * 64], &mut sums), Err(ReduceError::Size));
    assert!(reducer.is_complete(), "two of the three rows were the frame's");
    assert_eq!(reducer.take(&[200; 64], &mut sums), Err(ReduceError::Size), "one row too many");
    let last = (1..=16).map(|border| entry(&sums, &reducer.reduction(), 1, border));
    assert_eq!(last.collect::<Vec<_>>(), (1..=16).map(|n| 9 * n).collect::<Vec<_>>());
    let mut reducer = Reducer::new(reduction(size, 4), size);
    let row = reducer.reduction().stride();
    assert_eq!(reducer.take(&[9; 4 * 64], &mut sums[..row - 1]), Err(ReduceError::Capacity));
    assert_eq!((reducer.rows_taken(), reducer.take(&[9; 4 * 64], &mut sums[..row])), (0, Ok(())));
    assert_eq!(reducer.take(&[9; 4 * 64], &mut sums[..2 * row - 1]), Err(ReduceError::Capacity));
}

#[test]
fn the_largest_boxes_that_the_patch_allows_and_the_memory_asks_for() {
    let factor = |frame, ratio, capacity| {
        Reduction::choose(frame, ratio, capacity).map(|r| if r.is_boxes() { r.factor() } else { 0 })
    };
    // Three boxes a patch pixel, in powers of two; the frame itself below two of its pixels.
    let wanted = [(0.2, 0), (1.999, 0), (2.0, 1), (5.9, 1), (6.0, 2), (8.0, 2), (11.9, 2), (12.0, 4), (14.8, 4)];
    let coarser = [(24.0, 8), (47.9, 8), (48.0, 16), (191.9, 32), (192.0, 64), (1e9, 64), (f32::NAN, 1), (-1.0, 0)];
    for (ratio, wanted) in wanted.into_iter().chain(coarser) {
        assert_eq!(factor((512, 512), ratio, usize::MAX), Ok(wanted), "ratio {ratio}");
    }
    // Two bytes a box and four a row. One byte less, and boxes are larger.
    for (capacity, wanted) in [(132_096, 2), (132_095, 4), (33_280, 4), (33_279, 8), (8_448, 8), (8_447, 16)] {
        assert_eq!(factor((512, 512), 8.0, capacity), Ok(wanted), "{capacity} bytes");
    }
    assert_eq!(factor((512, 512), 1.5, 262_144), Ok(0));
    assert_eq!(factor((512, 512), 1.5, 262_143), Ok(2), "boxes of a pixel each take twice as much as the frame");
    // 64 x 64 are the largest: eight rows of eight.
    assert_eq!((factor((512, 512), 8.0, 160), factor((512, 512), 8.0, 159)), (Ok(64), Err(ReduceError::Capacity)));
    assert_eq!(factor((127, 512), 192.0, usize::MAX), Err(ReduceError::Capacity), "not two boxes across");
    assert_eq!(factor((512, 127), 192.0, usize::MAX), Err(ReduceError::Capacity), "nor along");
    assert_eq!(factor((128, 128), 192.0, usize::MAX), Ok(64));
    for frame in [(0, 0), (1, 1), (0, 512), (1, 512), (512, 1)] {
        assert_eq!(factor(frame, 1.0, usize::MAX), Err(ReduceError::Capacity), "{frame:?}");
    }
    assert_eq!((factor((2, 2), 1.0, 4), factor((2, 2), 3.0, 16)), (Ok(0), Ok(1)));
}
