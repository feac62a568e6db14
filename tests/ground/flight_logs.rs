//! Real flight logs as pyulog 1.3.0 and pymavlink 2.4.50 read them: `tests/logs/figures.py` prints their figures again.

use plumbline_survey::io::data;
use plumbline_survey::logs::attitude::Attitude;
use plumbline_survey::logs::{File, Log, open};
use std::path::PathBuf;

/// File, message, samples, first and last time (seconds), a column, and the sum over it.
type Figures = (&'static str, &'static str, usize, [f64; 2], &'static str, f64);

const FIGURES: [Figures; 17] = [
    ("px4_a.ulg", "vehicle_attitude", 779, [375.484921, 401.644234], "q[3]", 129.92409412562847),
    ("px4_a.ulg", "sensor_combined", 4445, [375.484685, 401.678042], "accelerometer_m_s2[2]", -43539.51288795471),
    ("px4_a.ulg", "vehicle_local_position", 257, [375.484921, 401.656503], "x", 40.3474293500185),
    ("px4_zurich.ulg", "vehicle_attitude", 1099, [5080.903927, 5120.480777], "q[0]", 639.0496692900779),
    ("px4_zurich.ulg", "actuator_outputs:1", 364, [5080.896209, 5120.420946], "output[0]", 1495089.3505859375),
    ("px4_zurich.ulg", "esc_status", 127, [5081.348405, 5120.249475], "esc[5].esc_rpm", 0.0),
    ("px4_zurich.ulg", "distance_sensor", 361, [5080.853612, 5120.415622], "current_distance", 2832.1899439394474),
    ("arduplane.BIN", "ATT", 963, [21.219842, 175.124089], "Yaw", 195514.92503261566),
    ("arduplane.BIN", "XKF1:1", 1926, [21.139041, 175.124089], "PN", 403141.50482433237),
    ("arduplane.BIN", "GPS", 770, [21.259826, 175.044121], "Lat", 37103.8966612),
    ("arduplane.BIN", "BARO", 770, [21.239834, 175.024129], "Alt", 86635.85757446289),
    ("arduplane.BIN", "POS", 963, [21.219842, 175.124089], "Lng", 15766.3682841),
    ("arduplane.tlog", "ATTITUDE", 60, [60.045, 119.046], "yaw", -11.485273698344827),
    ("arduplane.tlog", "ATTITUDE_QUATERNION", 12001, [60.001, 119.999], "q4", -1275.1444066923868),
    ("arduplane.tlog", "AHRS2:1.1", 60, [1_790_000_060.045, 1_790_000_119.046], "altitude", 19243.66958618164),
    ("arduplane.tlog", "GLOBAL_POSITION_INT", 600, [60.059, 119.959], "lat", 289120735278.0),
    ("arduplane.tlog", "DISTANCE_SENSOR", 1200, [60.041, 119.989], "current_distance", 15700935.0),
];

/// File, samples, the number of one, its time (seconds), and roll, pitch and yaw there, degrees.
type Attitudes = (&'static str, usize, usize, f64, [f64; 3]);

const ATTITUDES: [Attitudes; 4] = [
    ("px4_a.ulg", 779, 500, 392.398096, [0.41385517487876783, 4.445606414054462, -19.235442363907115]),
    ("px4_zurich.ulg", 1099, 500, 5100.009523, [-15.515070538022798, -16.14503499808153, 35.34698403758476]),
    ("arduplane.BIN", 963, 500, 101.211166, [-1.7065250873565674, -2.7081499099731445, 256.09814453125]),
    ("arduplane.tlog", 12001, 5000, 84.999, [-17.90790378484727, -4.4855793142194305, -37.44866490072352]),
];

fn path(test: &str, file: &str) -> Option<PathBuf> {
    data::for_test(test, &format!("logs/{file}"))
}

#[test]
fn messages_are_as_other_programs_read_them() {
    for (file, message, samples, [first_s, last_s], column, sum) in FIGURES {
        let Some(path) = path("messages_are_as_other_programs_read_them", file) else { return };
        let File::Log(kind, bytes) = open(&path).expect("a file") else { panic!("{file} is no log") };
        let log = Log::read(file, kind, &bytes, &|_| true).expect("a log");
        let (_, series) = log.series(message).expect(message);
        let values = series.column(column).expect(column);
        assert_eq!((series.samples, values.len()), (samples, samples), "{file}, {message}");
        // Stamps since 1970 are rounded to 0.2 µs in double precision.
        let is_near = |found: f64, wanted: f64| (found - wanted).abs() < 1e-6;
        assert!(is_near(series.t_s[0], first_s) && is_near(series.t_s[samples - 1], last_s), "{file}, {message}");
        let found: f64 = values.iter().sum();
        assert!((found - sum).abs() <= 1e-9 * sum.abs(), "{file}, {message}: {found}, not {sum}");
        assert_eq!(log.notes, Vec::<String>::new());
    }
}

#[test]
fn attitudes_are_as_other_programs_read_them() {
    for (file, samples, number, t_s, angles_deg) in ATTITUDES {
        let Some(path) = path("attitudes_are_as_other_programs_read_them", file) else { return };
        let attitude = Attitude::read(&path).expect("a log");
        assert_eq!(attitude.samples.len(), samples, "{file}: {:?}", attitude.notes);
        let found = attitude.samples[number];
        let angles = [found.roll_rad, found.pitch_rad, found.yaw_rad].map(f64::to_degrees);
        let is_near = angles.iter().zip(angles_deg).all(|(found, wanted)| (found - wanted).abs() < 1e-4);
        assert!(is_near && (found.t_s - t_s).abs() < 1e-6, "{file}: {found:?}");
    }
}

/// The table was made of the log: microseconds from the first sample, quaternions with seven decimals.
#[test]
fn a_table_and_the_log_it_was_made_of_are_one_flight() {
    let test = "a_table_and_the_log_it_was_made_of_are_one_flight";
    let table = data::for_test(test, "flights/zurich_lidar/att_q.csv");
    let (Some(table), Some(log)) = (table, path(test, "px4_zurich.ulg")) else { return };
    let [table, log] = [table, log].map(|path| Attitude::read(&path).expect("attitudes").samples);
    assert_eq!(table.len(), log.len());
    for (a, b) in table.iter().zip(&log) {
        assert!((a.t_s - (b.t_s - log[0].t_s)).abs() < 1e-6, "{a:?} {b:?}");
        let off = [a.roll_rad - b.roll_rad, a.pitch_rad - b.pitch_rad, a.yaw_rad - b.yaw_rad];
        assert!(off.iter().all(|off| off.abs() < 3e-7), "{a:?} {b:?}");
    }
}
