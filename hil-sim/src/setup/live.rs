//! A live flight made ready: ground and reference around where the vehicle stands.

use super::{Setup, grid_of, grounds_of, of_ground};
use crate::scenario::{self, Scenario};
use crate::vehicle::motion::{Motion, TrueState};
use crate::vehicle::mount::payload_of;
use crate::world::{Bounds, procedural_around};
use plumbline_firmware::shared_memory::AREA_MAX;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;

/// Side of a reference tile unless it is given: 2800 pixels of 2 m, which is what a board holds.
const TILE_SIDE_M: f64 = 5600.0;

/// Where the vehicle stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Degrees.
    pub lat_deg: f64,
    /// Degrees.
    pub lon_deg: f64,
    /// Height of the ground, above mean sea level.
    pub home_alt_m: f64,
}

impl Start {
    /// The UTM zone's EPSG code. The exceptions in Norway and Svalbard are left aside: a neighbouring zone is no error there.
    fn utm(&self) -> u32 {
        let zone = ((self.lon_deg + 180.0) / 6.0).floor().rem_euclid(60.0) as u32 + 1;
        (if self.lat_deg < 0.0 { 32_700 } else { 32_600 }) + zone
    }
}

impl Setup {
    /// Prepares a live flight from `start`. Its motion is that of a vehicle that stands there: what is flown is recorded.
    ///
    /// # Errors
    /// One sentence for files that are missing or broken, a ground that the vehicle does not stand on, a place that has no UTM
    /// zone, a reference that does not fit on board.
    pub fn live(scenario: Scenario, start: &Start) -> Result<Self, InputError> {
        if scenario.world.navigation.is_some() || scenario.world.follow_up.servo_commanded {
            return Err(InputError::new(format!(
                "{}: [navigation] and follow_up.servo_commanded are of the simulated vehicle; a real autopilot has its own",
                scenario.file
            )));
        }
        if let Some(key) = scenario.of_procedural_ground() {
            return Err(InputError::new(format!(
                "{}: {key} is of the procedural ground of the simulated vehicle's flights",
                scenario.file
            )));
        }
        let payload = payload_of(&scenario)?;
        let on_grid = |crs: &Crs| crs.from_wgs84(start.lat_deg, start.lon_deg);
        let (ground, reference) = match &scenario.world.ground {
            scenario::Ground::Ortho { .. } => grounds_of(&scenario)?,
            scenario::Ground::Procedural => {
                let (east_m, north_m) = on_grid(&Crs::from_epsg(start.utm())?)?;
                let side_m = scenario.run.live.ground_side_m;
                (procedural_around(scenario.run.seed, start.utm(), [east_m, north_m], side_m), None)
            }
        };
        let crs = grid_of(&scenario, &ground)?;
        let (east_m, north_m) = on_grid(&crs)?;
        if !ground.bounds().contains(east_m, north_m) {
            let (lat, lon) = (start.lat_deg, start.lon_deg);
            let why = format!("the vehicle stands at latitude {lat:.6}, longitude {lon:.6}, which it does not show");
            return Err(of_ground(&scenario, &why));
        }
        let motion = Motion::recorded(vec![(0.0, TrueState { east_m, north_m, ..TrueState::default() })]);
        let wanted = wanted(&scenario, [east_m, north_m]);
        Setup::finish(scenario, payload, (ground, reference), crs, motion, &wanted, Vec::new())
    }
}

/// The square that the tile is to cover.
fn wanted(scenario: &Scenario, [east_m, north_m]: [f64; 2]) -> Bounds {
    let (live, resolution_m) = (&scenario.run.live, scenario.vehicle.resolution_m);
    let fits_m = (AREA_MAX as f64).sqrt().floor() * resolution_m;
    let half_m = 0.5 * live.tile_side_m.unwrap_or(TILE_SIDE_M.min(fits_m));
    let (east_m, north_m) = (east_m + live.tile_offset_m[0], north_m + live.tile_offset_m[1]);
    Bounds { west_m: east_m - half_m, east_m: east_m + half_m, south_m: north_m - half_m, north_m: north_m + half_m }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_lies_around_the_start_in_its_utm_zone() {
        let start = Start { lat_deg: -35.363_261, lon_deg: 149.165_23, home_alt_m: 584.0 };
        let mut scenario = Scenario::default();
        scenario.vehicle.resolution_m = 2.0;
        scenario.run.live.tile_side_m = Some(1200.0);
        scenario.run.live.tile_offset_m = [100.0, -50.0];
        let setup = Setup::live(scenario, &start).unwrap();
        assert_eq!(
            (setup.crs.system(), setup.flash.head.size),
            (plumbline_survey::crs::System::Epsg(32755), (600, 600))
        );
        let (east_m, north_m) = setup.crs.from_wgs84(start.lat_deg, start.lon_deg).unwrap();
        let off = [setup.tile_centre[0] - east_m - 100.0, setup.tile_centre[1] - north_m + 50.0];
        assert!(off[0].hypot(off[1]) < 2.0, "{off:?}");
        assert_eq!(setup.motion.state(5).east_m, east_m);
        assert!(setup.ground.bounds().contains(east_m + 3999.0, north_m - 3999.0));
        for (lat_deg, lon_deg, epsg) in [(48.0, 16.4, 32633), (-10.0, -179.9, 32701), (10.0, 179.9, 32660)] {
            assert_eq!(Start { lat_deg, lon_deg, home_alt_m: 0.0 }.utm(), epsg);
        }
    }
}
