# SPDX-License-Identifier: GPL-3.0-or-later
"""World files: errors name file, key and reason; what is accepted means what it says."""

from pathlib import Path

import pytest

from ground.errors import GroundError
from ground.sim.worldfile import WorldError, read_world

START = "[start]\nx_m = 1.0\ny_m = 2.0\n"
WALL = "[[wall]]\nfrom = [0, 0]\nto = [1, 0]\nheight_m = 2.0\n"
DISC = "[[disc]]\ncenter = [0, 0]\nradius_m = 0.3\nheight_m = 1.0\n"


def write(folder: Path, text: str) -> Path:
    path = folder / "room.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "key", "reason"),
    [
        ("", "start", "is missing"),
        ("start = 3", "start", "must be a table"),
        ("[start]\nx_m = 1.0", "start.y_m", "is missing"),
        ("[start]\nx_m = 'a'\ny_m = 0", "start.x_m", "must be a number, is 'a'"),
        ("[start]\nx_m = true\ny_m = 0", "start.x_m", "must be a number, is True"),
        ("[start]\nx_m = nan\ny_m = 0", "start.x_m", "must lie within"),
        ("[start]\nx_m = 1e9\ny_m = 0", "start.x_m", "must lie within -100 and 100"),
        ("colour = 1\n" + START, "colour", "is not known here"),
        ("ceiling_m = -1\n" + START, "ceiling_m", "must lie within"),
        (START + "[floor]\nquality = 1.5", "floor.quality", "must lie within 0 and 1"),
        (
            START + "[[floor.patch]]\nfrom = [1, 1]\nto = [0, 2]\nquality = 0.5",
            "floor.patch[0].to",
            "must be greater than from",
        ),
        (START + WALL.replace("[1, 0]", "[1]"), "wall[0].to", "must be a pair of numbers"),
        (START + WALL.replace("[1, 0]", "[1, 'a']"), "wall[0].to", "must be a number, is 'a'"),
        (START + WALL.replace("[1, 0]", "[0, 0]"), "wall[0].to", "is the same point as from"),
        (START + WALL + WALL.replace("height_m = 2.0", ""), "wall[1].height_m", "is missing"),
        (START + WALL + "hight_m = 1", "wall[0].hight_m", "is not known here"),
        (START + WALL + "thickness_m = 0", "wall[0].thickness_m", "must lie within"),
        (START + "[wall]\nfrom = [0, 0]", "wall", "must be a list of tables, written [[wall]]"),
        (START + DISC + "vanishes_s = 0", "disc[0].vanishes_s", "must be later than appears_s"),
        (START + DISC + "reflectivity = 2", "disc[0].reflectivity", "must lie within"),
        (START + DISC + "name = 5", "disc[0].name", "must be text, is 5"),
        (START + DISC + "[disc.motion]\npath = []", "disc[0].motion.path", "must be a list of"),
        (
            START + DISC + "[disc.motion]\npath = [[1, 1], [2]]\nspeed_mps = 1",
            "disc[0].motion.path[1]",
            "must be a pair",
        ),
        (
            START + DISC + "[disc.motion]\npath = [[1, 1]]\nspeed_mps = 0",
            "disc[0].motion.speed_mps",
            "must lie within 0.01 and 10",
        ),
        (
            START + DISC + "[disc.motion]\npath = [[0, 0]]\nspeed_mps = 1\nloop = true",
            "disc[0].motion.path",
            "leads nowhere",
        ),
        (
            START + DISC + "[disc.motion]\npath = [[1, 1]]\nspeed_mps = 1\nloop = 1",
            "disc[0].motion.loop",
            "must be true or false",
        ),
        (START + "[eeprom]\n'way.speed' = 'fast'", "eeprom.way.speed", "must be a number"),
        (START + "[demo]\ngoal = 3", "demo.goal", "must be a pair"),
    ],
)
def test_an_error_names_file_key_and_reason(
    tmp_path: Path, text: str, key: str, reason: str
) -> None:
    with pytest.raises(WorldError) as caught:
        read_world(write(tmp_path, text))
    named = f"room.toml: {key}: "
    assert str(caught.value).startswith(named)
    assert reason in str(caught.value).removeprefix(named)
    assert isinstance(caught.value, GroundError)


def test_text_that_is_not_toml_is_refused_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=r"room\.toml: is not TOML: .*line 2"):
        read_world(write(tmp_path, "[start]\nx_m = = 1\n"))


def test_an_unknown_name_lists_the_worlds_there_are() -> None:
    with pytest.raises(WorldError, match="castle: there is no such world") as missing:
        read_world("castle")
    assert "clutter, door, empty, flat, hall, person" in missing.value.step


def test_a_file_means_what_it_says(tmp_path: Path) -> None:
    spec = read_world(
        write(
            tmp_path,
            START
            + "yaw_deg = 90\n[floor]\nquality = 0.5\n"
            + WALL
            + DISC
            + "bottom_m = 0.5\nappears_s = 3\n"
            + "[disc.motion]\npath = [[1, 1]]\nspeed_mps = 0.5\n"
            + "when_near = { center = [2, 2], radius_m = 1 }\n"
            + "[eeprom]\n'way.speed' = 0.4\n[demo]\ngoal = [1, 2]\n",
        )
    )
    assert (spec.name, spec.start_m, spec.floor_quality) == ("room", (1.0, 2.0), 0.5)
    assert spec.start_yaw_rad == pytest.approx(1.5707963)
    wall, disc = spec.obstacles
    assert (wall.center_m, wall.half_m, wall.top_m) == ((0.5, 0.0), (0.5, 0.05), 2.0)
    assert (disc.bottom_m, disc.top_m, disc.appears_s) == (0.5, 1.5, 3.0)
    assert disc.motion and disc.motion.trigger and disc.motion.trigger.radius_m == 1.0
    assert spec.eeprom == {"way.speed": 0.4}
    assert spec.demo_goal_m == (1.0, 2.0)
