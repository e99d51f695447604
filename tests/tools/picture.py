# SPDX-License-Identifier: GPL-3.0-or-later
"""The README's picture: the page of a demo, taken when the drone has arrived.

`python -m tests.tools.picture FILE.png` (make picture); needs chromium.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

PORT = 8790
PAGE_MS = 30_000
FLIGHT_MS = 300_000
VIEWPORT = {"width": 1280, "height": 800}


def open_page(page: Page) -> None:
    """Load the page of the demo, which takes a moment to serve it."""
    for _ in range(PAGE_MS // 500):
        try:
            page.goto(f"http://127.0.0.1:{PORT}/")
            return
        except Exception as error:
            if "ERR_CONNECTION_REFUSED" not in str(error):
                raise
            page.wait_for_timeout(500)
    raise SystemExit("the demo's page does not answer")


def take(path: Path) -> None:
    """Fly the demo in real time and save its page on arrival."""
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("chromium is missing")
    demo = subprocess.Popen(
        [sys.executable, "-m", "ground", "demo", "--port", str(PORT)],
        stdout=subprocess.DEVNULL,
    )
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=chromium, args=["--no-sandbox", "--disable-gpu"]
            )
            page = browser.new_page(viewport=VIEWPORT)
            open_page(page)
            page.get_by_text("arrived").first.wait_for(timeout=FLIGHT_MS)
            page.screenshot(path=path)
            browser.close()
    finally:
        demo.terminate()
        demo.wait(timeout=30)


if __name__ == "__main__":
    take(Path(sys.argv[1]))
