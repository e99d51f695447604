# SPDX-License-Identifier: GPL-3.0-or-later
"""A kept map goes back to the drone, completely or with a clear refusal."""

import re
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest
from typer.testing import CliRunner

from ground.cli.app import app
from ground.core import CellState, MissionCmd, MissionState
from ground.errors import CommandRefused, GroundError, NoAnswer
from ground.link.wire import decode_map_piece, encode_map_piece
from ground.map.files import load_map, save_map
from ground.map.groundmap import GroundMap
from ground.model import MapPiece, Point
from ground.requests import Outgoing
from ground.sim.process import SimulatorProcess
from ground.sim.world import load_world
from ground.sim.worldfile import WORLDS_DIR
from ground.station.maps import send_map
from ground.station.station import Station
from tests.ground.fakelink import HELLO, FakeLink
from tests.ground.stations import packet_of, telemetry, with_station

EMPTY = WORLDS_DIR / "empty.toml"
FURNITURE = """
[[box]]
name = "wardrobe"
center = [4.3, 0.6]
size = [1.4, 1.2]
height_m = 2.0

[[box]]
name = "shelf"
center = [0.4, 4.4]
size = [0.8, 1.2]
height_m = 2.0

[[box]]
name = "cupboard"
center = [3.0, 4.7]
size = [0.6, 0.6]
height_m = 2.0
"""
ELSEWHERE = "[start]\nx_m = 3.6\ny_m = 3.2\nyaw_deg = -60\n\n"
GOAL_M = (0.6, 0.4)


def some_map(seed: int = 3) -> GroundMap:
    """A map of noise, with points in some of the obstacles."""
    rng = np.random.default_rng(seed)
    grid = GroundMap()
    grid.take_hello(HELLO)
    grid.states[24:90, 40:100] = rng.integers(0, len(CellState), (66, 60))
    rows, columns = np.nonzero(grid.states == CellState.OCCUPIED)
    some = slice(0, len(rows), 3)
    grid.eighths[rows[some], columns[some]] = rng.integers(0, 64, len(rows[some]))
    return grid


class TakingLink(FakeLink):
    """Sends tiles back as the drone's map does; some are lost on the way."""

    def __init__(self, loss: float) -> None:
        super().__init__(self._hear)
        self._random = Random(1)
        self._loss = loss
        self.taken = 0

    def _hear(self, message: Outgoing) -> bool:
        if isinstance(message, MapPiece):
            if self._random.random() < self._loss:
                return False
            self.taken += 1
            self.say(packet_of(replace(message, epoch=HELLO.epoch)))
        return True


def sent_over(link: FakeLink, kept: GroundMap) -> GroundMap:
    """The drone's map as the ground sees it afterwards."""
    seen = GroundMap()

    async def work(station: Station) -> None:
        await send_map(station, kept)
        seen.states[:] = station.picture.map.states

    with_station(link, work)
    return seen


@pytest.mark.parametrize("loss", [0.0, 0.3])
def test_what_arrives_is_what_was_kept(loss: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ground.station.maps.PACE_S", 0.0)
    monkeypatch.setattr("ground.station.maps.QUIET_S", 0.05)
    link, kept = TakingLink(loss), some_map()
    assert np.array_equal(sent_over(link, kept).states, kept.states)
    assert [act.cmd for act in link.acts] == [MissionCmd.FORGET]


def test_what_never_arrives_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ground.station.maps.PACE_S", 0.0)
    monkeypatch.setattr("ground.station.maps.QUIET_S", 0.01)
    with pytest.raises(NoAnswer, match="tiles of the map did not arrive"):
        sent_over(TakingLink(1.0), some_map())


def test_in_the_air_nothing_is_sent() -> None:
    link = FakeLink()

    async def work(station: Station) -> None:
        link.say(telemetry(100, MissionState.HOVER))
        await station.greet()
        with pytest.raises(CommandRefused, match="only possible on the ground"):
            await send_map(station, some_map())

    with_station(link, work)
    assert link.acts == []


def test_a_map_of_another_grid_is_refused_with_both_grids() -> None:
    kept = some_map()
    kept.origin = Point(-1.0, -3.2)
    with pytest.raises(GroundError, match=r"\(-1\.00, -3\.20\) do not fit .* \(-3\.20, -3\.20\)"):
        sent_over(FakeLink(), kept)


def test_a_piece_is_the_same_after_its_bytes() -> None:
    kept = some_map()
    for tile in range(0, 256, 7):
        piece = kept.piece(tile, 2)
        (back,) = decode_map_piece(encode_map_piece(piece))
        assert set(back.points) <= set(piece.points)
        assert back.whole == (back.points == piece.points)
        assert replace(back, points=piece.points, whole=False) == piece


def test_a_saved_map_is_loaded_as_it_was(tmp_path: Path) -> None:
    kept = some_map()
    save_map(kept, tmp_path / "map.npz")
    loaded = load_map(tmp_path / "map.npz")
    assert np.array_equal(loaded.states, kept.states)
    points = kept.eighths != 255
    assert np.array_equal(loaded.eighths[points], kept.eighths[points])
    assert (loaded.cell_m, loaded.origin) == (kept.cell_m, kept.origin)


@pytest.mark.parametrize("damage", ["missing", "text", "shape", "state"])
def test_what_is_no_map_is_refused(damage: str, tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    states = np.full((128, 128), 7 if damage == "state" else 1, np.uint8)
    if damage == "text":
        path.write_text("not a map")
    elif damage != "missing":
        states = states[:5] if damage == "shape" else states
        obstacles = np.zeros((0, 2))
        np.savez(path, states=states, obstacles_m=obstacles, cell_m=0.05, origin_m=(0.0, 0.0))
    told = "cannot read" if damage == "missing" else "not a map"
    with pytest.raises(GroundError, match=told):
        load_map(path)


def run(*arguments: str) -> None:
    result = CliRunner().invoke(app, list(arguments))
    assert result.exit_code == 0, result.stderr


@pytest.fixture(scope="module")
def explored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a home and its map, in both forms that can be sent back."""
    folder = tmp_path_factory.mktemp("explored")
    (folder / "home.toml").write_text(EMPTY.read_text() + FURNITURE)
    with SimulatorProcess("--world", str(folder / "home.toml"), "--speed", "max") as simulator:
        run("explore", "--uri", simulator.uri)
        for name in ("map.npz", "map.yaml"):
            run("map", "save", str(folder / name), "--uri", simulator.uri)
    return folder


@pytest.mark.parametrize("name", ["map.npz", "map.yaml"])
def test_restarted_elsewhere_it_takes_its_map_back_and_flies_to_a_goal_in_it(
    explored: Path, tmp_path: Path, name: str
) -> None:
    home, moved = explored / "home.toml", tmp_path / "moved.toml"
    moved.write_text(re.sub(r"\[start\][^\[]*", ELSEWHERE, home.read_text()))
    with SimulatorProcess("--world", str(moved), "--speed", "max") as simulator:
        run("map", "load", str(explored / name), "--uri", simulator.uri)
        run("goto", *map(str, GOAL_M), "--uri", simulator.uri)
        truth = simulator.stop()
    place = load_world(str(home)).to_map(*truth["true_pose"][:2])
    assert place == pytest.approx(GOAL_M, abs=0.35)
    assert truth["collisions"] == 0
