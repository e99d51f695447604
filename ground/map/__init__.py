# SPDX-License-Identifier: GPL-3.0-or-later
"""The map on the ground, received in tiles, and its files."""
