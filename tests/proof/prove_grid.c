// SPDX-License-Identifier: GPL-3.0-or-later
/* The grid, drawn into with frames and poses of any bits for any time, and asked for anything. */
#include "any.h"
#include "grid.h"

static grid_t grid;

static void draw(void) {
  scan_frame_t frame;
  frame.hit = any_u8;
  frame.clear = any_u8;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    frame.range_m[beam] = any_float;
  }
  grid_insert(&grid, &frame, any_pose2());
}

static void ask(void) {
  uint32_t bits[GRID_BIT_WORDS];
  grid_cell_t cell;
  vec2_t point_m;
  if (grid_locate(&grid, any_vec2(), &cell)) {
    grid_points_add(&grid, cell, any_vec2(), any_u8 & 1);
    grid_points_remove(&grid, cell);
  }
  grid_set_value(&grid, any_int, any_int, any_int);
  (void)grid_value(&grid, any_int, any_int);
  (void)grid_point(&grid, any_int, any_int, &point_m);
  grid_occupied_row(&grid, any_int, bits);
  grid_known_row(&grid, any_int, bits);
  (void)grid_segment_known(&grid, any_vec2(), any_vec2(), any_float);
}

int main(void) {
  grid_config_t cfg = grid_config_default();
  vec2_t centre_m = {any_between(-30.0f, 30.0f), any_between(-30.0f, 30.0f)};
  grid_init(&grid, &cfg, centre_m, any_float);
  while (any_int) {
    draw();
    ask();
  }
  return 0;
}
