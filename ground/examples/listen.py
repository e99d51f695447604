# SPDX-License-Identifier: GPL-3.0-or-later
"""Listen to the drone while it flies, and print the smallest distance that it has measured."""

import asyncio
import math

from ground import Station
from ground.model import Ranges


async def watch(drone: Station) -> None:
    """Print each distance that is smaller than all before."""
    smallest_m = math.inf
    with drone.listen() as listener:
        while True:
            message = await listener.next()
            if isinstance(message, Ranges):
                sides = (message.front_m, message.back_m, message.left_m, message.right_m)
                nearest_m = min((side for side in sides if side is not None), default=math.inf)
                if nearest_m < smallest_m:
                    smallest_m = nearest_m
                    print(f"{smallest_m:.2f} m")


async def main() -> None:
    """Take off, look around and land, while watch() listens."""
    async with Station.connect() as drone:
        watching = asyncio.create_task(watch(drone))
        await drone.take_off()
        await drone.look_around()
        await drone.land()
        watching.cancel()


if __name__ == "__main__":
    asyncio.run(main())
