# SPDX-License-Identifier: GPL-3.0-or-later
"""Contrast of two colours, as WCAG 2 defines it."""


def contrast(one: str, other: str) -> float:
    """Contrast of two colours like #0d9488, from 1 to 21."""
    dark, light = sorted((_luminance(one), _luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def _luminance(colour: str) -> float:
    """Relative luminance of a colour."""
    parts = [part / 255 for part in bytes.fromhex(colour[1:7])]
    red, green, blue = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
