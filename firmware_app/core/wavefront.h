// SPDX-License-Identifier: GPL-3.0-or-later
/** @file wavefront.h  Breadth-first waves over the clearance bits: what can be reached, and a path.
 *
 * Waves spread from a root cell, 32 cells of a row at a time, in turn to the 4 and to the 8
 * neighbours. So the cells of equal wave number form octagons, and path lengths measured in waves
 * are at most 12 % off relative to each other. A reached cell keeps its wave number modulo 3 in two
 * bits, which is enough to walk back to the root: 4,096 bytes, no queue, no heap.
 *
 * A diagonal step needs both cells beside it free, because a body may not squeeze between two
 * blocked cells that touch at a corner. So the cells reached are exactly the 4-connected region of
 * the root.
 *
 * This stands in for A*, whose open list does not fit into the memory. The work is done wave by
 * wave; the slicing does not change the result. */
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
  WAVEFRONT_REACHED,   ///< the wave has reached the target
  WAVEFRONT_EXHAUSTED, ///< everything reachable is labelled, and the target is not part of it
} wavefront_status_t;

/** Where the wave may go, and when it ends. */
typedef enum {
  WAVEFRONT_TO_CELL,    ///< through free cells, until it reaches the target
  WAVEFRONT_OBSERVED,   ///< through observed free cells, to the end; reports frontiers
  WAVEFRONT_EVERYWHERE, ///< through free cells, to the end
} wavefront_kind_t;

typedef struct {
  /** Label of a cell = low + 2 high: 0 if not reached, else wave number % 3 + 1. */
  uint32_t low[GRID_SIDE_CELLS * GRID_BIT_WORDS];
  uint32_t high[GRID_SIDE_CELLS * GRID_BIT_WORDS];
  uint32_t rows[GRID_BIT_WORDS];    ///< rows in which the last wave reached a cell
  uint32_t columns[GRID_BIT_WORDS]; ///< columns that the wave may enter
  int16_t first_row, last_row;      ///< rows that the wave may enter
  wavefront_kind_t kind;
  grid_cell_t root;
  grid_cell_t target;
  uint16_t waves;  ///< number of the last wave; once the target is reached, of the wave there
  uint16_t walked; ///< steps of the walk back from the target
  grid_cell_t at;  ///< cell of the walk
  int points;      ///< points of its path so far
  wavefront_status_t status;
  /** WAVEFRONT_OBSERVED: cells with an unknown neighbour that the last wave reached, at most one of
   * each eight columns of a row and WAVEFRONT_MET in all. */
  uint8_t met_ix[WAVEFRONT_MET], met_iy[WAVEFRONT_MET];
  uint8_t met;
} wavefront_t;

/** Begin at the root cell, which is taken as free. The target counts for WAVEFRONT_TO_CELL only. */
void wavefront_start(wavefront_t *wave, wavefront_kind_t kind, grid_cell_t root,
                     grid_cell_t target);
/** Limit the wave to a rectangle, both corners included; root and target must lie in it. Not for
 * WAVEFRONT_OBSERVED. */
void wavefront_limit(wavefront_t *wave, grid_cell_t low, grid_cell_t high);
/** Spread up to max_waves waves. Only WAVEFRONT_OBSERVED reads the grid. */
wavefront_status_t wavefront_extend(wavefront_t *wave, const clearance_t *clearance,
                                    const grid_t *grid, int max_waves);
bool wavefront_reached(const wavefront_t *wave, int ix, int iy);
/** Make a cell that wave number `waves` reached the target. */
void wavefront_aim(wavefront_t *wave, grid_cell_t target, int waves);
/** The reached cell whose centre is nearest to the point. */
grid_cell_t wavefront_nearest(const wavefront_t *wave, vec2_t point_cells);
/** Once the target is reached: walk back from it to the root, max_steps at a time. The points of
 * the path are cell centres, each in sight of the next; `path` must be the same array in all calls.
 * @return number of points once the root is reached; WAVEFRONT_WALKING before; 0 if more than
 * capacity are needed */
int wavefront_path(wavefront_t *wave, const clearance_t *clearance, lattice_t *path, int capacity,
                   int max_steps);

#endif
