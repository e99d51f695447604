// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("O2", "fp-contract=off")
#include "wavefront.h"

#include <string.h>

enum {
  LABELS = 3,
  NEIGHBOURS = 8,
  STRAIGHT = 4, ///< the first four neighbours are straight, the others diagonal
};

static uint32_t label_of(uint32_t wave) {
  return wave % LABELS + 1u;
}

/** True if this wave goes to all 8 neighbours. */
static bool is_diagonal(uint32_t wave) {
  return (wave & 1u) == 0u;
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

void wavefront_start(wavefront_t *wave, wavefront_kind_t kind, grid_cell_t root,
                     grid_cell_t target) {
  memset(wave, 0, sizeof *wave);
  memset(wave->columns, 0xFF, sizeof wave->columns);
  wave->last_row = GRID_SIDE_CELLS - 1;
  wave->kind = kind;
  wave->root = root;
  wave->target = target;
  wave->rows[root.iy / 32] = 1u << (root.iy % 32);
  wave->status = WAVEFRONT_RUNNING;
  set_label(wave, root.ix, root.iy, label_of(0u));
  if (kind == WAVEFRONT_TO_CELL && root.ix == target.ix && root.iy == target.iy) {
    wave->status = WAVEFRONT_REACHED;
  }
}

void wavefront_limit(wavefront_t *wave, grid_cell_t low, grid_cell_t high) {
  wave->first_row = (int16_t)(low.iy > 0 ? low.iy : 0);
  wave->last_row = (int16_t)(high.iy < GRID_SIDE_CELLS ? high.iy : GRID_SIDE_CELLS - 1);
  grid_columns(low.ix, high.ix, wave->columns);
}

/** One row as a wave needs it. */
typedef struct {
  uint32_t front[GRID_BIT_WORDS]; ///< cells that the last wave reached
  uint32_t open[GRID_BIT_WORDS];  ///< cells that a wave may enter
} wave_row_t;

/** Read row iy; outside the limits it is empty. The front may include cells of earlier waves with
 * the same label, whose neighbours were all reached before. */
static void read_row(const wavefront_t *wave, const clearance_t *clearance, const grid_t *grid,
                     int iy, wave_row_t *row) {
  memset(row, 0, sizeof *row);
  if (iy < wave->first_row || iy > wave->last_row) {
    return;
  }
  uint32_t known[GRID_BIT_WORDS];
  memcpy(known, wave->columns, sizeof known);
  if (wave->kind == WAVEFRONT_OBSERVED) {
    grid_known_row(grid, iy, known);
  }
  uint32_t label = label_of(wave->waves);
  uint32_t not_low = (label & 1u) != 0u ? 0u : ~0u;
  uint32_t not_high = (label & 2u) != 0u ? 0u : ~0u;
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    int word = iy * GRID_BIT_WORDS + i;
    row->front[i] = (wave->low[word] ^ not_low) & (wave->high[word] ^ not_high);
    row->open[i] = ~clearance->bits[word] & known[i];
  }
}

/** The two horizontal neighbours of each bit of word i. */
static uint32_t sideways(const uint32_t bits[GRID_BIT_WORDS], int i) {
  uint32_t from_left = bits[i] << 1 | (i > 0 ? bits[i - 1] >> 31 : 0u);
  uint32_t from_right = bits[i] >> 1 | (i + 1 < GRID_BIT_WORDS ? bits[i + 1] << 31 : 0u);
  return from_left | from_right;
}

/** Cells of word i of row `here` that a wave reaches by a diagonal step from the front of the row
 * `from`, where both cells beside the step are open. */
static uint32_t diagonal(const wave_row_t *from, const wave_row_t *here, int i) {
  uint32_t left = i > 0 ? from->front[i - 1] & here->open[i - 1] : 0u;
  uint32_t right = i + 1 < GRID_BIT_WORDS ? from->front[i + 1] & here->open[i + 1] : 0u;
  uint32_t passing = from->front[i] & here->open[i];
  return (passing << 1 | left >> 31 | passing >> 1 | right << 31) & from->open[i];
}

/** True if a cell of the front is in word i or beside it. @param front  union of three rows */
static bool near_front(const uint32_t front[GRID_BIT_WORDS], int i) {
  uint32_t left = i > 0 ? front[i - 1] >> 31 : 0u;
  uint32_t right = i + 1 < GRID_BIT_WORDS ? front[i + 1] << 31 : 0u;
  return (front[i] | left | right) != 0u;
}

/** Unknown cells of the row; none outside the grid, where there is nothing to observe. */
static void unknown_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]) {
  bool inside = iy >= 0 && iy < GRID_SIDE_CELLS;
  grid_known_row(grid, iy, bits);
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    bits[i] = inside ? ~bits[i] : 0u;
  }
}

/** Note which of the cells that a wave has just reached in a row have an unknown neighbour. */
static void meet(wavefront_t *wave, const grid_t *grid, int iy,
                 const uint32_t fresh[GRID_BIT_WORDS]) {
  uint32_t above[GRID_BIT_WORDS];
  uint32_t here[GRID_BIT_WORDS];
  uint32_t below[GRID_BIT_WORDS];
  unknown_row(grid, iy + 1, above);
  unknown_row(grid, iy, here);
  unknown_row(grid, iy - 1, below);
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    uint32_t cells = (above[i] | below[i] | sideways(here, i)) & fresh[i];
    while (cells != 0u && wave->met < WAVEFRONT_MET) {
      int bit = __builtin_ctz(cells);
      wave->met_ix[wave->met] = (uint8_t)(i * 32 + bit);
      wave->met_iy[wave->met++] = (uint8_t)iy;
      cells &= ~(0xFFu << (bit & ~7)); // one of each eight columns is enough
    }
  }
}

/** Label the cells that a wave has just reached in a row. */
static void label_row(wavefront_t *wave, const grid_t *grid, int iy,
                      const uint32_t fresh[GRID_BIT_WORDS]) {
  uint32_t label = label_of(wave->waves + 1u);
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    wave->low[iy * GRID_BIT_WORDS + i] |= (label & 1u) != 0u ? fresh[i] : 0u;
    wave->high[iy * GRID_BIT_WORDS + i] |= (label & 2u) != 0u ? fresh[i] : 0u;
  }
  int ix = wave->target.ix;
  if (wave->kind == WAVEFRONT_OBSERVED) {
    meet(wave, grid, iy, fresh);
  } else if (wave->kind == WAVEFRONT_TO_CELL && iy == wave->target.iy &&
             (fresh[ix / 32] >> (ix % 32) & 1u) != 0u) {
    wave->status = WAVEFRONT_REACHED;
  }
}

/** Spread the next wave into row iy. @return true if it reached a cell there */
__attribute__((noinline)) static bool spread_into(wavefront_t *wave, const grid_t *grid, int iy,
                                                  const wave_row_t *below, const wave_row_t *here,
                                                  const wave_row_t *above) {
  uint32_t fronts[GRID_BIT_WORDS];
  uint32_t reached[GRID_BIT_WORDS];
  uint32_t any = 0u;
  bool diagonally = is_diagonal(wave->waves + 1u);
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    fronts[i] = above->front[i] | below->front[i] | here->front[i];
  }
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    int word = iy * GRID_BIT_WORDS + i;
    reached[i] = 0u;
    if (!near_front(fronts, i)) {
      continue;
    }
    uint32_t next = above->front[i] | below->front[i] | sideways(here->front, i);
    if (diagonally) {
      next |= diagonal(above, here, i) | diagonal(below, here, i);
    }
    reached[i] = next & here->open[i] & ~(wave->low[word] | wave->high[word]);
    any |= reached[i];
  }
  if (any != 0u) {
    label_row(wave, grid, iy, reached);
  }
  return any != 0u;
}

static bool row_in(const uint32_t rows[GRID_BIT_WORDS], int iy) {
  return (rows[iy / 32] >> (iy % 32) & 1u) != 0u;
}

/** Spread one wave; only rows of the last wave and beside them can be reached. @return true if it
 * reached a cell */
static bool one_wave(wavefront_t *wave, const clearance_t *clearance, const grid_t *grid) {
  uint32_t touched[GRID_BIT_WORDS];
  uint32_t reached[GRID_BIT_WORDS] = {0u};
  wave_row_t rows[3]; // row iy is kept in rows[iy % 3]
  int ready = -2;     // the last row that was read
  wave->met = 0;
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    touched[i] = wave->rows[i] | sideways(wave->rows, i);
  }
  for (int iy = 0; iy < GRID_SIDE_CELLS; iy++) {
    if (!row_in(touched, iy)) { // skip it, or the rest of its word if that is empty
      iy = touched[iy / 32] >> (iy % 32) == 0u ? iy | 31 : iy;
      continue;
    }
    for (int read = ready < iy - 2 ? iy - 1 : ready + 1; read <= iy + 1; read++) {
      read_row(wave, clearance, grid, read, &rows[(read + 3) % 3]);
    }
    ready = iy + 1;
    if (spread_into(wave, grid, iy, &rows[(iy + 2) % 3], &rows[iy % 3], &rows[(iy + 1) % 3])) {
      reached[iy / 32] |= 1u << (iy % 32);
    }
  }
  memcpy(wave->rows, reached, sizeof reached);
  wave->waves++;
  return (reached[0] | reached[1] | reached[2] | reached[3]) != 0u;
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

void wavefront_aim(wavefront_t *wave, grid_cell_t target, int waves) {
  wave->target = target;
  wave->waves = (uint16_t)waves;
  wave->status = WAVEFRONT_REACHED;
}

/** Find a reached cell of row iy that is nearer to the point than *squared [cells^2], if any. */
static void nearest_in_row(const wavefront_t *wave, int iy, vec2_t point, float *squared,
                           grid_cell_t *cell) {
  float dy = (float)iy + 0.5f - point.y;
  for (int i = 0; i < GRID_BIT_WORDS && dy * dy < *squared; i++) {
    uint32_t bits = wave->low[iy * GRID_BIT_WORDS + i] | wave->high[iy * GRID_BIT_WORDS + i];
    while (bits != 0u) {
      int ix = i * 32 + __builtin_ctz(bits);
      float dx = (float)ix + 0.5f - point.x;
      bits &= bits - 1u;
      if (dx * dx + dy * dy < *squared) {
        *squared = dx * dx + dy * dy;
        *cell = (grid_cell_t){ix, iy};
      }
    }
  }
}

grid_cell_t wavefront_nearest(const wavefront_t *wave, vec2_t point_cells) {
  grid_cell_t cell = wave->root;
  float squared = 1.0e9f;
  for (int iy = 0; iy < GRID_SIDE_CELLS; iy++) {
    nearest_in_row(wave, iy, point_cells, &squared, &cell);
  }
  return cell;
}

static lattice_t centre_of(grid_cell_t cell) {
  const int half = LATTICE_PER_CELL / 2;
  return (lattice_t){(int16_t)(cell.ix * LATTICE_PER_CELL + half),
                     (int16_t)(cell.iy * LATTICE_PER_CELL + half)};
}

/** The neighbour from which wave k reached `cell`. Wave numbers of straight neighbours differ by at
 * most one, so that labels modulo 3 are unambiguous. Those of diagonal neighbours may differ by
 * two; but then the two cells beside the step do not both belong to wave k. */
static grid_cell_t step_back(const wavefront_t *wave, grid_cell_t cell, uint32_t k) {
  static const int8_t dx[NEIGHBOURS] = {1, -1, 0, 0, 1, 1, -1, -1};
  static const int8_t dy[NEIGHBOURS] = {0, 0, 1, -1, 1, -1, 1, -1};
  int neighbours = is_diagonal(k) ? NEIGHBOURS : STRAIGHT;
  for (int i = 0; i < neighbours; i++) {
    int ix = cell.ix + dx[i];
    int iy = cell.iy + dy[i];
    bool beside = i < STRAIGHT || (label_at(wave, ix, cell.iy) == label_of(k) &&
                                   label_at(wave, cell.ix, iy) == label_of(k));
    if (beside && label_at(wave, ix, iy) == label_of(k - 1u)) {
      return (grid_cell_t){ix, iy};
    }
  }
  return cell;
}

/** Walk one cell back; where it goes out of sight of the path's last point, add a point. @return
 * false if the path is full */
static bool walk_step(wavefront_t *wave, const clearance_t *clearance, lattice_t *path,
                      int capacity) {
  grid_cell_t next = step_back(wave, wave->at, wave->waves - wave->walked);
  if (!clearance_sees(clearance, path[wave->points - 1], centre_of(next))) {
    if (wave->points >= capacity - 1) {
      return false;
    }
    path[wave->points++] = centre_of(wave->at);
  }
  wave->at = next;
  wave->walked++;
  return true;
}

int wavefront_path(wavefront_t *wave, const clearance_t *clearance, lattice_t *path, int capacity,
                   int max_steps) {
  if (wave->status != WAVEFRONT_REACHED || capacity < 2) {
    return 0;
  }
  if (wave->points == 0) {
    wave->at = wave->target;
    path[wave->points++] = centre_of(wave->at);
  }
  for (int i = 0; i < max_steps && wave->walked < wave->waves; i++) {
    if (!walk_step(wave, clearance, path, capacity)) {
      return 0;
    }
  }
  if (wave->walked < wave->waves) {
    return WAVEFRONT_WALKING;
  }
  path[wave->points++] = centre_of(wave->root);
  return wave->points;
}
