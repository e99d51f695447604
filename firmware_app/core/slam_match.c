// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "slam_match.h"

#include <math.h>
#include <string.h>

enum { REACH_CELLS = 5 };

static const uint32_t OCCUPIED_BITS = 0x88888888u;
static const float FAR_CELLS = 1.0e5f;      ///< a step that diverged: no wall is there
static const float WEIGHT_MIN = 3.4f;       ///< lighter neighbourhoods are no wall
static const float LENGTH_MIN_CELLS = 0.4f; ///< shorter ones have no direction
static const float SQUARE_MIN = 0.765f;     ///< cosine of the largest incidence: 40 degrees
static const float CONE_SD = 0.020f;    ///< of a range seen obliquely, times tan and sin of that
static const float ASIDE_MAX_M = 0.10f; ///< of an end from the middle of its wall, along it
static const float STRAIGHT_M = 1.0f;   ///< a wall of known direction is followed so far
static const float FADE_M = 0.6f;       ///< where its cells count half
static const float LINE_SD_M = 0.020f;  ///< of the cells of a wall, at least

/** Weighted moments of the occupied cells around a point, relative to it, in cells. */
typedef struct {
  float weight;
  float x, y, xx, yy, xy;
} moments_t;

/** What lasts in a cell, relative to a point, and how much speaks for it. @return false if nothing
 */
static bool obstacle(const grid_t *grid, int ix, int iy, vec2_t around_cells, vec2_t *off_cells,
                     float *weight) {
  if ((unsigned)ix >= GRID_SIDE_CELLS || (unsigned)iy >= GRID_SIDE_CELLS) {
    return false;
  }
  uint32_t value = grid->cells[iy * GRID_ROW_WORDS + ix / 8] >> (ix % 8 * 4) & 15u;
  if (value < GRID_OCCUPIED_MIN) {
    return false;
  }
  int place = grid_lasting_eighths(grid, ix, iy);
  off_cells->x = (float)ix + ((float)(place & 7) + 0.5f) * 0.125f - around_cells.x;
  off_cells->y = (float)iy + ((float)(place >> 3) + 0.5f) * 0.125f - around_cells.y;
  *weight = (float)(value - GRID_OCCUPIED_MIN + 1);
  return place >= 0;
}

static void add_cell(const grid_t *grid, int ix, int iy, vec2_t around_cells, float kernel_cells2,
                     moments_t *sum) {
  vec2_t off;
  float w;
  if (!obstacle(grid, ix, iy, around_cells, &off, &w)) {
    return;
  }
  float near = 1.0f / (1.0f + vec2_dot(off, off) / kernel_cells2);
  w *= near * near;
  sum->weight += w;
  sum->x += w * off.x;
  sum->y += w * off.y;
  sum->xx += w * off.x * off.x;
  sum->yy += w * off.y * off.y;
  sum->xy += w * off.x * off.y;
}

static moments_t moments_around(const grid_t *grid, vec2_t p_cells, float kernel_cells2) {
  moments_t sum = {0};
  if (!(fabsf(p_cells.x) < FAR_CELLS && fabsf(p_cells.y) < FAR_CELLS)) {
    return sum;
  }
  int cx = (int)floorf(p_cells.x);
  int cy = (int)floorf(p_cells.y);
  for (int iy = cy - REACH_CELLS; iy <= cy + REACH_CELLS; iy++) {
    for (int ix = cx - REACH_CELLS; ix <= cx + REACH_CELLS; ix++) {
      bool inside = ix >= 0 && iy >= 0 && ix < GRID_SIDE_CELLS && iy < GRID_SIDE_CELLS;
      if (inside && (grid->cells[iy * GRID_ROW_WORDS + ix / 8] & OCCUPIED_BITS) != 0u) {
        add_cell(grid, ix, iy, p_cells, kernel_cells2, &sum);
      }
    }
  }
  return sum;
}

/** A wall near a beam's end: offset from the end to the wall's middle, its normal, and how sharp it
 * is. */
typedef struct {
  vec2_t offset_m;
  vec2_t normal;
  float flatness; ///< 0 a blob .. 1 a line
  float thickness_m2;
  float length_m2; ///< variance along the wall
  float weight;    ///< of the cells that it was made from: independent hits, about
} wall_t;

/** A wall whose direction is known is straight: move it across to where its cells lie, far along
 * it. What was drawn first holds what is drawn next; by the cells nearby alone a wall bends with
 * the drift of the odometry. */
__attribute__((noinline)) static void straighten(const grid_t *grid, vec2_t end_cells,
                                                 float kernel_cells2, wall_t *wall) {
  float across = vec2_dot(wall->offset_m, wall->normal) * grid->cells_per_m;
  float reach = STRAIGHT_M * grid->cells_per_m;
  float fade2 = FADE_M * FADE_M * grid->cells_per_m * grid->cells_per_m;
  float weight = 0.0f;
  float sum = 0.0f;
  float along = -reach;
  for (int steps = (int)(2.0f * reach / 3.0f); steps >= 0; steps--) {
    float aside = across - 1.0f;
    for (int row = 0; row < 3; row++) {
      vec2_t off = {aside * wall->normal.x - along * wall->normal.y,
                    aside * wall->normal.y + along * wall->normal.x};
      vec2_t at = vec2_add(end_cells, off);
      float w;
      if (obstacle(grid, (int)at.x, (int)at.y, end_cells, &off, &w)) {
        float found = vec2_dot(off, wall->normal);
        float near = 1.0f / (1.0f + (found - across) * (found - across) / kernel_cells2);
        w *= near * near / (1.0f + along * along / fade2);
        weight += w;
        sum += w * found;
      }
      aside += 1.0f;
    }
    along += 3.0f;
  }
  if (weight > 0.0f) {
    float shift_m = (sum / weight - across) * grid->cell_m;
    wall->offset_m = vec2_add(wall->offset_m, vec2_scale(wall->normal, shift_m));
  }
}

__attribute__((noinline)) static bool find_wall(const slam_t *slam, const grid_t *grid,
                                                vec2_t end_m, wall_t *wall) {
  float kernel_cells = slam->cfg.kernel_m * grid->cells_per_m;
  vec2_t end_cells = grid_to_cells(grid, end_m);
  moments_t sum = moments_around(grid, end_cells, kernel_cells * kernel_cells);
  if (sum.weight < WEIGHT_MIN) {
    return false;
  }
  float mx = sum.x / sum.weight;
  float my = sum.y / sum.weight;
  float xx = sum.xx / sum.weight - mx * mx;
  float yy = sum.yy / sum.weight - my * my;
  float xy = sum.xy / sum.weight - mx * my;
  float half = 0.5f * (xx - yy);
  float root = sqrtf(half * half + xy * xy);
  float longest = 0.5f * (xx + yy) + root;
  float least = geometry_clamp(0.5f * (xx + yy) - root, 0.0f, longest);
  if (longest < LENGTH_MIN_CELLS * LENGTH_MIN_CELLS) {
    return false;
  }
  vec2_t normal = half < 0.0f ? (vec2_t){half - root, xy} : (vec2_t){xy, -(half + root)};
  float norm = vec2_norm(normal);
  wall->normal = norm > 1.0e-9f ? vec2_scale(normal, 1.0f / norm) : (vec2_t){1.0f, 0.0f};
  wall->offset_m = vec2_scale((vec2_t){mx, my}, grid->cell_m);
  wall->flatness = (longest - least) / longest;
  wall->length_m2 = longest * grid->cell_m * grid->cell_m;
  wall->weight = sum.weight;
  wall->thickness_m2 = least * grid->cell_m * grid->cell_m;
  if (slam_walls_know(&slam->walls, &slam->filter, &wall->normal)) {
    straighten(grid, end_cells, kernel_cells * kernel_cells, wall);
  }
  return true;
}

/** One beam end's share: ray leads from the body to the end, arm is the end relative to the newest
 * body, both in map directions. A wall seen obliquely stands too near, because a cone reports what
 * is nearest in it; and a line reaches no farther than what it was drawn from. */
static void add_end(const slam_t *slam, const wall_t *wall, vec2_t arm_m, vec2_t ray_m,
                    float range_m, slam_match_t *match) {
  float square_m = vec2_dot(wall->normal, ray_m);
  float aside_m = wall->offset_m.x * wall->normal.y - wall->offset_m.y * wall->normal.x;
  if (fabsf(square_m) < SQUARE_MIN * range_m || fabsf(aside_m) > ASIDE_MAX_M) {
    return;
  }
  float sd_m = slam->cfg.range_sd_m + slam->cfg.range_sd_per_m * range_m;
  float cone_m = CONE_SD * (range_m * range_m / fabsf(square_m) - fabsf(square_m)); // r tan sin
  float line_m2 = (wall->thickness_m2 + LINE_SD_M * LINE_SD_M) *
                  (1.0f + aside_m * aside_m / wall->length_m2) / wall->weight;
  float information = wall->flatness / (line_m2 + sd_m * sd_m + cone_m * cone_m);
  float error_m = vec2_dot(wall->offset_m, wall->normal);
  float mahalanobis2 = information * error_m * error_m;
  float bound2 = slam->cfg.robust * slam->cfg.robust;
  float weight = bound2 / (bound2 + mahalanobis2);
  weight = weight * weight * information * slam->cfg.information;
  const float jacobian[3] = {wall->normal.x, wall->normal.y,
                             -wall->normal.x * arm_m.y + wall->normal.y * arm_m.x};
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) {
      match->hessian[a][b] += weight * jacobian[a] * jacobian[b];
    }
    match->gradient[a] += weight * jacobian[a] * error_m;
  }
  match->matched++;
  match->inliers += mahalanobis2 < bound2;
}

void slam_match(const slam_t *slam, const grid_t *grid, pose2_t pose, slam_match_t *match) {
  memset(match, 0, sizeof *match);
  pose2_t newest = slam->frames[slam->closed - 1].pose;
  pose2_t map_from_odom = pose2_compose(pose, pose2_inverse(newest));
  for (int i = 0; i < slam->closed; i++) {
    const scan_frame_t *frame = &slam->frames[i];
    pose2_t body = pose2_compose(map_from_odom, frame->pose);
    for (int beam = 0; beam < SCAN_BEAMS; beam++) {
      if ((frame->hit >> beam & 1) == 0) {
        continue;
      }
      vec2_t ray =
          vec2_rotate((vec2_t){frame->range_m[beam], 0.0f}, body.yaw_rad + scan_bearing_rad(beam));
      vec2_t end_m = vec2_add(pose2_position(body), ray);
      wall_t wall;
      match->ends++;
      if (find_wall(slam, grid, end_m, &wall)) {
        add_end(slam, &wall, vec2_sub(end_m, pose2_position(pose)), ray, frame->range_m[beam],
                match);
      }
    }
  }
}
