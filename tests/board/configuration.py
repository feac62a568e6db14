#!/usr/bin/env python3
"""Writes configuration and tiles as they lie in flash, by an encoder of its own (postcard:
https://postcard.jamesmunns.com/wire-format).

Usage: configuration.py OUT. A frame of 512 x 480, an opening edge and 1 ms of exposure: what the flight computer takes.
"""

import struct
import sys
import zlib


class Encoder:
    def __init__(self):
        self.bytes = bytearray()

    def unsigned(self, *values):
        for value in values:
            while value >= 0x80:
                self.bytes.append(value & 0x7F | 0x80)
                value >>= 7
            self.bytes.append(value)

    def signed(self, *values):
        self.unsigned(*(2 * value if value >= 0 else -2 * value - 1 for value in values))

    def floats(self, *values):
        self.bytes += struct.pack(f"<{len(values)}f", *values)

    def byte(self, *values):
        self.bytes += bytes(values)


def configuration():
    m = Encoder()
    m.unsigned(512, 480)
    m.floats(1.05, 0.98, 0, 0)  # fields of view, principal point
    m.byte(0, 1)  # no distortion; follow-up axis measured
    m.floats(0.1, 0, 0.05, 0, 0, 0)  # lever arm, boresight
    m.floats(0.00175, 0.0003, 0.01, 0.001, 0.002, 0.1, 0.5, 1.0, 0.1, 0.1, 15.0, 0.04)  # sigmas
    m.unsigned(5000)
    m.floats(0.05, 3.0, 0.01, 0.5)  # attitude's motions
    m.unsigned(200_000)
    m.floats(2.0, 20.0, 0.5, 5.0)  # position's
    m.unsigned(2000, 2000, 1000, 50_000)  # latencies
    m.unsigned(0)  # global shutter
    m.byte(2)  # lag
    m.unsigned(100_000, 500_000, 1_000_000, 200_000)  # limits
    m.unsigned(10)  # search
    m.byte(0)  # no patches
    m.byte(1, 1)  # stamps: the opening edge, rising
    m.signed(-10, 0)
    m.unsigned(50)
    m.floats(1.0)
    m.byte(1)
    m.unsigned(1000)
    m.floats(2.0)
    m.unsigned(300)
    m.floats(20.0, 1.0, 20.0, 0.1, 500.0, 5000.0)
    m.byte(0)  # the exposure stays
    m.byte(1, 1, 1, 0, 171)  # link: autopilot, range finder's component and any sensor of it, encoder
    m.unsigned(20_000)
    m.byte(0, 1)  # fixes in the autopilot's own message, sensor 1
    m.unsigned(500_000)
    m.floats(5.0, 0.5)
    m.byte(0, 255, 0, 0)  # sources left alone, orders of 255, no resets, no start
    return store(b"PLBM", 7, bytes(m.bytes))


def tiles(cols=200, rows=200):
    head = struct.pack("<2HfIii", cols, rows, 5.0, 32633, 480_000_000, 160_000_000)
    head += struct.pack("<12f", 74_000, 0, 0, 0, 0, 0, 111_000, 0, 0, 0, 0.01, 1.0)  # polynomials, convergence, scale
    pixels = bytes((17 * n * n >> 3) & 0xFF for n in range(cols * rows))
    return store(b"PLBT", 1, head.ljust(96, b"\0") + pixels)


def store(magic, version, payload):
    header = magic + struct.pack("<HHII", version, 0, len(payload), zlib.crc32(payload)) + bytes(12)
    return header + struct.pack("<I", zlib.crc32(header)) + payload


if __name__ == "__main__":
    with open(sys.argv[1], "wb") as out:
        # Both stores as they lie in bank 2: the configuration's sector, then the tiles'.
        out.write(configuration().ljust(128 * 1024, b"\xff") + tiles())
