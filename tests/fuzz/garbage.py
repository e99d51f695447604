# SPDX-License-Identifier: GPL-3.0-or-later
"""Fuzzing of Python's decoders with inputs that are nearly valid.

A target is a function of a random generator: the same seed, the same nonsense. It raises where
something is accepted that should not be, or breaks. What may be refused is refused with the
exception that its user expects.
"""

from __future__ import annotations

import asyncio
import json
import logging
import struct
from collections.abc import Callable
from random import Random

from ground.core import PACKET_BYTES, WIRE_VERSION, WireType
from ground.link.logblocks import LogBlock, log_blocks
from ground.link.wire import decode_message
from ground.model import Incoming
from ground.sim.runtime import Options, Simulator
from ground.sim.world import World
from ground.sim.worldfile import read_world
from ground.station.station import Station
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet
from ground.web.frames import NOTHING, map_frame, state_frame
from ground.web.page import Page
from tests.fuzz.damaged import ODD_FLOATS, SPECIAL, map_file, recording, world
from tests.ground.fakelink import FakeLink

Target = Callable[[Random], None]
CLIENTS = (("a", 1), ("b", 2), ("c", 3))
REQUESTS = (  # port, channel, and the length of what belongs there
    (0, 0, 4), (2, 0, 3), (2, 1, 2), (2, 2, 6), (2, 3, 3), (3, 0, 14), (4, 0, 2), (4, 1, 6),
    (4, 2, 8), (5, 0, 3), (5, 1, 5), (5, 1, 29), (6, 0, 12), (6, 1, 29), (7, 0, 17), (7, 0, 15),
    (7, 1, 5), (8, 0, 15), (8, 0, 20), (9, 0, 1), (9, 1, 2), (13, 0, 2), (13, 1, 1),
    (13, 2, PACKET_BYTES), (15, 0, 9), (15, 1, 1), (15, 3, 0),
)  # fmt: skip


# --- the simulator's end of the radio ------------------------------------------------------------


def datagram(random: Random) -> bytes:
    """A request whose body has mostly small numbers, or random bytes."""
    if random.random() < 0.1:
        return random.randbytes(random.randrange(40))
    port, channel, length = random.choice(REQUESTS)
    length += random.choice((0, 0, 0, 0, -1, 1))
    small = random.random() < 0.7
    body = bytes(random.randrange(14 if small else 256) for _ in range(max(length, 0)))
    if random.random() < 0.2 and length >= 8:
        body = body[:-4] + struct.pack("<f", random.choice(ODD_FLOATS))
    return bytes((port << 4 | random.randrange(4) << 2 | channel,)) + body


def crtp(random: Random) -> None:
    """Three clients send nonsense to one drone, which keeps answering."""
    simulator = Simulator(World(read_world("empty")), Options(seed=1))
    for _ in range(400):
        simulator.deliver(random.choice(CLIENTS), datagram(random))
        if random.random() < 0.3:
            simulator.step()
        if random.random() < 0.01:
            simulator.radio.expire(simulator.time_s + random.choice((0.0, 0.5, 2.0)))
        for _, sent in simulator.outgoing():
            assert 1 <= len(sent) <= 31, sent
    simulator.deliver(CLIENTS[0], b"\xfcecho")
    assert (CLIENTS[0], b"\xfcecho") in list(simulator.outgoing())
    assert simulator.status()["app_alive"]
    simulator.radio.expire(simulator.time_s + 2.0)
    assert not simulator.radio.connected()


# --- what the ground hears -----------------------------------------------------------------------


def app_packet(random: Random) -> bytes:
    """A packet of our version and a known type, or random bytes."""
    length = random.choice((*range(2, PACKET_BYTES + 1), PACKET_BYTES))
    body = random.randbytes(length - 2)
    if random.random() < 0.5:
        body = bytes(byte % 12 for byte in body)
    return bytes((WIRE_VERSION, random.choice(list(WireType)))) + body


def log_values(random: Random, block: LogBlock) -> dict[str, float]:
    """Numbers as the types of the block's variables can hold them."""
    found: dict[str, float] = {}
    for name, kind in block.variables:
        if kind in ("float", "FP16"):
            found[name] = random.choice((*ODD_FLOATS, random.uniform(-5, 5)))
        else:
            bits = int(kind.strip("uint_"))
            found[name] = random.choice((0, 1, 2, (1 << bits) - 1, random.getrandbits(bits)))
    return found


def ground(random: Random) -> None:
    """Whatever a drone sends, the page can show what the ground makes of it."""
    station = Station(FakeLink())
    blocks = log_blocks(20)
    for _ in range(60):
        message: Incoming | None
        if random.random() < 0.5:
            message = decode_message(app_packet(random))
        else:
            block = random.choice(blocks)
            message = block.decode(random.getrandbits(24), log_values(random, block))
        if message is not None:
            station._take(message)
    text, _ = state_frame(Cockpit(station), random.choice((NOTHING, ((5, 5), (0, 10**6)))))
    json.loads(text)
    map_frame(station.picture)
    assert 0.0 <= station.picture.map.completeness <= 1.0


# --- pages ---------------------------------------------------------------------------------------


def json_value(random: Random, depth: int = 0) -> object:
    """Any JSON value, odd numbers included."""
    kinds: list[Callable[[], object]] = [
        lambda: random.choice(SPECIAL),
        lambda: random.choice(ODD_FLOATS),
        lambda: random.choice((None, True, False, "", "stop", "goto", "land", "choose")),
    ]
    if depth < 3:
        kinds.append(lambda: [json_value(random, depth + 1) for _ in range(random.randrange(3))])
        kinds.append(lambda: {"do": json_value(random, depth + 1)})
    return random.choice(kinds)()


class _Silent:
    """Stands for a browser's socket."""

    async def send_text(self, text: str) -> None:
        json.loads(text)


def wishes(random: Random) -> None:
    """Whatever a page requests is answered or ignored, and a stop is accepted."""

    async def run() -> None:
        fleet = Fleet.of(Cockpit(), Cockpit())
        page = Page(_Silent(), fleet)  # type: ignore[arg-type]
        for _ in range(20):
            wish = {key: json_value(random) for key in ("do", "x", "y", "drone", "from", "want")}
            wish["do"] = random.choice(
                (wish["do"], "goto", "choose", "self_test", "hold", "ask", "layers")
            )
            await page._take(json.loads(json.dumps(wish)))
        await asyncio.gather(*page._commands)
        await page._take({"do": "stop"})
        assert all(cockpit.stop_latched for cockpit in fleet.cockpits)
        await fleet.close()

    logging.disable()
    try:
        asyncio.run(run())
    finally:
        logging.disable(logging.NOTSET)


TARGETS: dict[str, Target] = {
    target.__name__: target for target in (crtp, ground, wishes, recording, map_file, world)
}
