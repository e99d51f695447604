# SPDX-License-Identifier: GPL-3.0-or-later
"""Explore a room and save its map for ROS and as an image."""

import asyncio

from ground import Station


async def main() -> None:
    """Fly."""
    async with Station.connect() as drone:
        await drone.explore()
        for name in ("room.yaml", "room.png"):
            await drone.save_map(name, overwrite=True)


if __name__ == "__main__":
    asyncio.run(main())
