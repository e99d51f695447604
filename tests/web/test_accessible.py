# SPDX-License-Identifier: GPL-3.0-or-later
"""axe-core looks at the page in all its states: at a desk, on a phone, in light and dark."""

import socket
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, expect

from ground.sim.process import SimulatorProcess
from tests.web.browsing import DESK, PHONE, Tab, tab_at
from tests.web.grounds import GroundProcess

GRAVE = ("serious", "critical")
CLOSED = "summary, [aria-expanded=false]"
LOOKS = {
    "desk-light": (DESK, False),
    "desk-dark": (DESK, True),
    "phone-light": (PHONE, False),
    "phone-dark": (PHONE, True),
}


class Looks:
    """The same page in all looks at once, and what axe found grave in any of them."""

    def __init__(self, tabs: dict[str, Tab]) -> None:
        self.tabs = tabs
        self.found: list[str] = []

    @property
    def one(self) -> Tab:
        """Whichever: what is done in it is seen in all."""
        return next(iter(self.tabs.values()))

    def examine(self, state: str) -> None:
        """All of them, as they are now."""
        for look, tab in self.tabs.items():
            self._examine(f"{state}-{look}", tab)

    def open_all(self, state: str) -> None:
        """Each part that can be opened, opened and closed again."""
        for look, tab in self.tabs.items():
            for number in range(tab.page.locator(CLOSED).count()):
                part = tab.page.locator(CLOSED).nth(number)
                if part.is_visible() and part.is_enabled():
                    part.click()
                    self._examine(f"{state}-open{number + 1}-{look}", tab)
                    tab.page.keyboard.press("Escape")

    def _examine(self, name: str, tab: Tab) -> None:
        tab.shot(name)
        for issue in Axe().run(tab.page).response["violations"]:
            if issue["impact"] in GRAVE:
                self.found += [f"{name}: {issue['id']}: {n['html']}" for n in issue["nodes"]]


@pytest.fixture
def looks(browser: Browser) -> Iterator[tuple[Looks, GroundProcess, int]]:
    """Pages of a station whose drone is not there yet, and the port that it will be at."""
    with socket.socket(type=socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
    with ExitStack() as stack:
        ground = stack.enter_context(GroundProcess(f"udp://127.0.0.1:{port}"))
        tabs = {
            name: stack.enter_context(tab_at(browser, ground.address, size, dark))
            for name, (size, dark) in LOOKS.items()
        }
        yield Looks(tabs), ground, port


def test_no_state_of_the_page_shuts_anybody_out(
    looks: tuple[Looks, GroundProcess, int],
) -> None:
    shown, ground, port = looks
    for tab in shown.tabs.values():
        tab.page.goto(ground.address)
        tab.until(lambda state: not state["can"]["goto"])
    shown.examine("no-drone")
    with SimulatorProcess("--world", "flat", "--speed", "2", port=port):
        for tab in shown.tabs.values():
            tab.ready()
        shown.examine("on-the-ground")
        shown.open_all("on-the-ground")
        shown.one.click(1.0, 0.2)
        for tab in shown.tabs.values():
            tab.until(lambda state: state["route"])
        shown.examine("flying")
        shown.open_all("flying")
        shown.one.page.keyboard.press("Space")
        for tab in shown.tabs.values():
            tab.until(lambda state: state["stop"]["confirmed"])
        shown.examine("stopped")
    ground.kill()
    for tab in shown.tabs.values():
        expect(tab.page.locator("#link")).to_contain_text("gone")
    shown.examine("no-server")
    assert not shown.found, "\n".join(shown.found)
