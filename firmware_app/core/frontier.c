// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "frontier.h"

#include <string.h>

enum {
  RAYS = 16,
  RAY_BITS = 6, ///< fraction bits of the ray directions: 1/64 cell
  RAY_HALF = 1 << RAY_BITS >> 1,
  GAIN_MAX = 1400, ///< bound of the gain of a frontier [cells]: half a disc of radius 30
  LOOK_CELLS = 28, ///< cost of a look around: it takes as long as flying this far
  SAME_CELLS = 8,  ///< places closer than this in x and y count as the same
};

static const float STAY = 1.25f; ///< factor on the score of the frontier chosen last time

void frontier_vain_add(frontier_vain_t *vain, grid_cell_t cell) {
  vain->ix[vain->next] = (uint8_t)cell.ix;
  vain->iy[vain->next] = (uint8_t)cell.iy;
  vain->next = (uint8_t)((vain->next + 1u) % FRONTIER_VAIN);
  vain->count = (uint8_t)(vain->count + (vain->count < FRONTIER_VAIN));
}

static bool same(grid_cell_t a, int ix, int iy) {
  return a.ix - ix < SAME_CELLS && ix - a.ix < SAME_CELLS && a.iy - iy < SAME_CELLS &&
         iy - a.iy < SAME_CELLS;
}

static bool is_vain(const frontier_vain_t *vain, grid_cell_t cell) {
  for (int i = 0; i < vain->count; i++) {
    if (same(cell, vain->ix[i], vain->iy[i])) {
      return true;
    }
  }
  return false;
}

void frontier_start(frontier_t *frontier, frontier_mode_t mode, const frontier_vain_t *vain,
                    grid_cell_t last) {
  memset(frontier, 0, sizeof *frontier);
  frontier->mode = mode;
  frontier->vain = *vain;
  frontier->last = last;
}

/** Sum of the distances [cells] of the unknown cells along a ray. Distance is the weight, because
 * the sector that a cell stands for widens with it. */
static int along_ray(const grid_t *grid, const clearance_t *clearance, grid_cell_t from, int dx,
                     int dy) {
  int sum = 0;
  for (int step = 1; step <= FRONTIER_SIGHT_CELLS; step++) {
    int ix = from.ix + ((dx * step + RAY_HALF) >> RAY_BITS);
    int iy = from.iy + ((dy * step + RAY_HALF) >> RAY_BITS);
    if (clearance_blocked(clearance, ix, iy)) {
      break;
    }
    sum += grid_value(grid, ix, iy) == GRID_UNKNOWN ? step : 0;
  }
  return sum;
}

int frontier_gain(const grid_t *grid, const clearance_t *clearance, grid_cell_t from) {
  // In 1/RAY_ONE, by ray; three quarters of a turn on it is the sine.
  static const int8_t COSINE[RAYS] = {64,  59,  45,  24,  0, -24, -45, -59,
                                      -64, -59, -45, -24, 0, 24,  45,  59};
  int sum = 0;
  for (int ray = 0; ray < RAYS; ray++) {
    sum += along_ray(grid, clearance, from, COSINE[ray], COSINE[(ray + 3 * RAYS / 4) % RAYS]);
  }
  return sum * 25 / 64; // 25/64 is 2 pi / RAYS, the angle of one sector
}

/** Rate one frontier, and keep it if it is the best so far. */
static void rate(frontier_t *frontier, const wavefront_t *wave, const grid_t *grid,
                 const clearance_t *clearance, grid_cell_t cell) {
  if (is_vain(&frontier->vain, cell)) {
    return;
  }
  int gain = frontier_gain(grid, clearance, cell);
  if (gain < FRONTIER_GAIN_MIN) {
    return;
  }
  int tile = grid_tile(cell.ix, cell.iy);
  frontier->rated[tile / 32] |= 1u << (tile % 32);
  float score = (float)gain / (float)(wave->waves + LOOK_CELLS);
  score *= same(frontier->last, cell.ix, cell.iy) ? STAY : 1.0f;
  if (score > frontier->score) {
    frontier->best = cell;
    frontier->score = score;
    frontier->best_waves = wave->waves;
    frontier->best_gain = (uint16_t)gain;
  }
}

bool frontier_look(frontier_t *frontier, const wavefront_t *wave, const grid_t *grid,
                   const clearance_t *clearance) {
  while (frontier->looked < wave->met) {
    int i = frontier->looked++;
    grid_cell_t cell = {wave->met_ix[i], wave->met_iy[i]};
    int tile = grid_tile(cell.ix, cell.iy);
    if ((frontier->rated[tile / 32] >> (tile % 32) & 1u) == 0u) {
      rate(frontier, wave, grid, clearance, cell);
      return true;
    }
  }
  frontier->looked = 0;
  return false;
}

bool frontier_found(const frontier_t *frontier) {
  return frontier->best_gain > 0;
}

bool frontier_decided(const frontier_t *frontier, const wavefront_t *wave) {
  // Highest score of a frontier that later waves can meet.
  float at_most = STAY * (float)GAIN_MAX / (float)(wave->waves + LOOK_CELLS);
  return frontier_found(frontier) &&
         (frontier->mode != FRONTIER_GAIN || frontier->score >= at_most);
}
