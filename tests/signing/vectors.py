#!/usr/bin/env python3
"""Signed MAVLink 2 messages and what becomes of them, as pymavlink has it and as Python's hashlib has it.

Usage: vectors.py FILE writes the vectors; vectors.py --check FILE compares them with a file.

`sent`: messages that pymavlink signs with the key, and that our encoder has to sign alike. `received`: messages in the order in
which they come to a receiver with the key and its time, each with pymavlink's verdict and the reason that we should give. A
message that is forged never has the newest time of its stream: pymavlink takes a stream's time before it has checked the
signature, and would refuse what follows. `by_hand`: one message with each part written out, by hashlib alone.
"""

import hashlib
import io
import json
import logging
import struct
import sys

from pymavlink.dialects.v20 import common as mavlink

logging.disable(logging.CRITICAL)

KEY = hashlib.sha256(b"plumbline signing vectors").digest()
OTHER = hashlib.sha256(b"another key").digest()
NOW = 4018 * 86400 * 100_000  # 2026-01-01 in units of 10 us since 2015-01-01
MINUTE = 60 * 100_000


def speaker(key, system, component, link=0, stamp=NOW):
    mav = mavlink.MAVLink(io.BytesIO(), srcSystem=system, srcComponent=component)
    if key is not None:
        mav.signing.secret_key = key
        mav.signing.link_id = link
        mav.signing.timestamp = stamp
        mav.signing.sign_outgoing = True
    return mav


def heartbeat(mav):
    return bytes(mav.heartbeat_encode(1, 3, 0x80, 0, 4, 3).pack(mav))


def attitude(mav, ms):
    return bytes(mav.attitude_quaternion_encode(ms, 1.0, 0.25, -0.5, 0.125, 0.0, 0.0, 0.0).pack(mav))


def sent():
    mav = speaker(KEY, 1, 154, stamp=NOW + 1)
    messages = [
        mav.heartbeat_encode(mavlink.MAV_TYPE_GIMBAL, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 3, 3),
        mav.camera_trigger_encode(123_456_789_012, 77),
        mav.encapsulated_data_encode(7, bytes((n * n) & 0xFF for n in range(253))),
    ]
    packed = []
    for mav.seq, message in enumerate(messages):
        packed.append(bytes(message.pack(mav)).hex())
    return {"key": KEY.hex(), "stamp": NOW, "messages": packed}


def received():
    autopilot, encoder = speaker(KEY, 1, 1), speaker(KEY, 1, 171, link=3, stamp=NOW - MINUTE)
    unsigned, thief = speaker(None, 1, 1), speaker(OTHER, 1, 1)
    late = speaker(KEY, 2, 7, stamp=NOW - MINUTE - 1000)
    first, second = heartbeat(autopilot), attitude(autopilot, 1)
    third = attitude(autopilot, 2)
    # Its checksum is right: it covers no byte of the signature.
    forged = third[:-1] + bytes([third[-1] ^ 1])
    moved = third[:-13] + bytes([1]) + third[-12:]
    cases = [
        (unsigned.heartbeat_encode(1, 3, 0x80, 0, 4, 3).pack(unsigned), "Unsigned"),
        (heartbeat(thief), "Wrong"),
        (late.heartbeat_encode(1, 3, 0, 0, 4, 3).pack(late), "Late"),
        (attitude(encoder, 5), "Taken"),
        (second, "Taken"),
        (second, "Replayed"),
        (first, "Replayed"),
        (moved, "Wrong"),
    ]
    # pymavlink would remember these times: it is not asked for what comes behind them.
    cases += [(third, "Taken"), (forged, "Wrong"), (third, "Replayed")]
    listener = speaker(KEY, 255, 190, stamp=NOW)
    messages = []
    for data, verdict in cases:
        taken = is_taken(listener, bytes(data))
        assert taken == (verdict == "Taken"), (verdict, taken)
        messages.append({"bytes": bytes(data).hex(), "verdict": verdict, "pymavlink_takes": taken})
    return {"key": KEY.hex(), "stamp": NOW, "messages": messages}


def is_taken(listener, data):
    listener.robust_parsing = True
    parsed = listener.parse_char(data)
    assert parsed is not None
    return parsed.get_type() != "BAD_DATA"


def by_hand():
    """A HEARTBEAT, by the specification's own words: https://mavlink.io/en/guide/message_signing.html."""
    payload = struct.pack("<IBBBBB", 0, 1, 3, 0x80, 4, 3)
    header = bytes([0xFD, len(payload), 1, 0, 9, 1, 1, 0, 0, 0])
    message = header + payload
    message += struct.pack("<H", crc(message[1:] + bytes([50])))  # CRC_EXTRA of HEARTBEAT
    tail = bytes([2]) + (NOW + 5).to_bytes(6, "little")
    signature = hashlib.sha256(KEY + message + tail).digest()[:6]
    return {"key": KEY.hex(), "message": (message + tail + signature).hex(), "link": 2, "stamp": NOW + 5}


def crc(data):
    """CRC-16/MCRF4XX."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
    return value


def vectors():
    return json.dumps({"sent": sent(), "received": received(), "by_hand": by_hand()}, indent=1) + "\n"


if __name__ == "__main__":
    if sys.argv[1] == "--check":
        with open(sys.argv[2], encoding="ascii") as committed:
            if committed.read() != vectors():
                sys.exit(f"{sys.argv[2]} is not what pymavlink makes now")
    else:
        with open(sys.argv[1], "w", encoding="ascii") as out:
            out.write(vectors())
