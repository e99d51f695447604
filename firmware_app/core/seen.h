// SPDX-License-Identifier: GPL-3.0-or-later
/** @file seen.h  What was looked at lately: one bit for each tile of the grid, in two halves of the
 * time that a look counts. The map says what was ever there; doors close and people come, and four
 * beams do not see them everywhere. A tile counts for at least half of the time and at most all of
 * it. */
#ifndef SEEN_H
#define SEEN_H

#include <stdbool.h>
#include <stdint.h>

#include "grid.h"
#include "scan.h"

typedef struct {
  uint32_t now[GRID_TILE_WORDS];
  uint32_t before[GRID_TILE_WORDS];
  uint32_t turned_ms; ///< when `now` began
} seen_t;

void seen_forget(seen_t *seen);
/** Once a tick. age_s: how long a look counts. */
void seen_step(seen_t *seen, uint32_t time_ms, float age_s);
/** Where the beams of a set went, the drone's own place among it; its body at map_pose. */
void seen_mark(seen_t *seen, const grid_t *grid, const scan_frame_t *frame, pose2_t map_pose);
/** Nothing outside the grid was. */
bool seen_lately(const seen_t *seen, const grid_t *grid, vec2_t point_m);

#endif
