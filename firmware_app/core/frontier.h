// SPDX-License-Identifier: GPL-3.0-or-later
/** @file frontier.h  Exploration: which frontier promises the most new cells for the time it takes.
 *
 * A frontier is an observed cell beside an unknown one, reached by a wave through observed cells.
 * Its gain is the estimated number of unknown cells in sight: along each of a number of rays, up to
 * FRONTIER_SIGHT_CELLS or to the first blocked cell. Its cost is the path to it and a look around.
 * After Gonzalez-Banos and Latombe (2002), with gain / cost in place of their exponential.
 * The work is done in slices; the slicing does not change the result. */
#ifndef FRONTIER_H
#define FRONTIER_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "grid.h"
#include "wavefront.h"

enum {
  FRONTIER_SIGHT_CELLS = 30,
  FRONTIER_GAIN_MIN = 40, ///< cells; a smaller gain is not worth a flight
  FRONTIER_VAIN = 8,      ///< places remembered where a look showed too little
};

/** Values of the parameter way.frontier. */
typedef enum { FRONTIER_GAIN, FRONTIER_NEAREST, FRONTIER_RANDOM, FRONTIER_MODES } frontier_mode_t;

/** Places not to be looked at again, in a ring buffer: the oldest is forgotten first. */
typedef struct {
  uint8_t ix[FRONTIER_VAIN];
  uint8_t iy[FRONTIER_VAIN];
  uint8_t count;
  uint8_t next;
} frontier_vain_t;

/** A search for the best frontier, beside the wave that meets them. */
typedef struct {
  frontier_mode_t mode;
  frontier_vain_t vain;
  grid_cell_t last;                ///< frontier chosen last time, preferred so as not to turn round
  grid_cell_t best;                ///< best frontier so far
  float score;                     ///< its gain / cost
  uint16_t best_waves;             ///< number of the wave that met it
  uint16_t best_gain;              ///< [cells]; 0 if none was found
  uint8_t looked;                  ///< how many of the cells that the last wave met are rated
  uint32_t rated[GRID_TILE_WORDS]; ///< tiles in which a frontier with enough gain was found
} frontier_t;

void frontier_vain_add(frontier_vain_t *vain, grid_cell_t cell);

void frontier_start(frontier_t *frontier, frontier_mode_t mode, const frontier_vain_t *vain,
                    grid_cell_t last);
/** Estimate of the number of unknown cells that can be seen from a cell. */
int frontier_gain(const grid_t *grid, const clearance_t *clearance, grid_cell_t from);
/** Rate one of the cells that the last wave met. @return false if all of them are rated */
bool frontier_look(frontier_t *frontier, const wavefront_t *wave, const grid_t *grid,
                   const clearance_t *clearance);
/** True if the wave need not go on: no frontier that it has yet to meet can beat the best one, or
 * the mode takes the first one found. */
bool frontier_decided(const frontier_t *frontier, const wavefront_t *wave);
bool frontier_found(const frontier_t *frontier);

#endif
