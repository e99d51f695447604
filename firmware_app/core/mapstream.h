// SPDX-License-Identifier: GPL-3.0-or-later
/** @file mapstream.h  Which piece of the map to send next: changed tiles first, a slow sweep of all
 * the rest between. Every fourth piece belongs to the sweep, so that whatever was lost comes again.
 * A piece takes along the tiles behind its first one for as long as they fit. Listeners that take
 * turns would each hear the same part of every sweep: by chance it begins with its first piece once
 * more.
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
  uint16_t dice;  ///< bits 0-1: number of the piece; upper ones: by chance
} mapstream_t;

void mapstream_init(mapstream_t *stream);
/** Fill WIRE_MAP_BYTES with the next piece and forget that its tiles had changed. */
void mapstream_next(mapstream_t *stream, grid_t *grid, uint8_t epoch, uint8_t *bytes);
/** The other way: put a piece that was kept into the grid, with little evidence; a cell that
 * believes the same already stays. @return false if its check or its epoch does not match */
bool mapstream_take(grid_t *grid, uint8_t epoch, const uint8_t *bytes);

#endif
