//! The fixes' offsets along the camera's axes and along the map's.

use super::Page;
use crate::pages::scatter::{Offset, along, reach_m, scatter};
use maud::{Markup, html};
use plumbline_charts::plot::PlotError;

impl Page<'_> {
    pub(super) fn offsets(&self) -> Result<Markup, PlotError> {
        let of_map: Vec<Offset> = self
            .verdict
            .fixes()
            .map(|(index, fix)| {
                let row = &self.table.rows[index];
                let zero_m = row.truth_m.unwrap_or(row.place_m);
                (std::array::from_fn(|axis| fix.place_m[axis] - zero_m[axis]), self.verdict.is_right(fix))
            })
            .collect();
        let headings = self.verdict.fixes().map(|(index, _)| self.table.rows[index].attitude_rad[0]);
        let of_camera: Vec<Offset> = of_map
            .iter()
            .zip(headings)
            .map(|((offset, is_right), heading_rad)| (along(*offset, heading_rad), *is_right))
            .collect();
        let [of_camera_m, of_map_m] = [reach_m(of_camera.iter()), reach_m(of_map.iter())];
        let camera = scatter("to the camera’s right (m)", "forward (m)", &of_camera, of_camera_m)?;
        let map = scatter("east (m)", "north (m)", &of_map, of_map_m)?;
        Ok(html! {
            figure { (camera) figcaption { b { "Along the camera’s axes. " } "Beside the middle: the camera sits otherwise than its file says." } }
            figure { (map) figcaption { b { "Along the map’s axes. " } "Beside the middle: map or positions are off as a whole." } }
        })
    }
}
