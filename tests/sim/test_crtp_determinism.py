# SPDX-License-Identifier: GPL-3.0-or-later
"""Same seed and same packets at the same times: same flight, and same bytes sent."""

import struct

from ground.sim.runtime import Options, Simulator
from ground.sim.trouble import TroubleSpec
from ground.sim.world import load_world
from tests.sim.crtp_client import packet

ADDRESS = ("client", 1)
TAKE_OFF_AT, STEPS = 60, 900


def fly(seed: int, loss: float = 0.0, world: str = "flat") -> tuple[list[bytes], object]:
    """Nine seconds with three log blocks: all that was sent, and the final pose."""
    options = Options(seed=seed, trouble=TroubleSpec(loss, loss, loss))
    simulator = Simulator(load_world(world), options)
    simulator.deliver(ADDRESS, packet(2, 0, b"\3"))
    ((_, info),) = simulator.outgoing()
    (count,) = struct.unpack_from("<H", info, 2)
    for identity in range(count):
        simulator.deliver(ADDRESS, packet(2, 1, struct.pack("<H", identity)))
    for block in range(3):
        variables = b"".join(struct.pack("<BH", 7, 6 * block + i) for i in range(6))
        simulator.deliver(ADDRESS, packet(5, 1, bytes((6, block)) + variables))
        simulator.deliver(ADDRESS, packet(5, 1, bytes((3, block, 1 + block))))
    sent: list[bytes] = []
    for step in range(STEPS):
        if step >= TAKE_OFF_AT and step % 10 == 0:
            hover = struct.pack("<B4f", 10, 0.2, 0.0, 20.0, 0.4)
            simulator.deliver(ADDRESS, packet(7, 0, hover))
        simulator.step()
        sent += (datagram for _, datagram in simulator.outgoing())
    return sent, simulator.status()["true_pose"]


def test_same_seed_same_bytes() -> None:
    first, second = fly(3), fly(3)
    assert first == second
    assert len(first[0]) > 1000 and first[1] != fly(4)[1]


def test_trouble_is_repeatable_too() -> None:
    whole, (lossy, pose) = fly(3)[0], fly(3, loss=0.1)
    assert (lossy, pose) == fly(3, loss=0.1)
    assert 0.8 * len(whole) < len(lossy) < 1.1 * len(whole)
    assert sorted(set(lossy)) != sorted(set(whole))
