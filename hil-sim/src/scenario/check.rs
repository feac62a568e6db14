//! Validates a scenario; later code does not check again.

use super::bounds::within;
use super::footprint::footprint_margin_m;
use super::{
    AutoExposure, Camera, Changes, EdgeSource, FollowUpMode, Ground, Land, Payload, Run, Scenario, Vehicle, What,
};
use plumbline_core::camera::SQUARE_MAX;
use plumbline_survey::camera_file::{CameraFile, SIDE_MAX_PX, as_radians};
use plumbline_survey::error::InputError;

/// Least time between a frame's first row and the next frame's opening. Chosen: a millisecond, less the default arrival of
/// 50 µs.
const BETWEEN_FRAMES_US: u64 = 950;
/// Longest flight with `[navigation]`: its truth is kept, some 200 MB in that time.
const NAVIGATION_MAX_US: u64 = 2 * 3_600_000_000;
/// Slowest aeroplane, m/s, and how much faster than wind with its gusts it has to be to get anywhere. Chosen.
const SPEED_MIN_M_S: f64 = 8.0;
const OVER_WIND: f64 = 1.25;
/// Sigmas of jitter for which the order of events is guaranteed.
const JITTER_SIGMAS: f64 = 6.0;
/// Sigmas at which the simulator cuts the jitter of arrivals off: see [`Shutter`](super::vehicle::Shutter).
const ARRIVAL_SIGMAS: f64 = 4.0;

impl Vehicle {
    /// Checks every value.
    ///
    /// # Errors
    /// The message; the caller puts the file's name before it.
    pub fn check(&self) -> Result<(), String> {
        within(self.ranges())?;
        in_order("flight.tilt_hz", self.flight.tilt_hz)?;
        let AutoExposure { is_on, least_us, longest_us } = self.auto_exposure;
        if is_on && !(least_us..=longest_us).contains(&self.exposure_us) {
            return Err(format!(
                "exposure_us = {} is not between auto_exposure.least_us = {least_us} and auto_exposure.longest_us = \
                 {longest_us}, within which the exposure is controlled",
                self.exposure_us
            ));
        }
        let shutter = &self.shutter;
        let edge_us = f64::from(shutter.close_delay_us) + most(shutter.edge_jitter_us);
        let first_us = f64::from(shutter.arrival_latency_us) - ARRIVAL_SIGMAS * shutter.arrival_jitter_us;
        if shutter.edges == EdgeSource::Both && edge_us + 2.0 > first_us || first_us < 1.0 {
            return Err(format!(
                "shutter.arrival_latency_us = {} with its jitter is shorter than shutter.close_delay_us = {} with the \
                 edge's: a frame would arrive before its shutter closed",
                shutter.arrival_latency_us, shutter.close_delay_us
            ));
        }
        Ok(())
    }

    /// Checks that its firmware can take frames of `camera`: eq. 7 holds for square pixels alone.
    ///
    /// # Errors
    /// The message; the caller puts the file's name before it.
    pub fn check_camera(&self, camera: &CameraFile) -> Result<(), String> {
        let side = f64::from(SIDE_MAX_PX);
        within([
            ("camera.cols", camera.cols.into(), 1.0, side),
            ("camera.rows", camera.rows.into(), 1.0, side),
            ("camera.fov_h_deg", camera.fov_h_deg, 0.1, 170.0),
            ("camera.fov_v_deg", camera.fov_v_deg, 0.1, 170.0),
            ("camera.offset_m_px", camera.offset_m_px, -side, side),
            ("camera.offset_n_px", camera.offset_n_px, -side, side),
        ])?;
        if let Some([h, v]) = as_radians([camera.fov_h_deg, camera.fov_v_deg]) {
            return Err(format!(
                "camera.fov_h_deg = {} and camera.fov_v_deg = {} are degrees; as radians they are usual: write {h} and {v}",
                camera.fov_h_deg, camera.fov_v_deg
            ));
        }
        if let Some(d) = &camera.distortion {
            let keys = ["k1", "k2", "k3", "p1", "p2"].into_iter().zip([d.k1, d.k2, d.k3, d.p1, d.p2]);
            if let Some((key, value)) = keys.into_iter().find(|(_, k)| !(-10.0..=10.0).contains(k)) {
                return Err(format!("camera.distortion.{key} = {value} is not between -10 and 10"));
            }
        }
        let (k_h, k_v) = camera.tangent_per_px();
        if self.follow_up.mode == FollowUpMode::Followed && (k_h / k_v - 1.0).abs() > f64::from(SQUARE_MAX) {
            return Err(format!(
                "follow_up.mode = \"followed\" needs a field of view in proportion to the pixels, but camera.fov_h_deg \
                 = {} over {} columns and camera.fov_v_deg = {} over {} rows are not: camera.fov_v_deg = {:.4} would be",
                camera.fov_h_deg,
                camera.cols,
                camera.fov_v_deg,
                camera.rows,
                2.0 * (k_h * 0.5 * f64::from(camera.rows)).atan().to_degrees()
            ));
        }
        Ok(())
    }

    /// An exposure, its frame's way to the board and the next exposure follow each other.
    fn check_intervals(&self, run: &Run) -> Result<(), String> {
        let (shutter, rolling_us) = (&self.shutter, self.rolling_shutter_us());
        let arrives = f64::from(shutter.arrival_latency_us) + most(shutter.arrival_jitter_us);
        let [_, longest_us] = self.exposures_us();
        let exposed = f64::from(longest_us) + most(shutter.exposure_jitter_us);
        if exposed + rolling_us as f64 + f64::from(run.frame_jitter_us) + arrives + BETWEEN_FRAMES_US as f64
            <= run.frame_interval_us() as f64
        {
            return Ok(());
        }
        let rolling = match rolling_us {
            0 => String::new(),
            _ => format!(", rolling_shutter_ms = {}", self.rolling_shutter_ms),
        };
        let key = if self.auto_exposure.is_on { "auto_exposure.longest_us" } else { "exposure_us" };
        Err(format!(
            "{key} = {longest_us}{rolling}, frame_jitter_us = {} and shutter.arrival_latency_us = {} with their jitter do not \
             fit into frame_interval_ms = {}",
            run.frame_jitter_us, shutter.arrival_latency_us, run.frame_interval_ms
        ))
    }
}

impl Scenario {
    /// Checks every value that the scenario itself says.
    ///
    /// # Errors
    /// [`InputError`] names the file, the key, its value and what it may be.
    pub fn check(&self) -> Result<(), InputError> {
        let parts = || {
            self.vehicle.check()?;
            within(self.world.ranges())?;
            within(self.run.ranges())?;
            within(self.faults.ranges())?;
            in_order("flight.height_m", self.run.flight.height_m)?;
            self.vehicle.check_intervals(&self.run)?;
            if let Some((key, [from_s, to_s])) = self.faults.intervals().find(|(_, [from_s, to_s])| from_s > to_s) {
                return Err(format!("{key} = [{from_s}, {to_s}] has the later second first"));
            }
            self.check_faults()?;
            if self.world.follow_up.servo_commanded && self.vehicle.follow_up.mode == FollowUpMode::Fixed {
                return Err("follow_up.servo_commanded = true needs a servo, but follow_up.mode is \"fixed\"".into());
            }
            self.check_navigation()?;
            self.check_land()?;
            match (&self.camera, self.vehicle.head) {
                (Camera::Keys(_), Some(head)) => {
                    Err(format!("head = {head} is one of a camera_file, which is not given"))
                }
                (Camera::Keys(frame), None) => self.vehicle.check_camera(&frame.file()),
                (Camera::File(_), _) => Ok(()),
            }
        };
        parts().map_err(|what| InputError::new(format!("{}: {what}", self.file)))
    }

    /// Refuses a fault of what is not there.
    fn check_faults(&self) -> Result<(), String> {
        let timer = &self.world.timer;
        let measured = self.vehicle.follow_up.mode == FollowUpMode::Measured;
        for fault in self.faults.timed.all() {
            let missing = match fault.what {
                What::EncoderOff | What::EncoderStuck | What::EncoderBias if !measured => {
                    "an encoder: follow_up.mode = \"measured\""
                }
                What::ClockOffset | What::ClockAsymmetry | What::ClockJitter if !timer.timesync => {
                    "TIMESYNC: timer.timesync = true"
                }
                What::GnssOff | What::GnssJump | What::GnssDrag if self.world.navigation.is_none() => {
                    "[navigation]: elsewhere no satellite navigation is simulated"
                }
                What::ClockPhase if !timer.pps => "pulses: timer.pps = true",
                What::PowerOff if self.run.link.signing_key_path.is_some() => {
                    "a link without link.signing_key_path: the simulated board does not keep the time of signatures over a boot"
                }
                _ => continue,
            };
            return Err(format!("the fault {fault} needs {missing}"));
        }
        Ok(())
    }

    /// Refuses what makes no sense in a flight that is kept by its fixes.
    fn check_navigation(&self) -> Result<(), String> {
        let Some(navigation) = &self.world.navigation else { return Ok(()) };
        navigation.check()?;
        let (faults, flight) = (&self.faults.autopilot_faults, &self.vehicle.flight);
        if let Some(fault) = self.faults.timed.of(What::ClockReboot).next() {
            return Err(format!(
                "the fault {fault} makes no sense with [navigation]: a navigation does not survive a boot"
            ));
        }
        if faults.gnss_s.is_some() || faults.knows_no_place {
            return Err(
                "autopilot_faults.gnss_s and knows_no_place make no sense with [navigation]: navigation.gnss_lost_s says when it is lost"
                    .into(),
            );
        }
        if navigation.bank_max_deg > flight.tilt_max_deg {
            return Err(format!(
                "navigation.bank_max_deg = {} is more than flight.tilt_max_deg = {}, which frames are made for",
                navigation.bank_max_deg, flight.tilt_max_deg
            ));
        }
        let wind_m_s = navigation.wind_m_s + 3.0 * navigation.gust_m_s;
        if flight.speed_m_s < SPEED_MIN_M_S.max(OVER_WIND * wind_m_s) {
            return Err(format!(
                "flight.speed_m_s = {} is too slow for navigation.wind_m_s = {} with gusts of {}: at least {SPEED_MIN_M_S}, and \
                 {OVER_WIND} times the strongest wind",
                flight.speed_m_s, navigation.wind_m_s, navigation.gust_m_s
            ));
        }
        if self.run.duration_us() > NAVIGATION_MAX_US {
            return Err(format!(
                "frames = {} at frame_interval_ms = {} last longer than the {} hours that a flight with [navigation] may",
                self.run.frames,
                self.run.frame_interval_ms,
                NAVIGATION_MAX_US / 3_600_000_000
            ));
        }
        Ok(())
    }

    /// Refuses what only procedural ground can be where another one is flown over.
    fn check_land(&self) -> Result<(), String> {
        let world = &self.world;
        if world.land.parcel_m > 0.0 && world.land.stripe_m > 0.0 {
            return Err("land.parcel_m and land.stripe_m are both given, only one can be flown over".into());
        }
        let procedural = matches!(world.ground, Ground::Procedural);
        match self.of_procedural_ground() {
            Some(key) if !procedural => Err(format!("{key} is of procedural ground, but an orthophoto is flown over")),
            _ => Ok(()),
        }
    }

    /// The first part that is said of procedural ground and is not the default.
    #[must_use]
    pub fn of_procedural_ground(&self) -> Option<&'static str> {
        let world = &self.world;
        let said = [
            ("[land]", world.land != Land::default()),
            ("[changes]", world.changes != Changes::default()),
            ("reference.other_seed", world.reference.other_seed.is_some()),
        ];
        said.into_iter().find(|(_, is_said)| *is_said).map(|(key, _)| key)
    }

    /// Checks that a synthetic flight does not see the horizon.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn check_horizon(&self, payload: &Payload) -> Result<(), InputError> {
        if self.run.replay.is_some() || footprint_margin_m(self, payload).is_finite() {
            return Ok(());
        }
        let (tilt_deg, camera) = (self.vehicle.flight.tilt_max_deg, &payload.camera);
        Err(InputError::new(format!(
            "{}: flight.tilt_max_deg = {tilt_deg} brings the horizon into the frame of camera.fov_h_deg = {} and \
             camera.fov_v_deg = {}",
            self.file, camera.fov_h_deg, camera.fov_v_deg
        )))
    }
}

fn in_order(key: &str, [low, high]: [f64; 2]) -> Result<(), String> {
    if low > high { Err(format!("{key} = [{low}, {high}] has the higher value first")) } else { Ok(()) }
}

/// What white noise of `sigma_us` is at most.
fn most(sigma_us: f64) -> f64 {
    (JITTER_SIGMAS * sigma_us).ceil()
}
