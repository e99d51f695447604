// SPDX-License-Identifier: GPL-3.0-or-later
/** @file frontier.h  Where to look next: which frontier shows most for the time that it takes.
 *  A frontier is an observed cell beside an unobserved one that a wave through observed cells
 * reaches. It is worth what rays from it would see: unobserved cells in which the drone may be, as
 * far as FRONTIER_SIGHT_CELLS, until something is in the way. Its cost is the way there and a look
 * around. After Gonzalez-Banos and Latombe (2002), with the ratio of the two in place of an
 * exponential. Sliced; the slicing does not change the result. */
#ifndef FRONTIER_H
#define FRONTIER_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "grid.h"
#include "wavefront.h"

enum {
  FRONTIER_SIGHT_CELLS = 30,
  FRONTIER_GAIN_MIN = 40, ///< cells; less is not worth a flight
  FRONTIER_VAIN = 8,      ///< places remembered where looking showed nothing
};

typedef enum { FRONTIER_GAIN, FRONTIER_NEAREST, FRONTIER_RANDOM, FRONTIER_MODES } frontier_mode_t;

/** Places that need not be looked at again; the oldest is forgotten first. */
typedef struct {
  uint8_t ix[FRONTIER_VAIN];
  uint8_t iy[FRONTIER_VAIN];
  uint8_t count;
  uint8_t next;
} frontier_vain_t;

/** A search; it lives as long as its wave. */
typedef struct {
  frontier_mode_t mode;
  frontier_vain_t vain;
  grid_cell_t last; ///< the frontier before this one: to turn round costs more than it brings
  grid_cell_t best;
  float score;
  uint16_t best_waves;
  uint16_t best_gain;              ///< [cells]
  uint8_t looked;                  ///< of the cells that the last wave met
  uint32_t rated[GRID_TILE_WORDS]; ///< tiles that have a frontier which is worth it
} frontier_t;

void frontier_vain_add(frontier_vain_t *vain, grid_cell_t cell);

void frontier_start(frontier_t *frontier, frontier_mode_t mode, const frontier_vain_t *vain,
                    grid_cell_t last);
/** Unobserved cells that can be seen from there. */
int frontier_gain(const grid_t *grid, const clearance_t *clearance, grid_cell_t from);
/** Rate one of the cells that the last wave met. @return false when that was done for all */
bool frontier_look(frontier_t *frontier, const wavefront_t *wave, const grid_t *grid,
                   const clearance_t *clearance);
/** No frontier farther than the wave is can be better than the best. */
bool frontier_decided(const frontier_t *frontier, const wavefront_t *wave);
bool frontier_found(const frontier_t *frontier);

#endif
