# SPDX-License-Identifier: GPL-3.0-or-later
"""What the firmware is given: ranges, odometry, height, battery, and their faults."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from ground.sim.battery import HOVER_ENDURANCE_S, Battery
from ground.sim.controller import THRUST_MAX, Command
from ground.sim.estimator import Estimator
from ground.sim.model import RANGE_NONE_MM
from ground.sim.plant import PLANT_STEP_S, Plant
from ground.sim.profiles import PROFILES
from ground.sim.ranger import SENSOR_OFFSET_M
from ground.sim.sensors import RANGE_PERIOD_STEPS
from ground.sim.world import load_world
from tests.sim.plants import (
    OFF,
    OPEN_FLOOR,
    fly,
    hover,
    hovering,
    in_the_air,
    steps,
    wall_at,
    world_from,
)

FRONT, BACK, LEFT = range(3)


def test_a_published_range_of_a_hovering_drone_is_the_true_distance() -> None:
    plant = hovering(load_world("empty"), profile="real")
    ranges = []
    for now in steps(plant, hover(), 6.0):
        true_m = now.truth.position_m[0] - SENSOR_OFFSET_M
        ranges.append(now.readings.range_mm[BACK] / 1000.0 - true_m)
    assert np.median(ranges) == pytest.approx(0.0, abs=0.03)


def test_a_range_gets_published_when_it_is_60_to_100_ms_old(tmp_path: Path) -> None:
    box = "[[box]]\ncenter = [1.5, 0]\nsize = [0.2, 2]\nheight_m = 2\nappears_s = 5.0\n"
    delays_ms = []
    for seed in range(30):
        plant = fly(Plant(world_from(tmp_path, OPEN_FLOOR + box), seed), hover(), 5.0)
        seen = (
            now.time_s
            for now in steps(plant, hover(), 2.0)
            if abs(now.readings.range_mm[FRONT] - 1384) < 250
        )
        delays_ms.append(round(1000.0 * (next(seen) - 5.0)))
    assert 60 <= min(delays_ms) <= 100
    assert 150 <= max(delays_ms) <= 200


def test_a_set_stands_for_100_ms(tmp_path: Path) -> None:
    plant = hovering(wall_at(tmp_path, 1.5))
    published = [now.readings.range_mm for now in steps(plant, hover(), 3.0)]
    changes = [i for i in range(1, len(published)) if published[i] != published[i - 1]]
    assert len(changes) > 20
    assert all((b - a) % RANGE_PERIOD_STEPS == 0 for a, b in pairwise(changes))


def test_where_nothing_answers_the_range_is_the_firmwares_none(tmp_path: Path) -> None:
    plant = hovering(world_from(tmp_path, OPEN_FLOOR))
    seen = [now.readings.range_mm[FRONT] for now in steps(plant, hover(), 10.0)]
    assert np.mean(np.array(seen) == RANGE_NONE_MM) > 0.95


def test_before_the_first_set_ranges_are_zero(tmp_path: Path) -> None:
    plant = Plant(world_from(tmp_path, OPEN_FLOOR), 1)
    assert plant.readings.range_mm == (0, 0, 0, 0, 0)


def drift(profile: str, seed: int, quality: float = 1.0) -> tuple[float, float]:
    """Flow scale error, and yaw drift in deg/s, over two minutes at 0.5 m/s."""
    body = in_the_air()
    body.vx_mps = 0.5
    estimator = Estimator(PROFILES[profile], np.random.default_rng(seed))
    way_m, seconds = 0.0, 120.0
    for _ in range(round(seconds / PLANT_STEP_S)):
        x, y = estimator.x_m, estimator.y_m
        body.x_m += 0.5 * PLANT_STEP_S
        estimator.step(body, 0.5, quality)
        c, s = math.cos(estimator.yaw_rad), math.sin(estimator.yaw_rad)
        way_m += c * (estimator.x_m - x) + s * (estimator.y_m - y)
    return way_m / (0.5 * seconds) - 1.0, math.degrees(estimator.yaw_rad) / seconds


@pytest.mark.parametrize(
    ("profile", "scale", "yaw_dps"),
    [
        ("real", (0.02, 0.12), (0.01, 0.1)),
        ("low", (0.01, 0.03), (0.02, 0.1)),
        ("hard", (0.02, 0.04), (0.1, 0.5)),
    ],
)
def test_drift_is_that_of_its_profile(
    profile: str, scale: tuple[float, float], yaw_dps: tuple[float, float]
) -> None:
    drifts = np.abs([drift(profile, seed) for seed in range(12)])
    assert scale[0] < np.median(drifts[:, 0]) < scale[1]
    assert np.max(drifts[:, 0]) < scale[1] + 0.09
    assert yaw_dps[0] < np.median(drifts[:, 1]) < yaw_dps[1]
    assert np.max(drifts[:, 1]) < 1.3 * yaw_dps[1]


def test_real_flow_reads_too_much() -> None:
    assert np.mean([drift("real", seed)[0] for seed in range(12)]) > 0.03


def test_a_perfect_estimate_is_the_truth(tmp_path: Path) -> None:
    plant = hovering(world_from(tmp_path, OPEN_FLOOR))
    fly(plant, hover(vx_mps=0.4, vy_mps=0.2, yaw_rate_dps=40.0), 20.0)
    x, y, _ = plant.truth.position_m
    assert (plant.readings.x_m, plant.readings.y_m) == pytest.approx((x, y), abs=1e-6)
    turned = math.radians(plant.readings.yaw_deg) - plant.truth.yaw_rad
    assert math.remainder(turned, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_a_poor_floor_makes_it_worse() -> None:
    spread = {
        quality: np.std([drift("real", seed, quality)[0] for seed in range(8)])
        for quality in (1.0, 0.3)
    }
    assert spread[0.3] > 1.3 * spread[1.0]


def test_over_a_box_the_estimate_sinks_and_the_drone_climbs(tmp_path: Path) -> None:
    box = "[[box]]\ncenter = [2, 0]\nsize = [1.5, 3]\nheight_m = 0.25\n"
    plant = hovering(world_from(tmp_path, OPEN_FLOOR + box))
    heights = [(now.readings.z_m, now.truth.position_m[2]) for now in steps(plant, hover(0.4), 5.0)]
    assert min(estimated for estimated, _ in heights) < 0.38
    assert max(true for _, true in heights) > 0.68


def test_the_estimate_settles_within_two_seconds_and_again_after_a_reset(tmp_path: Path) -> None:
    plant = Plant(world_from(tmp_path, OPEN_FLOOR), 1)
    plant.step(OFF, True)
    assert plant.readings.var_velocity_m2ps2[0] > 0.01
    fly(plant, OFF, 2.0)
    assert plant.readings.var_velocity_m2ps2[0] < 0.001
    plant.reset_estimator(1.0, -2.0, 0.0, math.radians(30.0))
    plant.step(OFF, True)
    readings = plant.readings
    assert (readings.x_m, readings.y_m) == pytest.approx((1.0, -2.0))
    assert readings.yaw_deg == pytest.approx(30.0)
    assert readings.var_velocity_m2ps2[0] > 0.01


def test_after_a_reset_odometry_goes_on_from_there(tmp_path: Path) -> None:
    plant = fly(Plant(world_from(tmp_path, OPEN_FLOOR), 1, "perfect"), OFF, 1.0)
    plant.reset_estimator(5.0, 5.0, 0.0, math.radians(90.0))
    fly(plant, OFF, 0.1)
    fly(fly(plant, hover(), 5.0), hover(vx_mps=0.4), 4.0)
    forward_m, left_m, _ = plant.truth.position_m
    assert forward_m > 1.0
    estimate = (plant.readings.x_m, plant.readings.y_m)
    assert estimate == pytest.approx((5.0 - left_m, 5.0 + forward_m), abs=1e-6)


def test_the_start_pose_is_the_origin_of_the_estimate(tmp_path: Path) -> None:
    world = world_from(tmp_path, "[start]\nx_m = 3\ny_m = 4\nyaw_deg = 90\n")
    plant = fly(hovering(world), hover(vx_mps=0.4), 3.0)
    assert plant.truth.position_m[1] > 4.8
    x, y, _ = plant.truth.position_m
    estimate = (plant.readings.x_m, plant.readings.y_m)
    assert world.to_map(x, y) == pytest.approx(estimate, abs=1e-6)


def test_lost_flow_shows_and_lets_it_drift_away(tmp_path: Path) -> None:
    plant = hovering(world_from(tmp_path, OPEN_FLOOR), profile="real")
    plant.broken.flow = True
    before = plant.truth.position_m
    fly(plant, hover(), 15.0)
    assert math.dist(before[:2], plant.truth.position_m[:2]) > 0.5
    assert plant.readings.var_velocity_m2ps2[0] > 0.1
    assert plant.readings.motion_quality == 0
    plant.broken.flow = False
    fly(plant, hover(), 3.0)
    assert plant.readings.var_velocity_m2ps2[0] < 0.001
    assert math.hypot(*plant.truth.velocity_mps) < 0.2


def test_frozen_ranges_do_not_change(tmp_path: Path) -> None:
    plant = hovering(wall_at(tmp_path, 1.5))
    plant.broken.frozen_beams.update(range(5))
    frozen = plant.readings.range_mm
    assert all(now.readings.range_mm == frozen for now in steps(plant, hover(), 2.0))
    plant.broken.frozen_beams.clear()
    assert any(now.readings.range_mm != frozen for now in steps(plant, hover(), 1.0))


def test_a_dead_beam_reports_none_and_the_others_go_on(tmp_path: Path) -> None:
    plant = hovering(load_world("empty"))
    plant.broken.dead_beams.add(BACK)
    fly(plant, hover(), 0.2)
    seen = [now.readings.range_mm for now in steps(plant, hover(), 2.0)]
    assert all(ranges[BACK] == RANGE_NONE_MM for ranges in seen)
    assert any(ranges[LEFT] != RANGE_NONE_MM for ranges in seen)


def test_a_battery_lasts_as_long_as_it_is_told_to() -> None:
    short, usual = Battery(endurance_s=100.0), Battery()
    for battery in (short, usual):
        for _ in range(1000):
            battery.step(1.0, 0.1)
    assert short.charge == pytest.approx(0.0, abs=1e-6)
    assert usual.charge == pytest.approx(1.0 - 100.0 / HOVER_ENDURANCE_S)


def test_a_charge_lasts_seven_minutes_and_the_level_falls_in_tens() -> None:
    battery, levels = Battery(), set()
    assert battery.voltage_v == pytest.approx(4.2)
    for _ in range(round(HOVER_ENDURANCE_S)):
        battery.step(1.0, 1.0)
        levels.add(battery.percent)
    assert battery.voltage_v == pytest.approx(3.0, abs=0.05)
    assert battery.state == 3
    assert levels <= set(range(0, 100, 10))


def test_the_battery_sags_under_load_and_recovers() -> None:
    battery = Battery()
    assert battery.percent == 90
    for _ in range(300):
        battery.step(1.0, 0.01)
    loaded_v = battery.voltage_v
    assert loaded_v < 3.9
    for _ in range(300):
        battery.step(0.0, 0.01)
    assert battery.voltage_v > loaded_v + 0.2


@pytest.mark.parametrize(("charge", "climbs"), [(1.0, True), (0.0, False)])
def test_full_thrust_carries_it_only_with_charge(charge: float, climbs: bool) -> None:
    battery, body = Battery(charge), in_the_air()
    battery.step(1.0, 10.0)
    body.z_m = 5.0
    for _ in range(60):
        body.step(Command(thrust=THRUST_MAX), 0.0, battery.voltage_v)
    assert (body.vz_mps > 0.0) is climbs
