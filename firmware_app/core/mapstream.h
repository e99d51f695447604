// SPDX-License-Identifier: GPL-3.0-or-later
/** @file mapstream.h  Which piece of the map to send next: changed tiles first, a slow sweep of all
 * the rest between. Every fourth piece belongs to the sweep, so that whatever was lost comes again.
 */
#ifndef MAPSTREAM_H
#define MAPSTREAM_H

#include <stdbool.h>
#include <stdint.h>

#include "grid.h"
#include "wire.h"

typedef struct {
  uint8_t sweep;  ///< next tile of the sweep
  uint8_t cursor; ///< where the search for changed tiles goes on
  uint8_t turn;
  uint8_t rotation; ///< which points of a crowded tile go first
} mapstream_t;

void mapstream_init(mapstream_t *stream);
/** Fill WIRE_MAP_BYTES with the next piece and forget that its tile had changed. */
void mapstream_next(mapstream_t *stream, grid_t *grid, uint8_t epoch, uint8_t *bytes);
/** The other way: put a piece that was kept into the grid, with little evidence; a cell that
 * believes the same already stays. @return false if its check or its epoch does not match */
bool mapstream_take(grid_t *grid, uint8_t epoch, const uint8_t *bytes);

#endif
