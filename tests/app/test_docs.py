# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables in DESIGN.md agree with the source, and with what a client is told."""

import pytest

from ground.docparams import Variable, log_variables, map_variables, parameters
from ground.sim.process import SimulatorProcess
from tests.sim.crtp_client import RawClient
from tests.tools.docs import DESIGN, renewed
from tests.tools.elf_tables import EXTENDED, LOG_TYPES, PARAM_TYPES, READ_ONLY, TYPE_MASK

PARAM, LOG = 2, 5


def test_the_tables_are_current() -> None:
    """If not, `make docs` updates them."""
    text = DESIGN.read_text()
    assert renewed(text) == text
    assert renewed(text.replace("| `height` | float |", "| `height` | uint8 |")) == text
    with pytest.raises(ValueError, match="marks"):
        renewed("# no marks\n")


def test_a_running_drone_tells_the_same_names_types_and_access() -> None:
    with (
        SimulatorProcess("--world", "empty") as simulator,
        RawClient(simulator.uri) as client,
    ):
        params, logs = client.toc(PARAM), client.toc(LOG)
    told = {
        name.removeprefix("way."): (
            PARAM_TYPES[kind & TYPE_MASK],
            bool(kind & EXTENDED),
            bool(kind & READ_ONLY),
        )
        for name, (_, kind) in params.items()
        if name.startswith("way.")
    }
    assert told == {name: (one.type, one.stored, False) for name, one in parameters().items()}
    for group, documented in (("way", log_variables()), ("waymap", map_variables())):
        assert _types(logs, group) == {name: one.type for name, one in documented.items()}


def _types(table: dict[str, tuple[int, int]], group: str) -> dict[str, str]:
    prefix = f"{group}."
    return {
        name.removeprefix(prefix): LOG_TYPES[kind & TYPE_MASK]
        for name, (_, kind) in table.items()
        if name.startswith(prefix)
    }


def test_every_variable_has_something_to_say() -> None:
    every: list[Variable] = [*parameters().values(), *log_variables().values()]
    assert all(len(one.help) > 5 for one in every)
