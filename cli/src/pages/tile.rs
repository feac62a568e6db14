//! The reference tile under a map.

use plumbline_sim::setup::Setup;

/// The reference at a place, (east, north) of its centre in metres; none beyond it.
pub fn grey(setup: &Setup, (east, north): (f64, f64)) -> Option<u8> {
    let (flash, step_m) = (&setup.flash, setup.scenario.vehicle.resolution_m);
    let (cols, rows) = (f64::from(flash.head.size.0), f64::from(flash.head.size.1));
    let (col, row) = ((east / step_m + 0.5 * cols).floor(), (0.5 * rows - north / step_m).floor());
    let is_inside = (0.0..cols).contains(&col) && (0.0..rows).contains(&row);
    let index = row as usize * cols as usize + col as usize;
    flash.tile.get(index).copied().filter(|_| is_inside)
}
