# SPDX-License-Identifier: GPL-3.0-or-later
"""Families of kidnappings: in homes as mapped, or changed, and where the map knows nothing."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from tests.bench.reloc.homes import ALIKE, KINDS, make_alike, make_home, rearranged, shut
from tests.bench.reloc.kidnappings import Known, Outcome, Scene, kidnap, make_known, plain
from tests.bench.slam.routes import Lattice

PROFILE: Final = "real"
HOMES: Final = "homes"
A_HOME: Final = 4
"""Kidnappings in one home."""
_MOVED_SHARE: Final = 0.3

_Made = tuple[Known, Iterator[tuple[Scene, np.random.Generator]]]


def _rng(*seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def _home(one: int) -> Known:
    rng = _rng(one, 0)
    return make_known(make_home(KINDS[one % len(KINDS)], rng), PROFILE, rng)


def _as_mapped(one: int) -> _Made:
    known = _home(one)
    return known, ((plain(known.room), _rng(one, k)) for k in range(1, A_HOME + 1))


def _with_people(one: int) -> _Made:
    known = _home(one)
    scene = Scene(known.room, Lattice(known.room).points, people=2)
    return known, ((scene, _rng(one, 10, k)) for k in range(A_HOME))


def _rearranged(one: int) -> _Made:
    known = _home(one)
    rngs = (_rng(one, 20, k) for k in range(A_HOME))
    return known, ((plain(rearranged(known.room, _MOVED_SHARE, rng)), rng) for rng in rngs)


def _unmapped(one: int) -> _Made:
    """Behind a door that was shut while mapping, and is now open or still shut."""
    rng = _rng(one, 30)
    room = make_home(KINDS[1 + one % 2], rng)
    closed, wall_x_m = shut(room)
    known = make_known(closed, PROFILE, rng)
    mapped_right = Lattice(closed).points[0, 0] > wall_x_m

    points = Lattice(room).points
    behind = points[(points[:, 0] > wall_x_m) != mapped_right]
    count = A_HOME if len(behind) else 0  # nobody fits through some doors
    scenes = (Scene((room, closed)[k % 2], behind) for k in range(count))
    return known, ((scene, _rng(one, 31, k)) for k, scene in enumerate(scenes))


def _elsewhere(one: int) -> _Made:
    """In a home that the map does not contain."""
    known = _home(one)

    def scene(rng: np.random.Generator) -> Scene:
        other = make_home(KINDS[rng.integers(len(KINDS))], rng)
        return Scene(other, Lattice(other).points, on_map=False)

    rngs = (_rng(one, 40, k) for k in range(A_HOME))
    return known, ((scene(rng), rng) for rng in rngs)


def _alike(one: int) -> _Made:
    """In places that cannot be told apart."""
    rng = _rng(one, 100)
    known = make_known(make_alike(ALIKE[one % len(ALIKE)], rng), PROFILE, rng)
    return known, iter([(plain(known.room), rng)])


FAMILIES: Final[dict[str, Callable[[int], _Made]]] = {
    HOMES: _as_mapped,
    "people": _with_people,
    "rearranged": _rearranged,
    "alike": _alike,
    "unmapped": _unmapped,
    "elsewhere": _elsewhere,
}
NOWHERE: Final = ("unmapped", "elsewhere")
"""Where the map does not know the place."""


def kidnapped(family: str, seed: int, count: int) -> list[Outcome]:
    """So many kidnappings of a family, counting seeds up from the first."""
    found: list[Outcome] = []
    for one in itertools.count(seed):
        if len(found) >= count:
            break
        known, scenes = FAMILIES[family](one)
        found += [kidnap(known, scene, PROFILE, rng) for scene, rng in scenes]
    return found[:count]


def relocalised_fraction(seed: int, kidnappings: int = 200) -> float:
    """Share of kidnappings in homes that the core solves within the bench's limit."""
    outcomes = kidnapped(HOMES, seed, kidnappings)
    return sum(outcome.right for outcome in outcomes) / len(outcomes)
