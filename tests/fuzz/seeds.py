# SPDX-License-Identifier: GPL-3.0-or-later
"""Flights from which the nav target starts, in the language of fuzz_nav.c."""

import struct


def between(value: float, low: float, high: float) -> bytes:
    return struct.pack("<H", round((value - low) / (high - low) * 65535))


def number(value: float, low: float, high: float) -> bytes:
    return b"\0" + between(value, low, high)


def absurd(which: int) -> bytes:
    return bytes([14, which])


def lie(what: int, value: bytes) -> bytes:
    return bytes([0, what]) + value


def configure(what: int, value: bytes) -> bytes:
    return bytes([1, what]) + value


def command(cmd: int, x_m: float = 0.0, y_m: float = 0.0) -> bytes:
    return bytes([2, cmd]) + number(x_m, -3.3, 3.3) + number(y_m, -3.3, 3.3)


def near(beam: int, range_m: float) -> bytes:
    return bytes([3, beam]) + number(range_m, -0.1, 3.0)


def room(half_x_m: float, half_y_m: float) -> bytes:
    return bytes([4]) + between(half_x_m, 0.3, 5.0) + between(half_y_m, 0.3, 5.0)


def flip(flag: int) -> bytes:
    return bytes([5, flag])


def step(ticks: int) -> bytes:
    return b"\x08\xff" * (ticks // 256) + bytes([8, ticks % 256])


def steer(ahead: float, turn: float = 0.0) -> bytes:
    parts = (ahead, 0.0, turn, 0.1)
    return bytes([12, 0]) + b"".join(number(part, -1.2, 1.2) for part in parts)


LISTEN = bytes([7])
MAP = bytes([11, 0, 0])
TAKE_OFF, GOTO, EXPLORE, HOME, LAND, HOLD, SCAN, FORGET, RELOCALISE, SPIN = range(1, 11)
HEIGHT, BATTERY, TIME = 3, 8, 9  # of lie()
PLANNER = 11  # of configure()
CAN_FLY, LINK_ALIVE = 3, 6  # of flip()

NAV = {
    "goto": command(GOTO, 1.0, 0.7)
    + step(600)
    + LISTEN
    + command(HOME)
    + step(500)
    + command(LAND)
    + step(200)
    + LISTEN,
    "explore": configure(PLANNER, b"\1\1") + command(EXPLORE) + step(1500) + LISTEN,
    "by_hand": command(TAKE_OFF)
    + step(250)
    + (steer(0.5) + step(12)) * 20
    + (steer(-0.2, 0.8) + step(12)) * 10
    + step(100)
    + LISTEN,
    "hold": command(TAKE_OFF)
    + step(200)
    + command(HOLD)
    + step(20)
    + command(SCAN)
    + step(100)
    + command(FORGET)
    + step(100)
    + LISTEN,
    "forgotten": command(TAKE_OFF)
    + step(127)
    + command(SCAN)
    + step(101)
    + command(FORGET)
    + step(150)
    + LISTEN,
    "avoid": command(GOTO, 1.0) + step(300) + near(0, 0.1) + step(20) + room(2.0, 2.0) + step(200),
    "lost": command(GOTO, -1.0, 0.5)
    + step(260)
    + flip(LINK_ALIVE)
    + step(400)
    + flip(CAN_FLY)
    + step(5)
    + LISTEN,
    "lies": command(TAKE_OFF)
    + step(150)
    + lie(0, absurd(0))
    + step(3)
    + lie(TIME, b"\xff" * 4)
    + step(3)
    + lie(HEIGHT, absurd(3))
    + step(9)
    + LISTEN,
    "restarted": MAP * 9 + command(RELOCALISE) + step(1500) + LISTEN,
    "spin": command(SPIN) + step(600) + LISTEN,
    "high": lie(HEIGHT, absurd(10)) + step(1) + command(TAKE_OFF) + step(30) + LISTEN,
    "battery": command(EXPLORE)
    + step(300)
    + lie(BATTERY, number(3.25, 2.8, 4.2))
    + step(200)
    + lie(BATTERY, number(2.9, 2.8, 4.2))
    + step(200)
    + LISTEN,
}
