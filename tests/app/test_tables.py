# SPDX-License-Identifier: GPL-3.0-or-later
"""The names that users, scripts and cfclient rely on, and what clients are told about them."""

import math
import re
import struct
import zlib
from pathlib import Path

import pytest

from ground.core import MissionReason, ffi, lib
from ground.sim.firmware import Firmware
from ground.sim.model import Readings
from tests.app.drone import FLOAT, FP16, INT8, INT16, INT32, UINT8, UINT16, UINT32, Drone

APP = Path(__file__).parents[2] / "firmware_app" / "app"
P_FLOAT, P_UINT8 = 0x06, 0x08
EXTENDED, BY_FUNCTION = 0x10, 0x40

LOGS = {
    "state": UINT8,
    "fault": UINT8,
    "task": UINT8,
    "refused": UINT8,
    "x": FLOAT,
    "y": FLOAT,
    "yaw": FLOAT,
    "conf": UINT8,
    "source": UINT8,
    "goalX": FLOAT,
    "goalY": FLOAT,
    "pathLen": FLOAT,
    "planUs": UINT32,
    "planNodes": UINT16,
    "known": UINT16,
    "tickUs": UINT32 | BY_FUNCTION,
    "drops": UINT16,
    "bad": UINT16,
    "selfState": UINT8,
    "selfHash": UINT32,
}
PARAMS = {
    "cmd": P_UINT8,
    "goalX": P_FLOAT,
    "goalY": P_FLOAT,
    "height": P_FLOAT | EXTENDED,
    "speed": P_FLOAT | EXTENDED,
    "clearance": P_FLOAT | EXTENDED,
    "yawMode": P_UINT8 | EXTENDED,
    "yawRate": P_FLOAT | EXTENDED,
    "planner": P_UINT8 | EXTENDED,
    "slam": P_UINT8 | EXTENDED,
    "areaX0": P_FLOAT | EXTENDED,
    "areaY0": P_FLOAT | EXTENDED,
    "areaX1": P_FLOAT | EXTENDED,
    "areaY1": P_FLOAT | EXTENDED,
    "frontier": P_UINT8 | EXTENDED,
    "lost": P_UINT8 | EXTENDED,
    "lostTime": P_FLOAT | EXTENDED,
    "lowBat": P_FLOAT | EXTENDED,
    "cell": P_FLOAT | EXTENDED,
    "lookAge": P_FLOAT | EXTENDED,
    "lookWidth": P_FLOAT | EXTENDED,
    "yield": P_FLOAT | EXTENDED,
    "watch": P_FLOAT | EXTENDED,
    "turns": P_FLOAT | EXTENDED,
    "selftest": P_UINT8 | EXTENDED,
}
# What cfclient and cflib's helpers look up; without some of these they stop working.
STOCK_PARAMS = [
    "deck.bcMultiranger",
    "deck.bcFlow",
    "deck.bcFlow2",
    "deck.bcZRanger",
    "deck.bcZRanger2",
    "deck.bcLighthouse4",
    "deck.bcLoco",
    "deck.bcDWM1000",
    "deck.bcLedRing",
    "commander.enHighLevel",
    "flightmode.althold",
    "kalman.resetEstimation",
    "stabilizer.estimator",
    "stabilizer.controller",
    "stabilizer.stop",
    "supervisor.tmblChckEn",
    "posCtlPid.xVelMax",
    "multiranger.filterMask",
]
STOCK_LOGS = [
    "stateEstimate.x",
    "stateEstimate.qw",
    "stateEstimateZ.z",
    "stabilizer.thrust",
    "motor.m1",
    "motor.m4",
    "pm.vbat",
    "pm.state",
    "supervisor.info",
    "sys.canfly",
    "range.front",
    "range.zrange",
    "kalman.varPX",
    "gyro.z",
    "acc.z",
    "motion.squal",
    "radio.rssi",
    "crtp.rxRate",
]


def test_the_stable_log_variables_have_their_types() -> None:
    group = {e.name: e.type for e in Firmware().log_entries() if e.group == "way"}
    assert group == LOGS


def test_the_map_stream_fills_one_log_block() -> None:
    group = {e.name: e.type & 0x0F for e in Firmware().log_entries() if e.group == "waymap"}
    assert group == {**{f"m{i}": UINT32 for i in range(6)}, "m6": UINT16}


def test_the_stable_parameters_have_their_types_and_tuning_can_be_stored() -> None:
    entries = [e for e in Firmware().param_entries() if e.group == "way"]
    assert {e.name: e.type for e in entries} == PARAMS
    assert all(e.persistent == bool(e.type & EXTENDED) == e.extended for e in entries)


def test_what_stock_clients_need_is_there() -> None:
    drone = Drone()
    assert set(STOCK_PARAMS) <= set(drone.params)
    assert set(STOCK_LOGS) <= set(drone.logs)
    assert all(len(name) - 1 <= 24 for name in [*drone.params, *drone.logs])


def test_defaults_told_to_clients_are_those_of_the_core() -> None:
    drone, cfg = Drone(), ffi.new("nav_config_t *")
    lib.nav_config_default(cfg)
    core = {
        "height": cfg.height_m,
        "speed": cfg.follower.speed_mps,
        "clearance": cfg.clearance_m,
        "yawMode": cfg.follower.yaw_mode,
        "yawRate": math.degrees(cfg.follower.turn_rate_rps),
        "planner": cfg.planner,
        "slam": cfg.slam,
        "areaX0": cfg.area_min_m.x,
        "areaY0": cfg.area_min_m.y,
        "areaX1": cfg.area_max_m.x,
        "areaY1": cfg.area_max_m.y,
        "frontier": cfg.frontier,
        "lost": cfg.lost,
        "lostTime": cfg.lost_time_s,
        "lowBat": cfg.low_battery_v,
        "cell": cfg.cell_m,
        "lookAge": cfg.look_age_s,
        "lookWidth": cfg.look_half_width_m,
        "yield": cfg.guard.yield_m,
        "watch": math.degrees(cfg.watch_rad),
        "turns": cfg.turns,
    }
    assert core.keys() == PARAMS.keys() - {"cmd", "goalX", "goalY", "selftest"}
    assert drone.default("way.selftest") == 0
    assert {n: drone.default(f"way.{n}") for n in core} == pytest.approx(core, rel=1e-6)


def test_every_reason_has_words_of_its_own() -> None:
    text = (APP / "app_text.c").read_text()
    words = dict(re.findall(r'\[MISSION_(\w+)\] = "(.+)"', text))
    assert words.keys() == {reason.name for reason in MissionReason}
    assert len(set(words.values())) == len(words)


def test_nothing_is_refused_or_changed_at_start(drone: Drone) -> None:
    assert drone.updates() == []
    assert "refused" not in drone.console()
    assert all(drone.param(f"way.{n}") == drone.default(f"way.{n}") for n in PARAMS)


def test_the_hash_of_a_table_follows_from_its_contents() -> None:
    """The firmware's chained hash, computed again from what a client sees of the log table."""
    firmware = Firmware()
    crc, group = 0, ""
    lines: list[tuple[int, str]] = []
    for entry in firmware.log_entries():
        if entry.group != group:
            lines += [(0x80, f"stop_{group}")] if group else []
            lines.append((0x81, entry.group))
            group = entry.group
        lines.append((entry.type, entry.name))
    for kind, name in [*lines, (0x80, f"stop_{group}")]:
        crc = zlib.crc32(struct.pack("<IB", crc, kind) + name.encode("ascii"))
    assert firmware.log_crc() == crc
    assert firmware.log_crc() != firmware.param_crc()
    assert Firmware().log_crc() == crc


@pytest.mark.parametrize("source", ["app_params.c", "app_status.c", "app_map.c"])
def test_every_variable_has_a_doc_comment(source: str) -> None:
    text = (APP / source).read_text()
    documented = re.findall(r" \* @brief .+\n(?: \* .+\n)* \*/\n(?:LOG|PARAM)_ADD", text)
    assert len(documented) == len(re.findall(r"^(?:LOG|PARAM)_ADD", text, re.MULTILINE)) > 0


@pytest.mark.parametrize(
    ("value", "kind", "expected"),
    [
        (40000.7, UINT16, struct.pack("<H", 40000)),
        (-1.9, INT32, struct.pack("<i", -1)),
        (-1.0, INT16, struct.pack("<h", -1)),
        (-1.0, INT8, b"\xff"),
        (0.1, FLOAT, struct.pack("<f", 0.1)),
        (1.5, FP16, struct.pack("<e", 1.5)),
        (-0.25, FP16, struct.pack("<e", -0.25)),
        (1.0e6, FP16, b"\x00\x7c"),
        (-1.0e6, FP16, b"\x00\xfc"),
        (1.0e-8, FP16, b"\x00\x00"),
        (math.nan, UINT32, bytes(4)),
    ],
)
def test_samples_are_converted_to_the_type_asked_for(
    value: float, kind: int, expected: bytes
) -> None:
    drone = Drone()
    drone.firmware.set_sensors(Readings(motor_thrust=value))
    identity = drone.logs["stabilizer.thrust"]
    assert drone.firmware.log_read(identity, kind, 0) == expected
    assert drone.firmware.block_reader([identity], [kind]).read(0) == expected


def test_unknown_numbers_read_nothing() -> None:
    firmware = Firmware()
    count = firmware.log_count()
    assert firmware.log_read(count, FLOAT, 0) == b""
    assert firmware.log_read(0, 0, 0) == firmware.log_read(0, 9, 0) == b""
    assert firmware.block_reader([0, count], [FLOAT, FLOAT]).read(0) == b""
    assert firmware.param_read(-1) == b""
    assert firmware.param_write(len(firmware.param_entries()), b"\0") == 2


def test_read_only_parameters_change_only_from_within() -> None:
    drone = Drone()
    assert drone.write("deck.bcFlow2", 0) == 13
    assert drone.param("deck.bcFlow2") == 1
    drone.force("deck.bcFlow2", 0)
    assert drone.param("deck.bcFlow2") == 0
    assert drone.firmware.param_write(drone.params["way.speed"], b"\0") == 22
