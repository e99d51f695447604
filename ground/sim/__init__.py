# SPDX-License-Identifier: GPL-3.0-or-later
"""A simulated Crazyflie: world, body, sensors, and the radio protocol in front of them."""
