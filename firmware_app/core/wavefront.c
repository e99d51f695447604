// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "wavefront.h"

#include <string.h>

enum {
  LABELS = 3,
  LEG_MAX = 32, ///< steps between two points of a way: bounds the work of looking along it
};

static uint32_t label_of(uint32_t wave) {
  return wave % LABELS + 1u;
}

static void set_label(wavefront_t *wave, int ix, int iy, uint32_t label) {
  int word = iy * GRID_BIT_WORDS + ix / 32;
  uint32_t bit = 1u << (ix % 32);
  wave->low[word] |= (label & 1u) != 0u ? bit : 0u;
  wave->high[word] |= (label & 2u) != 0u ? bit : 0u;
}

static uint32_t label_at(const wavefront_t *wave, int ix, int iy) {
  if (ix < 0 || iy < 0 || ix >= GRID_SIDE_CELLS || iy >= GRID_SIDE_CELLS) {
    return 0u;
  }
  int word = iy * GRID_BIT_WORDS + ix / 32;
  return (wave->low[word] >> (ix % 32) & 1u) | (wave->high[word] >> (ix % 32) & 1u) << 1;
}

bool wavefront_reached(const wavefront_t *wave, int ix, int iy) {
  return label_at(wave, ix, iy) != 0u;
}

void wavefront_start(wavefront_t *wave, wavefront_target_t target, grid_cell_t start,
                     grid_cell_t goal) {
  memset(wave, 0, sizeof *wave);
  wave->target = target;
  wave->start = start;
  wave->goal = goal;
  wave->row_min = wave->row_max = (int16_t)start.iy;
  wave->status = WAVEFRONT_RUNNING;
  set_label(wave, start.ix, start.iy, label_of(0u));
  if (target == WAVEFRONT_TO_GOAL && start.ix == goal.ix && start.iy == goal.iy) {
    wave->status = WAVEFRONT_REACHED;
  }
}

/** Cells of row iy with the given label; a row outside the grid has none. */
static void labelled_row(const wavefront_t *wave, int iy, uint32_t label,
                         uint32_t bits[GRID_BIT_WORDS]) {
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    uint32_t low = 0u;
    uint32_t high = 0u;
    if (iy >= 0 && iy < GRID_SIDE_CELLS) {
      low = wave->low[iy * GRID_BIT_WORDS + i];
      high = wave->high[iy * GRID_BIT_WORDS + i];
    }
    bits[i] = ((label & 1u) != 0u ? low : ~low) & ((label & 2u) != 0u ? high : ~high);
  }
}

/** The two horizontal neighbours of each bit of word i. */
static uint32_t sideways(const uint32_t bits[GRID_BIT_WORDS], int i) {
  uint32_t from_left = bits[i] << 1 | (i > 0 ? bits[i - 1] >> 31 : 0u);
  uint32_t from_right = bits[i] >> 1 | (i + 1 < GRID_BIT_WORDS ? bits[i + 1] << 31 : 0u);
  return from_left | from_right;
}

static int first_bit(const uint32_t bits[GRID_BIT_WORDS]) {
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    for (int b = 0; bits[i] != 0u && b < 32; b++) {
      if ((bits[i] >> b & 1u) != 0u) {
        return i * 32 + b;
      }
    }
  }
  return -1;
}

/** Cells of row iy that were never observed; outside the grid there is nothing to observe. */
static void unknown_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]) {
  bool inside = iy >= 0 && iy < GRID_SIDE_CELLS;
  grid_known_row(grid, iy, bits);
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    bits[i] = inside ? ~bits[i] : 0u;
  }
}

/** Column of the first of these cells of a row that has an unknown neighbour, -1 if none has. */
static int first_frontier(const grid_t *grid, int iy, const uint32_t cells[GRID_BIT_WORDS]) {
  uint32_t above[GRID_BIT_WORDS];
  uint32_t here[GRID_BIT_WORDS];
  uint32_t below[GRID_BIT_WORDS];
  uint32_t frontier[GRID_BIT_WORDS];
  unknown_row(grid, iy + 1, above);
  unknown_row(grid, iy, here);
  unknown_row(grid, iy - 1, below);
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    frontier[i] = (above[i] | below[i] | sideways(here, i)) & cells[i];
  }
  return first_bit(frontier);
}

/** Among the freshly reached cells of a row, one that the search is for; its column, or -1. */
static int found_in_row(const wavefront_t *wave, const grid_t *grid, int iy,
                        const uint32_t fresh[GRID_BIT_WORDS]) {
  if (wave->target == WAVEFRONT_TO_GOAL) {
    bool met =
        iy == wave->goal.iy && (fresh[wave->goal.ix / 32] >> (wave->goal.ix % 32) & 1u) != 0u;
    return met ? wave->goal.ix : -1;
  }
  if (wave->target == WAVEFRONT_EVERYWHERE) {
    return -1;
  }
  return first_frontier(grid, iy, fresh);
}

/** The cells of three neighbouring rows that the last wave reached. */
typedef struct {
  uint32_t below[GRID_BIT_WORDS];
  uint32_t here[GRID_BIT_WORDS];
  uint32_t above[GRID_BIT_WORDS];
} front_t;

/** Label what the wave reaches in row iy. @return true if anything was reached */
static bool extend_row(wavefront_t *wave, const clearance_t *clearance, const grid_t *grid, int iy,
                       const front_t *front, uint32_t to_label) {
  uint32_t fresh[GRID_BIT_WORDS];
  uint32_t any = 0u;
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    int word = iy * GRID_BIT_WORDS + i;
    uint32_t labelled = wave->low[word] | wave->high[word];
    fresh[i] = (front->above[i] | front->below[i] | sideways(front->here, i)) &
               ~clearance->bits[word] & ~labelled;
    any |= fresh[i];
  }
  if (any != 0u && wave->target == WAVEFRONT_TO_FRONTIER) {
    uint32_t known[GRID_BIT_WORDS];
    grid_known_row(grid, iy, known);
    any = 0u;
    for (int i = 0; i < GRID_BIT_WORDS; i++) {
      fresh[i] &= known[i];
      any |= fresh[i];
    }
  }
  if (any == 0u) {
    return false;
  }
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    wave->low[iy * GRID_BIT_WORDS + i] |= (to_label & 1u) != 0u ? fresh[i] : 0u;
    wave->high[iy * GRID_BIT_WORDS + i] |= (to_label & 2u) != 0u ? fresh[i] : 0u;
  }
  int ix = wave->status == WAVEFRONT_RUNNING ? found_in_row(wave, grid, iy, fresh) : -1;
  if (ix >= 0) {
    wave->goal = (grid_cell_t){ix, iy};
    wave->status = WAVEFRONT_REACHED;
  }
  return true;
}

/** One wave over the rows that the last one touched and one to both sides. @return true if it got
 * on
 */
static bool one_wave(wavefront_t *wave, const clearance_t *clearance, const grid_t *grid) {
  uint32_t from_label = label_of(wave->waves);
  uint32_t to_label = label_of(wave->waves + 1u);
  int first = wave->row_min > 0 ? wave->row_min - 1 : 0;
  int last = wave->row_max < GRID_SIDE_CELLS - 1 ? wave->row_max + 1 : GRID_SIDE_CELLS - 1;
  bool any = false;
  front_t front;
  labelled_row(wave, first - 1, from_label, front.below);
  labelled_row(wave, first, from_label, front.here);
  for (int iy = first; iy <= last; iy++) {
    labelled_row(wave, iy + 1, from_label, front.above);
    if (extend_row(wave, clearance, grid, iy, &front, to_label)) {
      any = true;
      wave->row_min = (int16_t)(iy < wave->row_min ? iy : wave->row_min);
      wave->row_max = (int16_t)(iy > wave->row_max ? iy : wave->row_max);
    }
    memcpy(front.below, front.here, sizeof front.below);
    memcpy(front.here, front.above, sizeof front.here);
  }
  wave->waves++;
  return any;
}

wavefront_status_t wavefront_extend(wavefront_t *wave, const clearance_t *clearance,
                                    const grid_t *grid, int max_waves) {
  for (int i = 0; i < max_waves && wave->status == WAVEFRONT_RUNNING; i++) {
    if (!one_wave(wave, clearance, grid)) {
      wave->status = WAVEFRONT_EXHAUSTED;
    }
  }
  return wave->status;
}

bool wavefront_nearest(const wavefront_t *wave, vec2_t point_cells, grid_cell_t *cell) {
  float best = 1.0e9f;
  for (int iy = wave->row_min; iy <= wave->row_max; iy++) {
    for (int ix = 0; ix < GRID_SIDE_CELLS; ix++) {
      vec2_t to_centre = {(float)ix + 0.5f - point_cells.x, (float)iy + 0.5f - point_cells.y};
      float distance2 = vec2_dot(to_centre, to_centre);
      if (distance2 < best && wavefront_reached(wave, ix, iy)) {
        best = distance2;
        *cell = (grid_cell_t){ix, iy};
      }
    }
  }
  return best < 1.0e9f;
}

static vec2_t centre_of(grid_cell_t cell) {
  return (vec2_t){(float)cell.ix + 0.5f, (float)cell.iy + 0.5f};
}

/** The neighbour that the wave came from. Labels of neighbours differ by one wave at most, so three
 * are enough. */
static grid_cell_t step_back(const wavefront_t *wave, grid_cell_t cell, uint32_t label) {
  static const int8_t dx[] = {1, -1, 0, 0};
  static const int8_t dy[] = {0, 0, 1, -1};
  for (int i = 0; i < 4; i++) {
    if (label_at(wave, cell.ix + dx[i], cell.iy + dy[i]) == label) {
      return (grid_cell_t){cell.ix + dx[i], cell.iy + dy[i]};
    }
  }
  return cell;
}

int wavefront_path(const wavefront_t *wave, const clearance_t *clearance, vec2_t *path_cells,
                   int capacity) {
  if (wave->status != WAVEFRONT_REACHED || capacity < 2) {
    return 0;
  }
  int count = 1;
  path_cells[0] = centre_of(wave->goal);
  grid_cell_t previous = wave->goal;
  int leg = 0;
  for (uint32_t k = wave->waves; k > 0u; k--) {
    grid_cell_t next = step_back(wave, previous, label_of(k - 1u));
    bool in_sight =
        leg < LEG_MAX && clearance_segment_free(clearance, path_cells[count - 1], centre_of(next));
    leg++;
    if (!in_sight && k < wave->waves) {
      leg = 1;
      if (count >= capacity - 1) {
        return 0;
      }
      path_cells[count++] = centre_of(previous);
    }
    previous = next;
  }
  path_cells[count++] = centre_of(wave->start);
  vec2_reverse(path_cells, count);
  return count;
}
