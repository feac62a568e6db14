//! The lever arm as it really is, in f64 and apart from the core's.

use crate::flight::TrueState;
use crate::render::Station;
use crate::stage::Stage;

/// Where the antenna is, grid east, north and up, of a vehicle whose camera is in `state` and sits `lever_arm_m` (forward,
/// right, down) from the antenna.
#[must_use]
pub fn antenna(state: &TrueState, [forward_m, right_m, down_m]: [f64; 3]) -> [f64; 3] {
    let body = Station { follow_up_rad: 0.0, ..Stage::mount_station(state) }.axes();
    let camera = [state.east_m, state.north_m, state.up_m];
    std::array::from_fn(|i| camera[i] - forward_m * body.forward[i] - right_m * body.right[i] - down_m * body.down[i])
}
