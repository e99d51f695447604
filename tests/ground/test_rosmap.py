# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps for ROS map_server: it can read what was written, and what it wrote can be read."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from ground.core import CellState
from ground.errors import GroundError
from ground.map.files import save_map
from ground.map.groundmap import GroundMap
from ground.map.ros import RosMap, fit, load_ros
from ground.model import Pose

SIDE = len(GroundMap().states)
HERE = Pose(0.0, 0.0, 0.0, 0.0)


def grid_of(states: NDArray[np.uint8]) -> GroundMap:
    grid = GroundMap()
    grid.states[:] = states
    return grid


def write(folder: Path, grey: list[list[int]], **changes: object) -> Path:
    """Write a map as another program does: 10 cm per pixel, corner at (-1, -2)."""
    Image.fromarray(np.array(grey, np.uint8)).save(folder / "other.png")
    about = {
        "image": "other.png", "resolution": 0.1, "origin": [-1.0, -2.0, 0.0],
        "negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196,
    }  # fmt: skip
    (folder / "other.yaml").write_text(yaml.safe_dump(about | changes))
    return folder / "other.yaml"


def cell_at(grid: GroundMap, x_m: float, y_m: float) -> CellState:
    column = math.floor((x_m - grid.origin.x_m) / grid.cell_m)
    row = math.floor((y_m - grid.origin.y_m) / grid.cell_m)
    return CellState(grid.states[row, column])


def test_what_is_written_is_as_map_server_wants_it(tmp_path: Path) -> None:
    states = np.zeros((SIDE, SIDE), np.uint8)
    states[10, 20], states[100, 30] = CellState.OCCUPIED, CellState.FREE
    grid = grid_of(states)
    save_map(grid, tmp_path / "room.yaml")
    about = yaml.safe_load((tmp_path / "room.yaml").read_text())
    assert (about["free_thresh"], about["occupied_thresh"], about["negate"]) == (0.196, 0.65, 0)
    assert about["resolution"] == pytest.approx(grid.cell_m)
    assert about["origin"] == pytest.approx([grid.origin.x_m, grid.origin.y_m, 0.0])
    pgm = (tmp_path / about["image"]).read_bytes()
    header = b"P5\n%d %d\n255\n" % (SIDE, SIDE)
    assert pgm.startswith(header)
    pixels = np.frombuffer(pgm[len(header) :], np.uint8).reshape(SIDE, SIDE)
    occupied = (255 - pixels.astype(float)) / 255
    assert np.argwhere(occupied > 0.65).tolist() == [[SIDE - 1 - 10, 20]], "north comes first"
    assert np.argwhere(occupied < 0.196).tolist() == [[SIDE - 1 - 100, 30]]


@given(st.binary(min_size=64, max_size=64))
def test_a_map_that_was_written_comes_back(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    tile = np.frombuffer(data, np.uint8).reshape(8, 8) % len(CellState)
    states = np.tile(tile, (SIDE // 8, SIDE // 8)).astype(np.uint8)
    file = tmp_path_factory.mktemp("maps") / "room.yaml"
    save_map(grid_of(states), file)
    if states.any():
        assert np.array_equal(fit(load_ros(file), GroundMap(), None).states, states)


def test_a_coarser_map_of_another_place_lies_where_it_says(tmp_path: Path) -> None:
    ros = load_ros(write(tmp_path, [[254, 254, 254], [254, 205, 0]]))
    grid = fit(ros, GroundMap(), None)
    assert cell_at(grid, -0.75, -1.95) is CellState.OCCUPIED, "right, in the lower row"
    assert cell_at(grid, -0.85, -1.95) is CellState.UNKNOWN
    assert cell_at(grid, -0.95, -1.85) is CellState.FREE, "the upper row"
    assert cell_at(grid, -0.95, -1.75) is CellState.UNKNOWN, "above it"
    assert grid.obstacles_m().mean(axis=0) == pytest.approx([-0.75, -1.95], abs=0.02)


def test_the_place_where_it_stands_becomes_the_origin(tmp_path: Path) -> None:
    ros = load_ros(write(tmp_path, [[254, 254, 254], [254, 254, 0]]))
    grid = fit(ros, GroundMap(), Pose(-0.75, -2.95, 0.0, math.pi / 2))
    assert cell_at(grid, 1.0, 0.0) is CellState.OCCUPIED, "a metre ahead of who looks north"


def test_a_map_that_is_turned_lies_turned(tmp_path: Path) -> None:
    file = write(tmp_path, [[254, 254, 0]], origin=[0.0, 0.0, math.pi / 2])
    assert cell_at(fit(load_ros(file), GroundMap(), None), -0.05, 0.25) is CellState.OCCUPIED


def test_negate_turns_the_meaning_round(tmp_path: Path) -> None:
    ros = load_ros(write(tmp_path, [[255, 0]], negate=1))
    assert ros.states.tolist() == [[CellState.OCCUPIED, CellState.FREE]]


def test_a_thin_wall_survives_a_finer_and_a_coarser_grid() -> None:
    states = np.full((400, 400), CellState.FREE, np.uint8)
    states[:, 200] = CellState.OCCUPIED
    for resolution_m in (0.01, 0.02, 0.08):
        half_m, cos, sin = 200 * resolution_m, math.cos(0.3), math.sin(0.3)
        corner = Pose(half_m * (sin - cos), half_m * (-sin - cos), 0.0, 0.3)
        ros = RosMap(states, resolution_m, corner)
        grid = fit(ros, GroundMap(), None)
        xy = grid.obstacles_m()
        assert len(xy) > 30
        rows = np.unique(np.floor((xy[:, 1] - grid.origin.y_m) / grid.cell_m))
        assert np.all(np.diff(rows) == 1), "no gap"


@pytest.mark.parametrize(
    "changes",
    [
        {"resolution": 0.0}, {"resolution": "fine"}, {"origin": [0.0, 1.0]}, {"origin": 3},
        {"origin": [math.nan, 0.0, 0.0]}, {"image": "none.png"}, {"image": "other.yaml"},
        {"free_thresh": None}, {"negate": "no"},
    ],
)  # fmt: skip
def test_what_is_no_map_is_refused(tmp_path: Path, changes: dict[str, object]) -> None:
    with pytest.raises(GroundError, match=r"other\.yaml"):
        load_ros(write(tmp_path, [[0, 254]], **changes))


@pytest.mark.parametrize("text", ["", "[1, 2]", "{", "image: {}"])
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "other.yaml").write_text(text)
    with pytest.raises(GroundError, match=r"other\.yaml"):
        load_ros(tmp_path / "other.yaml")


def test_a_map_of_elsewhere_is_refused(tmp_path: Path) -> None:
    ros = load_ros(write(tmp_path, [[0, 254]], origin=[50.0, 0.0, 0.0]))
    with pytest.raises(GroundError, match="nothing of that map"):
        fit(ros, GroundMap(), HERE)
