// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "clearance.h"

#include <math.h>
#include <string.h>

#include "ray.h"

static const float COORDINATE_MAX = 4096.0f; ///< [cells]; farther points count as blocked

/** The disc by which an occupied cell is inflated: all cells whose square comes nearer than the
 * radius to the square of the middle cell. */
static void make_disc(clearance_t *clearance, float radius_cells) {
  for (int dy = 0; dy <= CLEARANCE_REACH_MAX; dy++) {
    float gap_y = dy > 1 ? (float)(dy - 1) : 0.0f;
    float room = radius_cells * radius_cells - gap_y * gap_y;
    if (room <= 0.0f && dy > 0) {
      break;
    }
    int half = room > 0.0f ? -(int)floorf(-sqrtf(room)) : 0;
    clearance->half_width[dy] = (uint8_t)(half < CLEARANCE_REACH_MAX ? half : CLEARANCE_REACH_MAX);
    clearance->reach = (uint8_t)dy;
  }
}

void clearance_init(clearance_t *clearance, const grid_t *grid, float radius_m, vec2_t fence_min_m,
                    vec2_t fence_max_m) {
  memset(clearance, 0, sizeof *clearance);
  clearance_configure(clearance, grid, radius_m, fence_min_m, fence_max_m);
}

void clearance_configure(clearance_t *clearance, const grid_t *grid, float radius_m,
                         vec2_t fence_min_m, vec2_t fence_max_m) {
  memset(clearance->stale_rows, 0xFF, sizeof clearance->stale_rows);
  make_disc(clearance,
            geometry_clamp(radius_m * grid->cells_per_m, 0.0f, (float)CLEARANCE_REACH_MAX));
  vec2_t low = grid_to_cells(grid, fence_min_m);
  vec2_t high = grid_to_cells(grid, fence_max_m);
  const float side = (float)GRID_SIDE_CELLS;
  clearance->fence_x0 = (int16_t)-floorf(-geometry_clamp(low.x - 1.0e-3f, 0.0f, side));
  clearance->fence_y0 = (int16_t)-floorf(-geometry_clamp(low.y - 1.0e-3f, 0.0f, side));
  clearance->fence_x1 = (int16_t)((int)floorf(geometry_clamp(high.x + 1.0e-3f, 0.0f, side)) - 1);
  clearance->fence_y1 = (int16_t)((int)floorf(geometry_clamp(high.y + 1.0e-3f, 0.0f, side)) - 1);
}

void clearance_observed_only(clearance_t *clearance, bool on) {
  if (clearance->observed_only != on) {
    clearance->observed_only = on;
    memset(clearance->stale_rows, 0xFF, sizeof clearance->stale_rows);
  }
}

void clearance_mark(clearance_t *clearance, grid_t *grid) {
  for (int iy = 0; iy < GRID_SIDE_CELLS; iy++) {
    if ((grid->changed_rows[iy / 32] >> (iy % 32) & 1u) == 0u) {
      continue;
    }
    for (int y = iy - clearance->reach; y <= iy + clearance->reach; y++) {
      if (y >= 0 && y < GRID_SIDE_CELLS) {
        clearance->stale_rows[y / 32] |= 1u << (y % 32);
      }
    }
  }
  memset(grid->changed_rows, 0, sizeof grid->changed_rows);
}

/** Cells of row iy that lie outside the geofence. */
static void outside_fence(const clearance_t *clearance, int iy, uint32_t bits[GRID_BIT_WORDS]) {
  bool row_inside = iy >= clearance->fence_y0 && iy <= clearance->fence_y1;
  grid_columns(clearance->fence_x0, clearance->fence_x1, bits);
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    bits[i] = row_inside ? ~bits[i] : ~0u;
  }
}

static void rebuild_row(clearance_t *clearance, const grid_t *grid, int iy) {
  uint32_t blocked[GRID_BIT_WORDS];
  outside_fence(clearance, iy, blocked);
  if (clearance->observed_only) {
    uint32_t known[GRID_BIT_WORDS];
    grid_known_row(grid, iy, known);
    for (int i = 0; i < GRID_BIT_WORDS; i++) {
      blocked[i] |= ~known[i];
    }
  }
  for (int dy = -clearance->reach; dy <= clearance->reach; dy++) {
    uint32_t row[GRID_BIT_WORDS];
    grid_occupied_row(grid, iy + dy, row);
    if ((row[0] | row[1] | row[2] | row[3]) == 0u) {
      continue;
    }
    for (int i = clearance->half_width[dy < 0 ? -dy : dy]; i > 0; i--) {
      grid_widen_row(row);
    }
    for (int i = 0; i < GRID_BIT_WORDS; i++) {
      blocked[i] |= row[i];
    }
  }
  memcpy(&clearance->bits[iy * GRID_BIT_WORDS], blocked, sizeof blocked);
}

int clearance_refresh(clearance_t *clearance, const grid_t *grid, int max_rows) {
  int left = 0;
  for (int iy = 0; iy < GRID_SIDE_CELLS; iy++) {
    uint32_t bit = 1u << (iy % 32);
    if ((clearance->stale_rows[iy / 32] & bit) == 0u) {
      continue;
    }
    if (max_rows > 0) {
      rebuild_row(clearance, grid, iy);
      clearance->stale_rows[iy / 32] &= ~bit;
      max_rows--;
    } else {
      left++;
    }
  }
  return left;
}

bool clearance_blocked(const clearance_t *clearance, int ix, int iy) {
  if (ix < 0 || iy < 0 || ix >= GRID_SIDE_CELLS || iy >= GRID_SIDE_CELLS) {
    return true;
  }
  return (clearance->bits[iy * GRID_BIT_WORDS + ix / 32] >> (ix % 32) & 1u) != 0u;
}

static bool traceable(vec2_t point) {
  return fabsf(point.x) < COORDINATE_MAX && fabsf(point.y) < COORDINATE_MAX;
}

bool clearance_blocked_at(const clearance_t *clearance, vec2_t point_cells) {
  return !traceable(point_cells) ||
         clearance_blocked(clearance, (int)floorf(point_cells.x), (int)floorf(point_cells.y));
}

bool clearance_square_free(const clearance_t *clearance, vec2_t point_cells, int reach) {
  if (!traceable(point_cells)) {
    return false;
  }
  int ix = (int)floorf(point_cells.x);
  int iy = (int)floorf(point_cells.y);
  for (int y = iy - reach; y <= iy + reach; y++) {
    for (int x = ix - reach; x <= ix + reach; x++) {
      if (clearance_blocked(clearance, x, y)) {
        return false;
      }
    }
  }
  return true;
}

bool clearance_segment_free(const clearance_t *clearance, vec2_t a_cells, vec2_t b_cells) {
  if (clearance_blocked_at(clearance, a_cells) || clearance_blocked_at(clearance, b_cells)) {
    return false;
  }
  ray_t ray = ray_start(a_cells, b_cells);
  while (ray_next(&ray)) {
    if (clearance_blocked(clearance, ray.ix, ray.iy)) {
      return false;
    }
    if (ray.corner && clearance_blocked(clearance, ray.ix - ray.step_x, ray.iy) &&
        clearance_blocked(clearance, ray.ix, ray.iy - ray.step_y)) {
      return false;
    }
  }
  return true;
}

bool clearance_nearest_free(const clearance_t *clearance, vec2_t point_cells, int max_cells,
                            vec2_t *free_cells) {
  if (!traceable(point_cells)) {
    return false;
  }
  int ix = (int)floorf(point_cells.x);
  int iy = (int)floorf(point_cells.y);
  float best = (float)(max_cells + 1);
  bool found = false;
  for (int dy = -max_cells; dy <= max_cells; dy++) {
    for (int dx = -max_cells; dx <= max_cells; dx++) {
      vec2_t centre = {(float)(ix + dx) + 0.5f, (float)(iy + dy) + 0.5f};
      float distance = vec2_distance(centre, point_cells);
      if (distance < best && !clearance_blocked(clearance, ix + dx, iy + dy)) {
        best = distance;
        *free_cells = centre;
        found = true;
      }
    }
  }
  return found;
}
