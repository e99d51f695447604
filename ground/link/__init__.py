# SPDX-License-Identifier: GPL-3.0-or-later
"""The link to a drone by radio, USB, serial or UDP: keeping it up, and the packets on it."""
