# SPDX-License-Identifier: GPL-3.0-or-later
"""Every command and every line of code in the README is run, in its order, on simulated drones.

What measures for minutes has left its report in tests/bench/measured; what needs a machine of its
own is run by CI, or by another test. What is added or replaced here stands in ADDED and INSTEAD.
"""

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.request import HTTPCookieProcessor, build_opener

import pytest

from tests.project.files import ROOT
from tests.project.readme import code, commands, was_measured

ADDED = {
    # beside other tests; fast, but not so that it takes a whole core while it waits
    "sim": ("--port", "0", "--speed", "25"),
    "ground": ("--port", "0"),
    "replay": ("--port", "0"),
}
INSTEAD = {
    "CRAZYFLIE_BASE=../crazyflie-firmware": "CRAZYFLIE_BASE=/dev/null",  # somebody may have one
}
ELSEWHERE = {
    "make demo": (".ci/run", "step demo"),
    "make demo HEADLESS=1 JSON=out.json": (".ci/run", "step demo HEADLESS=1 JSON=out.json"),
    "make test": (".ci/run", "make test"),
    "make check": (".ci/run", "step check"),
    "make mutate": ("tests/analysis/test_mutate.py", "tests.tools.mutate"),
    "make fuzz": ("tests/fuzz/test_fuzz.py", "tests.tools.fuzz"),
    "make prove": (".ci/run", "step prove"),
    "make sizes": ("tests/project/test_sizes.py", "tests.tools.sizes"),
    # these three look at ports that only one test may use
    "wayflie scan": ("tests/web/test_station.py", '"scan"'),
    "wayflie sim --drones 4": ("tests/web/test_station.py", "drones=2"),
    "wayflie ground --all": ("tests/web/test_station.py", '"--all"'),
}
ENDS = {  # with what code, having said what; otherwise with 0
    "make firmware": (2, "must be a checkout of crazyflie-firmware"),
    "make flash": (0, "cfloader flash firmware_app/build/cf2.bin stm32-fw"),
    "wayflie doctor": (1, "Crazyradio"),
    "wayflie ground": (130, "http://127.0.0.1"),
    "wayflie ground --bind": (130, "?token="),
    "wayflie goto": (0, "arrived"),
    "wayflie explore": (0, "everything that can be reached is explored"),
    "wayflie map save": (0, "room.yaml"),
    "wayflie map load": (0, "known cells sent"),
    "wayflie replay": (130, "recording"),
    "wayflie plot": (0, "flight.png"),
}
(SIM,) = (words for words in commands() if words[1:3] == ["sim", "--world"])
SMALL = "empty"  # a world that is explored in a third of the time
HERE = [
    words
    for words in commands()
    if not was_measured(words) and " ".join(words) not in ELSEWHERE and words[1:2] != ["sim"]
]


@dataclass(frozen=True, slots=True)
class Ended:
    """How a command ended."""

    code: int
    said: str


def full(words: list[str]) -> list[str]:
    """The command to run for these words of the README."""
    words = [INSTEAD.get(word, word) for word in words]
    if words[0] == "make":
        pretended = ["-n", "-o", ".venv-cfclient/.installed"] if words[1] == "flash" else []
        return ["make", "--no-print-directory", "-C", str(ROOT), *pretended, *words[1:]]
    added = ADDED.get(words[1], ()) if words[1:] else ()
    return [sys.executable, "-m", "ground", *words[1:], *added]


@contextlib.contextmanager
def started(command: list[str], folder: Path, uri: str = "") -> Iterator[subprocess.Popen[str]]:
    """It runs there and means that drone; it is killed if it is not ended meanwhile."""
    place = {"XDG_DATA_HOME": str(folder / "data"), "HOME": str(folder), "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        command, cwd=folder, env=os.environ | place | {"CFLIB_URI": uri},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            process.kill()


@contextlib.contextmanager
def drone(world: str, folder: Path) -> Iterator[str]:
    """A simulated one, by the README's own line but for the world; its URI."""
    with started(full([*SIM[:3], world]), folder) as simulator:
        assert simulator.stdout is not None
        found = re.search(r"udp://[\d.:]+", simulator.stdout.readline())
        assert found
        yield found[0]
        simulator.send_signal(signal.SIGINT)
        assert simulator.wait() == 0


def run(words: list[str], folder: Path, uri: str) -> Ended:
    """To its end, which is Ctrl-C once its page has answered if it has one."""
    with started(full(words), folder, uri) as process:
        said = ""
        if words[1:2] in (["ground"], ["replay"]):
            assert process.stdout is not None
            said = process.stdout.readline()
            (address,) = re.findall(r"http://\S+", said)
            with build_opener(HTTPCookieProcessor()).open(address) as page:
                assert b"<title>Wayflie" in page.read()
            process.send_signal(signal.SIGINT)
        rest, _ = process.communicate()
        return Ended(process.returncode, said + rest)


def ending(words: list[str]) -> tuple[int, str]:
    """What ENDS says of the longest beginning of these words."""
    beginnings = [" ".join(words[:count]) for count in range(len(words), 0, -1)]
    return next((ENDS[one] for one in beginnings if one in ENDS), (0, "wayflie"))


@pytest.mark.timeout(1800)
def test_every_command_runs_and_says_what_it_did(tmp_path: Path) -> None:
    assert len(HERE) >= 14
    with drone(SIM[3], tmp_path) as first:
        for words in HERE:
            with contextlib.ExitStack() as stack:
                exploring = words[1:] == ["explore"]
                uri = stack.enter_context(drone(SMALL, tmp_path)) if exploring else first
                ended = run(words, tmp_path, uri)
            code, said = ending(words)
            assert ended.code == code, f"{words}: {ended.said}"
            assert said in ended.said, f"{words}: {ended.said}"
    left = {path.name for path in tmp_path.iterdir()}
    assert {"room.yaml", "room.pgm", "flight.mcap", "flight.png"} <= left


@pytest.mark.parametrize("line", ELSEWHERE)
def test_what_is_not_run_here_is_run_elsewhere(line: str) -> None:
    assert line.split() in commands()
    file, said = ELSEWHERE[line]
    assert said in (ROOT / file).read_text()


def test_the_code_does_what_it_says(tmp_path: Path) -> None:
    (program,) = code("python")
    command = [sys.executable, "-c", program]
    with drone(SMALL, tmp_path) as uri, started(command, tmp_path, uri) as process:
        said, _ = process.communicate()
    assert process.returncode == 0, said
    assert (tmp_path / "room.yaml").exists()
    assert re.search(r"^\[\[10\.5 +20\.5", said, re.MULTILINE)
