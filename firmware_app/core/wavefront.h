// SPDX-License-Identifier: GPL-3.0-or-later
/** @file wavefront.h  Exact reachability over the clearance bits, and a near shortest way.
 *  A wave from the root over whole words of bits at a time. Waves go to the 4 neighbours and to the
 * 8 neighbours in turn, so that equal waves are octagons and no way is taken for more than 12 %
 * longer or shorter, against another, than it is. A reached cell keeps its wave number modulo 3 in
 * two bits, which is enough to walk back: 4,096 bytes, no queue, no heap. A diagonal step needs
 * both cells beside it free, so reachability is that of 4 neighbours: exact for the rule that a
 * body may not squeeze between two blocked cells that touch at a corner. It stands in for A*, whose
 * open list does not fit beside the bits. Sliced by waves; the slicing does not change the result.
 */
#ifndef WAVEFRONT_H
#define WAVEFRONT_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "grid.h"
#include "lattice.h"

enum { WAVEFRONT_WALKING = -1, WAVEFRONT_MET = 64 };

typedef enum {
  WAVEFRONT_RUNNING,
  WAVEFRONT_REACHED,   ///< the target was met
  WAVEFRONT_EXHAUSTED, ///< everything reachable is labelled and the target is not among it
} wavefront_status_t;

/** What the wave looks for, and where it may go. */
typedef enum {
  WAVEFRONT_TO_CELL,    ///< the target cell
  WAVEFRONT_OBSERVED,   ///< nothing: label all that can be reached through observed cells
  WAVEFRONT_EVERYWHERE, ///< nothing: label all that can be reached
} wavefront_kind_t;

typedef struct {
  uint32_t low[GRID_SIDE_CELLS * GRID_BIT_WORDS]; ///< label = low + 2 high; 0 not reached, else
                                                  ///< wave % 3 + 1
  uint32_t high[GRID_SIDE_CELLS * GRID_BIT_WORDS];
  uint32_t rows[GRID_BIT_WORDS];    ///< rows in which the last wave reached a cell
  uint32_t columns[GRID_BIT_WORDS]; ///< that the wave may enter
  int16_t first_row, last_row;      ///< likewise
  wavefront_kind_t kind;
  grid_cell_t root;
  grid_cell_t target; ///< the cell met, once reached
  uint16_t waves;     ///< so far; once reached: to the target
  uint16_t walked;    ///< steps back from the target
  grid_cell_t at;     ///< where the walk is
  int points;         ///< of its path
  wavefront_status_t status;
  /** WAVEFRONT_OBSERVED: cells beside unobserved ones that the last wave reached; of each eight in
   * a row one, of all the first so many. */
  uint8_t met_ix[WAVEFRONT_MET], met_iy[WAVEFRONT_MET];
  uint8_t met;
} wavefront_t;

/** Begin at the root cell, which is taken as free: from a blocked place give the nearest free cell
 *  (clearance_nearest_free). The target counts for WAVEFRONT_TO_CELL alone. */
void wavefront_start(wavefront_t *wave, wavefront_kind_t kind, grid_cell_t root,
                     grid_cell_t target);
/** Keep the wave in these cells, both included; root and target must be among them. */
void wavefront_limit(wavefront_t *wave, grid_cell_t low, grid_cell_t high);
/** Advance up to max_waves. The grid is read for WAVEFRONT_OBSERVED alone. */
wavefront_status_t wavefront_extend(wavefront_t *wave, const clearance_t *clearance,
                                    const grid_t *grid, int max_waves);
bool wavefront_reached(const wavefront_t *wave, int ix, int iy);
/** Let a cell that wave number `waves` reached be the target. */
void wavefront_aim(wavefront_t *wave, grid_cell_t target, int waves);
/** Reached cell nearest to the point (in cells). */
grid_cell_t wavefront_nearest(const wavefront_t *wave, vec2_t point_cells);
/** Once the target is met: walk back from it to the root, max_steps at a time. The path's points
 * are cell centres, each in sight of the next; it must be the same array until the end is reached.
 *  @return points at the end; WAVEFRONT_WALKING before; 0 if more than capacity are needed */
int wavefront_path(wavefront_t *wave, const clearance_t *clearance, lattice_t *path, int capacity,
                   int max_steps);

#endif
