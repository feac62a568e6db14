"""Loads plan.plan as QGroundControl does, independently of what wrote it, and holds it against plan.json.

    python3 tests/plan/qgc_plan.py FOLDER

FOLDER is what `plumbline plan --out` wrote. Needs jsonschema and pymavlink. The schema is that of QGroundControl's developer
guide ("Plan File Format") and of the keys that its loader demands (MissionController, MissionItem::load,
SimpleMissionItem::load). The items then go through pymavlink as a plain-text mission, as they would to a vehicle.
"""

import json
import math
import sys
import tempfile
from pathlib import Path

import jsonschema
from pymavlink import mavutil, mavwp

NUMBER_OR_NULL = {"type": ["number", "null"]}
ITEM = {
    "type": "object",
    "required": ["type", "frame", "command", "params", "autoContinue", "doJumpId"],
    "properties": {
        "type": {"const": "SimpleItem"},
        "frame": {"enum": [0, 2]},
        "command": {"enum": [16, 20, 22, 84, 178, 203]},
        "autoContinue": {"type": "boolean"},
        "doJumpId": {"type": "integer", "minimum": 1},
        "params": {"type": "array", "minItems": 7, "maxItems": 7, "items": NUMBER_OR_NULL},
        "AMSLAltAboveTerrain": NUMBER_OR_NULL,
        "Altitude": {"type": "number"},
        "AltitudeMode": {"enum": [1, 2, 3, 4]},
    },
    "additionalProperties": False,
    # A waypoint or a take-off has its altitude's keys all or none, and a place.
    "if": {"properties": {"command": {"enum": [16, 22, 84]}}},
    "then": {
        "required": ["AMSLAltAboveTerrain", "Altitude", "AltitudeMode"],
        "properties": {
            "params": {
                "prefixItems": [NUMBER_OR_NULL] * 4
                + [
                    {"type": "number", "minimum": -90, "maximum": 90},
                    {"type": "number", "minimum": -180, "maximum": 180},
                    {"type": "number"},
                ]
            }
        },
    },
}
PLAN = {
    "type": "object",
    "required": ["fileType", "version", "groundStation", "mission", "geoFence", "rallyPoints"],
    "properties": {
        "fileType": {"const": "Plan"},
        "version": {"const": 1},
        "groundStation": {"type": "string"},
        "geoFence": {
            "type": "object",
            "required": ["version", "circles", "polygons"],
            "properties": {"version": {"const": 2}, "circles": {"type": "array"}, "polygons": {"type": "array"}},
        },
        "rallyPoints": {
            "type": "object",
            "required": ["version", "points"],
            "properties": {"version": {"const": 2}, "points": {"type": "array"}},
        },
        "mission": {
            "type": "object",
            "required": [
                "version", "firmwareType", "vehicleType", "cruiseSpeed", "hoverSpeed", "plannedHomePosition", "items",
            ],
            "properties": {
                "version": {"const": 2},
                "firmwareType": {"type": "integer"},
                "vehicleType": {"type": "integer"},
                "globalPlanAltitudeMode": {"enum": [0, 1, 2, 3, 4]},
                "cruiseSpeed": {"type": "number"},
                "hoverSpeed": {"type": "number"},
                "plannedHomePosition": {
                    "type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"},
                },
                "items": {"type": "array", "minItems": 1, "items": ITEM},
            },
            "additionalProperties": False,
        },
    },
    "additionalProperties": False,
}


def through_pymavlink(mission):
    """The items as pymavlink reads them from a plain-text mission (QGC WPL 110), home first."""
    rows = [[0, 1, 0, 16, 0, 0, 0, 0, *mission["plannedHomePosition"], 1]]
    for seq, item in enumerate(mission["items"], 1):
        params = [0 if value is None else value for value in item["params"]]
        rows.append([seq, 0, item["frame"], item["command"], *params, int(item["autoContinue"])])
    with tempfile.NamedTemporaryFile("w", suffix=".waypoints") as file:
        file.write("QGC WPL 110\n" + "".join("\t".join(map(str, row)) + "\n" for row in rows))
        file.flush()
        loader = mavwp.MAVWPLoader()
        loader.load(file.name)
    return [loader.wp(index) for index in range(loader.count())]


def metres(a, b):
    """Distance of two (lat, lon) on a sphere; good to 0.5 %."""
    north = math.radians(b[0] - a[0])
    east = math.radians(b[1] - a[1]) * math.cos(math.radians(a[0]))
    return 6_371_000 * math.hypot(north, east)


def check(folder):
    plan = json.loads((folder / "plan.plan").read_text())
    flown = json.loads((folder / "plan.json").read_text())
    jsonschema.Draft202012Validator(PLAN).validate(plan)
    items = plan["mission"]["items"]
    # What QGroundControl calls these: MAV_AUTOPILOT_ARDUPILOTMEGA or _PX4; fixed wing, quadrotor, VTOL.
    assert plan["mission"]["firmwareType"] in (3, 12) and plan["mission"]["vehicleType"] in (1, 2, 20)
    assert [item["doJumpId"] for item in items] == list(range(1, len(items) + 1))
    waypoints = through_pymavlink(plan["mission"])
    assert len(waypoints) == len(items) + 1
    # Take-off and return stand around the rest.
    takeoffs = {1: mavutil.mavlink.MAV_CMD_NAV_TAKEOFF, 2: mavutil.mavlink.MAV_CMD_NAV_TAKEOFF,
                20: mavutil.mavlink.MAV_CMD_NAV_VTOL_TAKEOFF}
    if waypoints[1].command != mavutil.mavlink.MAV_CMD_DO_CHANGE_SPEED:
        takeoff, back = waypoints.pop(1), waypoints.pop()
        assert takeoff.command == takeoffs[plan["mission"]["vehicleType"]]
        assert takeoff.z == waypoints[2].z
        assert back.command == mavutil.mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH
    speed = waypoints[1]
    assert speed.command == mavutil.mavlink.MAV_CMD_DO_CHANGE_SPEED
    assert (speed.param1, speed.param2) == (1, flown["speed_m_s"])
    rest = iter(waypoints[2:])
    radius = flown["checks"]["turn_radius_m"]
    triggers = any(item["command"] == 203 for item in items)
    for strip in flown["strips"]:
        photos = strip["photos"] if strip["heading_deg"] < 180 else strip["photos"][::-1]
        place = lambda wp: (wp.x, wp.y)
        at = lambda photo: (photo["lat"], photo["lon"])
        way = strip.get("way", [])
        way = way if strip["heading_deg"] < 180 else way[::-1]
        # What lies between the ends: photos, and waypoints where the ground is followed, by their distance.
        start = at(way[0]) if way else at(photos[0])
        between = [(metres(start, at(point)), point, False) for point in way[1:-1]]
        between += [(metres(start, at(photo)), photo, True) for photo in photos if triggers]
        lead_in = next(rest)
        for _, point, is_photo in sorted(between, key=lambda stop: stop[0]):
            waypoint = next(rest)
            assert (waypoint.command, waypoint.frame) == (16, mavutil.mavlink.MAV_FRAME_GLOBAL)
            assert metres(place(waypoint), at(point)) < 0.02 and abs(waypoint.z - point["z"]) <= 0.0051
            if is_photo:
                trigger = next(rest)
                assert (trigger.command, trigger.x) == (mavutil.mavlink.MAV_CMD_DO_DIGICAM_CONTROL, 1)
        end = next(rest)
        for waypoint, photo, point in [(lead_in, photos[0], way[:1]), (end, photos[-1], way[-1:])]:
            assert (waypoint.command, waypoint.frame) == (16, mavutil.mavlink.MAV_FRAME_GLOBAL)
            assert abs(metres(place(waypoint), at(photo)) / radius - 1) < 0.01
            assert abs(waypoint.z - (point[0] if point else photo)["z"]) <= 0.0051
        assert metres(place(lead_in), place(end)) > metres(at(photos[0]), at(photos[-1]))
    assert next(rest, None) is None
    return len(items)


if __name__ == "__main__":
    for folder in sys.argv[1:]:
        print(f"{folder}: {check(Path(folder))} items, as QGroundControl wants them")
