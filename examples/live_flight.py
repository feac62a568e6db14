#!/usr/bin/env python3
"""Has ArduPilot's simulated plane fly a rectangle and lose satellite navigation, while `plumbline fly` aids it.

Needs pymavlink (`pip install pymavlink`) and three ports of the simulator: the first one is this script's, the others are
those of `plumbline fly --autopilot ... --truth ...`; docs/live.md says how all three are started. What happens:

1. Parameters for external navigation are set; where that asks for it the autopilot is rebooted.
2. A rectangle is uploaded, the vehicle armed and sent off in AUTO.
3. On the second leg satellite navigation is switched off and the autopilot told to use its second set of sources, which is
   external navigation; 5 s later the wind changes.
4. The autopilot's position error is printed every 5 s. At the end the vehicle is disarmed, which ends the live flight.

With --signing-key the autopilot gets the key that it shares with the firmware, and signs on the firmware's port.
"""

import argparse
import math
import os
import sys
import time

os.environ.setdefault("MAVLINK20", "1")
from pymavlink import mavutil  # noqa: E402

mavlink = mavutil.mavlink

# Parameter, value, whether it counts only after a reboot. Sources: 6 is external navigation, 1 barometer or compass.
PARAMETERS = [
    ("EK2_ENABLE", 0, True),  # the older filter beside the one that flies
    ("SCHED_LOOP_RATE", 300, True),  # attitude at 100 Hz and more
    ("SERIAL1_PROTOCOL", 2, True),  # MAVLink 2 on the firmware's port
    ("SERIAL1_BAUD", 921, True),  # what it assumes to take: no time to speak of
    ("SERIAL2_PROTOCOL", 2, True),
    ("SERIAL2_BAUD", 921, True),
    ("VISO_TYPE", 1, True),  # external navigation by MAVLink
    ("RNGFND1_TYPE", 100, True),  # the simulated laser, looking down
    ("RNGFND1_ORIENT", 25, False),
    ("RNGFND1_MIN", 0.2, False),
    ("RNGFND1_MAX", 300, False),
    ("EK3_SRC2_POSXY", 6, False),
    ("EK3_SRC2_VELXY", 0, False),
    ("EK3_SRC2_POSZ", 1, False),
    ("EK3_SRC2_VELZ", 0, False),
    ("EK3_SRC2_YAW", 1, False),
]
# Some exist only once the one that switches them on has been set and the autopilot rebooted.
LATE = ("VISO_DELAY_MS", 0)
UNSIGNED_TRUTH = ("MAV3_OPTIONS", 1)  # the third port, which tells the truth, is not signed
AUTO = 10  # the plane's flight mode
FORCE = 21196  # arms past its checks: without fixes external navigation is not healthy on the ground
SIGNING_EPOCH = 1420070400  # 2015-01-01, from which signatures count 10 us
METRES_PER_DEGREE = 111318.84502145034  # the autopilot's own


class Vehicle:
    """A connection to the autopilot, and what it said last."""

    def __init__(self, address):
        self.address = address
        self.last = {}
        self.connect()

    def connect(self):
        until = time.time() + 60
        while True:
            try:
                self.link = mavutil.mavlink_connection(self.address, source_system=255, source_component=190)
                if self.link.wait_heartbeat(timeout=5):
                    break
                self.link.close()
            except OSError:
                pass
            if time.time() > until:
                sys.exit(f"no heartbeat at {self.address}")
            time.sleep(0.5)
        self.beat = 0
        self.request(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, 10)
        self.request(mavlink.MAVLINK_MSG_ID_SIM_STATE, 10)
        self.request(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT, 5)
        self.request(mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT, 2)

    def receive(self):
        """The next message, or None after a while."""
        if time.time() - self.beat > 1:
            self.beat = time.time()
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        message = self.link.recv_match(blocking=True, timeout=0.2)
        if message is None or message.get_srcComponent() != 1:
            return None
        self.last[message.get_type()] = message
        if message.get_type() == "STATUSTEXT":
            print("  autopilot:", message.text)
        return message

    def until(self, condition, seconds, what):
        """Receives until the condition holds."""
        end = time.time() + seconds
        while not condition():
            self.receive()
            if time.time() > end:
                sys.exit(f"waited {seconds} s for {what}")

    def wait(self, seconds):
        end = time.time() + seconds
        while time.time() < end:
            self.receive()

    def command(self, command, *parameters):
        """The result of a command, None without an answer."""
        parameters = list(parameters) + [0] * (7 - len(parameters))
        for _ in range(3):
            self.link.mav.command_long_send(self.link.target_system, 1, command, 0, *parameters)
            end = time.time() + 2
            while time.time() < end:
                message = self.receive()
                if message and message.get_type() == "COMMAND_ACK" and message.command == command:
                    return message.result
        return None

    def request(self, message, hertz):
        self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message, 1e6 / hertz)

    def parameter(self, name, value=None):
        """Sets a parameter or asks for it: its value afterwards, None where there is none of that name."""
        for _ in range(4):
            if value is None:
                self.link.mav.param_request_read_send(self.link.target_system, 1, name.encode(), -1)
            else:
                kind = mavlink.MAV_PARAM_TYPE_REAL32
                self.link.mav.param_set_send(self.link.target_system, 1, name.encode(), value, kind)
            end = time.time() + 1
            while time.time() < end:
                message = self.receive()
                if message and message.get_type() == "PARAM_VALUE" and message.param_id == name:
                    return message.param_value
        return None

    def set(self, name, value):
        if self.parameter(name, value) is None:
            sys.exit(f"cannot set {name}")


def prepare(vehicle):
    """External navigation as the second set of sources."""
    must_reboot = False
    for name, value, counts_late in PARAMETERS:
        if vehicle.parameter(name) != value:
            vehicle.parameter(name, value)
            must_reboot |= counts_late
    if must_reboot:
        print("reboot")
        vehicle.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1)
        vehicle.link.close()
        time.sleep(3)
        vehicle.connect()
    for name, value in [LATE] + [(name, value) for name, value, _ in PARAMETERS]:
        vehicle.set(name, value)


def share_key(vehicle, path):
    """Gives the autopilot the key of a file of 64 hexadecimal digits. This script's port takes unsigned messages all the same."""
    with open(path, encoding="ascii") as file:
        key = bytes.fromhex(file.read().strip())
    if len(key) != 32:
        sys.exit(f"{path}: a signing key is 64 hexadecimal digits")
    vehicle.set(*UNSIGNED_TRUTH)
    now = int((time.time() - SIGNING_EPOCH) * 1e5)
    vehicle.link.mav.setup_signing_send(vehicle.link.target_system, 1, list(key), now)
    print("the autopilot has the key")


def rectangle(home, height, side, heading):
    """Mission items (command, latitude, longitude, height): home, take-off, four corners, and back to the first."""
    heading = math.radians(heading)

    def place(forward, right):
        north = forward * math.cos(heading) - right * math.sin(heading)
        east = forward * math.sin(heading) + right * math.cos(heading)
        scale = METRES_PER_DEGREE * math.cos(math.radians(home[0]))
        return home[0] + north / METRES_PER_DEGREE, home[1] + east / scale

    items = [(mavlink.MAV_CMD_NAV_WAYPOINT, *home, 0), (mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, height)]
    for forward, right in ((side, 0), (side, side), (0, side), (0, 0)):
        items.append((mavlink.MAV_CMD_NAV_WAYPOINT, *place(forward, right), height))
    return items + [(mavlink.MAV_CMD_DO_JUMP, 0, 0, 0)]


def upload(vehicle, items):
    vehicle.link.mav.mission_count_send(vehicle.link.target_system, 1, len(items), 0)
    end = time.time() + 10
    while time.time() < end:
        message = vehicle.receive()
        if message is None:
            continue
        if message.get_type() in ("MISSION_REQUEST", "MISSION_REQUEST_INT"):
            command, latitude, longitude, height = items[message.seq]
            # Take-off by 12 degrees of pitch; the jump goes to item 2 for ever.
            parameters = {mavlink.MAV_CMD_NAV_TAKEOFF: (12, 0), mavlink.MAV_CMD_DO_JUMP: (2, -1)}.get(command, (0, 0))
            frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
            vehicle.link.mav.mission_item_int_send(
                vehicle.link.target_system, 1, message.seq, frame, command, 0, 1, *parameters, 0, 0,
                round(latitude * 1e7), round(longitude * 1e7), height, 0)
        elif message.get_type() == "MISSION_ACK":
            return message.type == mavlink.MAV_MISSION_ACCEPTED
    return False


def error(vehicle):
    """The autopilot's horizontal error, metres."""
    own, truth = vehicle.last["GLOBAL_POSITION_INT"], vehicle.last["SIM_STATE"]
    north = (own.lat - truth.lat_int) * 1e-7 * METRES_PER_DEGREE
    east = (own.lon - truth.lon_int) * 1e-7 * METRES_PER_DEGREE * math.cos(math.radians(own.lat * 1e-7))
    return math.hypot(north, east)


def take_off(vehicle, arguments):
    """Arms and flies to the middle of the second leg."""
    needed = mavlink.EKF_POS_HORIZ_ABS | mavlink.EKF_VELOCITY_HORIZ | mavlink.EKF_POS_VERT_ABS

    def is_ready():
        status = vehicle.last.get("EKF_STATUS_REPORT")
        return status is not None and status.flags & needed == needed and "SIM_STATE" in vehicle.last

    print("waiting for the autopilot's filter")
    vehicle.until(is_ready, 180, "a filter that is ready")
    truth = vehicle.last["SIM_STATE"]
    items = rectangle((truth.lat_int * 1e-7, truth.lon_int * 1e-7), arguments.height, arguments.side, arguments.heading)
    vehicle.until(lambda: upload(vehicle, items), 60, "the mission to be accepted")
    vehicle.until(lambda: vehicle.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, FORCE) == 0, 60, "arming")
    vehicle.link.set_mode(AUTO)
    print("armed, on its way")

    def is_on_second_leg():
        current = vehicle.last.get("MISSION_CURRENT")
        return current is not None and current.seq == 3

    vehicle.until(is_on_second_leg, 400, "the second leg")
    vehicle.wait(10)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vehicle", default="tcp:127.0.0.1:5760", help="the simulator's first port")
    parser.add_argument("--height", type=float, default=120, help="metres above home")
    parser.add_argument("--side", type=float, default=1500, help="of the rectangle, metres")
    parser.add_argument("--heading", type=float, default=353, help="of the first leg, degrees")
    parser.add_argument("--seconds", type=float, default=120, help="without satellite navigation")
    parser.add_argument("--wind", default="6,270", help="m/s, and where it comes from")
    parser.add_argument("--wind-after", default="8.5,295", help="from 5 s after the loss on")
    parser.add_argument("--signing-key", metavar="FILE", help="64 hexadecimal digits, as for [link] signing_key_path")
    parser.add_argument("--keep-gps", action="store_true", help="satellite navigation stays on")
    arguments = parser.parse_args()

    def wind(text):
        speed, direction = (float(number) for number in text.split(","))
        vehicle.set("SIM_WIND_SPD", speed)
        vehicle.set("SIM_WIND_DIR", direction)

    vehicle = Vehicle(arguments.vehicle)
    prepare(vehicle)
    if arguments.signing_key:
        share_key(vehicle, arguments.signing_key)
    vehicle.set("SIM_GPS1_ENABLE", 1)
    wind(arguments.wind)
    take_off(vehicle, arguments)
    if not arguments.keep_gps:
        vehicle.set("SIM_GPS1_ENABLE", 0)
        vehicle.command(mavlink.MAV_CMD_SET_EKF_SOURCE_SET, 2)
        print("satellite navigation is off")
    begin, next_line, is_changed = time.time(), 0, False
    while time.time() - begin < arguments.seconds:
        vehicle.receive()
        passed = time.time() - begin
        if passed >= 5 and not is_changed:
            is_changed = True
            wind(arguments.wind_after)
            print("the wind has changed")
        if passed >= next_line:
            print(f"{next_line:4d} s: off by {error(vehicle):.1f} m")
            next_line += 5
    vehicle.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, FORCE)
    print("disarmed: the flight is over")


if __name__ == "__main__":
    main()
