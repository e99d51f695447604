// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("O2", "fp-contract=off")
#include "taut.h"

#include <string.h>

enum {
  HULL_POINTS = 24, ///< capacity of a chain
  PASSES_MAX = 4,   ///< most passes of hulls
};

static const float LEAST_GAIN_CELLS = 1.0f / 256.0f; ///< a smaller one does not count as shorter

/** Obstacle corners in the triangle a, b, c (counter-clockwise), as a convex chain from a to c. */
typedef struct {
  lattice_t a, b, c;
  lattice_t chain[HULL_POINTS];
  int count;
} hull_t;

void taut_start(taut_t *taut, int count) {
  taut->count = (uint8_t)count;
  taut->at = 0;
  taut->passes = 0;
  taut->changed = false;
  taut->stage = count < 3 ? TAUT_DONE : TAUT_SHORTCUT;
}

static void remove_points(taut_t *taut, int first, int count) {
  memmove(&taut->points[first], &taut->points[first + count],
          (size_t)(taut->count - first - count) * sizeof *taut->points);
  taut->count = (uint8_t)(taut->count - count);
}

/** Remove the points between the present one and the last one that it sees, then go on to the next.
 * @return true at the end of the path */
static bool shortcut(taut_t *taut, const clearance_t *clearance) {
  int to = taut->count - 1;
  while (to > taut->at + 1 &&
         !clearance_sees(clearance, taut->points[taut->at], taut->points[to])) {
    to--;
  }
  if (to > taut->at + 1) {
    remove_points(taut, taut->at + 1, to - taut->at - 1);
  }
  taut->at++;
  return taut->at + 2 >= taut->count;
}

/** Extend [low, high] by the x of the part of the edge p, q that lies between y0 and y1. */
static void span_of_edge(lattice_t p, lattice_t q, int32_t y0, int32_t y1, int32_t *low,
                         int32_t *high) {
  if (p.y > q.y) {
    lattice_t lower = q;
    q = p;
    p = lower;
  }
  if (q.y < y0 || p.y > y1) {
    return;
  }
  int32_t dx = q.x - p.x;
  int32_t dy = q.y - p.y;
  int32_t from = p.y < y0 ? p.x + dx * (y0 - p.y) / dy : p.x;
  int32_t to = q.y > y1 ? p.x + dx * (y1 - p.y) / dy : q.x;
  *low = from < *low ? from : *low;
  *low = to < *low ? to : *low;
  *high = from > *high ? from : *high;
  *high = to > *high ? to : *high;
}

/** True if p lies in the triangle, but not on the side from a to c: that is the straight path, and
 * needs no point. */
static bool inside(const hull_t *hull, lattice_t p) {
  return lattice_cross(hull->a, hull->b, p) >= 0 && lattice_cross(hull->b, hull->c, p) >= 0 &&
         lattice_cross(hull->a, p, hull->c) > 0;
}

/** Extend the convex chain by a corner, unless the chain encloses it already. The pieces that see
 * the corner on their outer side are contiguous, and the corner takes their place. @return false if
 * there is no room */
static bool add_corner(hull_t *hull, lattice_t p) {
  int first = -1;
  int last = -1;
  for (int i = 0; i <= hull->count; i++) {
    lattice_t from = i > 0 ? hull->chain[i - 1] : hull->a;
    lattice_t to = i < hull->count ? hull->chain[i] : hull->c;
    if (lattice_cross(from, to, p) < 0) {
      first = first < 0 ? i : first;
      last = i;
    }
  }
  if (first < 0) {
    return true;
  }
  if (hull->count + 1 - (last - first) > HULL_POINTS) {
    return false;
  }
  memmove(&hull->chain[first + 1], &hull->chain[last],
          (size_t)(hull->count - last) * sizeof *hull->chain);
  hull->chain[first] = p;
  hull->count += 1 - (last - first);
  return true;
}

/** Add the corners among the 32 vertices of a word of row iy whose bits are set in `columns`.
 * @return false if there is no room */
static bool add_corners(hull_t *hull, const clearance_t *clearance, int iy, int word,
                        uint32_t columns) {
  uint32_t kinds[CLEARANCE_CORNER_KINDS];
  uint32_t any = clearance_corners(clearance, iy, word, kinds) & columns;
  while (any != 0u) {
    int i = __builtin_ctz(any);
    int kind = 0;
    any &= any - 1u;
    while ((kinds[kind] >> i & 1u) == 0u) {
      kind++;
    }
    lattice_t p = clearance_past_corner(word * 32 + i, iy, (clearance_corner_t)kind);
    // The obstacle of a corner at b may lie outside the triangle. If b is needed, the chain without
    // it is not in sight and tighten() keeps b.
    bool known =
        lattice_equal(p, hull->a) || lattice_equal(p, hull->b) || lattice_equal(p, hull->c);
    if (!known && inside(hull, p) && !add_corner(hull, p)) {
      return false;
    }
  }
  return true;
}

/** Add the corners on one row of vertices that lie in the triangle. @return false if there is no
 * room */
static bool add_row(hull_t *hull, const clearance_t *clearance, int iy) {
  int32_t y0 = iy * LATTICE_PER_CELL - CLEARANCE_CORNER_STEPS;
  int32_t y1 = iy * LATTICE_PER_CELL + CLEARANCE_CORNER_STEPS;
  int32_t low = LATTICE_MAX;
  int32_t high = 0;
  span_of_edge(hull->a, hull->b, y0, y1, &low, &high);
  span_of_edge(hull->b, hull->c, y0, y1, &low, &high);
  span_of_edge(hull->a, hull->c, y0, y1, &low, &high);
  int first = (low - CLEARANCE_CORNER_STEPS) >> LATTICE_BITS;
  int last = (high + CLEARANCE_CORNER_STEPS + LATTICE_PER_CELL - 1) >> LATTICE_BITS;
  first = first < 1 ? 1 : first;
  last = last > GRID_SIDE_CELLS - 1 ? GRID_SIDE_CELLS - 1 : last;
  for (int word = first >> 5; word <= last >> 5 && first <= last; word++) {
    uint32_t from = word == first >> 5 ? ~0u << (first & 31) : ~0u;
    uint32_t to = word == last >> 5 ? ~0u >> (31 - (last & 31)) : ~0u;
    if (!add_corners(hull, clearance, iy, word, from & to)) {
      return false;
    }
  }
  return true;
}

static int32_t min3(int32_t a, int32_t b, int32_t c) {
  int32_t least = a < b ? a : b;
  return least < c ? least : c;
}

/** Add all corners that lie in the triangle. @return false if there is no room */
__attribute__((noinline)) static bool find_hull(hull_t *hull, const clearance_t *clearance) {
  int32_t low = min3(hull->a.y, hull->b.y, hull->c.y);
  int32_t high = -min3(-hull->a.y, -hull->b.y, -hull->c.y);
  int first = (low - CLEARANCE_CORNER_STEPS + LATTICE_PER_CELL - 1) >> LATTICE_BITS;
  int last = (high + CLEARANCE_CORNER_STEPS) >> LATTICE_BITS;
  last = last > GRID_SIDE_CELLS - 1 ? GRID_SIDE_CELLS - 1 : last;
  for (int iy = first < 1 ? 1 : first; iy <= last; iy++) {
    if (!add_row(hull, clearance, iy)) {
      return false;
    }
  }
  return true;
}

/** Length from a along the chain to c; negative if one of its pieces is not in sight. */
static float chain_length(const hull_t *hull, const clearance_t *clearance) {
  float length_cells = 0.0f;
  lattice_t from = hull->a;
  for (int i = 0; i <= hull->count; i++) {
    lattice_t to = i < hull->count ? hull->chain[i] : hull->c;
    if (!clearance_sees(clearance, from, to)) {
      return -1.0f;
    }
    length_cells += lattice_distance(from, to);
    from = to;
  }
  return length_cells;
}

/** Replace point `at` by the chain. */
static void replace_point(taut_t *taut, int at, const hull_t *hull) {
  memmove(&taut->points[at + hull->count], &taut->points[at + 1],
          (size_t)(taut->count - at - 1) * sizeof *taut->points);
  memcpy(&taut->points[at], hull->chain, (size_t)hull->count * sizeof *taut->points);
  taut->count = (uint8_t)(taut->count + hull->count - 1);
}

/** Replace point `at` by the hull if that is shorter. @return number of points in its place now */
static int tighten(taut_t *taut, const clearance_t *clearance, int at) {
  lattice_t a = taut->points[at - 1];
  lattice_t b = taut->points[at];
  lattice_t c = taut->points[at + 1];
  int32_t turn = lattice_cross(a, b, c);
  hull_t hull = {.a = turn > 0 ? a : c, .b = b, .c = turn > 0 ? c : a};
  if (turn == 0 || !find_hull(&hull, clearance) || taut->count + hull.count > TAUT_POINTS + 1) {
    return 1;
  }
  float length_cells = chain_length(&hull, clearance);
  float before_cells = lattice_distance(a, b) + lattice_distance(b, c);
  if (length_cells < 0.0f || length_cells > before_cells - LEAST_GAIN_CELLS) {
    return 1;
  }
  if (turn < 0) {
    lattice_reverse(hull.chain, hull.count);
  }
  replace_point(taut, at, &hull);
  taut->changed = true;
  return hull.count;
}

static void end_of_pass(taut_t *taut) {
  taut->passes++;
  taut->stage = taut->changed && taut->passes < PASSES_MAX ? TAUT_SHORTCUT : TAUT_DONE;
  taut->at = 0;
}

/** Before the first hulls, shortcuts are taken from the goal backwards, too. */
static void end_of_shortcuts(taut_t *taut) {
  bool again = taut->stage == TAUT_SHORTCUT && taut->passes == 0;
  if (taut->stage == TAUT_SHORTCUT_BACK || again) {
    lattice_reverse(taut->points, taut->count);
  }
  taut->stage = again ? TAUT_SHORTCUT_BACK : TAUT_HULLS;
  taut->at = again ? 0 : 1;
  taut->changed = false;
}

bool taut_step(taut_t *taut, const clearance_t *clearance) {
  if (taut->stage == TAUT_HULLS) {
    if (taut->at + 1 < taut->count) {
      taut->at = (uint8_t)(taut->at + tighten(taut, clearance, taut->at));
    } else {
      end_of_pass(taut);
    }
  } else if (taut->stage != TAUT_DONE && shortcut(taut, clearance)) {
    end_of_shortcuts(taut);
  }
  return taut->stage == TAUT_DONE;
}
