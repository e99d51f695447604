# SPDX-License-Identifier: GPL-3.0-or-later
"""The body in the air, on the ground and in collisions."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from ground.sim.contacts import TUMBLE_MPS
from ground.sim.controller import TILT_MAX_DEG
from ground.sim.model import Mode, Setpoint
from ground.sim.plant import Plant
from ground.sim.vehicle import HOVER_THRUST
from ground.sim.world import World, load_world
from tests.sim.plants import OFF, OPEN_FLOOR, fly, fly_until, hover, hovering, steps, world_from

WALL_AHEAD = OPEN_FLOOR + "[[wall]]\nfrom = [1.55, -3]\nto = [1.55, 3]\nheight_m = 2\n"


@pytest.fixture
def open_floor(tmp_path: Path) -> World:
    return world_from(tmp_path, OPEN_FLOOR)


def attitude(roll_deg: float, pitch_deg: float, z_m: float = 0.5) -> Setpoint:
    return Setpoint(
        mode_z=Mode.ABSOLUTE,
        mode_roll=Mode.ABSOLUTE,
        mode_pitch=Mode.ABSOLUTE,
        mode_yaw=Mode.VELOCITY,
        roll_deg=roll_deg,
        pitch_deg=pitch_deg,
        z_m=z_m,
    )


def test_switched_off_it_stands_where_it_is(open_floor: World) -> None:
    plant = fly(Plant(open_floor, 1), OFF, 3.0)
    assert plant.truth.position_m == (0.0, 0.0, 0.0)
    assert plant.on_floor
    assert (plant.readings.x_m, plant.readings.y_m) == (0.0, 0.0)


def test_unarmed_it_stays_on_the_ground(open_floor: World) -> None:
    plant = fly(Plant(open_floor, 1), hover(), 3.0, armed=False)
    assert plant.truth.position_m[2] == 0.0
    assert plant.readings.motor_thrust == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_a_hover_holds_height_and_place(open_floor: World, seed: int) -> None:
    plant = hovering(open_floor, seed)
    places = [now.truth.position_m for now in steps(plant, hover(), 10.0)]
    assert all(0.44 < z < 0.56 for _, _, z in places)
    assert all(math.hypot(x, y) < 0.25 for x, y, _ in places)


def test_speeding_up_tilts_forward_then_settles(open_floor: World) -> None:
    plant = hovering(open_floor)
    tilts = [now.readings.pitch_deg for now in steps(plant, hover(vx_mps=0.5), 4.0)]
    assert -TILT_MAX_DEG - 5.0 < min(tilts[:100]) < -8.0
    assert all(abs(tilt) < 4.0 for tilt in tilts[-100:])
    assert plant.truth.velocity_mps[0] == pytest.approx(0.5, abs=0.08)
    assert plant.truth.velocity_mps[1] == pytest.approx(0.0, abs=0.08)


def test_velocity_is_meant_in_body_or_world_axes(open_floor: World) -> None:
    plant = fly(hovering(open_floor), hover(yaw_rate_dps=45.0), 2.0)
    assert math.degrees(plant.truth.yaw_rad) == pytest.approx(90.0, abs=8.0)
    body = fly(plant, hover(vx_mps=0.4), 3.0).truth.velocity_mps
    assert body[1] == pytest.approx(0.4, abs=0.1)
    in_world = replace(hover(vx_mps=0.4), velocity_body=False)
    assert fly(plant, in_world, 3.0).truth.velocity_mps[0] == pytest.approx(0.4, abs=0.1)


def test_it_flies_to_a_position_and_heading_no_faster_than_the_limit(open_floor: World) -> None:
    plant = hovering(open_floor)
    absolute = Mode.ABSOLUTE
    there = Setpoint(absolute, absolute, absolute, mode_yaw=absolute)
    there.x_m, there.y_m, there.z_m, there.yaw_deg = 2.0, -1.0, 0.8, -60.0
    speeds = [math.hypot(*now.truth.velocity_mps[:2]) for now in steps(plant, there, 8.0)]
    assert 0.8 < max(speeds) < 1.1 * math.sqrt(2.0) + 0.1
    assert plant.truth.position_m == pytest.approx((2.0, -1.0, 0.8), abs=0.1)
    assert math.degrees(plant.truth.yaw_rad) == pytest.approx(-60.0, abs=3.0)


@pytest.mark.parametrize(
    ("roll_deg", "pitch_deg", "axis", "sign"), [(8, 0, 1, -1), (-8, 0, 1, 1), (0, -8, 0, 1)]
)
def test_a_tilt_moves_it_that_way(
    open_floor: World, roll_deg: float, pitch_deg: float, axis: int, sign: int
) -> None:
    plant = fly(hovering(open_floor), attitude(roll_deg, pitch_deg), 1.0)
    assert plant.truth.velocity_mps[axis] * sign > 0.5
    assert abs(plant.truth.velocity_mps[1 - axis]) < 0.3
    assert plant.readings.roll_deg == pytest.approx(roll_deg, abs=2.0)
    assert plant.readings.pitch_deg == pytest.approx(pitch_deg, abs=2.0)


@pytest.mark.parametrize(("part", "lifts"), [(0.8, False), (1.2, True)])
def test_manual_thrust_lifts_only_above_its_weight(
    open_floor: World, part: float, lifts: bool
) -> None:
    manual = replace(attitude(0.0, 0.0), mode_z=Mode.OFF, thrust=part * HOVER_THRUST)
    plant = fly(Plant(open_floor, 1), manual, 1.0)
    assert (plant.truth.position_m[2] > 0.2) is lifts


def test_without_motors_it_falls_and_lands(open_floor: World) -> None:
    plant = hovering(open_floor)
    fly_until(plant, OFF, lambda now: now.on_floor, 1.0)
    assert fly(plant, OFF, 2.0).truth.position_m[2] == 0.0
    assert not plant.tumbled
    assert plant.collisions == 0


def test_falling_is_free_fall(open_floor: World) -> None:
    plant = fly(hovering(open_floor, z_m=1.0), OFF, 0.3)
    assert plant.readings.az_g < -0.7


def test_it_lands_gently_and_takes_off_again(open_floor: World) -> None:
    down = replace(hover(), mode_z=Mode.VELOCITY, vz_mps=-0.3)
    plant = fly_until(hovering(open_floor), down, lambda now: now.on_floor, 5.0)
    fly(plant, OFF, 1.0)
    assert plant.truth.position_m[2] == 0.0
    assert fly(plant, hover(), 4.0).truth.position_m[2] > 0.4


def test_pushing_against_a_wall_is_one_collision(tmp_path: Path) -> None:
    plant = fly(hovering(world_from(tmp_path, WALL_AHEAD)), hover(vx_mps=0.3), 12.0)
    assert plant.collisions == 1
    assert plant.truth.position_m[0] < 1.44
    (collision,) = plant.collision_log
    assert collision.by_drone
    assert collision.drone_mps == pytest.approx(0.3, abs=0.12)
    assert collision.obstacle_mps == 0.0
    assert not plant.tumbled


def test_coming_back_is_a_second_collision(tmp_path: Path) -> None:
    plant = fly(hovering(world_from(tmp_path, WALL_AHEAD)), hover(vx_mps=0.3), 8.0)
    fly(plant, hover(vx_mps=-0.3), 3.0)
    assert plant.collisions == 1
    assert fly(plant, hover(vx_mps=0.3), 6.0).collisions == 2


def test_a_hard_hit_ends_on_the_floor_upside_down(tmp_path: Path) -> None:
    world = world_from(tmp_path, WALL_AHEAD.replace("1.55", "3.0"))
    plant = fly(hovering(world), hover(vx_mps=1.5), 4.0)
    assert plant.collision_log[0].drone_mps > TUMBLE_MPS
    assert plant.tumbled
    fly(plant, hover(), 3.0)
    assert plant.truth.position_m[2] == 0.0
    assert abs(plant.readings.roll_deg) > 150.0


def test_somebody_walking_into_it_is_told_from_its_own_fault(tmp_path: Path) -> None:
    walker = (
        "[[disc]]\nname = 'somebody'\ncenter = [0, 3]\nradius_m = 0.25\nheight_m = 1.7\n"
        "[disc.motion]\npath = [[0, -3]]\nspeed_mps = 0.5\nstart_s = 6\n"
    )
    plant = fly(hovering(world_from(tmp_path, OPEN_FLOOR + walker)), hover(), 7.0)
    assert plant.collisions >= 1
    first = plant.collision_log[0]
    assert (first.obstacle, first.by_drone) == ("somebody", False)
    assert first.obstacle_mps == pytest.approx(0.5, abs=0.05)


def test_things_below_and_above_its_way_are_not_hit(tmp_path: Path) -> None:
    table = "[[box]]\ncenter = [1, 0]\nsize = [0.5, 2]\nheight_m = 0.05\nbottom_m = 0.9\n"
    carpet = "[[box]]\ncenter = [1, 0]\nsize = [0.5, 2]\nheight_m = 0.02\n"
    world = world_from(tmp_path, OPEN_FLOOR + table + carpet)
    plant = fly(hovering(world), hover(vx_mps=0.4), 6.0)
    assert plant.truth.position_m[0] > 1.8
    assert plant.collisions == 0


def test_it_can_land_on_a_box(tmp_path: Path) -> None:
    box = "[[box]]\ncenter = [1.5, 0]\nsize = [1.2, 3]\nheight_m = 0.2\n"
    plant = hovering(world_from(tmp_path, OPEN_FLOOR + box), z_m=0.6)
    fly_until(plant, hover(vx_mps=0.3, z_m=0.6), lambda now: now.truth.position_m[0] > 1.4, 9.0)
    fly(plant, OFF, 2.0)
    assert plant.truth.position_m[2] == pytest.approx(0.2)
    assert plant.collisions == 0


def test_flying_up_into_the_ceiling_is_a_collision(tmp_path: Path) -> None:
    world = world_from(tmp_path, "ceiling_m = 1.0\n" + OPEN_FLOOR)
    plant = fly(hovering(world), hover(z_m=1.5), 3.0)
    assert plant.collisions == 1
    assert plant.collision_log[0].obstacle == "ceiling"
    assert plant.truth.position_m[2] <= 1.0


def test_the_same_seed_gives_the_same_flight_and_another_does_not() -> None:
    def flight(seed: int) -> list[object]:
        plant = fly(Plant(load_world("flat"), seed), hover(yaw_rate_dps=30.0), 6.0)
        return [plant.readings, plant.truth]

    assert flight(5) == flight(5)
    assert flight(5) != flight(6)


def test_an_unknown_profile_is_refused(open_floor: World) -> None:
    with pytest.raises(ValueError, match="'best' is none of real, low, hard, perfect"):
        Plant(open_floor, 1, "best")
