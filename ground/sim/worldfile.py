# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads world files: checks the TOML and makes a WorldSpec of it.

Top-level keys: title, ceiling_m, [start], [floor] with [[floor.patch]], [[wall]], [[box]],
[[disc]], [eeprom], [demo]. An error is a WorldError that names file, key and reason.
"""

import math
import tomllib
from pathlib import Path
from typing import Final

from ground.errors import BadInput
from ground.sim.worldspec import (
    WALL_REFLECTIVITY,
    Motion,
    Obstacle,
    Patch,
    Point,
    Trigger,
    WorldSpec,
)

WORLDS_DIR: Final = Path(__file__).parent / "worlds"
MAX_EXTENT_M: Final = 100.0
MAX_TIME_S: Final = 1e6


class WorldError(BadInput):
    """A world file is missing or invalid."""

    def __init__(self, file: str, key: str, reason: str, step: str = "") -> None:
        super().__init__(f"{file}: {key}: {reason}" if key else f"{file}: {reason}", step)


class _Table:
    """A TOML table: typed reads whose errors name file and key, and a check for unknown keys."""

    def __init__(self, file: str, where: str, values: object) -> None:
        self._file, self._where = file, where
        if not isinstance(values, dict):
            raise WorldError(file, where, "must be a table")
        self._values: dict[str, object] = dict(values)

    def key(self, name: str) -> str:
        return f"{self._where}.{name}" if self._where else name

    def fail(self, name: str, reason: str) -> WorldError:
        return WorldError(self._file, self.key(name), reason)

    def has(self, name: str) -> bool:
        return name in self._values

    def take(self, name: str) -> object:
        if name not in self._values:
            raise self.fail(name, "is missing")
        return self._values.pop(name)

    def number(
        self,
        name: str,
        default: float | None = None,
        low: float = -MAX_EXTENT_M,
        high: float = MAX_EXTENT_M,
    ) -> float:
        if default is not None and not self.has(name):
            return default
        return self._checked(name, self.take(name), low, high)

    def _checked(self, name: str, value: object, low: float, high: float) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fail(name, f"must be a number, is {value!r}")
        if not low <= value <= high:
            raise self.fail(name, f"must lie within {low:g} and {high:g}, is {value:g}")
        return float(value)

    def length(self, name: str, default: float | None = None) -> float:
        return self.number(name, default, 1e-3)

    def time(self, name: str, default: float) -> float:
        if not self.has(name):
            return default
        return self.number(name, low=0.0, high=MAX_TIME_S)

    def text(self, name: str, default: str) -> str:
        value = self._values.pop(name, default)
        if not isinstance(value, str):
            raise self.fail(name, f"must be text, is {value!r}")
        return value

    def flag(self, name: str, default: bool) -> bool:
        value = self._values.pop(name, default)
        if not isinstance(value, bool):
            raise self.fail(name, f"must be true or false, is {value!r}")
        return value

    def point(self, name: str, low: float = -MAX_EXTENT_M) -> Point:
        return self._as_point(name, self.take(name), low)

    def _as_point(self, name: str, value: object, low: float) -> Point:
        if not isinstance(value, list) or len(value) != 2:
            raise self.fail(name, f"must be a pair of numbers, is {value!r}")
        x, y = (self._checked(name, part, low, MAX_EXTENT_M) for part in value)
        return x, y

    def points(self, name: str) -> tuple[Point, ...]:
        value = self.take(name)
        if not isinstance(value, list) or not value:
            raise self.fail(name, "must be a list of points")
        return tuple(
            self._as_point(f"{name}[{i}]", part, -MAX_EXTENT_M) for i, part in enumerate(value)
        )

    def table(self, name: str) -> "_Table":
        return _Table(self._file, self.key(name), self.take(name))

    def tables(self, name: str) -> list["_Table"]:
        value = self._values.pop(name, [])
        if not isinstance(value, list):
            raise self.fail(name, f"must be a list of tables, written [[{self.key(name)}]]")
        return [_Table(self._file, f"{self.key(name)}[{i}]", part) for i, part in enumerate(value)]

    def rest(self) -> dict[str, float]:
        """Everything that has not been read yet, as numbers."""
        return {name: self.number(name, low=-1e9, high=1e9) for name in list(self._values)}

    def done(self) -> None:
        for name in self._values:
            raise self.fail(name, "is not known here")


def read_world(name_or_path: str | Path) -> WorldSpec:
    """Read worlds/NAME.toml, or the file itself if the argument ends in .toml."""
    path = Path(name_or_path)
    if path.suffix != ".toml":
        path = WORLDS_DIR / f"{name_or_path}.toml"
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        known = ", ".join(sorted(file.stem for file in WORLDS_DIR.glob("*.toml")))
        step = f"worlds are {known}; or name a file that ends in .toml"
        missing = isinstance(error, FileNotFoundError)
        reason = "there is no such world" if missing else f"cannot be read: {error.strerror}"
        raise WorldError(str(name_or_path), "", reason, step) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise WorldError(path.name, "", f"is not TOML: {error}") from error
    return _world(path, _Table(path.name, "", values))


def _world(path: Path, top: _Table) -> WorldSpec:
    title = top.text("title", path.stem)
    start = top.table("start")
    start_m = (start.number("x_m"), start.number("y_m"))
    start_yaw_rad = math.radians(start.number("yaw_deg", 0.0, -360.0, 360.0))
    start.done()
    quality, patches = _floor(top)
    readers = (("wall", _wall), ("box", _box), ("disc", _disc))
    obstacles = [reader(table) for key, reader in readers for table in top.tables(key)]
    obstacles += _ceiling(top)
    eeprom = top.table("eeprom").rest() if top.has("eeprom") else {}
    goal = _demo_goal(top)
    top.done()
    return WorldSpec(
        path.stem,
        title,
        start_m,
        start_yaw_rad,
        tuple(obstacles),
        quality,
        patches,
        eeprom,
        goal,
    )


def _floor(top: _Table) -> tuple[float, tuple[Patch, ...]]:
    if not top.has("floor"):
        return 1.0, ()
    floor = top.table("floor")
    quality = floor.number("quality", 1.0, 0.0, 1.0)
    patches = []
    for table in floor.tables("patch"):
        patch = Patch(
            table.point("from"), table.point("to"), table.number("quality", low=0.0, high=1.0)
        )
        if not (patch.low_m[0] < patch.high_m[0] and patch.low_m[1] < patch.high_m[1]):
            raise table.fail("to", "must be greater than from in x and y")
        table.done()
        patches.append(patch)
    floor.done()
    return quality, tuple(patches)


def _demo_goal(top: _Table) -> Point | None:
    if not top.has("demo"):
        return None
    demo = top.table("demo")
    goal = demo.point("goal")
    demo.done()
    return goal


def _wall(table: _Table) -> Obstacle:
    a, b = table.point("from"), table.point("to")
    length_m = math.dist(a, b)
    if length_m < 1e-3:
        raise table.fail("to", "is the same point as from")
    center = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
    half = (length_m / 2, table.length("thickness_m", 0.1) / 2)
    yaw_rad = math.atan2(b[1] - a[1], b[0] - a[0])
    return _finish(table, center, half, yaw_rad, 0.0)


def _box(table: _Table) -> Obstacle:
    size = table.point("size", low=1e-3)
    yaw_rad = math.radians(table.number("yaw_deg", 0.0, -360.0, 360.0))
    return _finish(table, table.point("center"), (size[0] / 2, size[1] / 2), yaw_rad, 0.0)


def _disc(table: _Table) -> Obstacle:
    radius_m = table.length("radius_m")
    return _finish(table, table.point("center"), (radius_m, radius_m), 0.0, radius_m)


def _finish(table: _Table, center: Point, half: Point, yaw_rad: float, radius_m: float) -> Obstacle:
    bottom_m = table.number("bottom_m", 0.0, 0.0)
    height_m = table.length("height_m")
    appears_s, vanishes_s = table.time("appears_s", 0.0), table.time("vanishes_s", math.inf)
    if vanishes_s <= appears_s:
        raise table.fail("vanishes_s", "must be later than appears_s")
    obstacle = Obstacle(
        table.text("name", table.key("")[:-1]),
        center,
        half,
        yaw_rad,
        radius_m,
        bottom_m,
        bottom_m + height_m,
        table.number("reflectivity", WALL_REFLECTIVITY, 0.01, 1.0),
        appears_s,
        vanishes_s,
        _motion(table, center) if table.has("motion") else None,
    )
    table.done()
    return obstacle


def _motion(table: _Table, center: Point) -> Motion:
    motion = table.table("motion")
    path = motion.points("path")
    if all(point == center for point in path):
        raise motion.fail("path", "leads nowhere: every point is the center")
    result = Motion(
        path,
        motion.number("speed_mps", low=0.01, high=10.0),
        motion.time("start_s", 0.0),
        motion.flag("loop", False),
        _trigger(motion) if motion.has("when_near") else None,
        motion.time("pause_s", 0.0),
    )
    motion.done()
    return result


def _trigger(motion: _Table) -> Trigger:
    table = motion.table("when_near")
    trigger = Trigger(table.point("center"), table.length("radius_m"))
    table.done()
    return trigger


def _ceiling(top: _Table) -> list[Obstacle]:
    """A slab over everything, if the world has a ceiling."""
    if not top.has("ceiling_m"):
        return []
    bottom_m = top.length("ceiling_m")
    half = (MAX_EXTENT_M, MAX_EXTENT_M)
    return [Obstacle("ceiling", (0.0, 0.0), half, 0.0, 0.0, bottom_m, bottom_m + 0.2)]
