// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "slam_walls.h"

#include <math.h>
#include <string.h>

enum { KNOWN_MIN = 3 /* lines before a direction is used to straighten walls */ };
enum {
  POINTS_MIN = 6,      ///< points of a line that is a measurement
  POINTS_TO_JUDGE = 4, ///< points of a line from which a new one may deviate
  POINTS_MAX = 250,    ///< points of a line, for its counter of 8 bits
  GAP_MS = 600,        ///< longest time between two points of a line
  MEMORY = 60          ///< lines after which the counts of agreeing and differing are halved
};

static const float LENGTH_MAX_M = 1.6f;       ///< a line ends at this length
static const float LENGTH_MIN_M = 0.42f;      ///< shortest line that is a measurement, at range 0
static const float LENGTH_MIN_PER_M = 0.097f; ///< growth of LENGTH_MIN_M with range
static const float THICKNESS_M = 0.066f;      ///< largest standard deviation across, at range 1.4 m
static const float TURN_MAX_RAD = 0.21f;      ///< largest turn of the body during a line
static const float STEP_M = 0.15f;            ///< farthest next point of a line, at range 0
static const float STEP_PER_M = 0.15f;        ///< growth of STEP_M with range
static const float ASIDE_M = 0.037f;          ///< largest offset across, at range 0; twice at 1 m
static const float SQUARE_MIN = 0.82f;        ///< cosine of the largest incidence: 35 degrees
static const float NOISE_M = 0.006f;       ///< standard deviation of a point, at least, at range 0
static const float NOISE_PER_M = 0.01f;    ///< growth of NOISE_M with range
static const float WALLS_SD_RAD = 0.0053f; ///< by how much real walls deviate from straight
static const float SAME_RAD = 0.18f;       ///< a line this near to a known direction belongs to it
static const float AGREE_RAD = 0.07f;      ///< a line agrees within this and 2 standard deviations
static const float KNOWN_COS = 0.906f;     ///< a wall within 25 degrees of a direction has it
static const float PROVEN = 0.6f; ///< share of agreeing lines; chance gives a third at most

/** Line fitted to a beam's ends. */
typedef struct {
  vec2_t middle_m;     ///< relative to the first point
  vec2_t along;        ///< unit vector
  float length2_m2;    ///< variance along
  float thickness2_m2; ///< variance across
} fit_t;

static fit_t fit(const slam_line_t *line) {
  float share = 1.0f / (float)line->count;
  vec2_t middle_m = {line->x_m * share, line->y_m * share};
  float xx = line->xx_m2 * share - middle_m.x * middle_m.x;
  float yy = line->yy_m2 * share - middle_m.y * middle_m.y;
  float xy = line->xy_m2 * share - middle_m.x * middle_m.y;
  float half = 0.5f * (xx - yy);
  float root = sqrtf(half * half + xy * xy);
  float longest = 0.5f * (xx + yy) + root;
  vec2_t along = half < 0.0f ? (vec2_t){xy, root - half} : (vec2_t){half + root, xy};
  float norm = vec2_norm(along);
  return (fit_t){
      .middle_m = middle_m,
      .along = norm > 1.0e-9f ? vec2_scale(along, 1.0f / norm) : (vec2_t){1.0f, 0.0f},
      .length2_m2 = longest,
      .thickness2_m2 = geometry_clamp(0.5f * (xx + yy) - root, 0.0f, longest),
  };
}

static float cross(vec2_t a, vec2_t b) {
  return a.x * b.y - a.y * b.x;
}

/** Length of an evenly covered line whose points have this variance along it. */
static float length_m(float variance_m2) {
  return sqrtf(12.0f * variance_m2);
}

/** A line has ended. @return true if it is a measurement: long, thin and seen squarely */
static bool complete(const slam_line_t *line, float range_m, vec2_t ray, slam_bearing_t *bearing) {
  if (line->count < POINTS_MIN) {
    return false;
  }
  fit_t found = fit(line);
  float noise_m = NOISE_M + NOISE_PER_M * range_m;
  float thick_m = THICKNESS_M * sqrtf(0.5f + 0.25f * range_m * range_m);
  bool straight = length_m(found.length2_m2) > LENGTH_MIN_M + LENGTH_MIN_PER_M * range_m &&
                  found.thickness2_m2 < thick_m * thick_m &&
                  fabsf(cross(ray, found.along)) > SQUARE_MIN;
  if (straight) {
    float across_m2 = geometry_clamp(found.thickness2_m2, noise_m * noise_m, 1.0f);
    float variance = across_m2 / ((float)line->count * found.length2_m2); // of the slope
    float run_m = vec2_dot(line->last_m, found.along);
    bearing->angle_rad = geometry_atan2(found.along.y, found.along.x);
    bearing->sd_rad = sqrtf(variance + WALLS_SD_RAD * WALLS_SD_RAD);
    bearing->s_per_m = fabsf(run_m) > 0.1f ? 0.001f * (float)line->elapsed_ms / run_m : 0.0f;
  }
  return straight;
}

/** Does the line end because this point does not belong to it, or because it is long enough? */
static bool breaks(const slam_line_t *line, vec2_t point_m, float range_m) {
  if (vec2_distance(point_m, line->last_m) > STEP_M + STEP_PER_M * range_m) {
    return true;
  }
  if (line->count < POINTS_TO_JUDGE) {
    return false;
  }
  fit_t found = fit(line);
  vec2_t off_m = vec2_sub(point_m, found.middle_m);
  float along_m = vec2_dot(off_m, found.along);
  float aside_m = cross(off_m, found.along);
  float bound_m = ASIDE_M * (1.0f + range_m);
  float loose = 1.0f + 0.1f * along_m * along_m / (found.length2_m2 + 1.0e-4f);
  return aside_m * aside_m > bound_m * bound_m * loose || length_m(found.length2_m2) > LENGTH_MAX_M;
}

static void append(slam_line_t *line, vec2_t point_m, uint16_t elapsed_ms) {
  line->x_m += point_m.x;
  line->y_m += point_m.y;
  line->xx_m2 += point_m.x * point_m.x;
  line->yy_m2 += point_m.y * point_m.y;
  line->xy_m2 += point_m.x * point_m.y;
  line->last_m = point_m;
  line->elapsed_ms = elapsed_ms;
  line->count++;
}

void slam_walls_init(slam_walls_t *walls) {
  memset(walls, 0, sizeof *walls);
}

void slam_walls_break(slam_walls_t *walls) {
  memset(walls->lines, 0, sizeof walls->lines);
}

bool slam_walls_add(slam_walls_t *walls, const scan_frame_t *frame, pose2_t dead_then, int beam,
                    slam_bearing_t *bearing) {
  slam_line_t *line = &walls->lines[beam];
  bool hit = (frame->hit >> beam & 1) != 0;
  float range_m = frame->range_m[beam];
  vec2_t ray = vec2_towards(dead_then.yaw_rad + scan_bearing_rad(beam));
  vec2_t end_m = vec2_add(pose2_position(dead_then), vec2_scale(ray, range_m));
  bool completed = false;
  if (line->count > 0) {
    uint32_t elapsed_ms = frame->time_ms - line->first_ms;
    bool goes_on = hit && line->count < POINTS_MAX && elapsed_ms - line->elapsed_ms <= GAP_MS &&
                   fabsf(geometry_wrap_rad(dead_then.yaw_rad - line->yaw_rad)) <= TURN_MAX_RAD &&
                   !breaks(line, vec2_sub(end_m, line->first_m), range_m);
    if (goes_on) {
      append(line, vec2_sub(end_m, line->first_m), (uint16_t)elapsed_ms);
      return false;
    }
    completed = complete(line, range_m, ray, bearing);
    line->count = 0;
  }
  if (hit) {
    *line =
        (slam_line_t){.first_m = end_m, .yaw_rad = dead_then.yaw_rad, .first_ms = frame->time_ms};
    append(line, (vec2_t){0.0f, 0.0f}, 0);
  }
  return completed;
}

/** Count a line as agreeing or differing, and let older ones fade. */
static void count(slam_walls_t *walls, bool agrees) {
  if (walls->agreeing + walls->differing >= MEMORY) {
    walls->agreeing /= 2;
    walls->differing /= 2;
  }
  walls->agreeing = (uint8_t)(walls->agreeing + agrees);
  walls->differing = (uint8_t)(walls->differing + !agrees);
}

/** Index for a new direction: an unused one, or the one with the fewest lines after it has lost its
 *  last one; each call takes one line off it. @return -1 if none is free */
static int place_for_new(slam_walls_t *walls) {
  int least = 0;
  for (int i = 0; i < SLAM_DIRECTIONS; i++) {
    least = walls->found[i] < walls->found[least] ? i : least;
  }
  if (walls->found[least] > 0) {
    walls->found[least]--;
  }
  return walls->found[least] == 0 ? least : -1;
}

static bool proven(const slam_walls_t *walls) {
  float lines = (float)(walls->agreeing + walls->differing);
  return (float)walls->agreeing >= PROVEN * lines;
}

bool slam_walls_know(const slam_walls_t *walls, const slam_filter_t *filter, vec2_t *normal) {
  float best = KNOWN_COS;
  vec2_t from = *normal;
  for (int i = 0; i < SLAM_DIRECTIONS && proven(walls); i++) {
    if (walls->found[i] < KNOWN_MIN) {
      continue;
    }
    sincos_t direction = geometry_sincos(filter->direction_rad[i]);
    vec2_t candidate = {direction.cos, direction.sin};
    for (int quarter = 0; quarter < 4; quarter++) {
      float near = vec2_dot(from, candidate);
      if (near > best) {
        best = near;
        *normal = candidate;
      }
      candidate = (vec2_t){-candidate.y, candidate.x};
    }
  }
  return best > KNOWN_COS;
}

void slam_walls_tell(slam_walls_t *walls, slam_filter_t *filter, slam_bearing_t bearing) {
  bearing.angle_rad += filter->pose.yaw_rad - walls->dead.yaw_rad;
  int nearest = -1;
  float off_rad = SAME_RAD;
  float sd_rad = 0.0f;
  bool any = false;
  for (int i = 0; i < SLAM_DIRECTIONS; i++) {
    float sd_of_this_rad;
    float off = fabsf(slam_filter_off_rad(filter, &bearing, i, &sd_of_this_rad));
    any = any || walls->found[i] > 0;
    if (walls->found[i] > 0 && off < off_rad) {
      nearest = i;
      off_rad = off;
      sd_rad = sd_of_this_rad;
    }
  }
  if (any) {
    count(walls, nearest >= 0 && off_rad < AGREE_RAD + 2.0f * sd_rad);
  }
  if (nearest < 0) {
    int place = place_for_new(walls);
    if (place >= 0) {
      slam_filter_learn(filter, &bearing, place);
      walls->found[place] = 1;
    }
    return;
  }
  if (walls->found[nearest] < UINT8_MAX) {
    walls->found[nearest]++;
  }
  if (proven(walls)) {
    slam_filter_turn(filter, &bearing, nearest);
  }
}
