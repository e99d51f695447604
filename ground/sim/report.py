# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth about a simulated flight, for scoring; never for the drone or its display."""

from dataclasses import asdict
from math import dist, pi, remainder

from ground.sim.plant import Plant
from ground.sim.radio import Counters

_TRAIL_EVERY_S = 0.1
_DIGITS = 4


class Logbook:
    """Follows the plant: length of the path and, if wanted, the trail of true poses."""

    def __init__(self, plant: Plant, keep_trail: bool) -> None:
        self._plant = plant
        self._keep_trail = keep_trail
        self._trail: list[tuple[float, ...]] = []
        self._trail_due_s = 0.0
        self._last_m = plant.truth.position_m
        self._path_m = 0.0
        self._max_height_m = self._last_m[2]

    def note(self) -> None:
        """Note the state of the plant after a step."""
        truth = self._plant.truth
        self._path_m += dist(truth.position_m, self._last_m)
        self._last_m = truth.position_m
        self._max_height_m = max(self._max_height_m, truth.position_m[2])
        if self._keep_trail and truth.time_s >= self._trail_due_s:
            self._trail_due_s = truth.time_s + _TRAIL_EVERY_S
            self._trail.append((round(truth.time_s, 3), *self._pose()))

    def summary(self) -> dict[str, object]:
        """Figures of the flight; poses are x, y, z [m] and yaw [rad] in the world frame."""
        figures: dict[str, object] = {
            "sim_s": round(self._plant.time_s, 3),
            "collisions": self._plant.collisions,
            "collision_log": [
                asdict(one) | {"by_drone": one.by_drone} for one in self._plant.collision_log
            ],
            "path_m": round(self._path_m, _DIGITS),
            "max_height_m": round(self._max_height_m, _DIGITS),
            "true_pose": self._pose(),
            "battery_v": round(self._plant.readings.battery_v, _DIGITS),
        }
        if self._keep_trail:
            figures["trail"] = self._trail
        return figures

    def _pose(self) -> tuple[float, ...]:
        truth = self._plant.truth
        yaw_rad = remainder(truth.yaw_rad, 2 * pi)
        return tuple(round(value, _DIGITS) for value in (*truth.position_m, yaw_rad))


def traffic(counters: Counters, app_packets_lost: int) -> dict[str, object]:
    """Figures of the radio link."""
    return {
        "datagrams_in": counters.received,
        "datagrams_out": counters.sent,
        "datagrams_lost_up": counters.lost_up,
        "datagrams_lost_down": counters.lost_down,
        "datagrams_unsent": counters.unsent,
        "bad_packets": counters.bad,
        "bad_packet_reasons": counters.errors,
        "app_packets_lost": app_packets_lost,
        "clients_seen": counters.clients,
    }
