//! Offsets as dots around a cross.

use maud::Markup;
use plotters::element::{Circle, PathElement};
use plotters::style::Color;
use plumbline_charts::plot::{Axes, INK, PlotError, RECTIFIED, REFUSED, plain, plot};

/// Room beside the farthest one, and the narrowest picture, metres.
const ROOM: f64 = 1.15;
const HALF_MIN_M: f64 = 1.0;

/// An offset to the right and up, metres, and whether it is as it should be.
pub type Offset = ([f64; 2], bool);

/// From the middle to each side of a picture that holds all of them.
pub fn reach_m<'o>(offsets: impl Iterator<Item = &'o Offset>) -> f64 {
    offsets.map(|([x, y], _)| x.abs().max(y.abs())).fold(HALF_MIN_M, f64::max) * ROOM
}

/// The offsets over axes that reach so far.
///
/// # Errors
/// [`PlotError`].
pub fn scatter(x_text: &str, y_text: &str, offsets: &[Offset], far_m: f64) -> Result<Markup, PlotError> {
    let axes = Axes {
        x: -far_m..far_m,
        y: -far_m..far_m,
        x_text,
        y_text,
        x_label: &|value| plain(*value),
        y_label: &|value| plain(*value),
    };
    let cross = [vec![(-far_m, 0.0), (far_m, 0.0)], vec![(0.0, -far_m), (0.0, far_m)]];
    plot(&format!("Offsets of the fixes, {x_text} and {y_text}"), &axes, |chart| {
        chart.draw_series(cross.map(|line| PathElement::new(line, INK.stroke_width(2))))?;
        chart.draw_series(offsets.iter().map(|([x, y], is_right)| {
            Circle::new((*x, *y), 8, if *is_right { RECTIFIED } else { REFUSED }.mix(0.6).filled())
        }))?;
        Ok(())
    })
}

/// East and north as to the right and forward of what heads so, clockwise from north.
pub fn along([east, north]: [f64; 2], heading_rad: f64) -> [f64; 2] {
    let (sin, cos) = heading_rad.sin_cos();
    [east * cos - north * sin, east * sin + north * cos]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_east_is_forward_of_who_heads_east() {
        let [right, forward] = along([2.0, 0.5], std::f64::consts::FRAC_PI_2);
        assert!((right + 0.5).abs() < 1e-12 && (forward - 2.0).abs() < 1e-12);
    }
}
