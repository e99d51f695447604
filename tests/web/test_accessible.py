# SPDX-License-Identifier: GPL-3.0-or-later
"""axe-core checks the page in all its states: on a desktop, on a phone, in light and dark."""

import socket
from collections.abc import Sequence

from axe_playwright_python.base import AXE_SCRIPT
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, expect

from ground.sim.process import SimulatorProcess
from tests.web.browsing import DESK, PHONE, Tab, tab_at
from tests.web.grounds import GroundProcess

GRAVE = ("serious", "critical")
CLOSED = "summary, [aria-expanded=false]"
OPPOSITE = ("desk-light", "phone-dark")
LOOKS = {
    "desk-light": (DESK, False),
    "desk-dark": (DESK, True),
    "phone-light": (PHONE, False),
    "phone-dark": (PHONE, True),
}


class Looks:
    """A page that is examined in every state, and the serious findings of axe."""

    def __init__(self, tab: Tab) -> None:
        self.tab = tab
        self.found: list[str] = []

    def examine(self, state: str, looks: Sequence[str] = OPPOSITE) -> None:
        """Examine the page in its present state."""
        script = AXE_SCRIPT
        for look in looks:
            (width, height), dark = LOOKS[look]
            self.tab.page.set_viewport_size({"width": width, "height": height})
            self.tab.page.emulate_media(color_scheme="dark" if dark else "light")
            self.tab.shot(f"{state}-{look}")
            issues = Axe(script).run(self.tab.page).response["violations"]
            script = ""  # the page has it by now
            for issue in issues:
                if issue["impact"] in GRAVE:
                    at = f"{state}-{look}: {issue['id']}"
                    self.found += [f"{at}: {node['html']}" for node in issue["nodes"]]

    def open_all(self, state: str) -> None:
        """Open each part of the page that can be opened."""
        parts = self.tab.page.locator(CLOSED).element_handles()
        for part in parts:
            if part.is_visible() and part.is_enabled():
                part.click()
                self.examine(f"{state}-{part.text_content().strip().lower()}")
                part.click()


def test_no_state_of_the_page_shuts_anybody_out(browser: Browser) -> None:
    with socket.socket(type=socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
    with (
        GroundProcess(f"udp://127.0.0.1:{port}") as ground,
        tab_at(browser, ground.address) as tab,
    ):
        looks = Looks(tab)
        tab.page.goto(ground.address)
        tab.until(lambda state: not state["can"]["goto"])
        looks.examine("no-drone")
        with SimulatorProcess("--world", "flat", "--speed", "2", port=port):
            tab.ready()
            looks.examine("on-the-ground")
            tab.click(1.0, 0.2)
            tab.until(lambda state: state["route"])
            looks.examine("flying", [*LOOKS])
            looks.open_all("flying")
            tab.page.keyboard.press("Space")
            tab.until(lambda state: state["stop"]["confirmed"])
            looks.examine("stopped")
        ground.kill()
        expect(tab.page.locator("#link")).to_contain_text("gone")
        looks.examine("no-server")
    assert not looks.found, "\n".join(looks.found)
