// SPDX-License-Identifier: GPL-3.0-or-later
/** @file mapstream.h  Which piece of the map to send next.
 *
 * Changed tiles go first. Every fourth piece belongs to a slow sweep over all tiles, which repeats
 * whatever was lost. A piece holds as many consecutive tiles as fit.
 *
 * Clients that take turns in reading the stream would each hear the same part of every sweep.
 * Therefore a sweep repeats its first piece at random, which shifts the turns. */
#ifndef MAPSTREAM_H
#define MAPSTREAM_H

#include <stdbool.h>
#include <stdint.h>

#include "grid.h"
#include "wire.h"

typedef struct {
  uint8_t sweep;  ///< next tile of the sweep
  uint8_t cursor; ///< the search for changed tiles continues behind this tile
  uint16_t dice;  ///< state of a linear congruential generator: bits 0-1 count the pieces modulo 4,
                  ///< the upper bits are random
} mapstream_t;

void mapstream_init(mapstream_t *stream);
/** Write the next piece, WIRE_MAP_BYTES long, and mark its tiles as unchanged. */
void mapstream_next(mapstream_t *stream, grid_t *grid, uint8_t epoch, uint8_t *bytes);
/** The reverse: draw a piece of a saved map into the grid, as weak evidence. A cell that is in the
 * same state already keeps its value. @return false if checksum or epoch do not match */
bool mapstream_take(grid_t *grid, uint8_t epoch, const uint8_t *bytes);

#endif
