# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters are refused or accepted as a whole, and clients can see which."""

import math
import re
from pathlib import Path

import pytest

from ground.core import MissionCmd, MissionReason, MissionState
from tests.app.drone import Drone

FLOATS = [
    "height",
    "speed",
    "clearance",
    "yawRate",
    "areaX0",
    "areaY0",
    "areaX1",
    "areaY1",
    "lostTime",
    "lowBat",
    "cell",
    "lookAge",
    "lookWidth",
    "yield",
    "watch",
    "turns",
]
BYTES = ["yawMode", "planner", "slam", "lost", "frontier"]
BAD = [(name, value) for name in FLOATS for value in (math.nan, math.inf, -1e30, 1e30)]
BAD += [(name, 200) for name in BYTES]
BAD += [("height", 0.0), ("speed", -0.1), ("clearance", 0.0), ("cell", 0.0), ("lowBat", 0.0)]
GOOD = [
    ("height", 0.8),
    ("speed", 0.25),
    ("clearance", 0.2),
    ("yawMode", 2),
    ("yawRate", -30.0),
    ("planner", 1),
    ("slam", 1),
    ("areaX0", -2.0),
    ("areaY1", 2.5),
    ("lost", 3),
    ("frontier", 2),
    ("lostTime", 2.5),
    ("lowBat", 3.5),
    ("cell", 0.1),
    ("lookAge", 5.0),
    ("lookWidth", 0.2),
    ("yield", 0.0),
    ("watch", 60.0),
    ("turns", -3.0),
]


@pytest.mark.parametrize(("name", "value"), BAD)
def test_a_bad_value_is_refused_and_reads_back_unchanged(
    drone: Drone, name: str, value: float
) -> None:
    before = drone.param(f"way.{name}")
    drone.write(f"way.{name}", value)
    drone.run(0.1)
    assert drone.param(f"way.{name}") == before
    assert drone.updates() == [f"way.{name}"]
    assert f"way.{name} refused" in drone.console()


@pytest.mark.parametrize(("name", "value"), GOOD)
def test_a_good_value_stays(drone: Drone, name: str, value: float) -> None:
    drone.write(f"way.{name}", value)
    drone.run(0.1)
    assert drone.param(f"way.{name}") == pytest.approx(value)
    assert drone.updates() == []


def documented_ranges() -> list[tuple[str, float, float]]:
    """Name, lowest and highest value, as the doc comments tell the user."""
    text = (Path(__file__).parents[2] / "firmware_app/app/app_params.c").read_text()
    range_of = r"(-?[\d.]+) to (-?[\d.]+) \[.+\]\n \*/\nPARAM_ADD\w+\([^,]+, (\w+),"
    return [(name, float(low), float(high)) for low, high, name in re.findall(range_of, text)]


@pytest.mark.parametrize(("name", "low", "high"), documented_ranges())
def test_the_documented_range_is_the_range(
    drone: Drone, name: str, low: float, high: float
) -> None:
    for value in (low, high):
        drone.write(f"way.{name}", value)
        drone.run(0.1)
        assert drone.param(f"way.{name}") == pytest.approx(value)
    for value in (low - 0.01, high + 0.01):
        drone.write(f"way.{name}", value)
        drone.run(0.1)
        assert drone.param(f"way.{name}") == pytest.approx(high)


def test_every_number_has_a_documented_range() -> None:
    assert {name for name, _, _ in documented_ranges()} == set(FLOATS)


def test_a_bad_value_does_not_take_good_ones_with_it(drone: Drone) -> None:
    drone.write("way.speed", 0.3)
    drone.write("way.height", math.nan)
    drone.write("way.planner", 1)
    drone.run(0.1)
    assert drone.param("way.speed") == pytest.approx(0.3)
    assert drone.param("way.planner") == 1
    assert drone.updates() == ["way.height"]


def test_absurd_stored_values_are_replaced_at_start() -> None:
    drone = Drone()
    drone.force("way.speed", math.nan)
    drone.force("way.height", 0.7)
    drone.boot()
    assert drone.param("way.speed") == drone.default("way.speed")
    assert drone.param("way.height") == pytest.approx(0.7)


def test_the_flight_height_is_the_one_asked_for(drone: Drone) -> None:
    drone.write("way.height", 0.7)
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK
    drone.run_until(MissionState.HOVER)
    assert drone.readings.z_m == pytest.approx(0.7, abs=0.07)


def test_a_height_that_was_refused_is_not_flown(drone: Drone) -> None:
    drone.write("way.height", 9.0)
    drone.run(0.1)
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK
    drone.run_until(MissionState.HOVER)
    assert drone.readings.z_m == pytest.approx(drone.default("way.height"), abs=0.07)


def test_cmd_reads_zero_once_taken_and_clients_are_told(drone: Drone) -> None:
    drone.write("way.cmd", MissionCmd.TAKE_OFF)
    assert drone.param("way.cmd") == MissionCmd.TAKE_OFF
    drone.run(0.1)
    assert drone.param("way.cmd") == 0
    assert drone.updates() == ["way.cmd"]
    assert drone.state is MissionState.TAKEOFF


@pytest.mark.parametrize(
    ("cmd", "reason", "words"),
    [
        (99, MissionReason.UNKNOWN_COMMAND, "unknown command"),
        (MissionCmd.LAND, MissionReason.NOT_FLYING, "only while flying"),
        (MissionCmd.HOME, MissionReason.NOT_FLYING, "only while flying"),
    ],
)
def test_a_refused_command_says_why(
    drone: Drone, cmd: int, reason: MissionReason, words: str
) -> None:
    drone.write("way.cmd", cmd)
    drone.run(0.1)
    assert drone.refused is reason
    assert drone.param("way.cmd") == 0
    assert f"command {int(cmd)} refused: {words}\n" in drone.console()


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ((math.nan, 0.0), MissionReason.BAD_VALUE),
        ((0.0, math.inf), MissionReason.BAD_VALUE),
        ((40.0, 0.0), MissionReason.OUTSIDE_GRID),
    ],
)
def test_a_goal_that_is_none_is_refused_at_once(
    drone: Drone, goal: tuple[float, float], reason: MissionReason
) -> None:
    assert drone.command(MissionCmd.GOTO, goal) is reason
    assert drone.state is MissionState.IDLE


def test_the_answer_to_a_good_command_clears_the_refusal(drone: Drone) -> None:
    assert drone.command(MissionCmd.LAND) is MissionReason.NOT_FLYING
    assert drone.command(MissionCmd.TAKE_OFF) is MissionReason.OK
