//! The firmware as a companion: it checks the autopilot's parameters, has it use fixes where satellite navigation is lost, tells
//! of fixes that do not come, and starts where nobody knows a position.

mod orders;

use mavlink::MessageData;
use mavlink::dialects::common::ODOMETRY_DATA;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{Flight, Keep, fly};
use plumbline_sim::scenario::{Camera, Scenario, Start, SwitchSource};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::setup::Setup;

/// The default scene with a small camera; four frames a second from the third second on.
fn scenario(frames: u32) -> Scenario {
    let mut scenario = Scenario::seeded(1, frames);
    scenario.camera = Camera::of_size(128, 128);
    scenario
}

fn flown(scenario: Scenario) -> Flight {
    scenario.check().expect("a scenario");
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    fly(&setup, &mut link, Keep::default(), &mut Unrectified::default()).expect("it flies")
}

trait Told {
    /// How often the pilot was told this.
    fn count(&self, line: &str) -> usize;
}

impl Told for Flight {
    fn count(&self, line: &str) -> usize {
        self.lines.iter().filter(|told| told.starts_with(line)).count()
    }
}

#[test]
fn an_autopilot_that_is_set_right_is_ready_and_one_that_is_not_is_told_what_to_set() {
    let right = flown(scenario(12));
    assert_eq!(right.count("ready for fixes"), 1, "{:?}", right.lines);
    assert!(
        !right.lines.iter().any(|line| line.contains("set it to") || line.contains("unknown")),
        "{:?}",
        right.lines
    );
    let mut wrong = scenario(48);
    let parameters = &mut wrong.faults.autopilot_faults.parameters;
    (parameters.ek3_src2_posxy, parameters.viso_delay_ms) = (Some(3.0), Some(f32::NAN));
    let wrong = flown(wrong);
    assert_eq!(wrong.count("ready for fixes"), 0, "{:?}", wrong.lines);
    // At once, and ten seconds later.
    assert_eq!(wrong.count("EK3_SRC2_POSXY is 3, set it to 6"), 2, "{:?}", wrong.lines);
    assert!(wrong.count("VISO_DELAY_MS is unknown to the autopilot") >= 1, "{:?}", wrong.lines);
    assert!(wrong.count("no fixes: the autopilot's parameters are wrong") >= 1, "{:?}", wrong.lines);
    // Fixes are sent all the same: whether they are used is for the autopilot to say.
    assert!(wrong.messages.contains_key(&ODOMETRY_DATA::ID));
}

#[test]
fn advice_does_not_keep_a_vehicle_from_being_ready() {
    let mut advised = scenario(12);
    advised.faults.autopilot_faults.parameters.viso_pos_m_nse = Some(1.5);
    let advised = flown(advised);
    assert_eq!(advised.count("ready for fixes"), 1, "{:?}", advised.lines);
    assert_eq!(advised.count("VISO_POS_M_NSE is 1.5, set it to 0.2"), 1, "{:?}", advised.lines);
}

#[test]
fn fixes_are_used_while_satellite_navigation_is_lost() {
    // Lost until the seventh second, there from then on; fixes come from the third on.
    let mut switching = scenario(64);
    switching.vehicle.link.switch_source = SwitchSource::OnGnssLoss;
    switching.faults.autopilot_faults.gnss_s = Some([7.0, 1e3]);
    let switched = flown(switching.clone());
    let [fixes, gnss] = ["source set 2 of the EKF is in use", "source set 1 of the EKF is in use"];
    assert_eq!((switched.count(fixes), switched.count(gnss), switched.source_set), (1, 1, 1), "{:?}", switched.lines);
    // Not back before it has been there for ten seconds.
    let mut short = switching.clone();
    short.run.frames = 48;
    let short = flown(short);
    assert_eq!((short.count(fixes), short.count(gnss), short.source_set), (1, 0, 2), "{:?}", short.lines);
    let mut denied = switching.clone();
    denied.run.frames = 24;
    denied.faults.autopilot_faults.denies_source_set = true;
    let denied = flown(denied);
    assert_eq!(denied.count("source set 2 is denied by the autopilot"), 1, "{:?}", denied.lines);
    assert_eq!((denied.count(fixes), denied.source_set), (0, 1));
    // Nobody touches the sources unless that is set.
    let mut never = switching;
    (never.vehicle.link.switch_source, never.run.frames) = (SwitchSource::Never, 24);
    let never = flown(never);
    assert_eq!((never.count("source set"), never.source_set), (0, 1), "{:?}", never.lines);
}

#[test]
fn a_parameter_that_would_do_harm_keeps_the_sources_where_they_are() {
    let mut scenario = scenario(24);
    scenario.vehicle.link.switch_source = SwitchSource::OnGnssLoss;
    // It would take its own height for a measurement.
    scenario.faults.autopilot_faults.parameters.ek3_src2_posz = Some(6.0);
    let flight = flown(scenario);
    assert_eq!((flight.count("source set"), flight.source_set), (0, 1), "{:?}", flight.lines);
}

#[test]
fn lost_fixes_are_told_with_their_reason_and_that_they_come_again() {
    // A range finder that measures nothing is lived with; an attitude that does not come is not.
    let mut scenario = scenario(60);
    scenario.faults.range.zero_s = Some([4.0, 15.5]);
    scenario.faults.attitude_faults.gap_s = Some([4.0, 15.5]);
    let flight = flown(scenario);
    assert_eq!(flight.count("no fixes for 10 s: no_attitude"), 1, "{:?}", flight.lines);
    assert_eq!(flight.count("fixes again"), 1, "{:?}", flight.lines);
    assert!(flight.health.invalid > 0);
}

/// The place where the vehicle is at `at_s`, moved to the east, as the settings have it.
fn start(scenario: &Scenario, at_s: f64, east_m: f64, sigma_m: f64) -> Start {
    let setup = Setup::prepare(scenario.clone()).expect("it can be flown");
    let state = setup.motion.state((1e6 * at_s) as u64);
    let (lat_deg, lon_deg) = setup.crs.to_wgs84(state.east_m + east_m, state.north_m).expect("inside");
    Start { lat_deg, lon_deg, sigma_m, heading_sigma_deg: 0.0, altitude_m: 300.0, set_origin: true }
}

#[test]
fn a_vehicle_that_knows_no_place_starts_from_the_one_that_is_set() {
    // From the tenth second on the autopilot has an origin, with the first fix a position.
    let mut lost = scenario(56);
    lost.faults.autopilot_faults.knows_no_place = true;
    let without = flown(lost.clone());
    let accepted = |flight: &Flight| {
        let is_accepted = |frame: &&_| {
            let frame: &&plumbline_sim::run::FrameRecord = frame;
            frame.report.is_some_and(|r| r.refusal == 0)
        };
        flight.frames.iter().filter(is_accepted).count()
    };
    assert_eq!((accepted(&without), without.messages.get(&ODOMETRY_DATA::ID)), (0, None));
    assert!(without.count("no fixes: no position on the map") > 0, "{:?}", without.lines);
    lost.vehicle.link.start = Some(start(&lost, 10.5, 60.0, 100.0));
    let flight = flown(lost);
    assert!(accepted(&flight) > 20, "{}: {:?}", accepted(&flight), flight.lines);
    assert!(flight.messages.get(&ODOMETRY_DATA::ID).is_some_and(|count| *count > 4), "{:?}", flight.messages);
    assert_eq!(flight.count("ready for fixes"), 1, "{:?}", flight.lines);
    // Beyond the ordinary search at first, within it once the autopilot has its position.
    let radii: Vec<u8> =
        flight.frames.iter().filter_map(|frame| Some(frame.report?.search_px)).filter(|px| *px > 0).collect();
    assert_eq!((radii.first(), radii.last()), (Some(&64), Some(&10)), "{radii:?}");
}
