// SPDX-License-Identifier: GPL-3.0-or-later
/* A lost drone's flight on the chip: every call of reloc_work() is watched there. */
#include <stdint.h>

#include "lost.h"
#include "port.h"

enum { TICKS_MAX = 750, TICK_MS = 20 };

typedef struct {
  uint32_t cells[GRID_CELLS / 8];
  vec2_t middle_m;
  float cell_m;
  int32_t ticks, budget;
} flight_t;

static flight_t flight;
static grid_t grid;
static lost_t lost;
static float poses[3 * TICKS_MAX];
static float ranges_m[SCAN_RANGES * TICKS_MAX];
static lost_said_t said[TICKS_MAX];

static void read_map(void) {
  grid_config_t config = grid_config_default();
  grid_init(&grid, &config, flight.middle_m, flight.cell_m);
  for (int i = 0; i < GRID_CELLS; i++) {
    int value = (int)(flight.cells[i / 8] >> (i % 8 * 4) & 15u);
    grid_set_value(&grid, i % GRID_SIDE_CELLS, i / GRID_SIDE_CELLS, value);
  }
}

void port_main(void) {
  while (port_read(&flight, sizeof flight) && flight.ticks <= TICKS_MAX) {
    port_read(poses, 3u * (unsigned)flight.ticks * sizeof *poses);
    port_read(ranges_m, SCAN_RANGES * (unsigned)flight.ticks * sizeof *ranges_m);
    read_map();
    scan_config_t scan = scan_config_default();
    lost_fly(&lost, &grid, &scan, poses, ranges_m, flight.ticks, TICK_MS, flight.budget, said);
    port_write(said, (unsigned)flight.ticks * sizeof *said);
  }
}
