//! The highest of a surface, and how it stands out.

use crate::matching::directions::half::{SHIFTS, Scores};

/// Shifts that lie on the highest one's main lobe, along either axis.
const LOBE: usize = 2;

/// The highest of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Top {
    pub row: usize,
    pub col: usize,
    pub score: f32,
}

impl Top {
    /// The highest of scores.
    pub fn of(scores: &Scores) -> Self {
        let mut top = Top { row: 0, col: 0, score: f32::MIN };
        for (row, line) in scores.iter().enumerate() {
            for (col, &score) in line.iter().enumerate() {
                if score > top.score {
                    top = Top { row, col, score };
                }
            }
        }
        top
    }

    /// Steps to another one, the larger of both axes.
    pub fn apart(&self, other: &Top) -> usize {
        self.row.abs_diff(other.row).max(self.col.abs_diff(other.col))
    }

    /// The highest of other scores within a step of where it is.
    pub fn around(&self, scores: &Scores) -> f32 {
        let near = |at: usize| at.saturating_sub(1)..(at + 2).min(SHIFTS);
        let lines = scores.get(near(self.row)).unwrap_or(&[]);
        let beside = lines.iter().flat_map(|line| line.get(near(self.col)).unwrap_or(&[]));
        beside.fold(f32::MIN, |highest, &score| highest.max(score))
    }

    /// The highest off the main lobe.
    pub fn second(&self, scores: &Scores) -> f32 {
        let others = scores
            .iter()
            .enumerate()
            .flat_map(|(row, line)| line.iter().enumerate().map(move |(col, &score)| Top { row, col, score }));
        others.filter(|other| self.apart(other) > LOBE).fold(f32::MIN, |second, other| second.max(other.score))
    }

    /// Four times the score less the four beside it; on the border, that of the one beside.
    pub fn curvature(&self, scores: &Scores) -> f32 {
        let (row, col) = (self.row.clamp(1, SHIFTS - 2), self.col.clamp(1, SHIFTS - 2));
        4.0 * scores[row][col]
            - scores[row - 1][col]
            - scores[row + 1][col]
            - scores[row][col - 1]
            - scores[row][col + 1]
    }
}
