# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulator: a Crazyflie (body, sensors, firmware) in a world, reached by radio packets."""
