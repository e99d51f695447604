# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a recording: how far the drone flew, and its last map as SVG. Without a name, the newest."""

import math
import sys
from itertools import pairwise
from pathlib import Path

from ground.mapfile import save_map
from ground.model import Telemetry
from ground.picture import Picture
from ground.recordfolder import newest_recording
from ground.recording import read_recording


def main() -> None:
    """Read it."""
    named = [Path(name) for name in sys.argv[1:]]
    file = named[0] if named else newest_recording()
    picture, places = Picture(), []
    for time_s, message in read_recording(file):
        picture.take(message, time_s)
        if isinstance(message, Telemetry) and message.state.airborne:
            places.append((message.pose.x_m, message.pose.y_m))
    print(f"{file}: {sum(math.dist(a, b) for a, b in pairwise(places)):.1f} m")
    save_map(picture.map, Path("recording.svg"))


if __name__ == "__main__":
    main()
