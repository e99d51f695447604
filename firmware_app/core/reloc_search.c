// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("O3", "fp-contract=off")
/* Exhaustive search over free places and headings. Obstacles are dilated so that a coarse stride
 * cannot miss the true place. */
#include <math.h>
#include <string.h>

#include "reloc.h"
#include "reloc_parts.h"

enum {
  HEADINGS = 72,      ///< tried at each place
  STRIDE_CELLS = 4,   ///< between places tried, in rows and columns
  END_STEP = 29,      ///< coprime to RELOC_ENDS: successive ends point elsewhere, to reject early
  LEAST_PERCENT = 70, ///< share of the ends that must lie near an obstacle
  UNITS_AIM = 48,     ///< cost of placing the ends for a heading
  UNITS_KEEP = 12,    ///< cost of keeping a place
  ENDS_PER_UNIT = 16, ///< ends that are looked up at the cost of one unit
  PLACES_A_STEP = 8,  ///< places tried in a call of reloc_try()
};

static const float PI = 3.14159265f;
static const float HEADING_RAD = 6.28318531f / 72.0f; ///< between headings: 5 degrees
static const float APART_CELLS = 6.5f; ///< distance in x and y below which places may be the same
static const float APART_RAD = 0.218f; ///< turn below which they are the same: 12.5 degrees

bool reloc_is_thick(const reloc_t *reloc, int ix, int iy) {
  return ((ix | iy) & ~(GRID_SIDE_CELLS - 1)) == 0 &&
         (reloc->thick[iy * GRID_BIT_WORDS + ix / 32] >> (ix % 32) & 1u) != 0u;
}

void reloc_thicken_row(reloc_t *reloc, const grid_t *grid, int iy) {
  uint32_t *thick = &reloc->thick[iy * GRID_BIT_WORDS];
  memset(thick, 0, GRID_BIT_WORDS * sizeof *thick);
  for (int dy = -RELOC_THICK_CELLS; dy <= RELOC_THICK_CELLS; dy++) {
    uint32_t row[GRID_BIT_WORDS];
    grid_occupied_row(grid, iy + dy, row);
    for (int i = 0; i < GRID_BIT_WORDS; i++) {
      thick[i] |= row[i];
    }
  }
  for (int step = 0; step < RELOC_THICK_CELLS; step++) {
    grid_widen_row(thick);
  }
}

static float heading_rad(const reloc_t *reloc) {
  return HEADING_RAD * (float)reloc->heading - PI;
}

static int count_hits(const reloc_t *reloc) {
  int hits = 0;
  for (int i = 0; i < reloc->count; i++) {
    for (int beam = 0; beam < SCAN_BEAMS; beam++) {
      hits += reloc->sets[i].hit >> beam & 1;
    }
  }
  return hits;
}

static int8_t to_cell(float cells) {
  return (int8_t)floorf(geometry_clamp(cells, -127.0f, 127.0f) + 0.5f);
}

/** Store the offset of a beam's end from the anchor, in cells. */
static void put_end(reloc_t *reloc, int slot, pose2_t body, float range_m, int beam,
                    float cells_per_m) {
  sincos_t turn = geometry_sincos(body.yaw_rad + scan_bearing_rad(beam));
  reloc->end_cells[slot][0] = to_cell((body.x_m + range_m * turn.cos) * cells_per_m);
  reloc->end_cells[slot][1] = to_cell((body.y_m + range_m * turn.sin) * cells_per_m);
}

/** Choose beam ends evenly over the signature, and store their offsets at the present heading. */
static void aim(reloc_t *reloc, const grid_t *grid) {
  pose2_t from_odom =
      pose2_compose((pose2_t){0.0f, 0.0f, heading_rad(reloc)}, pose2_inverse(reloc->anchor));
  int hits = count_hits(reloc);
  bool enough = hits >= RELOC_ENDS;
  int wanted = enough ? RELOC_ENDS : hits;
  int seen = 0;
  int taken = 0;
  for (int i = 0; i < reloc->count; i++) {
    const reloc_set_t *set = &reloc->sets[i];
    pose2_t body = pose2_compose(from_odom, set->pose);
    for (int beam = 0; beam < SCAN_BEAMS; beam++) {
      if ((set->hit >> beam & 1) == 0) {
        continue;
      }
      if (taken < wanted && seen * wanted >= taken * hits) {
        int slot = enough ? taken * END_STEP % RELOC_ENDS : taken;
        put_end(reloc, slot, body, 0.001f * (float)set->range_mm[beam], beam, grid->cells_per_m);
        taken++;
      }
      seen++;
    }
  }
  reloc->ends = (uint8_t)taken;
}

void reloc_search(reloc_t *reloc) {
  reloc->places = 0;
  reloc->heading = reloc->row = reloc->column = 0;
}

/** Index of a hypothesis that is the same place as pose; -1 if there is none. */
static int not_apart(const reloc_t *reloc, pose2_t pose, float apart_m) {
  for (int i = 0; i < reloc->places; i++) {
    pose2_t other = reloc->place_list[i].pose;
    if (fabsf(other.x_m - pose.x_m) < apart_m && fabsf(other.y_m - pose.y_m) < apart_m &&
        fabsf(geometry_wrap_rad(other.yaw_rad - pose.yaw_rad)) < APART_RAD) {
      return i;
    }
  }
  return -1;
}

static int worst_place(const reloc_t *reloc) {
  int worst = 0;
  for (int i = 1; i < reloc->places; i++) {
    worst = reloc->place_list[i].score < reloc->place_list[worst].score ? i : worst;
  }
  return worst;
}

/** Keep a place if it is better than the hypothesis that is the same place, or belongs to the best
 *  RELOC_PLACES. Once the list is full, only places better than its worst are looked at further. */
static void keep(reloc_t *reloc, reloc_place_t place, float apart_m) {
  reloc_place_t *list = reloc->place_list;
  int at = not_apart(reloc, place.pose, apart_m);
  if (at >= 0 && list[at].score >= place.score) {
    return;
  }
  if (at < 0) {
    at = reloc->places < RELOC_PLACES ? reloc->places++ : worst_place(reloc);
  }
  list[at] = place;
  if (reloc->places == RELOC_PLACES) {
    int better = reloc->ends - 1 - (int)list[worst_place(reloc)].score;
    reloc->misses_max = (uint8_t)(better < reloc->misses_max ? better : reloc->misses_max);
  }
}

/** Count the ends that are not near an obstacle, up to one more than misses_max.
 *  @param units  the cost is added to it */
static int count_misses(const reloc_t *reloc, int ix, int iy, int *units) {
  int misses = 0;
  int end = 0;
  for (; end < reloc->ends && misses <= reloc->misses_max; end++) {
    misses += !reloc_is_thick(reloc, ix + reloc->end_cells[end][0], iy + reloc->end_cells[end][1]);
  }
  *units += 1 + end / ENDS_PER_UNIT;
  return misses;
}

static void next_place(reloc_t *reloc) {
  reloc->column = (uint8_t)(reloc->column + STRIDE_CELLS);
  if (reloc->column >= GRID_SIDE_CELLS) {
    reloc->column = 0;
    reloc->row = (uint8_t)(reloc->row + STRIDE_CELLS);
  }
  if (reloc->row >= GRID_SIDE_CELLS) {
    reloc->row = 0;
    reloc->heading++;
  }
}

/** @return units of work */
static int try_place(reloc_t *reloc, const grid_t *grid, int ix, int iy) {
  int units = 0;
  if (grid_state(grid, ix, iy) != GRID_CELL_FREE) {
    return units;
  }
  int misses = count_misses(reloc, ix, iy, &units);
  if (misses <= reloc->misses_max) {
    vec2_t at_m = grid_centre_m(grid, (grid_cell_t){ix, iy});
    reloc_place_t place = {
        {at_m.x, at_m.y, heading_rad(reloc)}, 1.0f, (float)(reloc->ends - misses)};
    keep(reloc, place, APART_CELLS * grid->cell_m);
    units += UNITS_KEEP;
  }
  return units;
}

int reloc_try(reloc_t *reloc, const grid_t *grid) {
  if (reloc->heading == HEADINGS) {
    return 0;
  }
  int units = 1;
  if (reloc->column == 0 && reloc->row == 0) {
    aim(reloc, grid);
    units += UNITS_AIM;
    if (reloc->heading == 0) {
      reloc->misses_max = (uint8_t)(reloc->ends * (100 - LEAST_PERCENT) / 100);
    }
  }
  for (int i = 0; i < PLACES_A_STEP; i++) {
    units += try_place(reloc, grid, reloc->column, reloc->row);
    next_place(reloc);
    if (reloc->column == 0) {
      break;
    }
  }
  return units;
}
