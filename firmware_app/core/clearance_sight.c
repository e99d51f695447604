// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("O2", "fp-contract=off")
/* Lines of sight and corners on whole rows of bits: each row that a segment crosses usually costs
 * one or two masked words, however many of its cells the segment crosses. */
#include "clearance.h"

enum {
  HIGH_BITS = 16, ///< x at the borders between rows is computed in 1/65,536 cell
  FINE_BITS = HIGH_BITS - LATTICE_BITS,
  LAST_COLUMN = GRID_SIDE_CELLS - 1,
};

/** True if any of the columns first..last of the row is blocked. */
static bool any_blocked(const uint32_t row[GRID_BIT_WORDS], int first, int last) {
  int at = first >> 5;
  int end = last >> 5;
  uint32_t from = ~0u << (first & 31);
  uint32_t to = ~0u >> (31 - (last & 31));
  if (at == end) {
    return (row[at] & from & to) != 0u;
  }
  if ((row[at] & from) != 0u) {
    return true;
  }
  while (++at < end) {
    if (row[at] != 0u) {
      return true;
    }
  }
  return (row[end] & to) != 0u;
}

/** True if a cell of row iy is blocked between x0 and x1 [1/65,536 cell], widened by the margin. */
static bool row_blocked(const clearance_t *clearance, int iy, int32_t x0, int32_t x1) {
  const int32_t margin = CLEARANCE_MARGIN_STEPS << FINE_BITS;
  int first = ((x0 < x1 ? x0 : x1) - margin) >> HIGH_BITS;
  int last = ((x0 < x1 ? x1 : x0) + margin) >> HIGH_BITS;
  first = first < 0 ? 0 : first;
  last = last > LAST_COLUMN ? LAST_COLUMN : last;
  return any_blocked(&clearance->bits[iy * GRID_BIT_WORDS], first, last);
}

bool clearance_sees(const clearance_t *clearance, lattice_t a, lattice_t b) {
  if (a.y > b.y) {
    lattice_t low = b;
    b = a;
    a = low;
  }
  int iy = a.y >> LATTICE_BITS;
  int last = b.y >> LATTICE_BITS;
  int32_t x = a.x << FINE_BITS;
  int32_t end = b.x << FINE_BITS;
  if (iy == last) {
    return !row_blocked(clearance, iy, x, end);
  }
  // x at the first border between two rows, and the step in x from one border to the next. As |dx|
  // is less than 2^15, the products fit into 32 bits.
  int32_t dx = b.x - a.x;
  int32_t dy = b.y - a.y;
  int32_t in_first = LATTICE_PER_CELL - (a.y & (LATTICE_PER_CELL - 1));
  int32_t border = x + dx * (in_first << FINE_BITS) / dy;
  int32_t step = iy + 1 < last ? dx * (1 << HIGH_BITS) / dy : 0;
  while (iy < last) {
    if (row_blocked(clearance, iy++, x, border)) {
      return false;
    }
    x = border;
    border += step;
  }
  return !row_blocked(clearance, last, x, end);
}

uint32_t clearance_corners(const clearance_t *clearance, int iy, int word,
                           uint32_t kinds[CLEARANCE_CORNER_KINDS]) {
  const uint32_t *above = &clearance->bits[iy * GRID_BIT_WORDS];
  const uint32_t *below = above - GRID_BIT_WORDS;
  uint32_t upper_right = above[word];
  uint32_t lower_right = below[word];
  uint32_t upper_left = upper_right << 1 | (word > 0 ? above[word - 1] >> 31 : 1u);
  uint32_t lower_left = lower_right << 1 | (word > 0 ? below[word - 1] >> 31 : 1u);
  kinds[CLEARANCE_CORNER_LOWER_LEFT] = lower_left & ~(lower_right | upper_left | upper_right);
  kinds[CLEARANCE_CORNER_LOWER_RIGHT] = lower_right & ~(lower_left | upper_left | upper_right);
  kinds[CLEARANCE_CORNER_UPPER_LEFT] = upper_left & ~(upper_right | lower_left | lower_right);
  kinds[CLEARANCE_CORNER_UPPER_RIGHT] = upper_right & ~(upper_left | lower_left | lower_right);
  return kinds[0] | kinds[1] | kinds[2] | kinds[3];
}

lattice_t clearance_past_corner(int ix, int iy, clearance_corner_t kind) {
  bool right = kind == CLEARANCE_CORNER_LOWER_LEFT || kind == CLEARANCE_CORNER_UPPER_LEFT;
  bool up = kind == CLEARANCE_CORNER_LOWER_LEFT || kind == CLEARANCE_CORNER_LOWER_RIGHT;
  int dx = right ? CLEARANCE_CORNER_STEPS : -CLEARANCE_CORNER_STEPS;
  int dy = up ? CLEARANCE_CORNER_STEPS : -CLEARANCE_CORNER_STEPS;
  return (lattice_t){(int16_t)(ix * LATTICE_PER_CELL + dx), (int16_t)(iy * LATTICE_PER_CELL + dy)};
}
