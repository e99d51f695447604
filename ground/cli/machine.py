# SPDX-License-Identifier: GPL-3.0-or-later
"""What `wayflie doctor` finds without a drone: packages, the radio dongle, permissions."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from enum import Enum
from importlib.metadata import version
from pathlib import Path
from urllib.parse import urlsplit

from ground.errors import LinkUnavailable
from ground.link.drivers import check_uri, init_drivers

UsbIds = tuple[int, int]
DONGLES: dict[UsbIds, str] = {(0x1915, 0x7777): "Crazyradio", (0x35F0, 0xBAD2): "Crazyradio 2.0"}
CRAZYFLIES: dict[UsbIds, str] = {(0x0483, 0x5740): "Crazyflie"}
RULES_FILE = "/etc/udev/rules.d/99-bitcraze.rules"
SYSFS = Path("/sys/bus/usb/devices")


class Verdict(Enum):
    """Whether a finding prevents a flight."""

    GOOD = "good"
    NOTE = "note"
    BAD = "bad"


@dataclass(frozen=True, slots=True)
class Finding:
    """One examined thing, with the next step if something is missing."""

    what: str
    verdict: Verdict
    sentence: str
    next_step: str = ""

    def as_dict(self) -> dict[str, str]:
        """The finding as it goes into a report."""
        return asdict(self) | {"verdict": self.verdict.value}


@dataclass(frozen=True, slots=True)
class UsbDevice:
    """A USB device, and the file that opens it."""

    ids: UsbIds
    node: Path


def usb_devices(folder: Path = SYSFS) -> Iterator[UsbDevice]:
    """The USB devices that Linux lists; none on other systems."""
    for device in sorted(folder.glob("*/idVendor")):
        try:
            found = {
                name: (device.parent / name).read_text().strip()
                for name in ("idVendor", "idProduct", "busnum", "devnum")
            }
            ids = int(found["idVendor"], 16), int(found["idProduct"], 16)
            place = f"{int(found['busnum']):03}/{int(found['devnum']):03}"
        except (OSError, ValueError):
            continue  # unplugged in the meantime
        yield UsbDevice(ids, Path("/dev/bus/usb") / place)


def _may_use(path: Path) -> bool:
    return os.access(path, os.R_OK | os.W_OK)


def machine(
    uri: str,
    devices: Callable[[], Iterator[UsbDevice]] = usb_devices,
    may_use: Callable[[Path], bool] = _may_use,
) -> Iterator[Finding]:
    """Examine what this machine needs for this URI."""
    yield Finding("cflib", Verdict.GOOD, f"cflib {version('cflib')}")
    try:
        check_uri(uri)
        init_drivers()
    except LinkUnavailable as error:
        yield Finding("address", Verdict.BAD, str(error), "give --uri or CFLIB_URI; `wayflie scan`")
        return
    match urlsplit(uri).scheme:
        case "radio":
            yield _usb("Crazyradio", DONGLES, devices(), may_use, "plug a Crazyradio in")
        case "usb":
            yield _usb("USB cable", CRAZYFLIES, devices(), may_use, "plug the Crazyflie in")
        case "serial":
            yield _serial(uri.removeprefix("serial://"), may_use)


def _usb(
    what: str,
    wanted: dict[UsbIds, str],
    devices: Iterator[UsbDevice],
    may_use: Callable[[Path], bool],
    plug_in: str,
) -> Finding:
    found = [device for device in devices if device.ids in wanted]
    if not found:
        return Finding(what, Verdict.BAD, "none is plugged into this machine", plug_in)
    name = wanted[found[0].ids]
    if not any(may_use(device.node) for device in found):
        sentence = f"{name}: no permission for {found[0].node}"
        return Finding(what, Verdict.BAD, sentence, _rule(*found[0].ids))
    return Finding(what, Verdict.GOOD, name)


def _rule(vendor: int, product: int) -> str:
    return (
        f'write SUBSYSTEM=="usb", ATTRS{{idVendor}}=="{vendor:04x}", '
        f'ATTRS{{idProduct}}=="{product:04x}", MODE="0664", GROUP="plugdev" into {RULES_FILE}, '
        "`sudo usermod -aG plugdev $USER`, log in again, plug it in again"
    )


def _serial(device: str, may_use: Callable[[Path], bool]) -> Finding:
    path = Path(device) if device.startswith("/") else Path("/dev") / device
    if not path.is_char_device():
        step = "plug the adapter in; `wayflie scan` lists devices"
        return Finding("serial line", Verdict.BAD, f"{path} is not there", step)
    if not may_use(path):
        step = "`sudo usermod -aG dialout $USER`, then log in again"
        return Finding("serial line", Verdict.BAD, f"no permission for {path}", step)
    return Finding("serial line", Verdict.GOOD, str(path))
