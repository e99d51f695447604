# SPDX-License-Identifier: GPL-3.0-or-later
"""Updates per second: the core against CrazySLAM's Python, on the same sets of ranges.

CrazySLAM (github.com/khazit/CrazySLAM) is not part of this project: a checkout is named on the
command line, and scikit-image must be installed for it. An update is one set of four ranges with
all that it causes; the core's holds the predictions of five ticks, matching and drawing.
"""

from __future__ import annotations

import importlib
import math
import statistics
import struct
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ground.errors import GroundError
from ground.sim.footprints import Array
from tests.bench.slam.beams import BEARINGS_RAD
from tests.bench.slam.drive import HERE, drive
from tests.bench.slam.flights import Flight, make_flight
from tests.firmware.build import HERE as FIRMWARE_TESTS
from tests.firmware.build import Program, build
from tests.firmware.chip import CLOCK_HZ, Chip
from tests.firmware.replay import on_this_machine
from tests.tools.objects import CORE

PARTICLES: Final = 500
BEAMS: Final = 4
_FAR_M: Final = 4.0
_PEER_SETS: Final = 1000
_ROUNDS: Final = 3
_NOISE: Final = np.diag([1e-4, 1e-4, 1e-4])
_CORRELATION: Final = np.array([[0, -1], [-1, 10]])
_CHIP_TICKS: Final = 750
_WATCHED: Final = "drive_fly"
_PROGRAM: Final = Program(
    "drive",
    (HERE / "chip_drive.c", HERE / "drive.c", *sorted(CORE.glob("*.c"))),
    (HERE, FIRMWARE_TESTS, CORE),
)


def set_ticks(ranges_m: Array) -> NDArray[np.intp]:
    """Ticks at which a new set of ranges arrives."""
    changed = np.any(np.diff(ranges_m, axis=0) != 0.0, axis=1)
    return np.flatnonzero(changed) + 1


def _agent(folder: Path, flight: Flight) -> Any:  # noqa: ANN401
    """CrazySLAM's agent, with a map as large and as fine as ours."""
    sys.path.insert(0, str(folder))
    try:
        slam = importlib.import_module("crazyslam.slam")
        mapping = importlib.import_module("crazyslam.mapping")
    except ImportError as error:
        raise GroundError(f"--peer {folder}: {error}") from error
    finally:
        sys.path.remove(str(folder))
    fine = round(1 / flight.cell_m)
    size_m = math.ceil(128 * flight.cell_m)
    return slam.SLAM(
        mapping.init_params_dict(size=size_m, resolution=fine),
        PARTICLES,
        np.zeros(3),
        _NOISE,
        _CORRELATION,
    )


def _peer_updates(folder: Path, flight: Flight, first: int) -> Callable[[], int]:
    """Its updates over some sets of the flight; its y axis points the other way."""
    ticks = set_ticks(flight.ranges_m)[first : first + _PEER_SETS]
    poses = flight.odometry[ticks] * (1.0, -1.0, 1.0)
    ranges_m = np.where(flight.ranges_m[ticks] > 0, flight.ranges_m[ticks], _FAR_M)
    agent = _agent(folder, flight)
    bearings = np.array(BEARINGS_RAD)

    def run() -> int:
        for i in range(1, len(ticks)):
            agent.update_state(ranges_m[i], bearings, poses[i] - poses[i - 1])
        return len(ticks) - 1

    return run


def _our_updates(flight: Flight) -> Callable[[], int]:
    def run() -> int:
        drive(flight.odometry, flight.ranges_m, flight.centre_m, flight.cell_m)
        return len(set_ticks(flight.ranges_m))

    return run


def _rate_hz(run: Callable[[], int]) -> float:
    """Updates per second of this thread's processor time."""
    begin_s = time.thread_time()
    count = run()
    return count / (time.thread_time() - begin_s)


def chip_figures(flight: Flight) -> dict[str, float]:
    """The first 15 s on the emulated chip: cycles of an update, and the rate."""
    ticks = min(_CHIP_TICKS, len(flight.odometry))
    up = np.full((ticks, 1), -1.0)
    data = b"".join(
        (
            struct.pack("<3fi", *flight.centre_m, flight.cell_m, ticks),
            flight.odometry[:ticks].astype("<f4").tobytes(),
            np.hstack([flight.ranges_m[:ticks], up]).astype("<f4").tobytes(),
        )
    )
    run = Chip(build(_PROGRAM, "firmware")).run(data, (_WATCHED,))
    cycles = float(run.cycles[_WATCHED].sum()) / len(set_ticks(flight.ranges_m[:ticks]))
    return {
        "chip_update_cycles": cycles,
        "chip_hz": CLOCK_HZ / cycles,
        "chip_same_bits": float(run.output == on_this_machine(_PROGRAM, data)),
    }


def compare(folder: Path, seed: int) -> dict[str, float]:
    """Run both alternately on one flight, so that load affects both; compare medians."""
    flight = make_flight(seed, "real")
    ours = _our_updates(flight)
    ours()  # compiles
    peers = [_peer_updates(folder, flight, _PEER_SETS * i) for i in range(_ROUNDS)]
    pairs = [(_rate_hz(ours), _rate_hz(peer)) for peer in peers]
    return {
        "ours_hz": statistics.median(ours_hz for ours_hz, _ in pairs),
        "peer_hz": statistics.median(peer_hz for _, peer_hz in pairs),
        "ratio": statistics.median(ours_hz / peer_hz for ours_hz, peer_hz in pairs),
        **chip_figures(flight),
    }
