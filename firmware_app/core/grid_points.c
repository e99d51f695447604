// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Obstacle points: a 4-way set-associative table of 16-bit entries.
 * Entry: bits 0-5 place in the cell in eighths (x low), 6-11 tag, 12-14 weight, 15 in use.
 * The 14-bit cell index is scrambled by a bijection; its upper 8 bits choose the set, the lower 6
 * are the tag, so an entry names its cell exactly. */
#include "grid.h"

enum {
  TAG_BITS = 6,
  PLACE_MASK = 0x3F,
  WEIGHT_SHIFT = 12,
  WEIGHT_MASK = 7,
  WEIGHT_MAX = 4, ///< hits that the mean remembers
  IN_USE = 0x8000,
};

static uint32_t scrambled(grid_cell_t cell) {
  uint32_t index = (uint32_t)(cell.iy * GRID_SIDE_CELLS + cell.ix);
  index ^= index >> 7;
  return (index * 0x2545u) & (GRID_CELLS - 1u);
}

/** Index of the cell's entry, -1 if it has none. */
static int find(const grid_t *grid, grid_cell_t cell) {
  uint32_t key = scrambled(cell);
  int first = (int)(key >> TAG_BITS) * GRID_POINT_WAYS;
  for (int i = first; i < first + GRID_POINT_WAYS; i++) {
    uint32_t point = grid->points[i];
    if ((point & IN_USE) != 0u && ((point >> TAG_BITS) & PLACE_MASK) == (key & PLACE_MASK)) {
      return i;
    }
  }
  return -1;
}

/** The entry of the set to give up: an unused one, else the one with the least weight. */
static uint16_t *weakest(grid_t *grid, uint32_t set_index) {
  uint16_t *set = &grid->points[set_index * GRID_POINT_WAYS];
  uint16_t *least = set;
  for (int way = 0; way < GRID_POINT_WAYS; way++) {
    if ((set[way] & IN_USE) == 0) {
      return &set[way];
    }
    if (set[way] >> WEIGHT_SHIFT < *least >> WEIGHT_SHIFT) {
      least = &set[way];
    }
  }
  return least;
}

static uint32_t eighths(float cells, int whole) {
  return (uint32_t)geometry_clamp((cells - (float)whole) * 8.0f, 0.0f, 7.0f);
}

static uint32_t mean(uint32_t old, uint32_t hit, uint32_t weight) {
  return (old * weight + hit + (weight + 1u) / 2u) / (weight + 1u);
}

static uint16_t entry(uint32_t key, uint32_t x, uint32_t y, uint32_t weight) {
  return (uint16_t)(IN_USE | weight << WEIGHT_SHIFT | (key & PLACE_MASK) << TAG_BITS | y << 3 | x);
}

void grid_points_add(grid_t *grid, grid_cell_t cell, vec2_t point_m) {
  vec2_t cells = grid_to_cells(grid, point_m);
  uint32_t x = eighths(cells.x, cell.ix);
  uint32_t y = eighths(cells.y, cell.iy);
  uint32_t key = scrambled(cell);
  int i = find(grid, cell);
  if (i < 0) {
    *weakest(grid, key >> TAG_BITS) = entry(key, x, y, 1u);
    return;
  }
  uint32_t point = grid->points[i];
  uint32_t weight = (point >> WEIGHT_SHIFT) & WEIGHT_MASK;
  uint32_t next = weight < WEIGHT_MAX ? weight + 1u : weight;
  grid->points[i] =
      entry(key, mean(point & 7u, x, weight), mean((point >> 3) & 7u, y, weight), next);
}

void grid_points_remove(grid_t *grid, grid_cell_t cell) {
  int i = find(grid, cell);
  if (i >= 0) {
    grid->points[i] = 0;
  }
}

int grid_point_eighths(const grid_t *grid, int ix, int iy) {
  if (grid_state(grid, ix, iy) != GRID_CELL_OCCUPIED) {
    return -1;
  }
  int i = find(grid, (grid_cell_t){ix, iy});
  return i >= 0 ? grid->points[i] & PLACE_MASK : -1;
}

bool grid_point(const grid_t *grid, int ix, int iy, vec2_t *point_m) {
  int place = grid_point_eighths(grid, ix, iy);
  if (place < 0) {
    return false;
  }
  vec2_t cells = {(float)ix + ((float)(place & 7) + 0.5f) * 0.125f,
                  (float)iy + ((float)(place >> 3) + 0.5f) * 0.125f};
  *point_m = grid_to_metres(grid, cells);
  return true;
}
