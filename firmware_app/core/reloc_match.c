// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Match and score of one hypothesis against the grid. */
#include <math.h>

#include "reloc.h"
#include "reloc_parts.h"

enum {
  REACH_CELLS = RELOC_THICK_CELLS, ///< rows and columns around a beam's end that are searched
  PATH_BITS = 16                   ///< fraction bits of a cell, along a ray
};

static const uint32_t OCCUPIED_BITS = 0x88888888u; ///< "occupied" of the eight cells in a word
static const uint32_t SEVEN = 0x01111111u;         ///< mask of 2 REACH_CELLS + 1 cells of eight
static const float REACH_MAX_CELLS = 3.6f; ///< farthest obstacle that a beam's end may belong to
static const float FAR_CELLS = 1000.0f;    ///< coordinates beyond this are off the map
static const float PATH_MARGIN_M = 0.3f;   ///< end of a beam where it may graze its own obstacle
static const float IN_UNKNOWN = 0.1f;      ///< score of a beam that ends in an unknown cell
static const float OLD = 0.4f;             ///< weight of the oldest set in a match; newest: 1
static const float OBLIQUE = 0.3f;         ///< weight of a beam that grazes its obstacle
static const float SQUARE_CELLS2 = 0.1f;   ///< squared distance below which incidence is unknown
static const float WEIGHT_MIN = 3.0f;      ///< total weight needed to move a hypothesis
static const float TURN_MAX_RAD = 0.1f;    ///< largest turn in one pass
static const float SPREAD_MIN_M2 = 0.01f;  ///< keeps the turn finite when all ends coincide
static const float STRETCH_M2 = 0.2f;      ///< prior of stretch 1, as a sum of squared levers
static const float STRETCH_MIN = 0.8f;     ///< bounds of stretch
static const float STRETCH_MAX = 1.2f;
static const float THROUGH = -0.5f; ///< score of a beam that passes an obstacle

/** Occupied cells among the eight from ix on, as bits 0, 4, 8 ...; cells outside count as free. */
static uint32_t eight_from(const grid_t *grid, int ix, int iy) {
  if ((unsigned)iy >= GRID_SIDE_CELLS || ix <= -8 || ix >= GRID_SIDE_CELLS) {
    return 0u;
  }
  const uint32_t *row = &grid->cells[iy * GRID_ROW_WORDS];
  int word = (ix + 8) / 8 - 1;
  int shift = (ix + 8) % 8 * 4;
  uint32_t low = word >= 0 ? row[word] & OCCUPIED_BITS : 0u;
  uint32_t high = word + 1 < GRID_ROW_WORDS ? row[word + 1] & OCCUPIED_BITS : 0u;
  return (shift == 0 ? low : low >> shift | high << (32 - shift)) >> 3;
}

/** Vector to the nearest occupied cell. @return false if none is within reach */
static bool nearest(const reloc_t *reloc, const grid_t *grid, vec2_t place_cells,
                    vec2_t *away_cells) {
  if (!(fabsf(place_cells.x) < FAR_CELLS && fabsf(place_cells.y) < FAR_CELLS)) {
    return false;
  }
  int cx = (int)floorf(place_cells.x);
  int cy = (int)floorf(place_cells.y);
  if (!reloc_is_thick(reloc, cx, cy)) {
    return false;
  }
  float best = REACH_MAX_CELLS * REACH_MAX_CELLS;
  bool found = false;
  for (int i = 0; i <= 2 * REACH_CELLS; i++) {
    int iy = cy + (i % 2 == 0 ? i / 2 : -(i + 1) / 2); // the middle row, then those beside it
    float y = (float)iy + 0.5f - place_cells.y;
    if (y * y >= best) {
      continue;
    }
    uint32_t bits = eight_from(grid, cx - REACH_CELLS, iy) & SEVEN;
    for (; bits != 0u; bits &= bits - 1u) {
      int ix = cx - REACH_CELLS + __builtin_ctz(bits) / 4;
      float x = (float)ix + 0.5f - place_cells.x;
      if (x * x + y * y < best) {
        best = x * x + y * y;
        *away_cells = (vec2_t){x, y};
        found = true;
      }
    }
  }
  return found;
}

/** Unit vector along a beam, map frame, of a body with this heading. */
static vec2_t beam_direction(int beam, sincos_t body) {
  switch (beam) {
  case SCAN_BACK:
    return (vec2_t){-body.cos, -body.sin};
  case SCAN_LEFT:
    return (vec2_t){-body.sin, body.cos};
  case SCAN_RIGHT:
    return (vec2_t){body.sin, -body.cos};
  default:
    return (vec2_t){body.cos, body.sin};
  }
}

/** Map pose of the body at a set, by the present hypothesis. */
static pose2_t body_at(const reloc_t *reloc, const reloc_set_t *set) {
  return reloc_pose_at(reloc, &reloc->place_list[reloc->place], set->pose);
}

/** Weight of a set in a match: OLD for the oldest up to 1 for the newest. */
static float recency(const reloc_t *reloc, int set) {
  int rank = (set + RELOC_SETS - reloc->oldest) % RELOC_SETS + 1;
  return OLD + (1.0f - OLD) * (float)rank / (float)reloc->count;
}

/** Weight of a beam's end in a match. A cone reports the near edge of an obstacle that it meets
 *  obliquely, so such a beam weighs little; so does a distant obstacle. */
static float weight_of(vec2_t direction, vec2_t away_cells) {
  float distance2 = vec2_dot(away_cells, away_cells);
  float along = vec2_dot(away_cells, direction);
  return (1.0f - 0.8f * distance2 / (REACH_MAX_CELLS * REACH_MAX_CELLS)) *
         (OBLIQUE + along * along / (distance2 + SQUARE_CELLS2));
}

/** Add one beam's end to the sums. Inlined, it would make the caller's stack frame too large. */
static void __attribute__((noinline))
add_end(reloc_sums_t *sums, vec2_t arm_m, vec2_t lever_m, vec2_t away_m, float w) {
  sums->weight += w;
  sums->arm_m = vec2_add(sums->arm_m, vec2_scale(arm_m, w));
  sums->away_m = vec2_add(sums->away_m, vec2_scale(away_m, w));
  sums->lever_m = vec2_add(sums->lever_m, vec2_scale(lever_m, w));
  sums->arm2_m2 += w * vec2_dot(arm_m, arm_m);
  sums->lever2_m2 += w * vec2_dot(lever_m, lever_m);
  sums->arm_lever_m2 += w * (arm_m.x * lever_m.y - arm_m.y * lever_m.x);
  sums->along_m2 += w * vec2_dot(lever_m, away_m);
  sums->cross_m2 += w * (arm_m.x * away_m.y - arm_m.y * away_m.x);
}

void reloc_match_set(reloc_t *reloc, const grid_t *grid, int set) {
  const reloc_set_t *measured = &reloc->sets[set];
  pose2_t body = body_at(reloc, measured);
  sincos_t turn = geometry_sincos(body.yaw_rad);
  const reloc_place_t *place = &reloc->place_list[reloc->place];
  vec2_t lever_m = vec2_sub(pose2_position(body), pose2_position(place->pose));
  float factor = recency(reloc, set);
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    if ((measured->hit >> beam & 1) == 0) {
      continue;
    }
    vec2_t direction = beam_direction(beam, turn);
    vec2_t end_m = vec2_add(pose2_position(body),
                            vec2_scale(direction, 0.001f * (float)measured->range_mm[beam]));
    vec2_t away_cells;
    if (nearest(reloc, grid, grid_to_cells(grid, end_m), &away_cells)) {
      vec2_t arm_m = vec2_sub(end_m, pose2_position(place->pose));
      add_end(&reloc->sums, arm_m, lever_m, vec2_scale(away_cells, grid->cell_m),
              factor * weight_of(direction, away_cells));
    }
  }
}

/** Weighted least squares for shift, turn and stretch. The sums are centred first, which leaves a
 *  system of two equations for turn and stretch; the shift follows. */
void reloc_match_end(reloc_t *reloc) {
  const reloc_sums_t *sums = &reloc->sums;
  if (sums->weight < WEIGHT_MIN) {
    return;
  }
  reloc_place_t *place = &reloc->place_list[reloc->place];
  float share = 1.0f / sums->weight;
  vec2_t arm_m = vec2_scale(sums->arm_m, share);
  vec2_t lever_m = vec2_scale(sums->lever_m, share);
  vec2_t away_m = vec2_scale(sums->away_m, share);
  float known_m2 = STRETCH_M2 * share;
  float arm2_m2 = sums->arm2_m2 * share - vec2_dot(arm_m, arm_m) + SPREAD_MIN_M2;
  float lever2_m2 = sums->lever2_m2 * share - vec2_dot(lever_m, lever_m) + known_m2;
  float both_m2 = sums->arm_lever_m2 * share - (arm_m.x * lever_m.y - arm_m.y * lever_m.x);
  float cross_m2 = sums->cross_m2 * share - (arm_m.x * away_m.y - arm_m.y * away_m.x);
  float along_m2 =
      sums->along_m2 * share - vec2_dot(lever_m, away_m) - known_m2 * (place->stretch - 1.0f);
  float whole = 1.0f / (arm2_m2 * lever2_m2 - both_m2 * both_m2);
  float turn_rad = geometry_clamp((cross_m2 * lever2_m2 - along_m2 * both_m2) * whole,
                                  -TURN_MAX_RAD, TURN_MAX_RAD);
  float more = (along_m2 * arm2_m2 - cross_m2 * both_m2) * whole;
  float stretch = geometry_clamp(place->stretch * (1.0f + more), STRETCH_MIN, STRETCH_MAX);
  more = stretch / place->stretch - 1.0f;
  place->stretch = stretch;
  pose2_t *pose = &place->pose;
  pose->x_m += away_m.x + turn_rad * arm_m.y - more * lever_m.x;
  pose->y_m += away_m.y - turn_rad * arm_m.x - more * lever_m.y;
  pose->yaw_rad = geometry_wrap_rad(pose->yaw_rad + turn_rad);
}

/** Is any of the first `steps` cells along the ray occupied? */
static bool passes_obstacle(const grid_t *grid, vec2_t from_cells, vec2_t direction, int steps) {
  const float one = (float)(1 << PATH_BITS);
  int32_t x = (int32_t)(from_cells.x * one);
  int32_t y = (int32_t)(from_cells.y * one);
  int32_t dx = (int32_t)(direction.x * one);
  int32_t dy = (int32_t)(direction.y * one);
  for (; steps > 0; steps--) {
    x += dx;
    y += dy;
    int ix = x >> PATH_BITS;
    int iy = y >> PATH_BITS;
    if (((ix | iy) & ~(GRID_SIDE_CELLS - 1)) != 0) {
      return false;
    }
    if ((grid->cells[iy * GRID_ROW_WORDS + ix / 8] >> (ix % 8 * 4) & GRID_OCCUPIED_MIN) != 0u) {
      return true;
    }
  }
  return false;
}

/** Score of a beam that ends there. */
static float worth_of_end(const reloc_t *reloc, const grid_t *grid, vec2_t end_cells) {
  vec2_t away_cells;
  if (nearest(reloc, grid, end_cells, &away_cells)) {
    return 1.0f - vec2_dot(away_cells, away_cells) / (REACH_MAX_CELLS * REACH_MAX_CELLS);
  }
  bool unknown =
      grid_state(grid, (int)floorf(end_cells.x), (int)floorf(end_cells.y)) == GRID_CELL_UNKNOWN;
  return unknown ? IN_UNKNOWN : 0.0f;
}

void reloc_judge_set(reloc_t *reloc, const grid_t *grid, int set) {
  const reloc_set_t *measured = &reloc->sets[set];
  pose2_t body = body_at(reloc, measured);
  sincos_t turn = geometry_sincos(body.yaw_rad);
  vec2_t from_cells = grid_to_cells(grid, pose2_position(body));
  if (!(fabsf(from_cells.x) < FAR_CELLS && fabsf(from_cells.y) < FAR_CELLS)) {
    reloc->sums.weight += 1.0f;
    return;
  }
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    bool hit = (measured->hit >> beam & 1) != 0;
    bool clear = (measured->clear >> beam & 1) != 0;
    vec2_t direction = beam_direction(beam, turn);
    float range_cells = 0.001f * (float)measured->range_mm[beam] * grid->cells_per_m;
    int steps = (int)(range_cells - PATH_MARGIN_M * grid->cells_per_m);
    reloc->sums.weight += hit ? 1.0f : 0.0f;
    if ((hit || clear) && passes_obstacle(grid, from_cells, direction, steps)) {
      reloc->sums.score += THROUGH;
    } else if (hit) {
      reloc->sums.score +=
          worth_of_end(reloc, grid, vec2_add(from_cells, vec2_scale(direction, range_cells)));
    }
  }
}
