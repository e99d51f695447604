# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of faults by name, and what each does to the simulated drone."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from ground.sim.broken import Broken
from ground.sim.firmware import Firmware
from ground.sim.flightstack import FlightStack
from ground.sim.hearing import numbers_of
from ground.sim.params import Params
from ground.sim.plant import Plant
from ground.sim.radio import Radio
from ground.sim.ranger import BEAMS
from ground.sim.trouble import TroubleSpec
from ground.sim.world import World
from ground.sim.worldspec import Obstacle, Point

_RUNAWAY_MPS2: Final = 0.3
_STEP_M: Final = 0.15
_JUMP_M: Final = 1.0
_LATE_MS: Final = 300
_SHARE: Final = 0.3
_SAG_V: Final = 0.6
_LOW_CHARGE: Final = 0.12
_CARRIED_M: Final = (0.7, 2.0)
_HELD_M: Final = 0.6
_BOX_M: Final = 0.25
_CELL_M: Final = 0.6
_NEAREST_M: Final = 0.5
_TOP_M: Final = 2.0
_DIRECTIONS: Final = 16


@dataclass(frozen=True, slots=True)
class Bench:
    """What faults may act on."""

    world: World
    plant: Plant
    firmware: Firmware
    stack: FlightStack
    params: Params
    radio: Radio


End = Callable[[], None]
Begin = Callable[[Bench, float], End]


@dataclass(frozen=True, slots=True)
class Fault:
    """One entry of the table; begin() starts the fault and returns what ends it."""

    what: str
    begin: Begin
    seconds: float = math.inf
    """How long it lasts unless told otherwise."""
    lasts: bool = True
    """Whether it can end; otherwise it happens once, and the drone must cope."""


def _once(act: Callable[[Bench], None]) -> Begin:
    def begin(bench: Bench, seconds: float) -> End:
        act(bench)
        return lambda: None

    return begin


def _beams(kind: str, *beams: int) -> Begin:
    """Break beams: `kind` is frozen, dead or short."""

    def begin(bench: Bench, seconds: float) -> End:
        broken: set[int] = getattr(bench.plant.broken, f"{kind}_beams")
        broken.update(beams)
        return lambda: broken.difference_update(beams)

    return begin


def _sensors(**values: float | bool) -> Begin:
    """Set fields of Broken, and restore them at the end."""
    sound = Broken()

    def begin(bench: Bench, seconds: float) -> End:
        def put(source: dict[str, float | bool]) -> None:
            for name, value in source.items():
                setattr(bench.plant.broken, name, value)

        put(values)
        return lambda: put({name: getattr(sound, name) for name in values})

    return begin


def _deck_gone(deck: str, blind: Begin) -> Begin:
    """Remove a deck: before the app boots it is not detected, later its driver blocks for ever."""

    def begin(bench: Bench, seconds: float) -> End:
        identity = bench.params.find(f"deck.{deck}")
        if identity is not None and not bench.firmware.alive():
            bench.firmware.param_force(identity, b"\0")
        return blind(bench, seconds)

    return begin


def _trouble(spec: TroubleSpec) -> Begin:
    def begin(bench: Bench, seconds: float) -> End:
        before = bench.radio.trouble
        bench.radio.trouble = spec
        return lambda: setattr(bench.radio, "trouble", before)

    return begin


def _late(bench: Bench, seconds: float) -> End:
    bench.radio.late_ms = _LATE_MS
    return lambda: setattr(bench.radio, "late_ms", 0)


def _silent(bench: Bench, seconds: float) -> End:
    bench.radio.silent = True
    return lambda: setattr(bench.radio, "silent", False)


def _sag(bench: Bench, seconds: float) -> End:
    bench.plant.battery.sag_v = _SAG_V
    return lambda: setattr(bench.plant.battery, "sag_v", 0.0)


def _drain(charge: float) -> Begin:
    def act(bench: Bench) -> None:
        bench.plant.battery.charge = min(bench.plant.battery.charge, charge)

    return _once(act)


def _stall(bench: Bench, seconds: float) -> End:
    bench.firmware.stall(round(1000 * seconds))
    return lambda: None


def _carry(bench: Bench, seconds: float) -> End:
    """Carry the drone where there is most room and hold it there; at the end let it go."""
    x_m, y_m, z_m = bench.plant.truth.position_m
    angles = np.arange(_DIRECTIONS) * math.tau / _DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles), np.zeros(_DIRECTIONS)], axis=1)
    room_m = bench.world.cast((x_m, y_m, _HELD_M), ways, 2 * _CARRIED_M[1]).distance_m
    way = int(np.argmax(np.minimum(room_m, 2 * _CARRIED_M[1])))
    by_m = min(float(room_m[way]) - _NEAREST_M, _CARRIED_M[1])
    by_m = max(by_m, 0.0) if room_m[way] < _CARRIED_M[0] + _NEAREST_M else by_m
    x_m, y_m = x_m + by_m * ways[way][0], y_m + by_m * ways[way][1]
    bench.plant.carry(x_m, y_m, max(_HELD_M, z_m))
    return lambda: bench.plant.let_go(z_m)


def _box(name: str, center_m: Point, half_m: Point) -> Obstacle:
    return Obstacle(name, center_m, half_m, 0.0, 0.0, 0.0, _TOP_M)


def _put(bench: Bench, boxes: tuple[Obstacle, ...]) -> End:
    bench.world.put(boxes)
    return lambda: bench.world.take_away(boxes, bench.plant.time_s)


def _wall_in(bench: Bench, seconds: float) -> End:
    """Build a cell around the drone that leaves room to hover."""
    x_m, y_m, _ = bench.plant.truth.position_m
    long_m, thick_m = _CELL_M + 0.1, 0.05
    sides = (
        _box("cell", (x_m + _CELL_M, y_m), (thick_m, long_m)),
        _box("cell", (x_m - _CELL_M, y_m), (thick_m, long_m)),
        _box("cell", (x_m, y_m + _CELL_M), (long_m, thick_m)),
        _box("cell", (x_m, y_m - _CELL_M), (long_m, thick_m)),
    )
    return _put(bench, sides)


def _block_goal(bench: Bench, seconds: float) -> End:
    """Put a box at the drone's goal, unless the drone is there already."""
    logs = numbers_of(bench.firmware.log_entries())
    goal = (
        struct.unpack("<f", bench.firmware.log_read(logs[name], 7, bench.firmware.now_ms()))[0]
        for name in ("way.goalX", "way.goalY")
    )
    goal_m: Point = bench.world.to_world(*goal)
    here_m = bench.plant.truth.position_m[:2]
    if math.dist(goal_m, here_m) < _BOX_M + _NEAREST_M:
        return lambda: None
    return _put(bench, (_box("blocker", goal_m, (_BOX_M, _BOX_M)),))


_ALL_BEAMS: Final = tuple(range(len(BEAMS)))

FAULTS: Final[dict[str, Fault]] = {
    "ranges-frozen": Fault("no range changes any more", _beams("frozen", *_ALL_BEAMS)),
    "ranges-dead": Fault("no range sensor answers", _beams("dead", *_ALL_BEAMS)),
    "ranges-short": Fault("far ranges are reported as near", _beams("short", *_ALL_BEAMS)),
    **{
        f"{beam}-{kind}": Fault(f"the sensor {beam} {what}", _beams(kind, number))
        for number, beam in enumerate(BEAMS)
        for kind, what in (
            ("frozen", "repeats its last range"),
            ("dead", "does not answer"),
            ("short", "reports far ranges as near"),
        )
    },
    "map-full": Fault("far ranges are random, to fill the map", _sensors(scattered=True)),
    "ranger-gone": Fault(
        "the Multi-ranger falls off",
        _deck_gone("bcMultiranger", _beams("frozen", *_ALL_BEAMS)),
    ),
    "flow-gone": Fault(
        "the Flow deck falls off: neither flow nor height",
        _deck_gone("bcFlow2", _sensors(flow=True, height=True)),
    ),
    "flow-lost": Fault("the floor is too dark or shiny for flow", _sensors(flow=True)),
    "box": Fault("something below is nearer than the floor", _sensors(step_m=_STEP_M), 2.0),
    "estimate-jumps": Fault(
        "the position estimate jumps",
        _once(lambda bench: bench.plant.jump_estimate(_JUMP_M, 0.0)),
        lasts=False,
    ),
    "estimate-diverges": Fault(
        "the estimated velocity runs away", _sensors(runaway_mps2=_RUNAWAY_MPS2)
    ),
    "kidnapped": Fault("a hand carries it elsewhere", _carry, 2.0),
    "tumbled": Fault(
        "it is hit and turns over", _once(lambda bench: bench.plant.tumble()), lasts=False
    ),
    "e-stop": Fault(
        "somebody presses the emergency stop",
        _once(lambda bench: bench.stack.emergency_stop()),
        lasts=False,
    ),
    "ground-silent": Fault("nothing gets through by radio", _silent),
    "packets-lost": Fault("packets get lost", _trouble(TroubleSpec(loss=_SHARE))),
    "packets-doubled": Fault("packets come twice", _trouble(TroubleSpec(duplication=_SHARE))),
    "packets-reordered": Fault("packets change places", _trouble(TroubleSpec(reorder=_SHARE))),
    "packets-late": Fault("packets are late", _late),
    "battery-sag": Fault("the battery voltage sags", _sag),
    "battery-low": Fault("the battery is nearly empty", _drain(_LOW_CHARGE), lasts=False),
    "battery-empty": Fault("the battery is empty", _drain(0.0), lasts=False),
    "time-jump": Fault("the app gets no CPU time", _stall, 1.0, lasts=False),
    "goal-blocked": Fault("something stands at its goal", _block_goal),
    "walled-in": Fault("walls are put up around it", _wall_in),
}
"""Faults by name, as --help and the console list them."""
