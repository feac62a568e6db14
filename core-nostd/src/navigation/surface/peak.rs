//! The peak of a score surface, its second peak and its curvature.

use crate::matching::directions::half::{SHIFTS, Scores};

/// Shifts up to this distance from the peak, along either axis, lie on its main lobe.
const MAIN_LOBE: usize = 2;

/// The highest score and its cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peak {
    pub row: usize,
    pub col: usize,
    pub score: f32,
}

impl Peak {
    /// The peak of scores; the first of equal ones.
    pub fn of(scores: &Scores) -> Self {
        let mut peak = Peak { row: 0, col: 0, score: f32::MIN };
        for (row, line) in scores.iter().enumerate() {
            for (col, &score) in line.iter().enumerate() {
                if score > peak.score {
                    peak = Peak { row, col, score };
                }
            }
        }
        peak
    }

    /// Cells to another one, the larger of both axes.
    pub fn distance(&self, other: &Peak) -> usize {
        self.row.abs_diff(other.row).max(self.col.abs_diff(other.col))
    }

    /// Highest of other scores within one cell of its position.
    pub fn max_near(&self, scores: &Scores) -> f32 {
        let near = |at: usize| at.saturating_sub(1)..(at + 2).min(SHIFTS);
        let lines = scores.get(near(self.row)).unwrap_or(&[]);
        let beside = lines.iter().flat_map(|line| line.get(near(self.col)).unwrap_or(&[]));
        beside.fold(f32::MIN, |highest, &score| highest.max(score))
    }

    /// Highest score off the main lobe.
    pub fn second_peak(&self, scores: &Scores) -> f32 {
        let others = scores
            .iter()
            .enumerate()
            .flat_map(|(row, line)| line.iter().enumerate().map(move |(col, &score)| Peak { row, col, score }));
        others.filter(|other| self.distance(other) > MAIN_LOBE).fold(f32::MIN, |second, other| second.max(other.score))
    }

    /// Four times the score less its four neighbours; on the border, that of the nearest cell inside.
    pub fn curvature(&self, scores: &Scores) -> f32 {
        let (row, col) = (self.row.clamp(1, SHIFTS - 2), self.col.clamp(1, SHIFTS - 2));
        4.0 * scores[row][col]
            - scores[row - 1][col]
            - scores[row + 1][col]
            - scores[row][col - 1]
            - scores[row][col + 1]
    }
}
