// SPDX-License-Identifier: GPL-3.0-or-later
#include "exact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool exact_blocked(const exact_map_t *map, int64_t x, int64_t y) {
  if (x < 0 || y < 0 || x >= map->width || y >= map->height) {
    return true;
  }
  return map->cells[y * map->width + x] != 0;
}

static exact_corner_t corner_kind(const exact_map_t *map, int x, int y) {
  bool low_left = exact_blocked(map, x - 1, y - 1);
  bool low_right = exact_blocked(map, x, y - 1);
  bool high_left = exact_blocked(map, x - 1, y);
  bool high_right = exact_blocked(map, x, y);
  int count = low_left + low_right + high_left + high_right;
  if (count == 1) {
    return EXACT_CONVEX;
  }
  return count == 2 && low_left == high_right ? EXACT_DOUBLE : EXACT_PLAIN;
}

exact_map_t *exact_map_new(const uint8_t *cells, int width, int height) {
  size_t size = (size_t)width * (size_t)height;
  exact_map_t *map = malloc(sizeof *map);
  uint8_t *copy = malloc(size);
  uint8_t *corners = malloc((size_t)(width + 1) * (size_t)(height + 1));
  if (map == 0 || copy == 0 || corners == 0) {
    free(map);
    free(copy);
    free(corners);
    return 0;
  }
  memcpy(copy, cells, size);
  *map = (exact_map_t){width, height, copy, corners};
  for (int y = 0; y <= height; y++) {
    for (int x = 0; x <= width; x++) {
      corners[y * (width + 1) + x] = (uint8_t)corner_kind(map, x, y);
    }
  }
  return map;
}

void exact_map_free(exact_map_t *map) {
  if (map != 0) {
    free(map->cells);
    free(map->corners);
    free(map);
  }
}

exact_point_t exact_point(double x_cells, double y_cells) {
  return (exact_point_t){llround(x_cells * EXACT_UNIT), llround(y_cells * EXACT_UNIT)};
}

static int64_t least(int64_t a, int64_t b) {
  return a < b ? a : b;
}

static int64_t most(int64_t a, int64_t b) {
  return a > b ? a : b;
}

/** The cell that a coordinate lies in; a border counts to the cell above it. */
static int64_t cell_of(int64_t coordinate) {
  return coordinate >> 22;
}

/** Twice the signed area of the triangle a, b, (x, y). */
static int64_t side(exact_point_t a, exact_point_t b, int64_t x, int64_t y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/** Whether the segment meets the inside of a box: no axis keeps them apart. */
static bool meets_box(exact_point_t a, exact_point_t b, exact_point_t low, exact_point_t high) {
  if (most(a.x, b.x) <= low.x || least(a.x, b.x) >= high.x || most(a.y, b.y) <= low.y ||
      least(a.y, b.y) >= high.y) {
    return false;
  }
  if (a.x == b.x && a.y == b.y) {
    return true;
  }
  int64_t s0 = side(a, b, low.x, low.y);
  int64_t s1 = side(a, b, high.x, low.y);
  int64_t s2 = side(a, b, low.x, high.y);
  int64_t s3 = side(a, b, high.x, high.y);
  bool left = s0 > 0 || s1 > 0 || s2 > 0 || s3 > 0;
  bool right = s0 < 0 || s1 < 0 || s2 < 0 || s3 < 0;
  return left && right;
}

static bool meets_cell(exact_point_t a, exact_point_t b, int64_t x, int64_t y, int64_t shrink) {
  exact_point_t low = {x * EXACT_UNIT + shrink, y * EXACT_UNIT + shrink};
  exact_point_t high = {(x + 1) * EXACT_UNIT - shrink, (y + 1) * EXACT_UNIT - shrink};
  return meets_box(a, b, low, high);
}

/** A vertical segment on a line of the lattice, whose cells to both sides are blocked somewhere. */
static bool in_vertical_seam(const exact_map_t *map, exact_point_t a, exact_point_t b) {
  if (a.x != b.x || a.x % EXACT_UNIT != 0) {
    return false;
  }
  int64_t x = cell_of(a.x);
  for (int64_t y = cell_of(least(a.y, b.y)); y * EXACT_UNIT < most(a.y, b.y); y++) {
    if (exact_blocked(map, x - 1, y) && exact_blocked(map, x, y)) {
      return true;
    }
  }
  return false;
}

static bool in_horizontal_seam(const exact_map_t *map, exact_point_t a, exact_point_t b) {
  if (a.y != b.y || a.y % EXACT_UNIT != 0) {
    return false;
  }
  int64_t y = cell_of(a.y);
  for (int64_t x = cell_of(least(a.x, b.x)); x * EXACT_UNIT < most(a.x, b.x); x++) {
    if (exact_blocked(map, x, y - 1) && exact_blocked(map, x, y)) {
      return true;
    }
  }
  return false;
}

/** Whether the lattice corner (x, y) is one that no way may pass, and lies on the segment. */
static bool at_double_corner(const exact_map_t *map, exact_point_t a, exact_point_t b, int64_t x,
                             int64_t y) {
  if (x < 0 || y < 0 || x > map->width || y > map->height ||
      map->corners[y * (map->width + 1) + x] != EXACT_DOUBLE) {
    return false;
  }
  int64_t px = x * EXACT_UNIT;
  int64_t py = y * EXACT_UNIT;
  return px >= least(a.x, b.x) && px <= most(a.x, b.x) && py >= least(a.y, b.y) &&
         py <= most(a.y, b.y) && side(a, b, px, py) == 0;
}

/** x on the segment at height y, rounded down; the segment is not horizontal. */
static int64_t x_at(exact_point_t a, exact_point_t b, int64_t y) {
  int64_t dy = b.y - a.y;
  int64_t part = (b.x - a.x) * (y - a.y);
  int64_t quotient = part / dy;
  return a.x + quotient - (part % dy != 0 && (part < 0) != (dy < 0));
}

/** The part of one row of cells: a is not above b. */
static bool row_free(const exact_map_t *map, exact_point_t a, exact_point_t b, int64_t y,
                     int64_t shrink) {
  int64_t x0 = a.x;
  int64_t x1 = b.x;
  if (a.y != b.y) {
    x0 = x_at(a, b, most(a.y, y * EXACT_UNIT));
    x1 = x_at(a, b, least(b.y, (y + 1) * EXACT_UNIT));
  }
  int64_t first = cell_of(least(x0, x1));
  int64_t last = cell_of(most(x0, x1) + 1);
  for (int64_t x = first; x <= last; x++) {
    if (exact_blocked(map, x, y) && meets_cell(a, b, x, y, shrink)) {
      return false;
    }
    if (at_double_corner(map, a, b, x, y)) {
      return false;
    }
  }
  return true;
}

bool exact_segment_free(const exact_map_t *map, exact_point_t a, exact_point_t b, int64_t shrink) {
  if (a.y > b.y) {
    exact_point_t swapped = a;
    a = b;
    b = swapped;
  }
  if (in_vertical_seam(map, a, b) || in_horizontal_seam(map, a, b)) {
    return false;
  }
  for (int64_t y = cell_of(a.y); y * EXACT_UNIT <= b.y; y++) {
    if (!row_free(map, a, b, y, shrink)) {
      return false;
    }
  }
  return true;
}

double exact_way_length(const exact_map_t *map, const double *xy_cells, int count, int64_t shrink) {
  const double far = 250.0;
  double length = 0.0;
  for (int i = 0; i + 1 < count; i++) {
    const double *leg = &xy_cells[2 * i];
    for (int k = 0; k < 4; k++) {
      if (!(fabs(leg[k]) < far)) {
        return -1.0 - i;
      }
    }
    if (!exact_segment_free(map, exact_point(leg[0], leg[1]), exact_point(leg[2], leg[3]),
                            shrink)) {
      return -1.0 - i;
    }
    length += hypot(leg[2] - leg[0], leg[3] - leg[1]);
  }
  return length;
}
