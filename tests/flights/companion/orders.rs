//! Orders of a ground station to the firmware.

use mavlink::dialects::common::{COMMAND_ACK_DATA, COMMAND_INT_DATA, GPS_RAW_INT_DATA, TIMESYNC_DATA};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData, calculate_crc};
use plumbline_firmware::wire::command::{
    ACCEPTED, Acknowledgement, Command, DENIED, EXTERNAL_POSITION_ESTIMATE, SET_EKF_SOURCE_SET, TEMPORARILY_REJECTED,
};
use plumbline_sim::ground_station::GroundStation;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Event, Link};
use plumbline_sim::scenario::{Scenario, SwitchSource};
use plumbline_sim::setup::Setup;
use plumbline_sim::vehicle::autopilot::Autopilot;

/// Us, the autopilot and the ground station.
const US: (u8, u8) = (1, 154);
const STATION: (u8, u8) = (255, 190);
const BEAT_TICKS: u32 = 100_000;

/// A message of `from`.
fn message(from: (u8, u8), data: &impl MessageData) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(MavHeader { system_id: from.0.into(), component_id: from.1, sequence: 0 }, data);
    raw.raw_bytes().to_vec()
}

/// An order to take a set of sources.
fn source_set(from: (u8, u8), set: f32, target: (u8, u8)) -> Vec<u8> {
    message(from, &Command { command: SET_EKF_SOURCE_SET, parameters: [set, 0.0], target })
}

/// COMMAND_INT by its bytes: four parameters, latitude, longitude, altitude, command, target, frame, two flags.
fn place(from: (u8, u8), sigma_m: f32, lat_e7: i32, lon_e7: i32) -> Vec<u8> {
    let parameters = [1.0f32, 0.1, sigma_m, 0.0].into_iter().flat_map(f32::to_le_bytes);
    let mut payload: Vec<u8> = parameters.collect();
    payload.extend([lat_e7, lon_e7].into_iter().flat_map(i32::to_le_bytes));
    payload.extend(f32::NAN.to_le_bytes());
    payload.extend(EXTERNAL_POSITION_ESTIMATE.to_le_bytes());
    payload.extend([US.0, US.1, 5, 0, 0]);
    let id = COMMAND_INT_DATA::ID as u8;
    let mut bytes = [&[0xFD, payload.len() as u8, 0, 0, 0, from.0, from.1, id, 0, 0][..], &payload].concat();
    let checksum = calculate_crc(&bytes[1..], COMMAND_INT_DATA::EXTRA_CRC);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// A firmware and its partners.
struct Bench {
    link: InProcess,
    station: GroundStation,
    autopilot: Autopilot,
    tick: u32,
    /// Whether the autopilot answers to sets of sources.
    answers: bool,
}

impl Bench {
    fn new(change: impl FnOnce(&mut Scenario)) -> Self {
        let mut scenario = Scenario::of_frames(1);
        change(&mut scenario);
        let setup = Setup::prepare(scenario).expect("it can be flown");
        let link = InProcess::new(&setup.flash).expect("it boots");
        let mut bench = Bench {
            link,
            station: GroundStation::default(),
            autopilot: Autopilot::new(300, 0),
            tick: 0,
            answers: true,
        };
        bench.beats(20);
        bench
    }

    fn step(&mut self, bytes: &[u8]) {
        let event = if bytes.is_empty() { Event::Nothing } else { Event::Bytes(bytes) };
        let sent = self.link.step(self.tick, event).expect("it runs");
        self.station.take(&sent);
    }

    /// So many beats, in which the autopilot answers; the sets of sources that it was commanded.
    fn beats(&mut self, count: u32) -> Vec<f32> {
        let mut sets = Vec::new();
        for beat in 0..count {
            self.tick += BEAT_TICKS;
            let heartbeat = if beat.is_multiple_of(10) { self.autopilot.heartbeat() } else { Vec::new() };
            self.step(&heartbeat);
            let gnss = GPS_RAW_INT_DATA { time_usec: self.tick.into(), ..GPS_RAW_INT_DATA::DEFAULT };
            self.step(&message((1, 1), &gnss));
            for ts1 in std::mem::take(&mut self.station.timesync) {
                let answer = TIMESYNC_DATA { tc1: i64::from(self.tick) * 1000, ts1 };
                self.step(&message((1, 1), &answer));
            }
            for name in std::mem::take(&mut self.station.parameters) {
                let answer = self.autopilot.parameter(&name, self.tick.into()).expect("it has it").1;
                self.step(&answer);
            }
            for command in std::mem::take(&mut self.station.commands) {
                let is_set = command.command == SET_EKF_SOURCE_SET;
                sets.extend(is_set.then_some(command.parameters[0]));
                if self.answers || !is_set {
                    let (_, answer) = self.autopilot.commanded(&command, self.tick.into());
                    self.step(&answer);
                }
            }
        }
        sets
    }

    fn results(&mut self) -> Vec<(u16, u8, (u8, u8))> {
        let each = std::mem::take(&mut self.station.acknowledged);
        each.into_iter().map(|ack| (ack.command, ack.result, ack.target)).collect()
    }
}

#[test]
fn a_ground_station_has_the_sources_switched_where_that_is_set() {
    let mut bench = Bench::new(|scenario| scenario.vehicle.link.switch_source = SwitchSource::Told);
    bench.step(&source_set(STATION, 2.0, US));
    assert_eq!(bench.beats(10), [2.0]);
    assert_eq!(bench.results(), [(SET_EKF_SOURCE_SET, ACCEPTED, STATION)]);
    assert_eq!(bench.autopilot.source_set(), 2);
    // What is meant for another, or comes from one, or is no set.
    bench.step(&source_set(STATION, 3.0, (1, 1)));
    bench.step(&source_set((254, 190), 3.0, US));
    assert_eq!((bench.beats(10), bench.results()), (vec![], vec![]));
    bench.step(&source_set(STATION, 4.0, US));
    assert_eq!((bench.beats(10), bench.results()), (vec![], vec![(SET_EKF_SOURCE_SET, DENIED, STATION)]));
    // An autopilot that says nothing, an acknowledgement that is for another, and one that is for us.
    bench.answers = false;
    bench.step(&source_set(STATION, 1.0, US));
    assert_eq!((bench.beats(25), bench.results()), (vec![1.0; 3], vec![]));
    let answer = |target| Acknowledgement { command: SET_EKF_SOURCE_SET, result: ACCEPTED, target };
    bench.step(&message((1, 1), &answer((255, 190))));
    assert_eq!((bench.beats(5), bench.results()), (vec![], vec![]));
    bench.step(&message((1, 1), &answer(US)));
    assert_eq!((bench.beats(15), bench.results()), (vec![], vec![(SET_EKF_SOURCE_SET, ACCEPTED, STATION)]));
    // 0 in an acknowledgement's last fields is cut off: for everybody.
    assert!(message((1, 1), &answer((0, 0))).len() < 12 + COMMAND_ACK_DATA::ENCODED_LEN + 1);
}

#[test]
fn where_the_sources_are_not_to_be_switched_an_order_is_denied() {
    let mut bench = Bench::new(|_| {});
    bench.step(&source_set(STATION, 2.0, US));
    assert_eq!((bench.beats(20), bench.results()), (vec![], vec![(SET_EKF_SOURCE_SET, DENIED, STATION)]));
    let mut bench = Bench::new(|scenario| {
        (scenario.vehicle.link.switch_source, scenario.vehicle.link.ground_station) = (SwitchSource::Told, 0);
    });
    bench.step(&source_set((0, 190), 2.0, US));
    bench.step(&source_set(STATION, 2.0, US));
    assert_eq!((bench.beats(20), bench.results()), (vec![], vec![]));
}

#[test]
fn a_ground_station_may_say_where_the_vehicle_stands() {
    let mut bench = Bench::new(|scenario| {
        scenario.run.frames = 1;
        scenario.faults.autopilot_faults.knows_no_place = true;
    });
    let crs = Setup::prepare(Scenario::of_frames(1)).expect("it can be flown");
    let state = crs.motion.state(0);
    let (lat, lon) = crs.crs.to_wgs84(state.east_m, state.north_m).expect("inside");
    let [lat_e7, lon_e7] = [lat, lon].map(|deg| (1e7 * deg).round() as i32);
    bench.station.lines.clear();
    bench.step(&place(STATION, 0.0, lat_e7, lon_e7));
    bench.step(&place((254, 190), 20.0, lat_e7, lon_e7));
    assert_eq!(bench.results(), [(EXTERNAL_POSITION_ESTIMATE, DENIED, STATION)]);
    bench.step(&place(STATION, 20.0, lat_e7, lon_e7));
    assert_eq!(bench.results(), [(EXTERNAL_POSITION_ESTIMATE, ACCEPTED, STATION)]);
    bench.beats(30);
    // No position is missing any more.
    assert_eq!(bench.station.origin, None, "only the settings know a height");
    let newest = bench.station.lines.last().cloned();
    assert!(!newest.clone().is_some_and(|line| line.contains("position")), "{newest:?}");
    let sample = plumbline_sim::vehicle::sensors::Sample {
        sampled_at_us: bench.tick.into(),
        arrived_at_us: bench.tick.into(),
        reading: plumbline_sim::vehicle::sensors::Reading::Position {
            east_m: state.east_m + 100.0,
            north_m: state.north_m,
            up_m: 500.0,
            velocity_ned_m_s: [20.0, 0.0, 0.0],
        },
    };
    let own = bench.autopilot.messages(&sample, &crs.crs).expect("inside").concat();
    bench.step(&own);
    bench.step(&place(STATION, 20.0, lat_e7, lon_e7));
    assert_eq!(bench.results(), [(EXTERNAL_POSITION_ESTIMATE, TEMPORARILY_REJECTED, STATION)]);
}
