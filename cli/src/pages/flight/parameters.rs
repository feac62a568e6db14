//! The main settings of the flight.

use super::Report;
use maud::{Markup, html};
use plumbline_charts::format::short;
use plumbline_sim::scenario::{FollowUpMode, Ground, Light, Scenario};
use plumbline_survey::camera_file::CameraFile;

/// Name and value.
type Row = (&'static str, String);
/// A table of the scenario.
type Group = (&'static str, Vec<Row>);

impl Report<'_> {
    pub(super) fn parameters(&self) -> Markup {
        let scenario = &self.setup.scenario;
        let camera = &self.setup.payload.camera;
        let groups = [flight(self), reference(self), camera_rows(scenario, camera), link(scenario), sensors(scenario)];
        html! {
            section {
                h2 { "Scenario" }
                div class="columns" {
                    @for (name, rows) in groups {
                        table {
                            thead { tr { th colspan="2" { (name) } } }
                            tbody { @for (name, value) in rows { tr { th { (name) } td class="t" { (value) } } } }
                        }
                    }
                }
            }
        }
    }
}

fn flight(report: &Report<'_>) -> Group {
    let (scenario, plan) = (&report.setup.scenario, &report.setup.plan);
    let (run, flight) = (&scenario.run, &scenario.vehicle.flight);
    let [low_m, high_m] = run.flight.height_m;
    let mut rows = vec![
        ("Frames", run.frames.to_string()),
        ("Height above the base", format!("{} to {} m", short(low_m), short(high_m))),
        ("Speed, rms", format!("{} m/s", short(flight.speed_m_s))),
    ];
    if plan.is_none() {
        let every = ("Every", format!("{} ms", run.frame_interval_ms));
        rows.splice(1..1, [every, ("Jitter", format!("{} µs", run.frame_jitter_us))]);
    }
    match &run.replay {
        None => rows.extend([
            ("Pitch and roll", format!("uniform within ±{}°", short(flight.tilt_max_deg))),
            ("Heading off the course", format!("{}°, 1 σ", short(run.flight.heading_wander_deg))),
        ]),
        Some(replay) => rows.extend([
            ("Attitude log", replay.att.display().to_string()),
            (
                "Flown from",
                replay.start_s.map_or_else(|| "its first row".to_owned(), |start| format!("{} s", short(start))),
            ),
            ("Time scale", short(replay.time_scale)),
        ]),
    }
    match &scenario.world.ground {
        Ground::Procedural => {
            let ground = if plan.is_some() {
                "procedural, over the plan's elevation model"
            } else {
                "procedural, level but for houses"
            };
            rows.push(("Ground", ground.to_owned()));
        }
        Ground::Ortho { ortho, dem, reference } => {
            let path = |path: &std::path::PathBuf| path.display().to_string();
            rows.push(("Ground", path(ortho)));
            let level = if plan.is_some() { "the plan's elevation model" } else { "flat, height 0" };
            rows.push(("Elevation", dem.as_ref().map_or_else(|| level.to_owned(), path)));
            rows.push(("Reference from", reference.as_ref().map_or_else(|| "the same picture".to_owned(), path)));
        }
    }
    ("Flight", rows)
}

fn camera_rows(scenario: &Scenario, camera: &CameraFile) -> Group {
    let (follow_up, servo) = (&scenario.vehicle.follow_up, &scenario.world.follow_up);
    let mut rows = vec![
        ("Frame", format!("{} × {} px", camera.cols, camera.rows)),
        ("Field of view across × along", format!("{}° × {}°", short(camera.fov_h_deg), short(camera.fov_v_deg))),
        ("Principal point right, forward", format!("{}, {} px", short(camera.offset_m_px), short(camera.offset_n_px))),
        ("Exposure", exposure(scenario)),
        ("Noise", format!("{} DN, 1 σ", short(scenario.world.noise_dn))),
    ];
    rows.push(match camera.distortion {
        None => ("Distortion", "none".to_owned()),
        Some(d) => ("Distortion k1 k2 k3 p1 p2", [d.k1, d.k2, d.k3, d.p1, d.p2].map(short).join(" ")),
    });
    let mode = match follow_up.mode {
        FollowUpMode::Followed => "servo follows, angle computed (eq. 7)",
        FollowUpMode::Measured => "servo follows, encoder read (eq. 3)",
        FollowUpMode::Fixed => "none, fixed to the body (eq. 3)",
    };
    rows.extend([("Follow-up", mode.to_owned()), ("Servo lag", format!("{} s", short(servo.servo_lag_s)))]);
    if follow_up.mode == FollowUpMode::Measured {
        rows.push(("Encoder", noisy(follow_up.noise_deg, "°", servo.rate_hz, servo.latency_us)));
    }
    ("Camera", rows)
}

/// The exposure, and the light where it is not the nominal one.
fn exposure(scenario: &Scenario) -> String {
    let (vehicle, light) = (&scenario.vehicle, &scenario.world.light);
    let [least_us, longest_us] = vehicle.exposures_us();
    let exposure = match vehicle.auto_exposure.is_on {
        true => format!("{least_us} to {longest_us} µs, controlled"),
        false => format!("{} µs", vehicle.exposure_us),
    };
    if *light == Light::default() {
        return exposure;
    }
    let [from, to] = [light.from_stops, light.to_stops].map(|stops| light.stops + stops);
    let ramp = if from == to { format!("{from:+}") } else { format!("{from:+} to {to:+}") };
    format!("{exposure}; light {ramp} stops")
}

fn sensors(scenario: &Scenario) -> Group {
    let (vehicle, world) = (&scenario.vehicle, &scenario.world);
    let (attitude, range, position, shutter) = (&vehicle.attitude, &vehicle.range, &vehicle.position, &vehicle.shutter);
    let rows = vec![
        ("Pitch and roll", noisy(attitude.white_deg, "°", attitude.rate_hz, world.attitude.latency_us)),
        ("… drift", format!("{}°, 1 σ, {} s", short(attitude.drift_deg), short(world.attitude.drift_s))),
        ("Heading, white", format!("{}°, 1 σ", short(attitude.heading_white_deg.unwrap_or(attitude.white_deg)))),
        ("… drift", format!("{}°, 1 σ", short(attitude.heading_drift_deg.unwrap_or(attitude.drift_deg)))),
        ("Slant range", noisy(range.sigma_m, " m", range.rate_hz, world.range.latency_us)),
        ("… without echo", format!("{} %", short(scenario.faults.range.dropout_percent))),
        ("Position prior", noisy(vehicle.position_sigma_m(), " m", position.rate_hz, world.position.latency_us)),
        ("… time constant", format!("{} s", short(world.position.time_constant_s))),
        ("… velocity", format!("{} m/s, 1 σ", short(position.velocity_sigma_m_s))),
        ("Shutter's edges", format!("{:?}, {} µs, 1 σ", shutter.edges, shutter.edge_jitter_us)),
        ("Frame's arrival", format!("{} µs late, {} µs, 1 σ", shutter.arrival_latency_us, shutter.arrival_jitter_us)),
        ("Capture timer", format!("{} ppm, starts at {}", short(world.timer.drift_ppm), world.timer.start_ticks)),
        ("Pulse per second", if world.timer.pps { "wired" } else { "not wired" }.to_owned()),
    ];
    ("Sensors", rows)
}

/// One sigma, rate and latency.
fn noisy(sigma: f64, unit: &str, rate_hz: u32, latency_us: u32) -> String {
    format!("{}{unit}, 1 σ, {rate_hz} Hz, {} ms late", short(sigma), short(f64::from(latency_us) / 1000.0))
}

fn reference(report: &Report<'_>) -> Group {
    let (vehicle, head) = (&report.setup.scenario.vehicle, &report.setup.flash.head);
    let reference = &report.setup.radiometry;
    let rows = vec![
        ("Pixel", format!("{} m", short(vehicle.resolution_m))),
        ("Tile", format!("{} × {} px, EPSG:{}", head.size.0, head.size.1, head.georeference.epsg)),
        ("Search", format!("±{} px", vehicle.search_px)),
        (
            "Gamma, gain, offset",
            format!("{}, {}, {} DN", short(reference.gamma), short(reference.gain), short(reference.offset)),
        ),
        ("Noise", format!("{} DN, 1 σ", short(reference.noise_dn))),
        ("Changed since", format!("{} % of the area", short(100.0 * reference.changed_fraction))),
    ];
    ("Reference", rows)
}

fn link(scenario: &Scenario) -> Group {
    let faults = &scenario.faults.link_faults;
    let rows = vec![
        ("Bits flipped", format!("{} %", short(faults.bit_error_percent))),
        ("Messages cut", format!("{} %", short(faults.cut_percent))),
        ("Messages of unknown kinds", format!("{} %", short(faults.unknown_percent))),
    ];
    ("Link faults", rows)
}
