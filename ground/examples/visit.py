# SPDX-License-Identifier: GPL-3.0-or-later
"""Visit some places, and report those that cannot be reached."""

import asyncio

from ground import NotReached, Station

PLACES_M = ((1.0, 0.5), (99.0, 0.0), (1.0, -0.5))


async def main() -> None:
    """Fly to each place in turn, then home."""
    async with Station.connect() as drone:
        for x_m, y_m in PLACES_M:
            try:
                await drone.goto(x_m, y_m)
                print(f"at ({x_m}, {y_m}):", drone.ranges)
            except NotReached as error:
                print(f"({x_m}, {y_m}) left out: {error}")
        await drone.home()


if __name__ == "__main__":
    asyncio.run(main())
