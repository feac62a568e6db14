"""Watches a simulated flight as a ground station does, by pymavlink: `plumbline fly --mavlink`.

    python3 tests/watched/ground_station.py PLUMBLINE FOLDER

FOLDER has dem.asc and camera.toml (as `cargo xtask test` writes them for missions). It plans a flight that follows the ground, flies it
beside a UDP and a TCP ground station, and asks both for the mission and the parameters; then a flight that is kept by its fixes, which goes
round. What is heard has to be what was planned.
"""

import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil, mavwp  # noqa: E402

UDP, TCP = 14_561, 14_562


def flying(plumbline, folder, port, arguments):
    command = [plumbline, "fly", "--mavlink", port, "--speed", "20", "--frames", "200", *arguments]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL)


def asked(link, kind, send):
    """Asks until it is answered, as ground stations do."""
    for _ in range(40):
        send()
        message = link.recv_match(type=kind, blocking=True, timeout=0.5)
        if message is not None:
            return message
    raise SystemExit(f"no {kind}")


def mission(link):
    system, component = link.target_system, link.target_component
    count = asked(link, "MISSION_COUNT", lambda: link.mav.mission_request_list_send(system, component)).count
    items = []
    for seq in range(count):
        item = asked(link, "MISSION_ITEM_INT", lambda: link.mav.mission_request_int_send(system, component, seq))
        while item.seq != seq:
            item = link.recv_match(type="MISSION_ITEM_INT", blocking=True, timeout=5)
        items.append(item)
    link.mav.mission_ack_send(system, component, mavutil.mavlink.MAV_MISSION_ACCEPTED)
    return items


def parameters(link):
    known = {}

    def ask():
        link.mav.param_request_list_send(link.target_system, link.target_component)

    first = asked(link, "PARAM_VALUE", ask)
    known[first.param_index] = first.param_id
    until = time.time() + 10
    while len(known) < first.param_count and time.time() < until:
        value = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=1)
        if value is None:
            ask()
        else:
            known[value.param_index] = value.param_id
    assert sorted(known) == list(range(first.param_count)), known
    return known


def watched(link):
    heartbeat = link.wait_heartbeat(timeout=120)
    assert heartbeat is not None, "no heartbeat"
    while (heartbeat.get_srcSystem(), heartbeat.get_srcComponent()) != (1, 1):
        heartbeat = link.recv_match(type="HEARTBEAT", blocking=True, timeout=10)
    link.target_system, link.target_component = 1, 1
    items, known = mission(link), parameters(link)
    # An upload is declined, and so is an order.
    denied = asked(link, "MISSION_ACK", lambda: link.mav.mission_count_send(1, 1, 3))
    assert denied.type == mavutil.mavlink.MAV_MISSION_DENIED, denied
    arm = mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM
    refused = asked(link, "COMMAND_ACK", lambda: link.mav.command_long_send(1, 1, arm, 0, 1, 0, 0, 0, 0, 0, 0))
    while refused.command != arm:
        refused = link.recv_match(type="COMMAND_ACK", blocking=True, timeout=10)
    assert refused.result == mavutil.mavlink.MAV_RESULT_UNSUPPORTED, refused
    # A fence there is none: the answer is about the fence.
    fence = mavutil.mavlink.MAV_MISSION_TYPE_FENCE
    count = asked(link, "MISSION_COUNT", lambda: link.mav.mission_request_list_send(1, 1, fence))
    while count.mission_type != fence:
        count = link.recv_match(type="MISSION_COUNT", blocking=True, timeout=10)
    assert count.count == 0, count
    flown = moves(link)
    # Item 0 is the home, a jump is flown to by nobody.
    places = [item.seq for item in items[1:] if item.command == mavutil.mavlink.MAV_CMD_NAV_WAYPOINT]
    assert flown and flown <= set(places), (flown, places)
    return items, known


def moves(link):
    """Attitudes with rates that fit them, and a heading that is the yaw; the items that are flown to."""
    newest, last, worst, fastest, headings, flown = None, None, [], 0.0, 0, set()
    until = time.time() + 15
    while time.time() < until and (len(worst) < 40 or headings < 20 or not flown):
        message = link.recv_match(type=["ATTITUDE", "GLOBAL_POSITION_INT", "MISSION_CURRENT"], blocking=True, timeout=5)
        assert message is not None, "nothing is heard"
        if message.get_type() == "MISSION_CURRENT":
            flown.add(message.seq)
        elif message.get_type() == "GLOBAL_POSITION_INT":
            if newest is not None and abs(message.time_boot_ms - newest.time_boot_ms) < 300:
                off = (message.hdg / 100 - math.degrees(newest.yaw) + 180) % 360 - 180
                assert abs(off) < 15, (message, newest)
                headings += 1
        else:
            if last is not None and 50 < message.time_boot_ms - last.time_boot_ms < 300:
                seconds = 1e-3 * (message.time_boot_ms - last.time_boot_ms)
                # phi' = p + (q sin phi + r cos phi) tan theta, by the mean of both ends.
                ends = [m.rollspeed + (m.pitchspeed * math.sin(m.roll) + m.yawspeed * math.cos(m.roll)) * math.tan(m.pitch) for m in (last, message)]
                worst.append(abs((message.roll - last.roll) / seconds - sum(ends) / 2))
                fastest = max(fastest, abs(message.rollspeed), abs(message.yawspeed))
            newest = last = message
    worst.sort()
    # The attitudes have 0.1 degrees of noise, 0.14 a difference over a tenth of a second: 0.025 rad/s, and the median is less.
    assert len(worst) >= 40 and worst[len(worst) // 2] < 0.05 and fastest > 0.01, (worst, fastest)
    assert headings >= 20, headings
    return flown


def check(plumbline, folder):
    # On a grid of its own, so that places on Earth are the grid's.
    dem = (folder / "dem.asc").read_text().replace("xllcenter -1500\nyllcenter -1500", "xllcenter 598500\nyllcenter 5298500")
    (folder / "grid.asc").write_text(dem)
    (folder / "grid.prj").write_text('PROJCS["x",UNIT["metre",1],AUTHORITY["EPSG","32632"]]')
    area = "600000,5300000,600400,5300300"
    plan = [plumbline, "plan", "--dem", "grid.asc", "--area", area, "--camera", "camera.toml", "--height-m", "300"]
    plan += ["--overlap", "60/30", "--follow-terrain", "10", "--vehicle", "multirotor", "--out", "watched"]
    subprocess.run(plan, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    strips = json.loads((folder / "watched/plan.json").read_text())["strips"]
    ways = [strip["way"] if strip["heading_deg"] < 180 else strip["way"][::-1] for strip in strips]
    planned = [point for way in ways for point in way]
    for port, address in [(f"udp:127.0.0.1:{UDP}", f"udpin:127.0.0.1:{UDP}"), (f"tcp:127.0.0.1:{TCP}", f"tcp:127.0.0.1:{TCP}")]:
        listening = mavutil.mavlink_connection(address) if port.startswith("udp") else None
        flight = flying(plumbline, folder, port, ["--plan", "watched/plan.json"])
        try:
            for _ in range(240):
                if listening is not None:
                    break
                time.sleep(0.5)
                try:
                    listening = mavutil.mavlink_connection(address, retries=1)
                except OSError:
                    pass
            items, known = watched(listening)
        finally:
            flight.terminate()
            flight.wait()
        waypoints = items[1:]
        assert len(waypoints) == len(planned), (len(waypoints), len(planned))
        for item, point in zip(waypoints, planned):
            assert item.command == mavutil.mavlink.MAV_CMD_NAV_WAYPOINT and item.frame == mavutil.mavlink.MAV_FRAME_GLOBAL
            # To the 1e-7 degrees that a message has.
            assert abs(item.x * 1e-7 - point["lat"]) < 2e-7 and abs(item.y * 1e-7 - point["lon"]) < 2e-7, (item.x, item.y, point)
            assert abs(item.z - point["z"]) < 0.01, (item, point)
        assert len({point["z"] for point in planned}) > 1
        print(f"{port}: {len(items)} items and {len(known)} parameters, as planned")
    port = f"tcp:127.0.0.1:{TCP + 1}"
    flight = flying(plumbline, folder, port, ["--set", "navigation.gnss_lost_s=5", "--set", "navigation.bank_max_deg=10"])
    try:
        time.sleep(3)
        items, _ = watched(mavutil.mavlink_connection(port, retries=120))
    finally:
        flight.terminate()
        flight.wait()
    last = items[-1]
    assert (last.command, last.param1, last.param2) == (mavutil.mavlink.MAV_CMD_DO_JUMP, 1, -1), last
    # As Mission Planner keeps it.
    loader = mavwp.MAVWPLoader()
    for item in items:
        loader.add(mavutil.mavlink.MAVLink_mission_item_message(
            1, 1, item.seq, item.frame, item.command, item.current, item.autocontinue,
            item.param1, item.param2, item.param3, item.param4, item.x * 1e-7, item.y * 1e-7, item.z))
    assert loader.count() == len(items)
    print(f"{port}: {len(items)} items around the waypoints")


if __name__ == "__main__":
    check(sys.argv[1], Path(sys.argv[2]))
