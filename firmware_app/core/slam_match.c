// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "slam_match.h"

#include <math.h>
#include <string.h>

enum { REACH_CELLS = 5 /* around a beam's end, in which cells are collected */ };

static const uint32_t OCCUPIED_BITS = 0x88888888u; ///< "occupied" of the eight cells in a word
static const float FAR_CELLS = 1.0e5f;      ///< coordinates beyond this: the match has diverged
static const float WEIGHT_MIN = 3.4f;       ///< total weight of cells that make a wall
static const float LENGTH_MIN_CELLS = 0.4f; ///< standard deviation along a wall, at least
static const float SQUARE_MIN = 0.765f;     ///< cosine of the largest incidence: 40 degrees
static const float CONE_SD = 0.020f;        ///< range error by the cone, times tan sin of incidence
static const float ASIDE_MAX_M = 0.10f;     ///< beam end to the wall's middle, along it, at most
static const float STRAIGHT_M = 1.0f;       ///< a wall of known direction is followed this far
static const float FADE_M = 0.6f;           ///< distance along it at which a cell's weight is half
static const float LINE_SD_M = 0.020f;      ///< standard deviation of a wall's cells, at least

/** Weighted moments of the occupied cells around a point, relative to it, in cells. */
typedef struct {
  float weight;
  float x, y, xx, yy, xy;
} moments_t;

/** Obstacle point of a cell, relative to around_cells, and its weight by log-odds.
 *  @return false if the cell is not occupied, or by something that moved */
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

/** Wall near a beam's end, fitted to the cells around. */
typedef struct {
  vec2_t offset_m; ///< from the beam's end to the wall's middle
  vec2_t normal;
  float flatness;     ///< 0 a blob .. 1 a line
  float thickness_m2; ///< variance across the wall
  float length_m2;    ///< variance along the wall
  float weight;       ///< total weight of its cells: about the number of independent hits
} wall_t;

/** Place a wall of known direction by its cells up to STRAIGHT_M along it, since such a wall is
 *  straight. By the cells nearby alone a wall bends with the drift of odometry while it is drawn;
 *  this way its first cells hold the next ones. */
__attribute__((noinline)) static void straighten(const grid_t *grid, vec2_t end_cells,
                                                 float kernel_cells2, wall_t *wall) {
  float across = vec2_dot(wall->offset_m, wall->normal) * grid->cells_per_m;
  float reach = STRAIGHT_M * grid->cells_per_m;
  float fade2 = FADE_M * FADE_M * grid->cells_per_m * grid->cells_per_m;
  float weight = 0.0f;
  float sum = 0.0f;
  float along = -reach; // samples: every third cell along the wall, three cells across it
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

/** Fit a wall to the cells around a beam's end: the eigenvalues of their covariance are the
 *  variances along and across it. @return false if there is none */
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

/** Add one beam end to the normal equations. ray_m leads from the body to the end, arm_m from the
 *  body's newest position to the end, both along the map's axes. Ends at oblique incidence are left
 *  out, because a cone reports what is nearest in it and the wall appears too near; so are ends far
 *  along the wall from its middle, where the line would be extrapolated. */
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
