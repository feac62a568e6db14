//! The fixes' offsets along the camera's axes and along the map's.

use super::Page;
use maud::{Markup, html};
use plotters::element::{Circle, PathElement};
use plotters::style::Color;
use plumbline_charts::plot::{Axes, INK, PlotError, RECTIFIED, REFUSED, plain, plot};

/// Room beside the farthest one, and the narrowest picture, metres.
const ROOM: f64 = 1.15;
const HALF_MIN_M: f64 = 1.0;

impl Page<'_> {
    pub(super) fn offsets(&self) -> Result<Markup, PlotError> {
        let of_map: Vec<([f64; 2], bool)> = self
            .verdict
            .fixes()
            .map(|(index, fix)| {
                let row = &self.table.rows[index];
                let zero_m = row.truth_m.unwrap_or(row.place_m);
                (std::array::from_fn(|axis| fix.place_m[axis] - zero_m[axis]), self.verdict.is_right(fix))
            })
            .collect();
        let headings = self.verdict.fixes().map(|(index, _)| self.table.rows[index].attitude_rad[0]);
        let of_camera: Vec<([f64; 2], bool)> = of_map
            .iter()
            .zip(headings)
            .map(|(([east, north], is_right), heading_rad)| {
                let (sin, cos) = heading_rad.sin_cos();
                ([east * cos - north * sin, east * sin + north * cos], *is_right)
            })
            .collect();
        let camera = scatter("to the camera’s right (m)", "forward (m)", &of_camera)?;
        let map = scatter("east (m)", "north (m)", &of_map)?;
        Ok(html! {
            figure { (camera) figcaption { b { "Along the camera’s axes. " } "Beside the middle: the camera sits otherwise than its file says." } }
            figure { (map) figcaption { b { "Along the map’s axes. " } "Beside the middle: map or positions are off as a whole." } }
        })
    }
}

fn scatter(x_text: &str, y_text: &str, offsets: &[([f64; 2], bool)]) -> Result<Markup, PlotError> {
    let far_m = offsets.iter().map(|([x, y], _)| x.abs().max(y.abs())).fold(HALF_MIN_M, f64::max) * ROOM;
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
