// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "grid.h"

#include <math.h>
#include <string.h>

#include "ray.h"

enum {
  APART_CELLS = 3, ///< within this of a firm obstacle, a hit belongs to that obstacle
  SWEPT = 2,       ///< rays of sweep() to each side of the beam's axis
};

static const float MERGED_M = 0.4f;    ///< nearer than this before an echo, a sensor may not see a
                                       ///< second obstacle: sweep() stops there
static const float SWEPT_M = 3.3f;     ///< length of the rays of sweep() without an echo
static const float SWEPT_RAD = 0.02f;  ///< between two rays of sweep()
static const float FAR_CELLS = 1.0e5f; ///< positions farther off than this are not traced
static const float RANGE_MAX_CELLS = 512.0f; ///< no sensor here measures more
static const uint32_t OCCUPIED_BITS = 0x88888888u;

grid_config_t grid_config_default(void) {
  return (grid_config_t){
      .hit = 3,
      .miss = 1, // three misses undo a hit: newer evidence wins, but one false miss does not
      .fan_half_rad = 0.105f, // 6 of the cone's 13.5 degrees: a scan turn, 60 deg/s with 10 sets
                              // a second, leaves no gaps
      .fan_margin_m = 0.15f,
  };
}

void grid_init(grid_t *grid, const grid_config_t *cfg, vec2_t centre_m, float cell_m) {
  memset(grid, 0, sizeof *grid);
  grid->cfg = *cfg;
  grid->cell_m = geometry_clamp(cell_m, 0.02f, 0.5f);
  grid->cells_per_m = 1.0f / grid->cell_m;
  float half_m = 0.5f * (float)GRID_SIDE_CELLS * grid->cell_m;
  grid->origin_m = (vec2_t){centre_m.x - half_m, centre_m.y - half_m};
}

static bool inside(int ix, int iy) {
  return (unsigned)ix < GRID_SIDE_CELLS && (unsigned)iy < GRID_SIDE_CELLS;
}

vec2_t grid_to_cells(const grid_t *grid, vec2_t point_m) {
  return vec2_scale(vec2_sub(point_m, grid->origin_m), grid->cells_per_m);
}

vec2_t grid_to_metres(const grid_t *grid, vec2_t point_cells) {
  return vec2_add(grid->origin_m, vec2_scale(point_cells, grid->cell_m));
}

vec2_t grid_centre_m(const grid_t *grid, grid_cell_t cell) {
  return grid_to_metres(grid, (vec2_t){(float)cell.ix + 0.5f, (float)cell.iy + 0.5f});
}

bool grid_locate(const grid_t *grid, vec2_t point_m, grid_cell_t *cell) {
  vec2_t cells = grid_to_cells(grid, point_m);
  bool within = cells.x >= 0.0f && cells.y >= 0.0f && cells.x < (float)GRID_SIDE_CELLS &&
                cells.y < (float)GRID_SIDE_CELLS;
  if (within) {
    *cell = (grid_cell_t){(int)cells.x, (int)cells.y};
  }
  return within;
}

/** Value of a cell that lies inside the grid. */
static int value_inside(const grid_t *grid, int ix, int iy) {
  unsigned x = (unsigned)ix;
  return (int)(grid->cells[(unsigned)iy * GRID_ROW_WORDS + x / 8u] >> (x % 8u * 4u) & 15u);
}

int grid_value(const grid_t *grid, int ix, int iy) {
  return inside(ix, iy) ? value_inside(grid, ix, iy) : GRID_UNKNOWN;
}

static grid_state_t state_of(int value) {
  if (value == GRID_UNKNOWN) {
    return GRID_CELL_UNKNOWN;
  }
  return value < GRID_OCCUPIED_MIN ? GRID_CELL_FREE : GRID_CELL_OCCUPIED;
}

grid_state_t grid_state(const grid_t *grid, int ix, int iy) {
  return state_of(grid_value(grid, ix, iy));
}

int grid_tile(int ix, int iy) {
  return iy / GRID_TILE_SIDE_CELLS * GRID_TILES_PER_ROW + ix / GRID_TILE_SIDE_CELLS;
}

static void mark_tile(grid_t *grid, int ix, int iy) {
  int tile = grid_tile(ix, iy);
  grid->changed_tiles[tile / 32] |= 1u << (tile % 32);
}

/** Write the value of a cell, and keep what is derived from it: the number of known cells, the
 * obstacle point, changed rows and tiles. @return true if the cell's state changed */
static bool put(grid_t *grid, int ix, int iy, int value) {
  int before = grid_value(grid, ix, iy);
  uint32_t *word = &grid->cells[iy * GRID_ROW_WORDS + ix / 8];
  int shift = ix % 8 * 4;
  *word = (*word & ~(15u << shift)) | (uint32_t)value << shift;
  grid_state_t was = state_of(before);
  grid_state_t is = state_of(value);
  if (was == is) {
    return false;
  }
  grid->known = (uint16_t)(grid->known + (was == GRID_CELL_UNKNOWN) - (is == GRID_CELL_UNKNOWN));
  if (was == GRID_CELL_OCCUPIED || is == GRID_CELL_OCCUPIED) {
    grid->changed_rows[iy / 32] |= 1u << (iy % 32);
  }
  if (was == GRID_CELL_OCCUPIED) {
    grid_points_remove(grid, (grid_cell_t){ix, iy});
  }
  mark_tile(grid, ix, iy);
  return true;
}

void grid_set_value(grid_t *grid, int ix, int iy, int value) {
  if (inside(ix, iy) && value >= GRID_UNKNOWN && value <= GRID_VALUE_MAX) {
    put(grid, ix, iy, value);
  }
}

void grid_doubt(grid_t *grid, int value_max) {
  for (int word = 0; word < GRID_CELLS / 8; word++) {
    int iy = word / GRID_ROW_WORDS;
    int ix = word % GRID_ROW_WORDS * 8;
    for (int end = ix + 8; (grid->cells[word] & OCCUPIED_BITS) != 0u && ix < end; ix++) {
      int value = grid_value(grid, ix, iy);
      if (value >= GRID_OCCUPIED_MIN && value <= value_max) {
        put(grid, ix, iy, GRID_UNKNOWN);
      }
    }
  }
}

grid_echo_t grid_classify_echo(const grid_t *grid, vec2_t end_m, int reach_cells) {
  grid_cell_t cell;
  grid_echo_t judged = GRID_ECHO_STRANGE;
  if (!grid_locate(grid, end_m, &cell)) {
    return GRID_ECHO_UNEXPLAINED;
  }
  for (int iy = cell.iy - reach_cells; iy <= cell.iy + reach_cells; iy++) {
    for (int ix = cell.ix - reach_cells; ix <= cell.ix + reach_cells; ix++) {
      int value = grid_value(grid, ix, iy);
      if (value >= GRID_OCCUPIED_MIN && grid_firm(grid, ix, iy)) {
        return GRID_ECHO_FAMILIAR;
      }
      judged = value == GRID_UNKNOWN ? GRID_ECHO_UNEXPLAINED : judged;
    }
  }
  return judged;
}

/** Count a hit. An unknown cell starts from the greatest value that means free. An obstacle that
 * appears in a free cell, with no firm one near, may be passing. */
static bool add_hit(grid_t *grid, grid_cell_t cell, vec2_t point_m) {
  int before = grid_value(grid, cell.ix, cell.iy);
  int value = (before == GRID_UNKNOWN ? GRID_OCCUPIED_MIN - 1 : before) + grid->cfg.hit;
  bool comes = state_of(before) == GRID_CELL_FREE && state_of(value) == GRID_CELL_OCCUPIED &&
               grid_classify_echo(grid, point_m, APART_CELLS) != GRID_ECHO_FAMILIAR;
  bool changed = put(grid, cell.ix, cell.iy, value < GRID_VALUE_MAX ? value : GRID_VALUE_MAX);
  if (state_of(value) == GRID_CELL_OCCUPIED) {
    grid_points_add(grid, cell, point_m, comes);
    mark_tile(grid, cell.ix, cell.iy);
  }
  return changed;
}

/** Count a miss. An unknown cell starts as in add_hit(). */
static bool add_miss(grid_t *grid, int ix, int iy) {
  int value = grid_value(grid, ix, iy);
  value = (value == GRID_UNKNOWN ? GRID_OCCUPIED_MIN - 1 : value) - grid->cfg.miss;
  return put(grid, ix, iy, value > GRID_FREE_MIN ? value : GRID_FREE_MIN);
}

/** A set of ranges while it is being drawn. */
typedef struct {
  vec2_t from_cells;            ///< the drone's position
  grid_cell_t ends[SCAN_BEAMS]; ///< cells in which the beams ended; ix is -1 without an echo
  int changed;                  ///< cells whose state changed
} insertion_t;

static bool is_end(const insertion_t *insertion, int ix, int iy) {
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    if (insertion->ends[beam].ix == ix && insertion->ends[beam].iy == iy) {
      return true;
    }
  }
  return false;
}

/** Clear the cells along one ray. Rays off the axis leave occupied cells alone: the cone's edge is
 * weak evidence. Most cells have the least value already and are skipped, which saves time. */
static void clear_ray(grid_t *grid, insertion_t *insertion, vec2_t to_cells, bool axis) {
  ray_t ray = ray_start(insertion->from_cells, to_cells);
  do {
    if (!inside(ray.ix, ray.iy)) {
      continue;
    }
    int value = value_inside(grid, ray.ix, ray.iy);
    bool concerned = value != GRID_FREE_MIN && (axis || value < GRID_OCCUPIED_MIN);
    if (concerned && !is_end(insertion, ray.ix, ray.iy)) {
      insertion->changed += add_miss(grid, ray.ix, ray.iy);
    }
  } while (ray_next(&ray));
}

static vec2_t ray_end(const grid_t *grid, const insertion_t *insertion, float angle_rad,
                      float range_m) {
  sincos_t direction = geometry_sincos(angle_rad);
  float cells = range_m * grid->cells_per_m;
  return vec2_add(insertion->from_cells, (vec2_t){direction.cos * cells, direction.sin * cells});
}

/** Clear the free space of one beam: its axis, and rays beside it close enough to leave no gap. */
static void clear_fan(grid_t *grid, insertion_t *insertion, float angle_rad, float range_m) {
  clear_ray(grid, insertion, ray_end(grid, insertion, angle_rad, range_m), true);
  float side_m = range_m - grid->cfg.fan_margin_m;
  if (side_m <= 0.0f) {
    return;
  }
  float half_cells = grid->cfg.fan_half_rad * side_m * grid->cells_per_m;
  int rays = (int)geometry_clamp(half_cells + 1.0f, 1.0f, 8.0f);
  for (int i = 1; i <= rays; i++) {
    float off_rad = grid->cfg.fan_half_rad * (float)i / (float)rays;
    clear_ray(grid, insertion, ray_end(grid, insertion, angle_rad + off_rad, side_m), false);
    clear_ray(grid, insertion, ray_end(grid, insertion, angle_rad - off_rad, side_m), false);
  }
}

/** Clear occupied cells up to to_m along a beam where no firm obstacle is near: what few hits
 * support and a beam sees past was noise or has gone. */
__attribute__((noinline)) static void sweep(grid_t *grid, insertion_t *insertion, float angle_rad,
                                            float to_m) {
  for (int i = -SWEPT; i <= SWEPT && to_m > 0.0f; i++) {
    float ray_rad = angle_rad + SWEPT_RAD * (float)i;
    ray_t ray = ray_start(insertion->from_cells, ray_end(grid, insertion, ray_rad, to_m));
    do {
      vec2_t place_m = grid_centre_m(grid, (grid_cell_t){ray.ix, ray.iy});
      if (grid_value(grid, ray.ix, ray.iy) >= GRID_OCCUPIED_MIN &&
          grid_classify_echo(grid, place_m, APART_CELLS) != GRID_ECHO_FAMILIAR) {
        insertion->changed += add_miss(grid, ray.ix, ray.iy);
      }
    } while (ray_next(&ray));
  }
}

/** True if the beam is in the mask and its range is plausible. */
static bool has_beam(const grid_t *grid, const scan_frame_t *frame, int mask, int beam) {
  float cells = frame->range_m[beam] * grid->cells_per_m;
  return (mask >> beam & 1) != 0 && cells >= 0.0f && cells < RANGE_MAX_CELLS;
}

int grid_insert(grid_t *grid, const scan_frame_t *frame, pose2_t map_pose) {
  insertion_t insertion = {.from_cells = grid_to_cells(grid, pose2_position(map_pose)),
                           .changed = 0};
  if (!(fabsf(insertion.from_cells.x) < FAR_CELLS && fabsf(insertion.from_cells.y) < FAR_CELLS)) {
    return 0;
  }
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    insertion.ends[beam].ix = -1;
    if (has_beam(grid, frame, frame->hit, beam)) {
      float angle_rad = map_pose.yaw_rad + scan_bearing_rad(beam);
      vec2_t end = grid_to_metres(grid, ray_end(grid, &insertion, angle_rad, frame->range_m[beam]));
      if (grid_locate(grid, end, &insertion.ends[beam])) {
        insertion.changed += add_hit(grid, insertion.ends[beam], end);
      }
    }
  }
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    if (has_beam(grid, frame, frame->hit | frame->clear, beam)) {
      float angle_rad = map_pose.yaw_rad + scan_bearing_rad(beam);
      bool echo = (frame->hit >> beam & 1) != 0;
      clear_fan(grid, &insertion, angle_rad, frame->range_m[beam]);
      if (grid->sweeping) {
        sweep(grid, &insertion, angle_rad, echo ? frame->range_m[beam] - MERGED_M : SWEPT_M);
      }
    }
  }
  return insertion.changed;
}

/** Pack the lowest bits of a word's eight nibbles into one byte. */
static uint32_t pack_nibbles(uint32_t word) {
  word &= 0x11111111u;
  word = (word | word >> 3) & 0x03030303u;
  word = (word | word >> 6) & 0x000F000Fu;
  return (word | word >> 12) & 0xFFu;
}

void grid_occupied_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]) {
  memset(bits, 0, GRID_BIT_WORDS * sizeof bits[0]);
  if (iy < 0 || iy >= GRID_SIDE_CELLS) {
    return;
  }
  const uint32_t *row = &grid->cells[iy * GRID_ROW_WORDS];
  for (int i = 0; i < GRID_ROW_WORDS; i++) {
    if ((row[i] & OCCUPIED_BITS) != 0u) {
      bits[i / 4] |= pack_nibbles(row[i] >> 3) << (i % 4 * 8);
    }
  }
}

/** A word with its lowest `count` bits set; count may be negative or exceed 32. */
static uint32_t low_bits(int count) {
  return count <= 0 ? 0u : count >= 32 ? ~0u : (1u << count) - 1u;
}

void grid_columns(int first, int last, uint32_t bits[GRID_BIT_WORDS]) {
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    bits[i] = low_bits(last + 1 - i * 32) & ~low_bits(first - i * 32);
  }
}

void grid_widen_row(uint32_t bits[GRID_BIT_WORDS]) {
  uint32_t before = 0u;
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    uint32_t word = bits[i];
    uint32_t after = i + 1 < GRID_BIT_WORDS ? bits[i + 1] : 0u;
    bits[i] = word | word << 1 | word >> 1 | before >> 31 | after << 31;
    before = word;
  }
}

void grid_known_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]) {
  memset(bits, 0, GRID_BIT_WORDS * sizeof bits[0]);
  if (iy < 0 || iy >= GRID_SIDE_CELLS) {
    return;
  }
  const uint32_t *row = &grid->cells[iy * GRID_ROW_WORDS];
  for (int i = 0; i < GRID_ROW_WORDS; i++) {
    uint32_t any = row[i] | row[i] >> 1;
    bits[i / 4] |= pack_nibbles(any | any >> 2) << (i % 4 * 8);
  }
}

static bool line_known(const grid_t *grid, vec2_t a_cells, vec2_t b_cells) {
  ray_t ray = ray_start(a_cells, b_cells);
  do {
    if (grid_value(grid, ray.ix, ray.iy) == GRID_UNKNOWN) {
      return false;
    }
  } while (ray_next(&ray));
  return true;
}

bool grid_segment_known(const grid_t *grid, vec2_t a_m, vec2_t b_m, float half_width_m) {
  vec2_t a = grid_to_cells(grid, a_m);
  vec2_t b = grid_to_cells(grid, b_m);
  vec2_t along = vec2_sub(b, a);
  float length = vec2_norm(along);
  if (!(length < 2.0f * (float)GRID_SIDE_CELLS && fabsf(a.x) < FAR_CELLS &&
        fabsf(a.y) < FAR_CELLS)) {
    return false;
  }
  vec2_t across =
      length > 0.0f ? vec2_scale((vec2_t){-along.y, along.x}, 1.0f / length) : (vec2_t){0.0f, 1.0f};
  float half = geometry_clamp(half_width_m * grid->cells_per_m, 0.0f, (float)GRID_SIDE_CELLS);
  int lines = (int)geometry_clamp(2.0f * half + 1.0f, 1.0f, 32.0f);
  for (int i = 0; i <= lines; i++) {
    vec2_t aside = vec2_scale(across, half * (2.0f * (float)i / (float)lines - 1.0f));
    if (!line_known(grid, vec2_add(a, aside), vec2_add(b, aside))) {
      return false;
    }
  }
  return true;
}
