//! Bytes that pass, a ground station that comes and goes, and what it is told.

use super::*;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, MISSION_ACK_DATA, MISSION_COUNT_DATA, MISSION_CURRENT_DATA,
    MISSION_ITEM_INT_DATA, MISSION_REQUEST_INT_DATA, MISSION_REQUEST_LIST_DATA, MavCmd, MavMissionResult, MavResult,
    PARAM_REQUEST_LIST_DATA, PARAM_VALUE_DATA,
};
use plumbline_firmware::wire::decoder::Decoder;

/// Answers each step with its event.
struct Echo;

impl Link for Echo {
    fn step(&mut self, _: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        Ok(if let Event::Bytes(bytes) = event { bytes.to_vec() } else { vec![0xEE] })
    }
}

#[test]
fn both_directions_are_heard_and_nothing_changes() {
    let heard = UdpSocket::bind("127.0.0.1:0").expect("a port");
    heard.set_read_timeout(Some(Duration::from_secs(5))).expect("set");
    let station: Station = format!("udp:{}", heard.local_addr().expect("bound")).parse().expect("a station");
    let mut mirror = Mirror::new(Box::new(Echo), Opened::new(&station).expect("open"), 1e3, &Knowledge::default());
    assert_eq!(mirror.step(0, Event::Bytes(b"abc")).expect("a step"), b"abc");
    assert_eq!(mirror.step(50_000, Event::Nothing).expect("a step"), [0xEE]);
    for wanted in [&b"abc"[..], b"abc", &[0xEE]] {
        let mut buffer = [0; 16];
        let count = heard.recv(&mut buffer).expect("heard");
        assert_eq!(&buffer[..count], wanted);
    }
}

#[test]
fn a_gimbals_attitude_is_told_as_a_ground_station_shows_it() {
    let (heading, pitch, roll) = (2.0f32, -0.3f32, 0.2f32);
    let half = |angle: f32| (0.5 * angle).sin_cos();
    let ((sy, cy), (sp, cp), (sr, cr)) = (half(heading), half(pitch), half(roll));
    let q = [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ];
    let state = AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA {
        time_boot_us: 7_000_000,
        q,
        ..AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::DEFAULT
    };
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(MavHeader { system_id: 1, component_id: 1, sequence: 9 }, &state);
    let told = attitude(raw.raw_bytes(), [0.1, -0.2, 0.3]).expect("an attitude");
    let payload = &told[HEAD..HEAD + usize::from(told[1])];
    let told = ATTITUDE_DATA::deser(MavlinkVersion::V2, payload).expect("a message");
    assert_eq!(told.time_boot_ms, 7000);
    for (told, wanted) in [(told.yaw, heading), (told.pitch, pitch), (told.roll, roll)] {
        assert!((told - wanted).abs() < 1e-5, "{told} {wanted}");
    }
    assert_eq!((told.rollspeed, told.pitchspeed, told.yawspeed), (0.1, -0.2, 0.3));
    assert_eq!(attitude(b"short", [0.0; 3]), None);
}

#[test]
fn a_ground_station_comes_and_goes() {
    let free = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("bound");
    let station: Station = format!("tcp:{free}").parse().expect("a station");
    let mut mirror = Mirror::new(Box::new(Echo), Opened::new(&station).expect("listens"), 1e3, &Knowledge::default());
    mirror.step(0, Event::Nothing).expect("alone");
    let mut stream = TcpStream::connect(free).expect("connected");
    (1..5).for_each(|step| assert_eq!(mirror.step(step, Event::Bytes(b"x")).expect("a step"), b"x"));
    let mut heard = [0; 3];
    stream.read_exact(&mut heard).expect("heard");
    assert_eq!(&heard, b"xxx");
    drop(stream);
    (5..20).for_each(|step| assert_eq!(mirror.step(step, Event::Bytes(b"x")).expect("a step"), b"x"));
}

#[test]
fn it_takes_as_long_as_it_says() {
    let station: Station = "udp:127.0.0.1:9".parse().expect("a station");
    let mut mirror = Mirror::new(Box::new(Echo), Opened::new(&station).expect("open"), 4.0, &Knowledge::default());
    let began = Instant::now();
    (0..=4).for_each(|step| drop(mirror.step(50_000 * step, Event::Nothing)));
    assert!(began.elapsed() >= Duration::from_millis(50), "{:?}", began.elapsed());
}

#[test]
fn what_is_no_station_is_refused() {
    for text in ["udp:14550", "tcp::5760", "tcp:localhost:0", "serial:/dev/ttyS0", "udp:host:x"] {
        assert!(text.parse::<Station>().is_err(), "{text}");
    }
}

/// A message of a ground station: system 255, component 190.
fn asked<D: MessageData>(message: &D) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(MavHeader { system_id: 255, component_id: 190, sequence: 3 }, message);
    raw.raw_bytes().to_vec()
}

/// The payloads of the answers of one kind.
fn told<D: MessageData>(answers: &[u8]) -> Vec<D> {
    let mut all = Vec::new();
    Decoder::new().take(answers, |packet| {
        if packet.id == D::ID {
            assert_eq!((packet.system, packet.component), answers::AUTOPILOT);
            all.extend(D::deser(MavlinkVersion::V2, packet.payload).ok());
        }
    });
    all
}

fn knowledge() -> Knowledge {
    let waypoint = |k: i32| Waypoint { place_e7: [480_000_000 + 1000 * k, 110_000_000 - k], up_m: 300.0 + k as f32 };
    let value = |k: u16| PARAM_VALUE_DATA {
        param_value: k.into(),
        param_count: 3,
        param_index: k,
        ..PARAM_VALUE_DATA::DEFAULT
    };
    Knowledge { waypoints: (0..4).map(waypoint).collect(), is_round: true, parameters: (0..3).map(value).collect() }
}

#[test]
fn the_mission_is_told_item_by_item_and_nobody_changes_it() {
    let (mut answers, mut listener) = (Answers::new(&knowledge()), Listener::default());
    let list = MISSION_REQUEST_LIST_DATA { target_system: 1, target_component: 1 };
    let bytes = asked(&list);
    // A message may come in pieces.
    assert!(answers.to(&mut listener, &bytes[..5]).is_empty());
    let count = told::<MISSION_COUNT_DATA>(&answers.to(&mut listener, &bytes[5..]));
    // Home, four waypoints, and the jump to the first.
    assert_eq!((count.len(), count[0].count, count[0].target_system), (1, 6, 255));
    let mut item = |seq: u16| {
        let request = MISSION_REQUEST_INT_DATA { seq, target_system: 1, ..MISSION_REQUEST_INT_DATA::DEFAULT };
        answers.to(&mut listener, &asked(&request))
    };
    for seq in 0..6 {
        let told = told::<MISSION_ITEM_INT_DATA>(&item(seq));
        let (command, k) = (told[0].command, i32::from(seq.max(1)) - 1);
        assert_eq!((told.len(), told[0].seq, told[0].target_component), (1, seq, 190));
        match seq {
            5 => assert_eq!((command, told[0].param1, told[0].param2), (MavCmd::MAV_CMD_DO_JUMP, 1.0, -1.0)),
            _ => assert_eq!(
                (told[0].x, told[0].y, told[0].z),
                (480_000_000 + 1000 * k, 110_000_000 - k, 300.0 + k as f32)
            ),
        }
    }
    let beyond = told::<MISSION_ACK_DATA>(&item(6));
    assert_eq!(beyond[0].mavtype, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
    let upload = MISSION_COUNT_DATA { count: 2, target_system: 1, target_component: 1 };
    let declined = told::<MISSION_ACK_DATA>(&answers.to(&mut listener, &asked(&upload)));
    assert_eq!(declined[0].mavtype, MavMissionResult::MAV_MISSION_DENIED);
}

#[test]
fn parameters_are_told_and_orders_declined_and_another_vehicle_is_left_alone() {
    let (mut answers, mut listener) = (Answers::new(&knowledge()), Listener::default());
    let list = PARAM_REQUEST_LIST_DATA { target_system: 1, target_component: 0 };
    let values = told::<PARAM_VALUE_DATA>(&answers.to(&mut listener, &asked(&list)));
    assert_eq!(values.iter().map(|value| value.param_index).collect::<Vec<u16>>(), [0, 1, 2]);
    let order = COMMAND_LONG_DATA { target_system: 1, target_component: 1, ..COMMAND_LONG_DATA::DEFAULT };
    let results = told::<COMMAND_ACK_DATA>(&answers.to(&mut listener, &asked(&order)));
    assert_eq!(results[0].result, MavResult::MAV_RESULT_UNSUPPORTED);
    for other in [
        PARAM_REQUEST_LIST_DATA { target_system: 7, ..list.clone() },
        PARAM_REQUEST_LIST_DATA { target_component: 100, ..list },
    ] {
        assert!(answers.to(&mut listener, &asked(&other)).is_empty());
    }
}

#[test]
fn the_item_that_is_flown_to_is_told_when_it_changes_and_once_a_second() {
    let heard = UdpSocket::bind("127.0.0.1:0").expect("a port");
    heard.set_read_timeout(Some(Duration::from_millis(200))).expect("set");
    let station: Station = format!("udp:{}", heard.local_addr().expect("bound")).parse().expect("a station");
    let fly = |knowledge: &Knowledge| {
        let mut mirror = Mirror::new(Box::new(Echo), Opened::new(&station).expect("open"), 1e3, knowledge);
        // Ten times a second for four seconds; the second waypoint from 1.5 s on.
        for step in 0..40u32 {
            mirror.show(&|| Moving { rates_rad_s: [0.0; 3], waypoint: Some(usize::from(step >= 15)) });
            mirror.step(100_000 * step, Event::Bytes(b"x")).expect("a step");
        }
        let mut all = Vec::new();
        let mut buffer = [0; 64];
        while let Ok(count) = heard.recv(&mut buffer) {
            all.extend(&buffer[..count]);
        }
        told::<MISSION_CURRENT_DATA>(&all).iter().map(|current| current.seq).collect::<Vec<u16>>()
    };
    // Item 0 is the home.
    assert_eq!(fly(&knowledge()), [1, 1, 2, 2, 2]);
    assert!(fly(&Knowledge::default()).is_empty());
}
