//! A start without satellite navigation: where the vehicle stands, until the autopilot has a position of its own.

use crate::wire::command::{ACCEPTED, DENIED, TEMPORARILY_REJECTED};
use plumbline_core::pipeline::PositionSample;
use plumbline_core::tile::Geographic;

/// What the settings know of the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartSettings {
    /// Where.
    pub place: Geographic,
    /// One sigma of it along each axis, metres.
    pub sigma_m: f32,
    /// One sigma of the autopilot's heading until it has a position, radians.
    pub heading_sigma_rad: f32,
    /// Height above sea level, millimetres.
    pub altitude_mm: i32,
    /// Whether the autopilot is given the place as the origin of its frame where it has none.
    pub sets_origin: bool,
}

/// Beats of ten a second without an origin after which one is set, and set again.
const ORIGIN_BEATS: u16 = 100;
/// How fast an armed vehicle may leave the place, m/s: what ArduPlane cruises at unless set (AIRSPEED_CRUISE). Nothing tells its
/// velocity yet.
const SPEED_M_PER_S: f32 = 12.0;
/// Roundings of one place differ by so much, 1e-7 degrees: a decimetre.
const NEAR_E7: u32 = 10;
/// Seconds from one beat to the next.
const BEAT_S: f32 = 0.1;

/// A place, and what it is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Where.
    pub place: Geographic,
    /// One sigma of each axis, metres.
    pub sigma_m: f32,
    /// One sigma of the velocity, each axis, m/s: on the ground it stands.
    pub velocity_m_per_s: f32,
    /// One sigma of the heading, radians.
    pub heading_rad: f32,
}

/// What is known of the start.
#[derive(Debug)]
pub struct Start {
    settings: Option<StartSettings>,
    /// By the settings, or by a ground station.
    place: Option<(Geographic, f32)>,
    /// Whether the autopilot has had a position of its own.
    has_own: bool,
    /// Beats since the vehicle was armed, and those without an origin.
    flown: u16,
    waited: u16,
}

impl Start {
    /// As the settings know it.
    pub fn new(settings: Option<StartSettings>) -> Self {
        let place = settings.map(|start| (start.place, start.sigma_m));
        Start { settings, place, has_own: false, flown: 0, waited: 0 }
    }

    /// The autopilot reports a position. One that is the start's, at rest, is the origin that it was given and no more: ArduPilot
    /// sends that for ever while its filter has no position.
    pub fn reported(&mut self, sample: &PositionSample) {
        let is_at_rest = (sample.north_m_per_s, sample.east_m_per_s) == (0.0, 0.0);
        let is_near = |place: Geographic| {
            let (lat, lon) = (sample.position.lat_e7, sample.position.lon_e7);
            lat.abs_diff(place.lat_e7) <= NEAR_E7 && lon.abs_diff(place.lon_e7) <= NEAR_E7
        };
        self.has_own |= !(is_at_rest && self.place.is_some_and(|(place, _)| is_near(place)));
    }

    /// It has rebooted, and knows nothing any more.
    pub fn forget(&mut self) {
        (self.has_own, self.flown, self.waited) = (false, 0, 0);
    }

    /// A ground station says where the vehicle is now; the result that it is answered.
    pub fn ordered(&mut self, place: Option<(Geographic, f32)>) -> u8 {
        if self.has_own {
            return TEMPORARILY_REJECTED;
        }
        if place.is_none() {
            return DENIED;
        }
        (self.place, self.flown) = (place, 0);
        ACCEPTED
    }

    /// To be called on each beat: where the vehicle is, as long as nobody else knows.
    pub fn next(&mut self, is_armed: bool) -> Option<Place> {
        let (place, sigma_m) = self.place.filter(|_| !self.has_own)?;
        self.flown = if is_armed { self.flown.saturating_add(1) } else { 0 };
        let gone_m = SPEED_M_PER_S * BEAT_S * f32::from(self.flown);
        let heading_rad = self.settings.map_or(0.0, |start| start.heading_sigma_rad);
        let velocity_m_per_s = if is_armed { SPEED_M_PER_S } else { 0.0 };
        Some(Place { place, sigma_m: plumbline_core::math::hypot(sigma_m, gone_m), velocity_m_per_s, heading_rad })
    }

    /// Whether the vehicle is where the start is, as far as anybody knows.
    pub fn is_needed(&self) -> bool {
        self.place.is_some() && !self.has_own
    }

    /// To be called on each beat: the origin that the autopilot is given, with its height in millimetres. `lacks`: it is there,
    /// the clock is tied, and it has neither an origin nor satellite navigation that would give it one.
    pub fn origin(&mut self, lacks: bool) -> Option<(Geographic, i32)> {
        let settings = self.settings.filter(|start| start.sets_origin && lacks);
        self.waited = if settings.is_some() { self.waited.saturating_add(1) } else { 0 };
        if self.waited < ORIGIN_BEATS {
            return None;
        }
        self.waited = 0;
        self.place.zip(settings).map(|((place, _), start)| (place, start.altitude_mm))
    }
}

#[cfg(test)]
mod tests {
    use super::{Start, StartSettings};
    use crate::wire::command::{ACCEPTED, DENIED, TEMPORARILY_REJECTED};
    use plumbline_core::pipeline::PositionSample;
    use plumbline_core::tile::Geographic;

    const PLACE: Geographic = Geographic { lat_e7: 480_000_000, lon_e7: 160_000_000 };
    const SETTINGS: StartSettings =
        StartSettings { place: PLACE, sigma_m: 9.0, heading_sigma_rad: 0.1, altitude_mm: 200_000, sets_origin: true };

    fn at(position: Geographic, north_m_per_s: f32) -> PositionSample {
        PositionSample { north_m_per_s, ..PositionSample::standing(position) }
    }

    #[test]
    fn the_vehicle_is_where_it_stands_until_the_autopilot_knows_better() {
        let mut start = Start::new(Some(SETTINGS));
        let standing = (0..50).filter_map(|_| start.next(false)).last().unwrap();
        assert_eq!((standing.place, standing.sigma_m, standing.heading_rad), (PLACE, 9.0, 0.1));
        // A second in the air: 12 m.
        let flying = (0..10).filter_map(|_| start.next(true)).last().unwrap();
        assert!((flying.sigma_m - 15.0).abs() < 1e-4, "{flying:?}");
        assert_eq!([standing.velocity_m_per_s, flying.velocity_m_per_s], [0.0, 12.0]);
        // The origin that the autopilot was given, at rest, is no position.
        start.reported(&at(PLACE, 0.0));
        assert!(start.next(true).is_some());
        start.reported(&at(PLACE, 0.1));
        assert_eq!((start.next(true), start.is_needed()), (None, false));
        start.forget();
        assert!(start.next(true).is_some() && start.is_needed());
        assert!(Start::new(None).next(true).is_none());
    }

    #[test]
    fn a_ground_station_may_say_where() {
        let mut start = Start::new(None);
        assert_eq!((start.ordered(None), start.next(false)), (DENIED, None));
        assert_eq!(start.ordered(Some((PLACE, 20.0))), ACCEPTED);
        assert_eq!(start.next(false).map(|place| (place.place, place.sigma_m)), Some((PLACE, 20.0)));
        start.reported(&at(Geographic { lat_e7: PLACE.lat_e7 + 100, ..PLACE }, 0.0));
        assert_eq!(start.ordered(Some((PLACE, 20.0))), TEMPORARILY_REJECTED);
    }

    #[test]
    fn an_origin_is_set_after_ten_seconds_without_one_and_where_that_is_wanted() {
        let mut start = Start::new(Some(SETTINGS));
        let given = |start: &mut Start, beats: u32, lacks| (0..beats).filter_map(|_| start.origin(lacks)).count();
        assert_eq!((given(&mut start, 99, true), given(&mut start, 1, true)), (0, 1));
        assert_eq!((given(&mut start, 99, true), given(&mut start, 1, false), given(&mut start, 99, true)), (0, 0, 0));
        assert_eq!(start.origin(true), Some((PLACE, 200_000)));
        let mut start = Start::new(Some(StartSettings { sets_origin: false, ..SETTINGS }));
        assert_eq!(given(&mut start, 1_000, true), 0);
    }
}
