# SPDX-License-Identifier: GPL-3.0-or-later
"""One simulated flight, recorded at both ends of the radio, and what the files are good for."""

import asyncio
import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory
from PIL import Image
from typer.testing import CliRunner

from ground.api import Station
from ground.cli.app import app
from ground.core import MissionCmd, MissionReason
from ground.errors import GroundError
from ground.map.files import load_map
from ground.map.ros import fit, load_ros
from ground.model import Ack, Event, Health, Odometry, Pose, Ranges, Telemetry
from ground.record.folder import new_recording
from ground.record.reader import Heard, Sent, read_entries, read_session
from ground.record.writer import RecordFile
from ground.requests import Command, Heartbeat
from ground.sim.calls import RecordedFirmware
from ground.sim.inputs import CALLS
from ground.sim.process import SimulatorProcess
from ground.sim.rerun_radio import RadioRerun
from ground.sim.world import load_world

WORLD, GOAL = "flat", (2.0, 0.0)


@dataclass(frozen=True)
class Flown:
    """Files of the flight: the ground's, the simulated drone's, and the truth."""

    radio: Path
    inputs: Path
    truth: Path


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    folder = tmp_path_factory.mktemp("flown")
    files = Flown(*(folder / name for name in ("radio.mcap", "inputs.mcap", "truth.json")))
    arguments = ("--world", WORLD, "--speed", "max", "--trail", "--record-inputs")
    with SimulatorProcess(*arguments, str(files.inputs)) as simulator:
        asyncio.run(fly(simulator.uri, files.radio))
        files.truth.write_text(json.dumps(simulator.stop()))
    return files


async def fly(uri: str, record: Path) -> None:
    """Fly to the goal and land there."""
    async with Station.connect(uri, record) as drone:
        await drone.goto(*GOAL)
        await drone.land()
        await drone.whole_map()


def run(*words: str, code: int = 0) -> str:
    """Run a command and return its output."""
    result = CliRunner().invoke(app, words)
    assert result.exit_code == code, result.output
    return result.output


def report(tmp_path: Path, file: Path, code: int = 0) -> dict[str, Any]:
    """The figures of a rerun."""
    run("replay", "--rerun", str(file), "--json", str(tmp_path / "r.json"), code=code)
    figures: dict[str, Any] = json.loads((tmp_path / "r.json").read_text())
    return figures


# --- the drone's end: bit for bit ----------------------------------------------------------------


def test_what_the_app_was_told_gives_the_same_bits_again(flown: Flown, tmp_path: Path) -> None:
    figures = report(tmp_path, flown.inputs)
    assert figures["different"] == 0
    assert figures["calls"] > 10_000


def test_the_second_time_can_be_kept_and_looked_at(flown: Flown, tmp_path: Path) -> None:
    again = tmp_path / "again.mcap"
    run("replay", "--rerun", str(flown.inputs), "--into", str(again))
    first = {m.drone_ms: m for m in spoken(flown.radio, Telemetry)}
    second = {m.drone_ms: m for m in spoken(again, Telemetry)}
    assert len(first) > 100
    assert first.items() <= second.items()


def test_one_other_bit_is_noticed(flown: Flown, tmp_path: Path) -> None:
    """A bit changed in one measurement of the flight makes what follows differ."""
    entries = [entry for entry in read_entries(flown.inputs) if entry.topic == CALLS]
    size = RecordedFirmware().sensor_bytes  # between the letters of two calls that follow
    copy = RecordFile(tmp_path / "other.mcap", {})
    for number, entry in enumerate(entries):
        data = entry.data
        if number - len(entries) // 2 in (0, 1):  # the app looks at every second
            starts = range(4, len(data) - size - 2)
            marks = [(i + 1, data[i : i + size + 2 : size + 1], data[i + size + 2]) for i in starts]
            (at,) = (at for at, letters, flag in marks if letters == b"sc" and flag < 2)
            data = data[:at] + struct.pack("<f", 9.0) + data[at + 4 :]  # x of the estimate
        copy.put(CALLS, data, number)
    copy.close()
    figures = report(tmp_path, tmp_path / "other.mcap", code=1)
    assert figures["different"] > 0
    assert figures["first_difference"] != ""


def test_a_torn_file_is_computed_up_to_the_tear(flown: Flown, tmp_path: Path) -> None:
    whole = flown.inputs.read_bytes()
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(whole[: len(whole) // 2])
    figures = report(tmp_path, torn)
    assert figures["different"] == 0
    assert 1 < figures["simulated_s"] < report(tmp_path, flown.inputs)["simulated_s"]


# --- the ground's end ----------------------------------------------------------------------------


def spoken(file: Path, kind: type) -> list[Any]:
    return [word.message for word in read_session(file) if isinstance(word.message, kind)]


def test_raw_measurements_and_what_was_sent_are_in_it(flown: Flown) -> None:
    assert len(spoken(flown.radio, Odometry)) > 4 * len(spoken(flown.radio, Ranges)) > 100
    commands = [w.message for w in read_session(flown.radio) if isinstance(w, Sent)]
    assert any(isinstance(message, Command) for message in commands)
    assert spoken(flown.radio, Health)


def test_what_came_over_the_radio_gives_nearly_the_same_flight(
    flown: Flown, tmp_path: Path
) -> None:
    figures = report(tmp_path, flown.radio)
    assert figures["ticks_with_odometry"] > 0.9 * figures["ticks"]
    assert figures["ticks_with_odometry"] + figures["ticks_without"] == figures["ticks"]
    assert figures["pose_apart_m_median_first_half"] < 0.1
    assert figures["of_those_the_same"] > 0.85
    assert figures["same_state"] > 0.5
    assert figures["checks"] == []


@pytest.mark.parametrize("kind", [Telemetry, Odometry])
def test_a_recording_that_begins_in_flight_is_not_computed(
    flown: Flown, kind: type[Telemetry] | type[Odometry]
) -> None:
    whole = read_session(flown.radio)
    high_s = next(word.time_s for word in whole if in_flight(word.message))
    session = [w for w in whole if not (isinstance(w.message, kind) and w.time_s < high_s)]
    with pytest.raises(GroundError, match="begins in flight"):
        RadioRerun(session, lambda *_: None).report()


def in_flight(message: object) -> bool:
    return isinstance(message, Telemetry) and message.pose.z_m > 0.3


def test_the_recording_has_what_was_measured_before_the_first_command(flown: Flown) -> None:
    session = [word.message for word in read_session(flown.radio)]
    begin = session[: next(i for i, word in enumerate(session) if isinstance(word, Command))]
    for kind in (Telemetry, Odometry, Ranges, Health):
        assert any(isinstance(word, kind) for word in begin), kind


def test_a_command_that_was_refused_is_not_given_again(flown: Flown) -> None:
    session = read_session(flown.radio)
    refused = {ack.sequence for ack in spoken(flown.radio, Ack) if ack.reason}
    commands = [word.message for word in session if isinstance(word.message, Command)]
    given = sum(command.sequence not in refused for command in commands)
    start_s = next(word.time_s for word in session if isinstance(word.message, Odometry))
    command = Command(7, MissionCmd.TAKE_OFF)
    answer = Ack(7, MissionCmd.TAKE_OFF, MissionReason.ESTIMATOR)
    session[:0] = [Sent(start_s, command), Heard(start_s, answer)]
    figures, _ = RadioRerun(session, lambda *_: None).report()
    assert figures["commands_sent"] == given
    assert figures["same_state"] > 0.5


def test_a_command_behind_many_packets_is_not_lost(flown: Flown) -> None:
    """More than the app's queue holds, all at one time: so it is when the ground falls behind."""
    session = read_session(flown.radio)
    first = next(i for i, word in enumerate(session) if isinstance(word.message, Command))
    beat = Sent(session[first].time_s, Heartbeat(0, 0))
    session[first:first] = [beat] * 50
    figures, _ = RadioRerun(session, lambda *_: None).report()
    assert figures["same_state"] > 0.5


def test_foxglove_finds_its_own_messages(flown: Flown) -> None:
    topics: dict[str, Any] = {}
    factory = DecoderFactory()
    schemas, channels = {}, {}
    with flown.radio.open("rb") as file:
        for record in StreamReader(file).records:
            match type(record).__name__:
                case "Schema":
                    schemas[record.id] = record
                case "Channel":
                    channels[record.id] = record
                case "Message" if channels[record.channel_id].topic.startswith("/view/"):
                    channel = channels[record.channel_id]
                    decode = factory.decoder_for(
                        channel.message_encoding, schemas[channel.schema_id]
                    )
                    topics[channel.topic] = decode(record.data)
    names = {"grid", "pose", "path", "log", "scan", "odometry", "frames"}
    assert set(topics) == {f"/view/{name}" for name in names}
    grid = topics["/view/grid"]
    assert len(grid.data) == grid.row_stride * grid.column_count == 128 * 128
    assert set(grid.data) == {0, 128, 255}
    assert topics["/view/pose"].frame_id == "map"


def test_its_map_is_one_for_map_server(flown: Flown, tmp_path: Path) -> None:
    """Read as map_server reads it, and compared with the true walls of the world."""
    run("map", "save", str(tmp_path / "room.yaml"), "--from", str(flown.radio))
    about = yaml.safe_load((tmp_path / "room.yaml").read_text())
    pixels = np.asarray(Image.open(tmp_path / about["image"]), float)
    occupied = np.argwhere((255 - pixels) / 255 > about["occupied_thresh"])
    free = np.argwhere((255 - pixels) / 255 < about["free_thresh"])
    assert len(occupied) > 100
    assert len(free) > 1000
    world = load_world(WORLD)

    def distances_m(cells: Any, upside_down: bool = False) -> Any:  # noqa: ANN401
        rows = cells[:, 0] if upside_down else len(pixels) - 1 - cells[:, 0]
        x_m = about["origin"][0] + about["resolution"] * (cells[:, 1] + 0.5)
        y_m = about["origin"][1] + about["resolution"] * (rows + 0.5)
        return world.surface_distance_m(np.column_stack(world.to_world(x_m, y_m)))

    assert np.median(np.abs(distances_m(occupied))) < 0.08
    assert np.percentile(np.abs(distances_m(occupied, upside_down=True)), 90) > 0.25
    assert np.mean(distances_m(free) > -0.1) > 0.95
    run("map", "save", str(tmp_path / "room.yaml"), "--from", str(flown.radio), code=1)


def test_a_map_is_loaded_where_the_drone_stands(flown: Flown, tmp_path: Path) -> None:
    room, after = tmp_path / "room.yaml", tmp_path / "after.npz"
    run("map", "save", str(room), "--from", str(flown.radio))
    with SimulatorProcess("--world", WORLD, "--speed", "max") as simulator:
        run("map", "load", str(room), "--pose=0.5,-0.25,1.57", "--uri", simulator.uri)
        run("map", "save", str(after), "--uri", simulator.uri)
        run("map", "load", str(after), "--pose", "0,0,0", "--uri", simulator.uri, code=2)
    held = load_map(after)
    laid = fit(load_ros(room), held, Pose(0.5, -0.25, 0.0, 1.57))
    assert np.array_equal(held.states, laid.states)
    assert np.count_nonzero(laid.states) > 1000


def test_the_newest_recording_is_taken_where_none_is_named(
    flown: Flown, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    run("plot", "--image", str(tmp_path / "a.png"), code=1)
    new_recording().write_bytes(b"")
    new_recording().write_bytes(flown.radio.read_bytes())
    run("plot", "--image", str(tmp_path / "a.png"))
    assert (tmp_path / "a.png").exists()


def test_poses_come_as_a_table(flown: Flown, tmp_path: Path) -> None:
    files = [str(tmp_path / name) for name in ("room.csv", "poses.csv")]
    run("map", "save", files[0], "--from", str(flown.radio), "--poses", files[1])
    table = np.genfromtxt(files[1], delimiter=",", names=True)
    assert len(table) == len(spoken(flown.radio, Telemetry))
    last = spoken(flown.radio, Telemetry)[-1].pose
    assert (table["x_m"][-1], table["y_m"][-1]) == pytest.approx((last.x_m, last.y_m), abs=1e-4)
    assert np.all(np.diff(table["time_s"]) >= 0)


@pytest.mark.parametrize("with_truth", [True, False])
def test_it_is_drawn(flown: Flown, tmp_path: Path, with_truth: bool) -> None:
    image = tmp_path / "flight.png"
    truth = ["--truth", str(flown.truth)] if with_truth else []
    run("plot", str(flown.radio), "--image", str(image), *truth)
    with Image.open(image) as drawn:
        assert drawn.size[0] > 1000
        assert len(drawn.convert("RGB").getcolors(1 << 24) or ()) > 50
    run("plot", str(flown.radio), "--image", str(image), code=1)


def test_events_of_the_flight_are_in_it(flown: Flown) -> None:
    assert spoken(flown.radio, Event)
