//! What is not known of a picture, filled in so that it says nothing: smoothly from what is known around it.
//!
//! The solution of Laplace's equation with the known pixels as its border, by relaxation from coarse to fine. It has hardly a gradient, and none
//! across its border, so that neither the mask's outline nor what was behind it is matched.

use plumbline_survey::io::picture::Picture;

/// Sweeps on each level. Chosen: on a coarser level the same wave is half as long, so few are left for the fine ones.
const SWEEPS: usize = 30;
/// Sides below which a level is not made coarser.
const COARSEST_PX: usize = 4;

/// `picture` with its unknown pixels, where `known` says false, filled in; as it is where nothing is known.
#[must_use]
pub fn filled(picture: &Picture, known: &[bool]) -> Picture {
    let values: Vec<f32> = picture.pixels.iter().map(|grey| f32::from(*grey)).collect();
    let filled = relaxed(&values, known, (picture.cols, picture.rows));
    Picture { pixels: filled.iter().map(|grey| grey.round().clamp(0.0, 255.0) as u8).collect(), ..*picture }
}

fn relaxed(values: &[f32], known: &[bool], (cols, rows): (usize, usize)) -> Vec<f32> {
    let mut filled = values.to_vec();
    if known.iter().all(|known| *known) || !known.contains(&true) {
        return filled;
    }
    if cols.min(rows) > COARSEST_PX {
        let (coarse_cols, coarse_rows) = (cols.div_ceil(2), rows.div_ceil(2));
        let (mut sums, mut counts) = (vec![0.0; coarse_cols * coarse_rows], vec![0.0f32; coarse_cols * coarse_rows]);
        for (index, value) in values.iter().enumerate().filter(|(index, _)| known[*index]) {
            let coarse = index / cols / 2 * coarse_cols + index % cols / 2;
            (sums[coarse], counts[coarse]) = (sums[coarse] + value, counts[coarse] + 1.0);
        }
        let coarse_known: Vec<bool> = counts.iter().map(|count| *count > 0.0).collect();
        let means: Vec<f32> = sums.iter().zip(&counts).map(|(sum, count)| sum / count.max(1.0)).collect();
        let coarse = relaxed(&means, &coarse_known, (coarse_cols, coarse_rows));
        for (index, value) in filled.iter_mut().enumerate().filter(|(index, _)| !known[*index]) {
            *value = coarse[index / cols / 2 * coarse_cols + index % cols / 2];
        }
    } else {
        let count = known.iter().filter(|known| **known).count() as f32;
        let mean = values.iter().zip(known).filter(|(_, known)| **known).map(|(value, _)| value).sum::<f32>() / count;
        filled.iter_mut().zip(known).filter(|(_, known)| !**known).for_each(|(value, _)| *value = mean);
    }
    let unknown: Vec<usize> = (0..known.len()).filter(|index| !known[*index]).collect();
    for _ in 0..SWEEPS {
        for &index in &unknown {
            let (col, row) = (index % cols, index / cols);
            // Beyond the picture it goes on as it is.
            let beside = [
                if col > 0 { index - 1 } else { index },
                if col + 1 < cols { index + 1 } else { index },
                if row > 0 { index - cols } else { index },
                if row + 1 < rows { index + cols } else { index },
            ];
            filled[index] = 0.25 * beside.iter().map(|at| filled[*at]).sum::<f32>();
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::filled;
    use plumbline_survey::io::picture::Picture;

    const SIDE: usize = 40;

    fn picture(of: impl Fn(usize, usize) -> u8) -> Picture {
        let pixels = (0..SIDE * SIDE).map(|index| of(index % SIDE, index / SIDE)).collect();
        Picture { cols: SIDE, rows: SIDE, pixels }
    }

    /// A plane solves Laplace's equation.
    #[test]
    fn a_hole_in_a_plane_is_the_plane() {
        let plane = picture(|col, row| (40 + 3 * col + 2 * row) as u8);
        let known: Vec<bool> = (0..SIDE * SIDE)
            .map(|index| !((10..30).contains(&(index % SIDE)) && (8..31).contains(&(index / SIDE))))
            .collect();
        let holed = Picture {
            pixels: plane.pixels.iter().zip(&known).map(|(grey, known)| if *known { *grey } else { 0 }).collect(),
            ..plane
        };
        let filled = filled(&holed, &known);
        let worst = filled.pixels.iter().zip(&plane.pixels).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(2), "{worst:?}");
    }

    #[test]
    fn what_is_known_stays_and_nothing_known_is_no_reason_to_fail() {
        let noise = picture(|col, row| (col * 37 + row * 91) as u8);
        let known: Vec<bool> = (0..SIDE * SIDE).map(|index| index % 3 != 0).collect();
        let filled_in = filled(&noise, &known);
        assert!(noise.pixels.iter().zip(&filled_in.pixels).zip(&known).all(|((a, b), known)| !known || a == b));
        assert_eq!(filled(&noise, &[false; SIDE * SIDE]), noise);
    }
}
