// SPDX-License-Identifier: GPL-3.0-or-later
/** @file seen.h  Which tiles of the grid a beam crossed lately.
 *
 * The map says what was observed at any time, but doors close and people come, and four beams do
 * not notice that everywhere. Two bits per tile stand for the present and the previous half of the
 * time age_s for which a look counts. So a look counts for at least half of age_s and at most all
 * of it. */
#ifndef SEEN_H
#define SEEN_H

#include <stdbool.h>
#include <stdint.h>

#include "grid.h"
#include "scan.h"

typedef struct {
  uint32_t now[GRID_TILE_WORDS];    ///< tiles crossed since turned_ms
  uint32_t before[GRID_TILE_WORDS]; ///< tiles crossed in the half before
  uint32_t turned_ms;               ///< start of the present half
} seen_t;

void seen_forget(seen_t *seen);
/** To be called each tick. @param age_s  how long a look counts */
void seen_step(seen_t *seen, uint32_t time_ms, float age_s);
/** Mark the tiles that the beams of a set crossed, measured with the body at map_pose. */
void seen_mark(seen_t *seen, const grid_t *grid, const scan_frame_t *frame, pose2_t map_pose);
/** True if the tile of the point was crossed lately; false outside the grid. */
bool seen_lately(const seen_t *seen, const grid_t *grid, vec2_t point_m);

#endif
