# SPDX-License-Identifier: GPL-3.0-or-later
"""The station's client beside another one: writes a parameter repeatedly until it is ended.

    python beside.py URI

Prints JSON when it is sent SIGTERM: what was written, what was not confirmed, what was lost.
"""

import asyncio
import json
import signal
import sys

from ground.errors import NoAnswer
from ground.link.radio import RadioLink
from ground.station.station import station_on

PAUSE_S = 0.2


async def work(uri: str) -> dict[str, int]:
    ended = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, ended.set)
    written = unanswered = other = 0
    seen: set[float] = set()
    async with station_on(RadioLink(uri)) as station:
        print("there", flush=True)
        while not ended.is_set():
            value = written % 64 / 64
            try:
                other += await station.set_parameter("way.goalY", value) != value
            except NoAnswer:
                unanswered += 1
            seen.add(station.picture.parameters.get("way.goalX", 0.0))
            written += 1
            await asyncio.sleep(PAUSE_S)
        stats = station.stats
    return {
        "written": written,
        "unanswered": unanswered,
        "other": other,
        "heard": len(seen),
        "log_packets": stats.log_packets,
        "lost_packets": stats.lost_packets,
    }


if __name__ == "__main__":
    print(json.dumps(asyncio.run(work(sys.argv[1]))), flush=True)
