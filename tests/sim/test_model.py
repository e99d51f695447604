# SPDX-License-Identifier: GPL-3.0-or-later
"""The plant's data types have the fields of the firmware port."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from ground.sim.model import Readings, Setpoint

PORT = Path(__file__).parents[2] / "firmware_app" / "host" / "sim_port.h"


def struct_fields(name: str) -> list[str]:
    text = re.sub(r"///.*|/\*.*?\*/", "", PORT.read_text(encoding="utf-8"))
    body = next(
        b for b, n in re.findall(r"typedef struct \{(.*?)\} (\w+);", text, re.S) if n == name
    )
    names: list[str] = []
    for declaration in body.split(";"):
        _, _, rest = declaration.strip().partition(" ")
        names += [re.sub(r"\[.*\]", "", part).strip() for part in rest.split(",") if part.strip()]
    return names


@pytest.mark.parametrize(
    ("word", "struct"), [(Readings, "sim_port_sensors_t"), (Setpoint, "sim_port_setpoint_t")]
)
def test_fields_are_those_of_the_port(word: type, struct: str) -> None:
    assert [f.name for f in fields(word)] == struct_fields(struct)
