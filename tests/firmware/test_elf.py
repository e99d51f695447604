# SPDX-License-Identifier: GPL-3.0-or-later
"""The chip's ELF holds the documented parameters and log variables."""

from dataclasses import replace
from pathlib import Path

import pytest

from ground import docparams
from tests.tools import elf_tables
from tests.tools.objects import CHIP, FIRMWARE_APP


@pytest.fixture(scope="module")
def elf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An ELF of the app's files that declare tables, without what they call."""
    folder = tmp_path_factory.mktemp("elf")
    files = [
        path for path in (FIRMWARE_APP / "app").glob("*.c") if "_GROUP_START" in path.read_text()
    ]
    assert {path.name for path in files} == {docparams.PARAMS, docparams.LOGS, docparams.MAP}
    includes = [f"-I{FIRMWARE_APP / part}" for part in ("app", "core", "host")]
    link = ["-nostdlib", "-Wl,--unresolved-symbols=ignore-all,--no-warn-rwx-segments,-e0"]
    CHIP.run("gcc", *CHIP.flags, *includes, *link, *files, "-o", "tables.elf", cwd=folder)
    return folder / "tables.elf"


def test_the_tables_in_the_elf_are_those_of_the_doc_comments(elf: Path) -> None:
    assert elf_tables.differences(elf) == []
    assert elf_tables.params_of(elf, "way")["height"].stored


def test_a_table_that_differs_is_told(elf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = dict(docparams.parameters())
    told["speed"] = replace(told["speed"], stored=False)
    del told["cmd"]
    monkeypatch.setattr(elf_tables, "parameters", lambda: told)
    lines = elf_tables.differences(elf)
    assert [line.partition(":")[0] for line in lines] == [
        "parameter way.cmd",
        "parameter way.speed",
    ]


def test_an_elf_without_the_app_is_told(tmp_path: Path) -> None:
    (tmp_path / "empty.c").write_text("int main(void) { return 0; }\n")
    CHIP.run("gcc", *CHIP.flags, "-nostdlib", "-Wl,-e0", "empty.c", "-o", "empty.elf", cwd=tmp_path)
    with pytest.raises(LookupError, match="no table way"):
        elf_tables.differences(tmp_path / "empty.elf")
