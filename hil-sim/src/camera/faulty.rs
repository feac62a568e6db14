//! What a scenario's timed faults make of the frames of a camera.

use crate::noise::pixels::to_grey;
use crate::noise::{stream, uniform};
use crate::scenario::{FaultList, What};

/// Radius of a blob on the lens: least and largest share of the frame's width.
const BLOB_RADIUS: [f64; 2] = [0.01, 0.04];
/// Share of the light that a blob lets through at its middle.
const BLOB_LIGHT: f64 = 0.2;

/// Passes the frames of one flight. Dirt and dead rows are drawn from the seed, and are the same in every frame.
#[derive(Debug)]
pub struct FaultyCamera {
    faults: FaultList,
    seed: u64,
    cols: usize,
    rows: usize,
    last: Option<Vec<u8>>,
}

impl FaultyCamera {
    /// Before the first frame of (cols, rows).
    #[must_use]
    pub fn new(faults: FaultList, seed: u64, (cols, rows): (usize, usize)) -> Self {
        FaultyCamera { faults, seed, cols, rows, last: None }
    }

    /// Frame `frame`, exposed at `at_us`, as the board gets it.
    #[must_use]
    pub fn pass(&mut self, frame: u32, at_us: u64, pixels: Vec<u8>) -> Vec<u8> {
        // Nothing is remembered where nothing can be repeated.
        if self.faults.of(What::CameraRepeated).next().is_none() {
            return self.spoilt(frame, at_us, pixels);
        }
        let pixels = match self.last.take() {
            Some(last) if self.faults.is(What::CameraRepeated, at_us) => last,
            _ => self.spoilt(frame, at_us, pixels),
        };
        self.last = Some(pixels.clone());
        pixels
    }

    fn spoilt(&self, frame: u32, at_us: u64, mut pixels: Vec<u8>) -> Vec<u8> {
        let faults = &self.faults;
        let gain = if frame % 2 == 1 { faults.product(What::CameraGainSteps, at_us) } else { 1.0 };
        let light = gain * faults.product(What::CameraDark, at_us);
        if light != 1.0 {
            pixels.iter_mut().for_each(|grey| *grey = to_grey(f64::from(*grey) * light));
        }
        for fault in faults.at(What::CameraDirty, at_us) {
            self.soil(fault.value as u32, &mut pixels);
        }
        for fault in faults.at(What::CameraDeadRows, at_us) {
            let mut rng = stream(self.seed, "fault.camera.dead_rows");
            for row in pixels.chunks_mut(self.cols.max(1)) {
                if uniform(&mut rng) * 100.0 < fault.value {
                    row.fill(0);
                }
            }
        }
        pixels
    }

    /// Round blobs, darkest at their middles.
    fn soil(&self, blobs: u32, pixels: &mut [u8]) {
        let mut rng = stream(self.seed, "fault.camera.dirty");
        let (cols, rows) = (self.cols as f64, self.rows as f64);
        for _ in 0..blobs {
            let [col, row, size] = [(); 3].map(|()| uniform(&mut rng));
            let (col, row) = (col * cols, row * rows);
            let radius = cols * (BLOB_RADIUS[0] + size * (BLOB_RADIUS[1] - BLOB_RADIUS[0]));
            let [top, bottom] = [row - radius, row + radius].map(|row| row.clamp(0.0, rows) as usize);
            for at_row in top..bottom {
                let line = pixels.iter_mut().skip(at_row * self.cols).take(self.cols);
                for (at_col, grey) in line.enumerate() {
                    let off = (at_col as f64 - col).hypot(at_row as f64 - row) / radius;
                    if off < 1.0 {
                        *grey = to_grey(f64::from(*grey) * (BLOB_LIGHT + (1.0 - BLOB_LIGHT) * off * off));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 100;

    fn frame(index: u32) -> Vec<u8> {
        (0..SIDE * SIDE).map(|pixel| 100 + ((pixel as u32 * 7 + index) % 50) as u8).collect()
    }

    /// Ten frames, one a second, of which those of the seconds 3 to 5 are faulty; all others are checked to be good.
    fn flown(word: &str) -> Vec<Vec<u8>> {
        let faults = [format!("{word}@3..6").parse().expect(word)].into_iter().collect();
        let mut camera = FaultyCamera::new(faults, 1, (SIDE, SIDE));
        let frames: Vec<_> =
            (0..10).map(|index| camera.pass(index, u64::from(index) * 1_000_000, frame(index))).collect();
        for index in (0..3).chain(6..10) {
            assert_eq!(frames[index as usize], frame(index), "{word}, frame {index}");
        }
        frames[3..6].to_vec()
    }

    #[test]
    fn frames_repeat_the_one_before() {
        assert_eq!(flown("camera.repeated"), vec![frame(2); 3]);
    }

    #[test]
    fn light_and_gain_are_factors() {
        let times = |factor: f64, index: u32| -> Vec<u8> {
            frame(index).iter().map(|grey| to_grey(f64::from(*grey) * factor)).collect()
        };
        assert_eq!(flown("camera.dark=0.1"), [3, 4, 5].map(|index| times(0.1, index)));
        assert_eq!(flown("camera.gain_steps=1.5"), [times(1.5, 3), frame(4), times(1.5, 5)]);
    }

    #[test]
    fn dirt_stays_where_it_is() {
        let frames = flown("camera.dirty=5");
        let spoilt = |at: usize| -> Vec<bool> {
            frames[at].iter().zip(frame(at as u32 + 3)).map(|(bad, good)| *bad < good).collect()
        };
        let dirt = spoilt(0);
        assert!(spoilt(1) == dirt && spoilt(2) == dirt);
        // Five discs of radius 1 to 4 pixels, which may overlap or lie on the border.
        let count = dirt.iter().filter(|dirty| **dirty).count();
        assert!((5..5 * 51).contains(&count), "{count}");
        assert!(frames[0].iter().zip(frame(3)).all(|(bad, good)| *bad <= good));
    }

    #[test]
    fn dead_rows_are_black_and_the_same_ones() {
        let frames = flown("camera.dead_rows=20");
        let dead = |frame: &Vec<u8>| -> Vec<bool> {
            frame.chunks(SIDE).map(|row| row.iter().all(|grey| *grey == 0)).collect()
        };
        let rows = dead(&frames[0]);
        assert!(dead(&frames[1]) == rows && dead(&frames[2]) == rows);
        let count = rows.iter().filter(|dead| **dead).count();
        // 20 of 100, give or take four of their deviations.
        assert!((4..36).contains(&count), "{count}");
        let whole = frames[0].chunks(SIDE).zip(frame(3).chunks(SIDE).map(<[u8]>::to_vec).collect::<Vec<_>>());
        assert!(whole.zip(&rows).all(|((bad, good), dead)| *dead || bad == good));
        assert!(flown("camera.dead_rows=100").iter().flatten().all(|grey| *grey == 0));
    }
}
