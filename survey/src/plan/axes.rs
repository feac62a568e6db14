//! The strips' own axes: along and across, on the ground.

/// Directions of a block of strips. Places are `[along, across]`, metres, without an offset: with heading 90 they are x and
/// y themselves. Across grows from strip to strip: to the left of the heading, towards growing y; strips that run due north
/// are laid towards growing x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// Clockwise from grid north, 0 to below 180.
    heading_deg: f64,
    /// East and north of a metre along.
    along: [f64; 2],
    /// East and north of a metre across.
    across: [f64; 2],
}

impl Axes {
    /// Axes of strips of this heading; opposite headings have the same strips.
    #[must_use]
    pub fn new(heading_deg: f64) -> Self {
        // Remainders of tiny negative angles round up to 180 itself.
        let turned = heading_deg.rem_euclid(180.0);
        let heading_deg = if turned < 180.0 { turned } else { 0.0 };
        let (along, across) = if heading_deg == 90.0 {
            ([1.0, 0.0], [0.0, 1.0])
        } else if heading_deg == 0.0 {
            ([0.0, 1.0], [1.0, 0.0])
        } else {
            let (sin, cos) = heading_deg.to_radians().sin_cos();
            ([sin, cos], [-cos, sin])
        };
        Axes { heading_deg, along, across }
    }

    /// Clockwise from grid north, 0 to below 180: the direction of along.
    #[must_use]
    pub fn heading_deg(&self) -> f64 {
        self.heading_deg
    }

    /// East and north of a metre along.
    #[must_use]
    pub fn along(&self) -> [f64; 2] {
        self.along
    }

    /// East and north of a metre across.
    #[must_use]
    pub fn across(&self) -> [f64; 2] {
        self.across
    }

    /// `[along, across]` of a point (x, y).
    #[must_use]
    pub fn of(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.along[0] * x + self.along[1] * y, self.across[0] * x + self.across[1] * y]
    }

    /// (x, y) of `[along, across]`.
    #[must_use]
    pub fn point(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        [self.along[0] * s + self.across[0] * t, self.along[1] * s + self.across[1] * t]
    }

    /// Whether along is the y axis; `None` where the strips run askew of both axes.
    pub(super) fn along_y(&self) -> Option<bool> {
        match self.heading_deg {
            90.0 => Some(false),
            0.0 => Some(true),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_headings_are_the_same_strips_and_points_come_back() {
        for heading in [0.0, 30.0, 90.0, 135.5, 179.999] {
            assert!((Axes::new(heading + 180.0).heading_deg() - heading).abs() < 1e-9);
            let axes = Axes::new(heading);
            let [x, y] = axes.point(axes.of([123.0, -45.0]));
            assert!((x - 123.0).abs() < 1e-9 && (y + 45.0).abs() < 1e-9);
            assert!(axes.across()[1] > 0.0 || heading == 0.0 && axes.across() == [1.0, 0.0]);
        }
        assert_eq!(Axes::new(270.0), Axes::new(90.0));
        assert_eq!(Axes::new(-1e-300).heading_deg(), 0.0);
        // North-east: a metre along is as much east as north.
        assert!((Axes::new(45.0).along()[0] - Axes::new(45.0).along()[1]).abs() < 1e-15);
    }
}
