# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a recording (the newest by default): print the distance flown, save the last map as SVG."""

import math
import sys
from itertools import pairwise
from pathlib import Path

from ground.map.files import save_map
from ground.model import Telemetry
from ground.record.folder import newest_recording
from ground.record.reader import read_recording
from ground.station.picture import Picture


def main() -> None:
    """Read the file named on the command line, or the newest recording."""
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
