# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters as the doc comments of the C source describe them, against the firmware itself."""

import pytest

from ground.docparams import Variable, log_variables, parameters
from ground.web.parameters import GROUPS
from tests.app.drone import Drone

COMMANDS = {"cmd", "goalX", "goalY"}


def test_every_parameter_of_the_app_is_documented_with_its_default() -> None:
    drone = Drone().boot()
    names = {name.removeprefix("way.") for name in drone.params if name.startswith("way.")}
    assert set(parameters()) == names
    for name, entry in parameters().items():
        assert entry.help
        assert entry.default == pytest.approx(drone.default(f"way.{name}"))
    logged = {name.removeprefix("way.") for name in drone.logs if name.startswith("way.")}
    assert set(log_variables()) == logged


def test_every_parameter_that_can_be_tuned_stands_in_one_group() -> None:
    grouped = [name for names in GROUPS.values() for name in names]
    assert sorted(grouped) == sorted(set(parameters()) - COMMANDS)


TUNABLE = [one for name, one in parameters().items() if name not in COMMANDS | {"selftest"}]


@pytest.fixture(scope="module")
def drone() -> Drone:
    return Drone().boot()


@pytest.mark.parametrize("entry", TUNABLE, ids=lambda entry: entry.name)
def test_the_drone_takes_just_the_range_that_is_documented(drone: Drone, entry: Variable) -> None:
    assert entry.low is not None
    assert entry.high is not None
    name = f"way.{entry.name}"
    step = 1.0 if entry.type == "uint8" else 0.01
    for value, taken in (
        (entry.low, True),
        (entry.high, True),
        (entry.high + step, False),
        (entry.low - step, False),
    ):
        if value < 0 and entry.type == "uint8":
            continue
        drone.write(name, value)
        drone.run(0.1)
        assert (drone.param(name) == pytest.approx(value)) is taken
    drone.write(name, entry.default)
    drone.run(0.1)
