# SPDX-License-Identifier: GPL-3.0-or-later
"""The README's pictures: the page of a demo when the drone has arrived, and how it got there.

`python -m tests.tools.picture FILE.png FILE.webp` (make picture); needs chromium.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
import time
from pathlib import Path

from PIL import Image
from playwright.sync_api import Locator, Page, sync_playwright

PORT = 8790
PAGE_MS = 30_000
FLIGHT_S = 300.0
VIEWPORT = {"width": 1280, "height": 800}
SHOT_EVERY_S = 0.5
FRAME_MS = 100
LAST_FRAME_MS = 3000
WIDE = 640
FRAMES_MAX = 100
QUALITIES = (60, 40)
BYTES_MAX = 1_000_000


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


def shot(of: Locator) -> Image.Image:
    """A small screenshot of the present page."""
    image = Image.open(io.BytesIO(of.screenshot())).convert("RGB")
    return image.resize((WIDE, round(image.height * WIDE / image.width)), Image.Resampling.LANCZOS)


def watch(page: Page) -> list[Image.Image]:
    """Take screenshots of the map until the drone has arrived."""
    shots, canvas = [], page.locator("section.map")
    begin_s = time.monotonic()
    arrived = page.locator("#events").get_by_text("arrived", exact=True)
    while not arrived.count():
        if time.monotonic() - begin_s > FLIGHT_S:
            raise SystemExit("the drone does not arrive")
        shots.append(shot(canvas))
        due_s = begin_s + len(shots) * SHOT_EVERY_S
        page.wait_for_timeout(max(0.0, 1000 * (due_s - time.monotonic())))
    return [*shots, shot(canvas)]


def save_animation(shots: list[Image.Image], path: Path) -> None:
    """Save an animation as fine as a README permits."""
    few = shots[:: -(-len(shots) // FRAMES_MAX)]
    frames = few if few[-1] is shots[-1] else [*few, shots[-1]]
    pauses_ms = [FRAME_MS] * (len(frames) - 1) + [LAST_FRAME_MS]
    for quality in QUALITIES:
        frames[0].save(
            path, save_all=True, append_images=frames[1:], duration=pauses_ms, loop=0,
            quality=quality,
        )  # fmt: skip
        if path.stat().st_size <= BYTES_MAX:
            return
    raise SystemExit(f"{path} has {path.stat().st_size} bytes: too many for a README")


def take(still: Path, animation: Path) -> None:
    """Fly the demo in real time; save its page on arrival, and the flight."""
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("chromium is missing")
    demo = subprocess.Popen(
        [sys.executable, "-m", "ground", "demo", "--port", str(PORT), "--record", "off"],
        stdout=subprocess.DEVNULL,
    )
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=chromium, args=["--no-sandbox", "--disable-gpu"]
            )
            page = browser.new_page(viewport=VIEWPORT)
            open_page(page)
            shots = watch(page)
            page.screenshot(path=still)
            browser.close()
    finally:
        demo.terminate()
        demo.wait(timeout=30)
    save_animation(shots, animation)


if __name__ == "__main__":
    take(Path(sys.argv[1]), Path(sys.argv[2]))
