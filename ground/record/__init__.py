# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of sessions: written, read, replayed, exported and plotted."""
