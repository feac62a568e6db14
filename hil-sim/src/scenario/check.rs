//! The door: what a scenario may say. Behind it nobody checks again.

use super::footprint::footprint_margin_m;
use super::{EdgeSource, FollowUpMode, Scenario, ScenarioError, Seconds};
use plumbline_core::budget::REACQUIRE_PX;
use plumbline_core::pose::noise::LAGS;
use plumbline_core::stamp::EXPOSURE_MAX_US;

/// Most frames of a flight: a day at 4 Hz is 345 600.
const FRAMES_MAX: u32 = 1_000_000;
/// Some air between a frame's first row and the next frame's opening.
const BETWEEN_FRAMES_US: u64 = 950;
/// Pixels are square where their sides differ by no more than this share, as in the core's `Camera::has_square_pixels`: what
/// the rounded fields of view of a data sheet allow.
const SQUARE_MAX: f64 = 1e-3;
/// Sigmas of jitter that every order of events is kept for.
const JITTER_SIGMAS: f64 = 6.0;

impl Scenario {
    /// Checks every value. Call it again after changing one, with the name of what changed it.
    ///
    /// # Errors
    /// [`ScenarioError`] names `file`, the key, its value and what it may be.
    pub fn check(&self, file: &str) -> Result<(), ScenarioError> {
        for (key, value, low, high) in self.ranges() {
            if !(low..=high).contains(&value) {
                return Err(ScenarioError(format!("{file}: {key} = {value} is not between {low} and {high}")));
            }
        }
        self.check_together().map_err(|what| ScenarioError(format!("{file}: {what}")))
    }

    /// Key, value, lowest, highest.
    fn ranges(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let (camera, flight, attitude, follow_up) = (&self.camera, &self.flight, &self.attitude, &self.follow_up);
        let (range, position, reference) = (&self.range, &self.position, &self.reference);
        let (shutter, timer, faults) = (&self.shutter, &self.timer, &self.link_faults);
        let mut ranges = vec![
            ("frames", self.frames.into(), 1.0, FRAMES_MAX.into()),
            ("resolution_m", self.resolution_m, 0.01, 1000.0),
            ("search_px", self.search_px.into(), 1.0, REACQUIRE_PX as f64),
            ("frame_interval_ms", self.frame_interval_ms.into(), 10.0, 3_600_000.0),
            ("frame_jitter_us", self.frame_jitter_us.into(), 0.0, 1e6),
            ("exposure_us", self.exposure_us.into(), 1.0, EXPOSURE_MAX_US.into()),
            ("exposure_samples", self.exposure_samples.into(), 1.0, 1000.0),
            ("rolling_shutter_ms", self.rolling_shutter_ms, 0.0, 1000.0),
            ("noise_dn", self.noise_dn, 0.0, 255.0),
            ("camera.cols", camera.cols.into(), 1.0, 8192.0),
            ("camera.rows", camera.rows.into(), 1.0, 8192.0),
            ("camera.fov_h_deg", camera.fov_h_deg, 0.1, 170.0),
            ("camera.fov_v_deg", camera.fov_v_deg, 0.1, 170.0),
            ("camera.offset_m_px", camera.offset_m_px, -8192.0, 8192.0),
            ("camera.offset_n_px", camera.offset_n_px, -8192.0, 8192.0),
            ("flight.height_m", flight.height_m[0], 0.1, 1e5),
            ("flight.height_m", flight.height_m[1], 0.1, 1e5),
            ("flight.tilt_max_deg", flight.tilt_max_deg, 0.0, 80.0),
            ("flight.tilt_hz", flight.tilt_hz[0], 1e-3, 10.0),
            ("flight.tilt_hz", flight.tilt_hz[1], 1e-3, 10.0),
            ("flight.speed_m_s", flight.speed_m_s, 0.0, 1000.0),
            ("flight.heading_wander_deg", flight.heading_wander_deg, 0.0, 180.0),
            ("attitude.rate_hz", attitude.rate_hz.into(), 1.0, 10_000.0),
            ("attitude.latency_us", attitude.latency_us.into(), 0.0, 1e7),
            ("attitude.delay_us", attitude.delay_us.into(), 0.0, 1e6),
            ("attitude.lag", attitude.lag.into(), 0.0, (LAGS - 1) as f64),
            ("attitude.white_deg", attitude.white_deg, 0.0, 90.0),
            ("attitude.drift_deg", attitude.drift_deg, 0.0, 90.0),
            ("attitude.drift_s", attitude.drift_s, 1e-3, 1e6),
            ("attitude.heading_white_deg", attitude.heading_white_deg.unwrap_or(0.0), 0.0, 90.0),
            ("attitude.heading_drift_deg", attitude.heading_drift_deg.unwrap_or(0.0), 0.0, 90.0),
            ("follow_up.servo_lag_s", follow_up.servo_lag_s, 0.0, 60.0),
            ("follow_up.noise_deg", follow_up.noise_deg, 0.0, 90.0),
            // Their messages stamp whole milliseconds.
            ("follow_up.rate_hz", follow_up.rate_hz.into(), 1.0, 1000.0),
            ("follow_up.latency_us", follow_up.latency_us.into(), 0.0, 1e7),
            ("follow_up.delay_us", follow_up.delay_us.into(), 0.0, 1e6),
            ("range.sigma_m", range.sigma_m, 0.0, 1000.0),
            ("range.rate_hz", range.rate_hz.into(), 1.0, 1000.0),
            ("range.latency_us", range.latency_us.into(), 0.0, 1e7),
            ("range.delay_us", range.delay_us.into(), 0.0, 1e6),
            ("range.dropout_percent", range.dropout_percent, 0.0, 100.0),
            ("position.sigma_m", position.sigma_m.unwrap_or(0.0), 0.0, 1e5),
            ("position.time_constant_s", position.time_constant_s, 1e-3, 1e6),
            ("position.white_m", position.white_m, 0.0, 1e5),
            ("position.velocity_sigma_m_s", position.velocity_sigma_m_s, 0.0, 1000.0),
            ("position.rate_hz", position.rate_hz.into(), 1.0, 1000.0),
            ("position.latency_us", position.latency_us.into(), 0.0, 1e7),
            ("position.delay_us", position.delay_us.into(), 0.0, 1e6),
            ("reference.gamma", reference.gamma.unwrap_or(1.0), 0.05, 20.0),
            ("reference.gain", reference.gain.unwrap_or(1.0), 0.01, 100.0),
            ("reference.offset_dn", reference.offset_dn.unwrap_or(0.0), -255.0, 255.0),
            ("reference.noise_dn", reference.noise_dn.unwrap_or(0.0), 0.0, 255.0),
            ("reference.changed_fraction", reference.changed_fraction.unwrap_or(0.0), 0.0, 1.0),
            ("shutter.edge_jitter_us", shutter.edge_jitter_us, 0.0, 1e4),
            ("shutter.open_delay_us", shutter.open_delay_us.into(), -1e5, 1e5),
            ("shutter.close_delay_us", shutter.close_delay_us.into(), -1e5, 1e5),
            ("shutter.exposure_jitter_us", shutter.exposure_jitter_us, 0.0, 1e4),
            ("shutter.arrival_latency_us", shutter.arrival_latency_us.into(), 1.0, 1e6),
            ("shutter.arrival_jitter_us", shutter.arrival_jitter_us, 0.0, 1e5),
            ("shutter.lost_edge_percent", shutter.lost_edge_percent, 0.0, 100.0),
            ("shutter.extra_edge_percent", shutter.extra_edge_percent, 0.0, 100.0),
            ("shutter.lost_frame_percent", shutter.lost_frame_percent, 0.0, 100.0),
            ("timer.drift_ppm", timer.drift_ppm, -500.0, 500.0),
            ("timer.rate_walk_ppm", timer.rate_walk_ppm, 0.0, 10.0),
            ("timer.pps_jitter_us", timer.pps_jitter_us, 0.0, 1e4),
            ("link_faults.bit_error_percent", faults.bit_error_percent, 0.0, 50.0),
            ("link_faults.cut_percent", faults.cut_percent, 0.0, 100.0),
            ("link_faults.unknown_percent", faults.unknown_percent, 0.0, 100.0),
        ];
        if let Some(d) = &camera.distortion {
            ranges.extend([
                ("camera.distortion.k1", d.k1, -10.0, 10.0),
                ("camera.distortion.k2", d.k2, -10.0, 10.0),
                ("camera.distortion.k3", d.k3, -10.0, 10.0),
                ("camera.distortion.p1", d.p1, -10.0, 10.0),
                ("camera.distortion.p2", d.p2, -10.0, 10.0),
            ]);
        }
        ranges.extend(self.plan.deviation_m.map(|m| ("plan.deviation_m", m, 0.0, 1000.0)));
        ranges.extend(self.intervals().flat_map(|(key, interval)| interval.map(|s| (key, s, 0.0, 1e9))));
        ranges.extend(self.mount.lever_arm_m.map(|m| ("mount.lever_arm_m", m, -100.0, 100.0)));
        ranges.extend(self.mount.boresight_deg.map(|deg| ("mount.boresight_deg", deg, -10.0, 10.0)));
        let truly = self.mount.true_boresight_deg.into_iter().flatten();
        ranges.extend(truly.map(|deg| ("mount.true_boresight_deg", deg, -10.0, 10.0)));
        if let Some(replay) = &self.replay {
            ranges.push(("replay.start_s", replay.start_s.unwrap_or(0.0), -1e9, 1e9));
            ranges.push(("replay.time_scale", replay.time_scale, 0.01, 100.0));
        }
        ranges
    }

    /// Every interval of trouble that is given, by its key.
    fn intervals(&self) -> impl Iterator<Item = (&'static str, Seconds)> + use<> {
        let attitude = &self.attitude_faults;
        let all = [
            ("timer.pps_lost_s", self.timer.pps_lost_s),
            ("attitude_faults.gap_s", attitude.gap_s),
            ("attitude_faults.stuck_s", attitude.stuck_s),
            ("attitude_faults.backwards_s", attitude.backwards_s),
            ("attitude_faults.nan_s", attitude.nan_s),
        ];
        all.into_iter().filter_map(|(key, interval)| Some((key, interval?)))
    }

    /// Eq. 7 holds for square pixels alone.
    fn check_square_pixels(&self) -> Result<(), String> {
        let (k_h, k_v) = self.camera.tangent_per_px();
        if self.follow_up.mode == FollowUpMode::Followed && (k_h / k_v - 1.0).abs() > SQUARE_MAX {
            return Err(format!(
                "follow_up.mode = \"followed\" needs a field of view in proportion to the pixels, but camera.fov_h_deg \
                 = {} over {} columns and camera.fov_v_deg = {} over {} rows are not: camera.fov_v_deg = {:.4} would be",
                self.camera.fov_h_deg,
                self.camera.cols,
                self.camera.fov_v_deg,
                self.camera.rows,
                2.0 * (k_h * 0.5 * f64::from(self.camera.rows)).atan().to_degrees()
            ));
        }
        Ok(())
    }

    /// What single values cannot say.
    fn check_together(&self) -> Result<(), String> {
        if let Some(head) = self.head.filter(|_| self.camera_file.is_none()) {
            return Err(format!("head = {head} is one of a camera_file, which is not given"));
        }
        let [low, high] = self.flight.height_m;
        if low > high {
            return Err(format!("flight.height_m = [{low}, {high}] has the higher value first"));
        }
        let [low, high] = self.flight.tilt_hz;
        if low > high {
            return Err(format!("flight.tilt_hz = [{low}, {high}] has the higher value first"));
        }
        let rolling_us = self.rolling_shutter_us();
        let shutter = &self.shutter;
        let most = |sigma_us: f64| (JITTER_SIGMAS * sigma_us).ceil();
        let arrives = f64::from(shutter.arrival_latency_us) + most(shutter.arrival_jitter_us);
        let exposed = f64::from(self.exposure_us) + most(shutter.exposure_jitter_us);
        if exposed + rolling_us as f64 + f64::from(self.frame_jitter_us) + arrives + BETWEEN_FRAMES_US as f64
            > self.frame_interval_us() as f64
        {
            let rolling = if rolling_us > 0 {
                format!(", rolling_shutter_ms = {}", self.rolling_shutter_ms)
            } else {
                String::new()
            };
            return Err(format!(
                "exposure_us = {}{rolling}, frame_jitter_us = {} and shutter.arrival_latency_us = {} with their jitter do not \
                 fit into frame_interval_ms = {}",
                self.exposure_us, self.frame_jitter_us, shutter.arrival_latency_us, self.frame_interval_ms
            ));
        }
        let edge_us = f64::from(shutter.close_delay_us) + most(shutter.edge_jitter_us);
        let first_us = f64::from(shutter.arrival_latency_us) - 4.0 * shutter.arrival_jitter_us;
        if shutter.edges == EdgeSource::Both && edge_us + 2.0 > first_us || first_us < 1.0 {
            return Err(format!(
                "shutter.arrival_latency_us = {} with its jitter is shorter than shutter.close_delay_us = {} with the \
                 edge's: a frame would arrive before its shutter closed",
                shutter.arrival_latency_us, shutter.close_delay_us
            ));
        }
        if let Some((key, [from_s, to_s])) = self.intervals().find(|(_, [from_s, to_s])| from_s > to_s) {
            return Err(format!("{key} = [{from_s}, {to_s}] has the later second first"));
        }
        self.check_square_pixels()?;
        if self.replay.is_none() && !footprint_margin_m(self).is_finite() {
            return Err(format!(
                "flight.tilt_max_deg = {} brings the horizon into the frame of camera.fov_h_deg = {} and \
                 camera.fov_v_deg = {}",
                self.flight.tilt_max_deg, self.camera.fov_h_deg, self.camera.fov_v_deg
            ));
        }
        Ok(())
    }
}

/// What the TOML reader found, as one sentence with the line it stands in.
pub(crate) fn sentence(file: &str, text: &str, error: &toml::de::Error) -> ScenarioError {
    let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
    let line = error.span().map(|span| line_of(text, span.start));
    ScenarioError(format!("{file}{}: {message}", line.unwrap_or_default()))
}

/// The line of a file's `text` in which byte `at` stands, to follow the file's name.
pub(crate) fn line_of(text: &str, at: usize) -> String {
    let number = text.get(..at).map_or(0, |before| before.matches('\n').count()) + 1;
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    format!(", line {number} (`{line}`)")
}
