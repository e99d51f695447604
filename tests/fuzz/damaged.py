# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged files, and intact ones that make no sense: recordings, maps, worlds."""

from __future__ import annotations

import asyncio
import io
import math
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from ground.errors import GroundError
from ground.map.files import load_map, save_map
from ground.map.groundmap import GroundMap
from ground.record.reader import read_session
from ground.record.recorder import RecordedLink
from ground.sim.world import World
from ground.sim.worldfile import WORLDS_DIR, read_world
from ground.station.picture import Picture
from tests.ground.fakelink import FakeLink
from tests.ground.stations import telemetry

SPECIAL = (0, 1, -1, 7, 127, 128, 255, 256, 32767, 65535, 2**31, -(2**31), 2**32 - 1, 10**400)
ODD_FLOATS = (math.nan, math.inf, -math.inf, 0.0, -0.0, 1e-45, 1e38, 1e9, -1.0)


def mutated(random: Random, data: bytes) -> bytes:
    """Change, remove, duplicate or insert some bytes."""
    found = bytearray(data)
    for _ in range(random.choice((1, 1, 2, 5, 20))):
        at = random.randrange(len(found) + 1)
        match random.randrange(5):
            case 0:
                found[at : at + 1] = bytes((random.randrange(256),))
            case 1:
                del found[at : at + random.choice((1, 4, 100))]
            case 2:
                found[at:at] = found[at : at + random.choice((1, 4, 100))]
            case 3:
                found[at:at] = random.randbytes(random.choice((1, 4)))
            case _ if at < len(found):
                found[at] ^= 1 << random.randrange(8)
    return bytes(found)


# --- files ---------------------------------------------------------------------------------------


@cache
def a_recording() -> bytes:
    async def write(path: Path) -> None:
        link = FakeLink()
        recorded = RecordedLink(link, path)
        await recorded.open()
        for drone_ms in range(3):
            link.say(telemetry(drone_ms, Picture().state))
        reader = aiter(recorded.messages())
        for _ in range(4):
            await anext(reader)
        await recorded.close()

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mcap"
        asyncio.run(write(path))
        return path.read_bytes()


@cache
def a_map() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.npz"
        save_map(GroundMap(), path)
        return path.read_bytes()


def _in_file(name: str, data: bytes, read: Callable[[Path], object]) -> None:
    with tempfile.TemporaryDirectory(prefix="wayflie-fuzz-") as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        try:
            read(path)
        except GroundError as error:
            assert str(error).strip()


def recording(random: Random) -> None:
    """A damaged recording only ends early."""
    data = mutated(random, a_recording())
    _in_file("flight.mcap", data, read_session)


def odd_map(random: Random) -> bytes:
    """An intact file with arrays that make no sense."""
    grid = GroundMap()
    arrays: dict[str, Any] = {
        "states": grid.states,
        "obstacles_m": grid.obstacles_m(),
        "cell_m": np.array(grid.cell_m),
        "origin_m": np.array((-3.2, -3.2)),
    }
    for _ in range(random.choice((1, 2))):
        name = random.choice(list(arrays))
        shape = random.choice(((), (1,), (2,), (3,), (2, 2), (0, 2), (5, 2), (128, 128), (2, 128)))
        kind = random.choice(("f8", "f4", "i1", "u1", "i8", "U3", "?", "c16"))
        value = random.choice((*ODD_FLOATS, 0.05, 1.0, 2.0)) if kind[0] in "fc" else 1
        arrays[name] = np.full(shape, value, kind)
    kept = io.BytesIO()
    np.savez(kept, **arrays)
    return kept.getvalue()


def map_file(random: Random) -> None:
    """A file that is no valid map is refused."""
    data = odd_map(random) if random.random() < 0.5 else mutated(random, a_map())
    _in_file("map.npz", data, load_map)


@cache
def worlds() -> tuple[str, ...]:
    return tuple(path.read_text() for path in sorted(WORLDS_DIR.glob("*.toml")))


def world(random: Random) -> None:
    """A world file is refused, or can be built."""
    lines = random.choice(worlds()).splitlines()
    for _ in range(random.choice((1, 2, 8))):
        at = random.randrange(len(lines))
        key, equals, value = lines[at].partition(" = ")
        match random.randrange(5):
            case 0 if equals:
                lines[at] = f"{key} = {random.choice((*SPECIAL[:-1], *ODD_FLOATS, '[]', '{}'))}"
            case 1:
                lines[at] = random.choice(lines)
            case 2:
                del lines[at : at + random.choice((1, 5))]
                lines.append("")
            case 3 if equals:
                lines[at] = f"{random.choice(lines).partition(' = ')[0]} = {value}"
            case _:
                damaged = mutated(random, lines[at].encode())
                lines[at] = damaged.decode("latin-1").replace("\n", "")
    data = "\n".join(lines).encode("utf-8", "surrogateescape")
    _in_file("room.toml", data, lambda path: World(read_world(path)))
