# SPDX-License-Identifier: GPL-3.0-or-later
"""For each way of breaking a rule of the code on purpose, a gate reports it."""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools import gates
from tests.tools.objects import CHIP, CHIP_STRICT, FIRMWARE_APP, Objects, compile_tree

PRAGMA = '#pragma GCC optimize("fp-contract=off")\n'
Edit = Callable[[str], str]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Objects:
    """Core and app, unchanged."""
    return compile_tree(CHIP, tmp_path_factory.mktemp("sound"))


@pytest.fixture
def copy(sound: Objects, tmp_path: Path) -> Objects:
    """A copy of them, to be changed."""
    shutil.copytree(FIRMWARE_APP, tmp_path / "source")
    shutil.copytree(sound.folder, tmp_path / "objects")
    return Objects(sound.toolchain, tmp_path / "source", tmp_path / "objects")


def break_in(copy: Objects, file: str, edit: Edit) -> list[str]:
    """Change one file, recompile what depends on it, and collect what the gates report."""
    path = copy.source / file
    before = path.read_text()
    path.write_text(edit(before))
    assert path.read_text() != before
    sources = [path] if path.suffix == ".c" else sorted((copy.source / "app").glob("*.c"))
    try:
        copy.compile(*sources)
    except subprocess.CalledProcessError as error:
        return [str(error.stderr)]
    return [complaint for gate in gates.GATES for complaint in gate(copy)]


def add(code: str) -> Edit:
    return lambda text: f"{text}\n{code}\n"


def test_without_a_change_nothing_is_reported(copy: Objects) -> None:
    assert break_in(copy, "core/route.c", add("// as before")) == []


# Added to route.c: what, how, and what a gate says to it.
BREAKS = [
    ("a function of libm", "float sinf(float); float x(float a) { return sinf(a); }", "needs sinf"),
    ("a double constant", "float x(float a) { return (float)(a * 4.0); }", "double-promotion"),
    ("double arithmetic", "double x(double a) { return a * 4.0; }", "needs __aeabi_dmul"),
    ("conversion to double", "double x(float a) { return (double)a; }", "needs __aeabi_f2d"),
    ("the heap", "void *malloc(unsigned); void *x(void) { return malloc(8); }", "needs malloc"),
    ("the console", 'int puts(const char *); int x(void) { return puts(""); }', "needs puts"),
    ("a global", "int x;", "route keeps x"),
    ("a hidden static", "int x(void) { static int kept = 3; return ++kept; }", "route keeps kept."),
    ("a large frame", "void x(void) { volatile char a[300]; a[0] = 1; }", "frame of 304 bytes"),
    ("a growing frame", "void x(int n) { volatile char a[n]; a[0] = 1; }", "frame that grows"),
    ("a large table", "const char x[65536] = {1};", "bytes of flash"),
]


@pytest.mark.parametrize(
    ("code", "complaint"), [rest for _, *rest in BREAKS], ids=[name for name, *_ in BREAKS]
)
def test_breaking_a_rule_of_the_core_is_reported(copy: Objects, code: str, complaint: str) -> None:
    reported = break_in(copy, "core/route.c", add(code))
    assert any(complaint in line for line in reported), reported


def tower(floors: int, bytes_each: int) -> str:
    """A chain of functions, each calling the next; the first is x0."""
    code = f"__attribute__((noinline)) static void x{floors}(volatile char *a) {{ a[0] = 1; }}"
    for i in reversed(range(floors)):
        code += (
            f"\n__attribute__((noinline)) static void x{i}(volatile char *a)"
            f"{{ volatile char b[{bytes_each}]; b[0] = a[0]; x{i + 1}(b); a[0] = b[0]; }}"
        )
    return code


# Added to nav.c, and called in every tick: so it lies on the way down from the app's task.
DEEP = [
    (
        "recursion",
        "static float x(float a) { return a < 1.0f ? a : x(a - 1.0f) * x(a - 2.0f); }",
        "nav->tick_s = x(nav->tick_s);",
        "recursion: appMain > ",
    ),
    (
        "recursion by a detour",
        "void x(nav_t *nav) { while (nav->epoch > 9) { nav_step(nav, &nav->input); } }",
        "x(nav);",
        "recursion: appMain > ",
    ),
    ("a pointer", "", "((void (*)(void))(uintptr_t)nav->epoch)();", "whose frame is not known"),
    ("a tower", tower(9, 200), "x0((volatile char *)nav);", "bytes of stack: appMain > "),
]


@pytest.mark.parametrize(
    ("code", "call", "complaint"), [rest for _, *rest in DEEP], ids=[name for name, *_ in DEEP]
)
def test_a_stack_without_a_bound_is_reported(
    copy: Objects, code: str, call: str, complaint: str
) -> None:
    function = "static void take_input(nav_t *nav, const nav_input_t *input) {\n"

    def edit(text: str) -> str:
        return text.replace(function, f"{code}\n{function}{call}\n")

    reported = break_in(copy, "core/nav.c", edit)
    assert any(complaint in line for line in reported), reported


@pytest.mark.parametrize("file", ["geometry.c", "slam.c", "selftest.c", "rrtstar.c"])
def test_fusing_is_reported(copy: Objects, file: str) -> None:
    reported = break_in(copy, f"core/{file}", lambda text: text.replace(PRAGMA, ""))
    assert any(f"{Path(file).stem} fuses: vf" in line for line in reported), reported


NAV_LIMIT_BYTES = 21_504


@pytest.mark.parametrize("over", [0, 1])
def test_a_word_too_much_in_nav_is_reported(copy: Objects, over: int) -> None:
    """The compiler reports it, in the firmware's own build too; nav_t grows by words."""
    words = (NAV_LIMIT_BYTES - gates.nav_bytes(copy)) // 4 + over
    reported = break_in(
        copy,
        "core/nav.h",
        lambda text: text.replace("} nav_t;", f"  uint32_t x[{words}];\n}} nav_t;"),
    )
    assert any("takes more memory than it may" in line for line in reported) == bool(over), reported


@pytest.mark.parametrize("over", [0, 1])
def test_a_byte_too_much_in_the_app_is_reported(copy: Objects, over: int) -> None:
    room = gates.RAM_LIMIT_BYTES - gates.ram_bytes(copy) + over
    reported = break_in(copy, "app/app_text.c", add(f"char app_text_x[{room}];"))
    assert reported == [f"{gates.RAM_LIMIT_BYTES + 1} bytes of static RAM"] * over


def test_a_function_of_the_firmware_that_nobody_approved_is_reported(copy: Objects) -> None:
    code = "void motorsStop(void); void app_text_x(void) { motorsStop(); }"
    assert "app_text needs motorsStop" in break_in(copy, "app/app_text.c", add(code))


def test_the_two_sets_of_flags_differ_in_what_they_allow(tmp_path: Path) -> None:
    """Without the pragma only the firmware's flags fuse, so testing with one set is not enough."""
    shutil.copytree(FIRMWARE_APP, tmp_path / "source")
    path = tmp_path / "source" / "core" / "geometry.c"
    path.write_text(path.read_text().replace(PRAGMA, ""))
    for toolchain, fuses in ((CHIP, True), (CHIP_STRICT, False)):
        folder = tmp_path / toolchain.name
        folder.mkdir()
        objects = Objects(toolchain, tmp_path / "source", folder)
        objects.compile(path)
        assert bool(gates.fused(objects)) == fuses
