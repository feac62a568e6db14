"""Prints what pyulog and pymavlink read of flight logs, for tests/ground/flight_logs.rs.

    python3 tests/logs/figures.py FOLDER

FOLDER holds the logs. Needs pyulog and pymavlink. A row is the file, the message, its samples, the first and the last time in seconds,
a column, and the sum over it.
"""

import sys
from pathlib import Path

from pymavlink import mavutil
from pyulog import ULog

ULOGS = [
    ("px4_a.ulg", "vehicle_attitude", 0, "q[3]"),
    ("px4_a.ulg", "sensor_combined", 0, "accelerometer_m_s2[2]"),
    ("px4_a.ulg", "vehicle_local_position", 0, "x"),
    ("px4_zurich.ulg", "vehicle_attitude", 0, "q[0]"),
    ("px4_zurich.ulg", "actuator_outputs", 1, "output[0]"),
    ("px4_zurich.ulg", "esc_status", 0, "esc[5].esc_rpm"),
    ("px4_zurich.ulg", "distance_sensor", 0, "current_distance"),
]
OTHERS = [
    ("arduplane.BIN", "ATT", "Yaw"),
    ("arduplane.BIN", "XKF1", "PN"),
    ("arduplane.BIN", "GPS", "Lat"),
    ("arduplane.BIN", "BARO", "Alt"),
    ("arduplane.BIN", "POS", "Lng"),
    ("arduplane.tlog", "ATTITUDE", "yaw"),
    ("arduplane.tlog", "ATTITUDE_QUATERNION", "q4"),
    ("arduplane.tlog", "AHRS2", "altitude"),
    ("arduplane.tlog", "GLOBAL_POSITION_INT", "lat"),
    ("arduplane.tlog", "DISTANCE_SENSOR", "current_distance"),
]


def time_s(message):
    for name, unit in (("TimeUS", 1e-6), ("time_boot_ms", 1e-3)):
        if hasattr(message, name):
            return getattr(message, name) * unit
    return message._timestamp


def rows(folder):
    for file, topic, instance, column in ULOGS:
        data = ULog(str(folder / file), [topic]).get_dataset(topic, instance).data
        yield file, topic, [t * 1e-6 for t in data["timestamp"]], column, [float(v) for v in data[column]]
    for file, name, column in OTHERS:
        log = mavutil.mavlink_connection(str(folder / file))
        messages = list(iter(lambda: log.recv_match(type=name), None))
        yield file, name, [time_s(m) for m in messages], column, [float(getattr(m, column)) for m in messages]


for file, name, times, column, values in rows(Path(sys.argv[1])):
    print(file, name, len(values), f"{times[0]:.6f} {times[-1]:.6f}", column, repr(sum(values)))
