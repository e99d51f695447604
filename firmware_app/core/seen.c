// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "seen.h"

#include <string.h>

/** Step along a beam [tile sides]: short enough to miss no tile but where it clips a corner. */
static const float STRIDE_TILES = 0.5f;

void seen_forget(seen_t *seen) {
  memset(seen->now, 0, sizeof seen->now);
  memset(seen->before, 0, sizeof seen->before);
}

void seen_step(seen_t *seen, uint32_t time_ms, float age_s) {
  if ((float)(time_ms - seen->turned_ms) > 500.0f * age_s) {
    memcpy(seen->before, seen->now, sizeof seen->before);
    memset(seen->now, 0, sizeof seen->now);
    seen->turned_ms = time_ms;
  }
}

/** Index of the tile that contains the point; -1 outside the grid. */
static int tile_at(const grid_t *grid, vec2_t point_m) {
  grid_cell_t cell;
  return grid_locate(grid, point_m, &cell) ? grid_tile(cell.ix, cell.iy) : -1;
}

void seen_mark(seen_t *seen, const grid_t *grid, const scan_frame_t *frame, pose2_t map_pose) {
  const float stride_m = STRIDE_TILES * (float)GRID_TILE_SIDE_CELLS * grid->cell_m;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    if (((frame->hit | frame->clear) >> beam & 1) == 0) {
      continue;
    }
    vec2_t step = vec2_rotate((vec2_t){stride_m, 0.0f}, map_pose.yaw_rad + scan_bearing_rad(beam));
    vec2_t at_m = pose2_position(map_pose);
    float left_m = frame->range_m[beam];
    int tile = tile_at(grid, at_m);
    while (left_m >= 0.0f && tile >= 0) {
      seen->now[tile / 32] |= 1u << (tile % 32);
      at_m = vec2_add(at_m, step);
      tile = tile_at(grid, at_m);
      left_m -= stride_m;
    }
  }
}

bool seen_lately(const seen_t *seen, const grid_t *grid, vec2_t point_m) {
  int tile = tile_at(grid, point_m);
  return tile >= 0 && ((seen->now[tile / 32] | seen->before[tile / 32]) >> (tile % 32) & 1u) != 0u;
}
