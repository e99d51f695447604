// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "frontier.h"

#include <string.h>

enum {
  RAYS = 16,
  RAY_ONE = 64,    ///< a step of a ray in the units of its direction
  GAIN_MAX = 1400, ///< half a disc
  LOOK_CELLS = 28, ///< a look around takes as long as to fly this far
  SAME_CELLS = 8,  ///< so near two places are one
};

static const float STAY = 1.25f; ///< the last frontier counts so much more

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

/** Sum of the distances of the unobserved cells along a ray: each stands for the more cells, the
 * farther it is. */
static int along_ray(const grid_t *grid, const clearance_t *clearance, grid_cell_t from, int dx,
                     int dy) {
  int sum = 0;
  for (int step = 1; step <= FRONTIER_SIGHT_CELLS; step++) {
    int ix = from.ix + ((dx * step + RAY_ONE / 2) >> 6);
    int iy = from.iy + ((dy * step + RAY_ONE / 2) >> 6);
    if (clearance_blocked(clearance, ix, iy)) {
      break;
    }
    sum += grid_value(grid, ix, iy) == GRID_UNKNOWN ? step : 0;
  }
  return sum;
}

int frontier_gain(const grid_t *grid, const clearance_t *clearance, grid_cell_t from) {
  static const int8_t COSINE[RAYS] = {64,  59,  45,  24,  0, -24, -45, -59,
                                      -64, -59, -45, -24, 0, 24,  45,  59};
  int sum = 0;
  for (int ray = 0; ray < RAYS; ray++) {
    sum += along_ray(grid, clearance, from, COSINE[ray], COSINE[(ray + 3 * RAYS / 4) % RAYS]);
  }
  return sum * 25 / 64; // 2 pi / 16
}

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
  float at_most = STAY * (float)GAIN_MAX / (float)(wave->waves + LOOK_CELLS);
  return frontier_found(frontier) &&
         (frontier->mode != FRONTIER_GAIN || frontier->score >= at_most);
}
