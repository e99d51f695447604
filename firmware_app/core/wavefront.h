// SPDX-License-Identifier: GPL-3.0-or-later
/** @file wavefront.h  Exact reachability over the clearance bits, and the short way along it.
 *  A breadth-first wave from the start over whole rows of bits at a time. Each reached cell keeps
 * its wave number modulo 3 in two bits, which is enough to walk back from any reached cell: 4,096
 * bytes, no queue, no heap. Steps go to the 4 neighbours: exact for the rule that a body may not
 * squeeze between two blocked cells that touch at a corner. Sliced by waves; the slicing does not
 * change the result. */
#ifndef WAVEFRONT_H
#define WAVEFRONT_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "grid.h"

typedef enum {
  WAVEFRONT_RUNNING,
  WAVEFRONT_REACHED,   ///< the goal was met
  WAVEFRONT_EXHAUSTED, ///< everything reachable is labelled and the goal is not among it
} wavefront_status_t;

/** What the wave looks for: one cell, or any cell of a kind. */
typedef enum {
  WAVEFRONT_TO_GOAL,     ///< the goal cell
  WAVEFRONT_TO_FRONTIER, ///< an observed cell beside an unknown one; the wave stays in observed
                         ///< cells
  WAVEFRONT_EVERYWHERE,  ///< nothing: label all that can be reached
} wavefront_target_t;

typedef struct {
  uint32_t low[GRID_SIDE_CELLS *
               GRID_BIT_WORDS]; ///< label = low + 2 high; 0 not reached, else wave % 3 + 1
  uint32_t high[GRID_SIDE_CELLS * GRID_BIT_WORDS];
  wavefront_target_t target;
  grid_cell_t start;
  grid_cell_t goal; ///< the cell met, once reached
  uint16_t waves;
  int16_t row_min, row_max; ///< rows that the waves have touched
  wavefront_status_t status;
} wavefront_t;

/** Begin at the start cell, which is taken as free: from a blocked place give the nearest free cell
 *  (clearance_nearest_free). */
void wavefront_start(wavefront_t *wave, wavefront_target_t target, grid_cell_t start,
                     grid_cell_t goal);
/** Advance up to max_waves. */
wavefront_status_t wavefront_extend(wavefront_t *wave, const clearance_t *clearance,
                                    const grid_t *grid, int max_waves);
bool wavefront_reached(const wavefront_t *wave, int ix, int iy);
/** Reached cell nearest to the point (in cells); false if nothing was reached. */
bool wavefront_nearest(const wavefront_t *wave, vec2_t point_cells, grid_cell_t *cell);
/** Walk back from wave->goal: the corners of the way from start to goal, as cell centres, each in
 * sight of the next.
 *  @return points written, 0 if not reached or more than capacity are needed */
int wavefront_path(const wavefront_t *wave, const clearance_t *clearance, vec2_t *path_cells,
                   int capacity);

#endif
