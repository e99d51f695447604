# SPDX-License-Identifier: GPL-3.0-or-later
"""A map file can be read again, by other programs too."""

from pathlib import Path
from xml.etree import ElementTree

import matplotlib.image
import numpy as np
import pytest

from ground.core import CellState
from ground.errors import BadInput, GroundError
from ground.map.files import PIXELS_PER_CELL, check_free, save_map
from ground.map.groundmap import GroundMap
from ground.model import MapPiece


@pytest.fixture
def grid() -> GroundMap:
    """A map whose south-west tile is free, with one wall cell in its second row."""
    states = bytearray([CellState.FREE] * 64)
    states[8 + 3] = CellState.OCCUPIED
    grid = GroundMap()
    grid.take_piece(MapPiece(0, 0, bytes(states), ((11, 0),)), 0.0)
    return grid


def test_png_is_a_picture_with_north_up(grid: GroundMap, tmp_path: Path) -> None:
    save_map(grid, tmp_path / "map.png")
    picture = matplotlib.image.imread(tmp_path / "map.png")
    assert picture.shape == (128 * PIXELS_PER_CELL, 128 * PIXELS_PER_CELL)
    cells = picture[::PIXELS_PER_CELL, ::PIXELS_PER_CELL][::-1]
    assert cells[1, 3] == 0
    assert cells[0, 0] > 0.99
    assert 0.7 < cells[127, 127] < 0.9


def test_npz_holds_the_arrays(grid: GroundMap, tmp_path: Path) -> None:
    save_map(grid, tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz") as arrays:
        assert np.array_equal(arrays["states"], grid.states)
        assert arrays["obstacles_m"] == pytest.approx(grid.obstacles_m())
        assert arrays["cell_m"] == pytest.approx(grid.cell_m)


@pytest.mark.parametrize("name", ["map.bmp", "map"])
def test_other_kinds_are_refused(grid: GroundMap, tmp_path: Path, name: str) -> None:
    with pytest.raises(BadInput, match="cannot write a map") as refused:
        save_map(grid, tmp_path / name)
    assert refused.value.step.startswith("use .yaml, .png, ")
    assert refused.value.__notes__ == [f"next: {refused.value.step}"]


@pytest.mark.parametrize(
    ("name", "there"), [("map.png", "map.png"), ("map.yaml", "map.pgm"), ("map.YAML", "map.pgm")]
)
def test_nothing_is_overwritten_unasked(tmp_path: Path, name: str, there: str) -> None:
    (tmp_path / there).touch()
    with pytest.raises(GroundError, match="exists already"):
        check_free(tmp_path / name, force=False)
    check_free(tmp_path / name, force=True)
    check_free(tmp_path / "other.yaml", force=False)


def test_csv_holds_the_obstacles(grid: GroundMap, tmp_path: Path) -> None:
    save_map(grid, tmp_path / "map.csv")
    table = np.genfromtxt(tmp_path / "map.csv", delimiter=",", names=True)
    assert (table["x_m"], table["y_m"]) == pytest.approx(grid.obstacles_m()[0], abs=1e-4)


def test_svg_is_drawn_in_metres(grid: GroundMap, tmp_path: Path) -> None:
    save_map(grid, tmp_path / "map.svg")
    svg = ElementTree.parse(tmp_path / "map.svg").getroot()
    (circle,) = svg.iter("{http://www.w3.org/2000/svg}circle")
    (obstacle,) = grid.obstacles_m()
    assert [float(circle.attrib[name]) for name in ("cx", "cy")] == pytest.approx(
        [obstacle[0], -obstacle[1]], abs=1e-3
    )
