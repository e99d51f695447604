// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Obstacle points: a 4-way set-associative table of 16-bit entries.
 *
 * Entry: bits 0-5 position in the cell in eighths (x low), 6-11 tag, 12-14 standing, 15 in use.
 * The 14-bit cell index is scrambled by a bijection; its upper 8 bits choose the set, the lower 6
 * are the tag. So an entry names its cell exactly, and the inverse of the bijection recovers it.
 *
 * Standing, from LASTING up: number of hits, 1 to 4, that weigh in the mean position. Below
 * LASTING the obstacle may be passing: it appeared in a free cell. A round of grid_fade() takes
 * such an obstacle through these standings:
 *
 *   created -> MET --end of round--> MISSED --hit--> MET_AGAIN --end of round--> MISSED_AGAIN
 *
 * A hit in MISSED_AGAIN, that is in a third round, makes it LASTING. At the end of a round, an
 * obstacle still in MISSED or MISSED_AGAIN is removed. */
#include "grid.h"

enum {
  TAG_BITS = 6,
  PLACE_MASK = 0x3F,
  MIDDLE = 4 << 3 | 4, ///< the eighths nearest to the middle of a cell
  STANDING_SHIFT = 12,
  STANDING_MASK = 7,
  MISSED = 0,       ///< not hit yet in this round, hit in the round before
  MISSED_AGAIN = 1, ///< not hit yet in this round, hit in the two rounds before
  MET = 2,          ///< hit in this round
  MET_AGAIN = 3,    ///< hit in this round and in the one before
  LASTING = 4,      ///< one hit
  STANDING_MAX = 7, ///< four hits or more
  IN_USE = 0x8000,
  UNSCRAMBLE = 0x258D, ///< inverse of the factor in scrambled(), modulo GRID_CELLS
};

static uint32_t scrambled(grid_cell_t cell) {
  uint32_t index = (uint32_t)(cell.iy * GRID_SIDE_CELLS + cell.ix);
  index ^= index >> 7;
  return (index * 0x2545u) & (GRID_CELLS - 1u);
}

/** Recover the cell of an entry from its set and tag. */
static grid_cell_t cell_of(int entry_index, uint32_t point) {
  uint32_t set = (uint32_t)(entry_index / GRID_POINT_WAYS);
  uint32_t key = set << TAG_BITS | (point >> TAG_BITS & PLACE_MASK);
  uint32_t index = key * UNSCRAMBLE & (GRID_CELLS - 1u);
  index ^= index >> 7; // its own inverse: the upper 7 of the 14 bits stay as they are
  return (grid_cell_t){(int)(index % GRID_SIDE_CELLS), (int)(index / GRID_SIDE_CELLS)};
}

static uint32_t standing_of(uint32_t point) {
  return point >> STANDING_SHIFT & STANDING_MASK;
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

/** Remove a passing obstacle: its cell is free again, as it was before. */
static void forget(grid_t *grid, int i) {
  grid_cell_t cell = cell_of(i, grid->points[i]);
  grid_set_value(grid, cell.ix, cell.iy, GRID_FADED);
}

/** Index of an entry of the set that may be overwritten: an unused one, else the one with the least
 * standing. If its obstacle may be passing, the cell becomes free too. */
static int make_room(grid_t *grid, uint32_t set_index) {
  int first = (int)set_index * GRID_POINT_WAYS;
  int least = first;
  for (int i = first; i < first + GRID_POINT_WAYS; i++) {
    if ((grid->points[i] & IN_USE) == 0) {
      return i;
    }
    if (grid->points[i] >> STANDING_SHIFT < grid->points[least] >> STANDING_SHIFT) {
      least = i;
    }
  }
  if (standing_of(grid->points[least]) < LASTING) {
    forget(grid, least);
  }
  return least;
}

/** Position within the cell `whole`, in eighths, 0..7. */
static uint32_t eighths(float cells, int whole) {
  return (uint32_t)geometry_clamp((cells - (float)whole) * 8.0f, 0.0f, 7.0f);
}

/** Mean of the old position, which has this weight, and one more hit, rounded to nearest. */
static uint32_t mean(uint32_t old, uint32_t hit, uint32_t weight) {
  return (old * weight + hit + (weight + 1u) / 2u) / (weight + 1u);
}

static uint16_t entry(uint32_t key, uint32_t x, uint32_t y, uint32_t standing) {
  return (uint16_t)(IN_USE | standing << STANDING_SHIFT | (key & PLACE_MASK) << TAG_BITS | y << 3 |
                    x);
}

/** Standing after one more hit. */
static uint32_t raised(uint32_t standing) {
  switch (standing) {
  case MISSED:
    return MET_AGAIN;
  case MET:
  case MET_AGAIN:
  case STANDING_MAX:
    return standing;
  default:
    return standing == MISSED_AGAIN ? LASTING : standing + 1u;
  }
}

void grid_points_add(grid_t *grid, grid_cell_t cell, vec2_t point_m, bool passing) {
  vec2_t cells = grid_to_cells(grid, point_m);
  uint32_t x = eighths(cells.x, cell.ix);
  uint32_t y = eighths(cells.y, cell.iy);
  uint32_t key = scrambled(cell);
  int i = find(grid, cell);
  if (i < 0) {
    i = make_room(grid, key >> TAG_BITS);
    grid->points[i] = entry(key, x, y, passing ? MET : LASTING);
    return;
  }
  uint32_t point = grid->points[i];
  uint32_t standing = standing_of(point);
  uint32_t weight = standing >= LASTING ? standing - LASTING + 1u : 1u;
  grid->points[i] =
      entry(key, mean(point & 7u, x, weight), mean((point >> 3) & 7u, y, weight), raised(standing));
}

int grid_lasting_eighths(const grid_t *grid, int ix, int iy) {
  int i = find(grid, (grid_cell_t){ix, iy});
  if (i < 0) {
    return MIDDLE;
  }
  return standing_of(grid->points[i]) < LASTING ? -1 : grid->points[i] & PLACE_MASK;
}

bool grid_firm(const grid_t *grid, int ix, int iy) {
  int i = find(grid, (grid_cell_t){ix, iy});
  return i < 0 || standing_of(grid->points[i]) >= LASTING + 2;
}

bool grid_fade(grid_t *grid, uint32_t time_ms) {
  uint8_t set = (uint8_t)(time_ms / GRID_FADE_MS % GRID_POINT_SETS);
  if (set == grid->faded_set) {
    return false;
  }
  grid->faded_set = set;
  bool faded = false;
  int first = set * GRID_POINT_WAYS;
  for (int i = first; i < first + GRID_POINT_WAYS; i++) {
    uint32_t standing = standing_of(grid->points[i]);
    if ((grid->points[i] & IN_USE) == 0 || standing >= LASTING) {
      continue;
    }
    if (standing >= MET) {
      grid->points[i] = (uint16_t)(grid->points[i] - ((MET - MISSED) << STANDING_SHIFT));
    } else {
      forget(grid, i);
      faded = true;
    }
  }
  return faded;
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
