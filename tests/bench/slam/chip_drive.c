// SPDX-License-Identifier: GPL-3.0-or-later
/* A part of a flight on the chip: what drive_fly() costs there is watched. */
#include <stdint.h>

#include "drive.h"
#include "port.h"

enum { TICKS_MAX = 750, TICK_MS = 20 };

typedef struct {
  vec2_t middle_m;
  float cell_m;
  int32_t ticks;
} flight_t;

static flight_t flight;
static drive_t drive;
static float poses[3 * TICKS_MAX];
static float ranges_m[SCAN_RANGES * TICKS_MAX];
static drive_said_t said[TICKS_MAX];

void port_main(void) {
  while (port_read(&flight, sizeof flight) && flight.ticks <= TICKS_MAX) {
    port_read(poses, 3u * (unsigned)flight.ticks * sizeof *poses);
    port_read(ranges_m, SCAN_RANGES * (unsigned)flight.ticks * sizeof *ranges_m);
    scan_config_t scan = scan_config_default();
    slam_config_t slam = slam_config_default();
    grid_config_t grid = grid_config_default();
    drive_start(&drive, &scan, &slam, &grid, flight.middle_m, flight.cell_m);
    drive_fly(&drive, poses, ranges_m, flight.ticks, TICK_MS, said);
    port_write(said, (unsigned)flight.ticks * sizeof *said);
  }
}
