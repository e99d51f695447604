// SPDX-License-Identifier: GPL-3.0-or-later
/* Scan, grid and clearance: arbitrary ranges, frames and poses never break the books that the map
 * keeps about itself. */
#include "bytes.h"
#include "clearance.h"
#include "grid.h"
#include "scan.h"

enum { STEPS_MAX = 200 };

typedef struct {
  scan_t scan;
  grid_t grid;
  clearance_t clearance;
  uint32_t time_ms;
} map_t;

static map_t map;

static pose2_t take_pose(bytes_t *bytes) {
  return (pose2_t){
      .x_m = take_float(bytes, -4.0f, 4.0f),
      .y_m = take_float(bytes, -4.0f, 4.0f),
      .yaw_rad = take_float(bytes, -4.0f, 4.0f),
  };
}

static void check_frame(const scan_frame_t *frame) {
  REQUIRE((frame->hit & frame->clear) == 0 && (frame->hit | frame->clear) < 1 << SCAN_BEAMS);
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    REQUIRE(geometry_is_finite(frame->range_m[beam]));
    REQUIRE((frame->hit >> beam & 1) == 0 || frame->range_m[beam] >= 0.0f);
  }
}

static void draw(const scan_frame_t *frame, pose2_t pose) {
  int known = map.grid.known;
  int changed = grid_insert(&map.grid, frame, pose);
  REQUIRE(changed >= 0 && map.grid.known >= known);
  REQUIRE(changed >= map.grid.known - known);
  clearance_mark(&map.clearance, &map.grid);
}

/** A tick of the sensors, and the frame drawn where they say that it was. */
static void sense(bytes_t *bytes) {
  scan_odometry_t odometry;
  float range_m[SCAN_RANGES];
  scan_frame_t frame;
  map.time_ms += take_below(bytes, 32) == 0 ? take_u32(bytes) : 20u;
  odometry.time_ms = map.time_ms;
  odometry.pose = take_pose(bytes);
  odometry.height_m = take_float(bytes, 0.0f, 1.0f);
  odometry.roll_rad = take_float(bytes, -0.5f, 0.5f);
  odometry.pitch_rad = take_float(bytes, -0.5f, 0.5f);
  for (int i = 0; i < SCAN_RANGES; i++) {
    range_m[i] = take_float(bytes, -0.5f, 4.0f);
  }
  if (scan_step(&map.scan, &odometry, range_m, &frame)) {
    check_frame(&frame);
    draw(&frame, frame.pose);
  }
}

static void draw_anything(bytes_t *bytes) {
  scan_frame_t frame;
  memset(&frame, 0, sizeof frame);
  frame.hit = take_u8(bytes);
  frame.clear = take_u8(bytes);
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    frame.range_m[beam] = take_float(bytes, 0.0f, 3.0f);
  }
  draw(&frame, take_pose(bytes));
}

static void ask(bytes_t *bytes) {
  vec2_t a = {take_float(bytes, -4.0f, 4.0f), take_float(bytes, -4.0f, 4.0f)};
  vec2_t b = {take_float(bytes, -4.0f, 4.0f), take_float(bytes, -4.0f, 4.0f)};
  grid_cell_t cell;
  if (grid_locate(&map.grid, a, &cell)) {
    REQUIRE(cell.ix >= 0 && cell.ix < GRID_SIDE_CELLS);
    REQUIRE(cell.iy >= 0 && cell.iy < GRID_SIDE_CELLS);
  }
  bool known = grid_segment_known(&map.grid, a, b, take_float(bytes, 0.0f, 0.5f));
  REQUIRE(!known || geometry_is_finite(a.x + a.y + b.x + b.y));
  int ix = (int)take_u32(bytes);
  int iy = (int)take_u32(bytes);
  REQUIRE(grid_value(&map.grid, ix, iy) >= 0 && grid_value(&map.grid, ix, iy) <= GRID_VALUE_MAX);
  grid_set_value(&map.grid, ix % 200, iy % 200, take_u8(bytes) % 20 - 2);
  clearance_mark(&map.clearance, &map.grid);
}

static void check_grid(const grid_t *grid) {
  int known = 0;
  for (int iy = 0; iy < GRID_SIDE_CELLS; iy++) {
    uint32_t occupied[GRID_BIT_WORDS];
    uint32_t seen[GRID_BIT_WORDS];
    grid_occupied_row(grid, iy, occupied);
    grid_known_row(grid, iy, seen);
    for (int ix = 0; ix < GRID_SIDE_CELLS; ix++) {
      grid_state_t state = grid_state(grid, ix, iy);
      vec2_t point;
      known += state != GRID_CELL_UNKNOWN;
      REQUIRE((occupied[ix / 32] >> (ix % 32) & 1u) == (state == GRID_CELL_OCCUPIED));
      REQUIRE((seen[ix / 32] >> (ix % 32) & 1u) == (state != GRID_CELL_UNKNOWN));
      if (grid_point(grid, ix, iy, &point)) {
        grid_cell_t cell;
        REQUIRE(state == GRID_CELL_OCCUPIED && grid_locate(grid, point, &cell));
        REQUIRE(cell.ix == ix && cell.iy == iy);
      }
    }
  }
  REQUIRE(known == grid->known);
}

/** The layer that followed the grid equals one built at once. */
static void check_clearance(float radius_m, vec2_t low, vec2_t high) {
  static clearance_t fresh;
  clearance_init(&fresh, &map.grid, radius_m, low, high);
  REQUIRE(clearance_refresh(&fresh, &map.grid, GRID_SIDE_CELLS) == 0);
  REQUIRE(clearance_refresh(&map.clearance, &map.grid, GRID_SIDE_CELLS) == 0);
  REQUIRE(memcmp(fresh.bits, map.clearance.bits, sizeof fresh.bits) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes_t bytes = {data, size};
  const grid_config_t grid_cfg = grid_config_default();
  const scan_config_t scan_cfg = scan_config_default();
  memset(&map, 0, sizeof map);
  vec2_t centre = {take_between(&bytes, -30.0f, 30.0f), take_between(&bytes, -30.0f, 30.0f)};
  centre = take_below(&bytes, 2) == 0 ? centre : (vec2_t){0.0f, 0.0f};
  grid_init(&map.grid, &grid_cfg, centre, take_float(&bytes, 0.02f, 0.5f));
  scan_init(&map.scan, &scan_cfg);
  float radius_m = take_float(&bytes, 0.08f, 0.5f);
  vec2_t low = {take_float(&bytes, -30.0f, 0.0f), take_float(&bytes, -30.0f, 0.0f)};
  vec2_t high = {take_float(&bytes, 0.0f, 30.0f), take_float(&bytes, 0.0f, 30.0f)};
  clearance_init(&map.clearance, &map.grid, radius_m, low, high);
  for (int i = 0; i < STEPS_MAX && bytes.left > 0; i++) {
    switch (take_below(&bytes, 4)) {
    case 0:
      draw_anything(&bytes);
      break;
    case 1:
      ask(&bytes);
      break;
    case 2:
      clearance_refresh(&map.clearance, &map.grid, take_below(&bytes, GRID_SIDE_CELLS));
      break;
    default:
      sense(&bytes);
      break;
    }
  }
  check_grid(&map.grid);
  check_clearance(radius_m, low, high);
  return 0;
}
