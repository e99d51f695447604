// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "slam_filter.h"

#include <math.h>
#include <string.h>

enum { X, Y, YAW, BIAS, SCALE, DRIFT_X, DRIFT_Y, DIRECTION };

static const float QUARTER_RAD = 1.57079633f; ///< a right angle
static const float START_SD_M = 0.014f;       ///< initial standard deviation of x and y
static const float START_SD_RAD = 0.00873f;   ///< initial standard deviation of the yaw: 0.5 deg
static const float BIAS_WALK_RPS = 5.2e-5f; ///< gyro bias: 0.003 deg/s per square root of a second
static const float SCALE_WALK = 0.0039f;    ///< flow scale, per square root of a second
static const float TURN_SD = 0.0080f;       ///< scale error of the gyro, per radian turned
static const float DRIFT_TAU_S = 13.0f;     ///< time constant of the drift
static const float DRIFT_LEARN_S = 11.0f;   ///< time constant with which its variance is learned
static const float DRIFT_MIN_M2PS2 = 4.0e-6f; ///< variance learned, at least: (2 mm/s)^2
static const float DRIFT_MAX_M2PS2 = 9.0e-4f; ///< variance learned, at most: (3 cm/s)^2
static const float SCALE_MAX = 0.3f;          ///< bound of the scale state
static const float BIAS_MAX_RPS = 0.035f;     ///< bound of the bias state: 2 deg/s
static const float ROBUST2 = 6.3f;            ///< Geman-McClure bound of a direction, squared
static const float SLOPE_MAX_S_PER_M = 10.0f; ///< bound of slam_bearing_t.s_per_m

/** Index of the covariance of two states. */
static int pair(int a, int b) {
  return a > b ? a * (a + 1) / 2 + b : b * (b + 1) / 2 + a;
}

static float cov(const slam_filter_t *filter, int a, int b) {
  return filter->covariance[pair(a, b)];
}

static void add_variance(slam_filter_t *filter, int state, float variance) {
  filter->covariance[pair(state, state)] += variance;
}

static float square(float value) {
  return value * value;
}

void slam_filter_init(slam_filter_t *filter, const slam_noise_t *noise, pose2_t map_pose) {
  memset(filter, 0, sizeof *filter);
  filter->pose = map_pose;
  slam_filter_forget(filter, noise);
}

void slam_filter_forget(slam_filter_t *filter, const slam_noise_t *noise) {
  memset(filter->covariance, 0, sizeof filter->covariance);
  filter->drift_m2ps2 = square(noise->drift_sd_mps);
  add_variance(filter, X, square(START_SD_M));
  add_variance(filter, Y, square(START_SD_M));
  add_variance(filter, YAW, square(START_SD_RAD));
  add_variance(filter, BIAS, square(noise->bias_sd_rps));
  add_variance(filter, SCALE, square(noise->scale_sd));
  add_variance(filter, DRIFT_X, filter->drift_m2ps2);
  add_variance(filter, DRIFT_Y, filter->drift_m2ps2);
}

void slam_filter_place(slam_filter_t *filter, float sd_m, float sd_rad) {
  for (int state = X; state <= YAW; state++) {
    for (int other = 0; other < SLAM_STATES; other++) {
      filter->covariance[pair(state, other)] = 0.0f;
    }
  }
  add_variance(filter, X, square(sd_m));
  add_variance(filter, Y, square(sd_m));
  add_variance(filter, YAW, square(sd_rad));
}

pose2_t slam_filter_move(slam_filter_t *filter, pose2_t step, float elapsed_s) {
  step.x_m = step.x_m * (1.0f - filter->scale) - filter->drift_mps.x * elapsed_s;
  step.y_m = step.y_m * (1.0f - filter->scale) - filter->drift_mps.y * elapsed_s;
  step.yaw_rad -= filter->bias_rps * elapsed_s;
  filter->drift_mps = vec2_scale(filter->drift_mps, 1.0f - elapsed_s / DRIFT_TAU_S);
  filter->pose = pose2_compose(filter->pose, step);
  return step;
}

/** Rows x, y and yaw of the transition matrix F over a motion. */
typedef struct {
  float row[3][DIRECTION];
} motion_t;

/** A bias turns the motion by its angle half-way, hence 0.5 elapsed_s. */
static void describe(motion_t *motion, vec2_t moved_m, float yaw_rad, float elapsed_s) {
  sincos_t heading = geometry_sincos(yaw_rad);
  *motion = (motion_t){{
      {1.0f, 0.0f, -moved_m.y, 0.5f * moved_m.y * elapsed_s, -moved_m.x, -heading.cos * elapsed_s,
       heading.sin * elapsed_s},
      {0.0f, 1.0f, moved_m.x, -0.5f * moved_m.x * elapsed_s, -moved_m.y, -heading.sin * elapsed_s,
       -heading.cos * elapsed_s},
      {0.0f, 0.0f, 1.0f, -elapsed_s, 0.0f, 0.0f, 0.0f},
  }};
}

/** Element (a, s) of F P, where P is the covariance. */
static float carried(const slam_filter_t *filter, const motion_t *motion, int a, int s) {
  float sum = 0.0f;
  for (int k = 0; k < DIRECTION; k++) {
    sum += motion->row[a][k] * cov(filter, k, s);
  }
  return sum;
}

/** P = F P F'. Apart from the rows of `motion`, F is the identity, with `keep` for the drift. */
__attribute__((noinline)) static void transport(slam_filter_t *filter, const motion_t *motion,
                                                float keep) {
  float moved[3][SLAM_STATES]; // rows x, y and yaw of F P
  for (int a = 0; a < 3; a++) {
    for (int s = 0; s < SLAM_STATES; s++) {
      moved[a][s] = carried(filter, motion, a, s);
    }
  }
  for (int s = 3; s < SLAM_STATES; s++) {
    float fade = s == DRIFT_X || s == DRIFT_Y ? keep : 1.0f;
    for (int a = 0; a < 3; a++) {
      filter->covariance[pair(s, a)] = fade * moved[a][s];
    }
  }
  for (int s = DRIFT_X; s < SLAM_STATES; s++) {
    for (int t = 3; t <= s; t++) {
      float fade = (s <= DRIFT_Y ? keep : 1.0f) * (t == DRIFT_X || t == DRIFT_Y ? keep : 1.0f);
      filter->covariance[pair(s, t)] *= fade;
    }
  }
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b <= a; b++) {
      float sum = 0.0f;
      for (int k = 0; k < DIRECTION; k++) {
        sum += moved[a][k] * motion->row[b][k];
      }
      filter->covariance[pair(a, b)] = sum;
    }
  }
}

/** Move the drift's variance towards the expected square of the present drift. */
static void learn_drift(slam_filter_t *filter, float elapsed_s) {
  float seen = 0.5f * (vec2_dot(filter->drift_mps, filter->drift_mps) +
                       cov(filter, DRIFT_X, DRIFT_X) + cov(filter, DRIFT_Y, DRIFT_Y));
  float share = geometry_clamp(elapsed_s / DRIFT_LEARN_S, 0.0f, 1.0f);
  filter->drift_m2ps2 = geometry_clamp(filter->drift_m2ps2 + share * (seen - filter->drift_m2ps2),
                                       DRIFT_MIN_M2PS2, DRIFT_MAX_M2PS2);
}

void slam_filter_grow(slam_filter_t *filter, const slam_noise_t *noise, vec2_t moved_m,
                      float turned_rad, float elapsed_s) {
  float keep = geometry_clamp(1.0f - elapsed_s / DRIFT_TAU_S, 0.0f, 1.0f);
  motion_t motion;
  describe(&motion, moved_m, filter->pose.yaw_rad, elapsed_s);
  transport(filter, &motion, keep);
  learn_drift(filter, elapsed_s);
  float calm =
      geometry_clamp(filter->drift_m2ps2 / (square(noise->drift_sd_mps) + 1.0e-12f), 0.0f, 2.0f);
  float flow_m2 = calm * (square(noise->flow_sd_mps) * elapsed_s +
                          square(noise->flow_sd_per_m) * vec2_dot(moved_m, moved_m));
  add_variance(filter, X, flow_m2);
  add_variance(filter, Y, flow_m2);
  add_variance(filter, YAW, square(noise->yaw_sd_rps) * elapsed_s + square(TURN_SD * turned_rad));
  add_variance(filter, BIAS, square(BIAS_WALK_RPS) * elapsed_s);
  add_variance(filter, SCALE, square(SCALE_WALK) * elapsed_s);
  float drift_m2ps2 = filter->drift_m2ps2 * (1.0f - keep * keep);
  add_variance(filter, DRIFT_X, drift_m2ps2);
  add_variance(filter, DRIFT_Y, drift_m2ps2);
}

bool slam_filter_invert(float m[3][3], float inverse[3][3]) {
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) {
      int r0 = (b + 1) % 3;
      int r1 = (b + 2) % 3;
      int c0 = (a + 1) % 3;
      int c1 = (a + 2) % 3;
      inverse[a][b] = m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0];
    }
  }
  float determinant = m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
  if (!(determinant > 1.0e-30f && geometry_is_finite(determinant))) {
    return false;
  }
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) {
      inverse[a][b] /= determinant;
    }
  }
  return true;
}

bool slam_filter_information(const slam_filter_t *filter, float inverse[3][3]) {
  float pose[3][3];
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) {
      pose[a][b] = cov(filter, a, b);
    }
  }
  return slam_filter_invert(pose, inverse);
}

/** Add a correction to every state; the pose turns about the pivot. */
static void shift(slam_filter_t *filter, const float off[SLAM_STATES], vec2_t pivot_m) {
  vec2_t arm_m = vec2_rotate(vec2_sub(pose2_position(filter->pose), pivot_m), off[YAW]);
  filter->pose.x_m = pivot_m.x + arm_m.x + off[X];
  filter->pose.y_m = pivot_m.y + arm_m.y + off[Y];
  filter->pose.yaw_rad = geometry_wrap_rad(filter->pose.yaw_rad + off[YAW]);
  filter->bias_rps = geometry_clamp(filter->bias_rps + off[BIAS], -BIAS_MAX_RPS, BIAS_MAX_RPS);
  filter->scale = geometry_clamp(filter->scale + off[SCALE], -SCALE_MAX, SCALE_MAX);
  filter->drift_mps = vec2_add(filter->drift_mps, (vec2_t){off[DRIFT_X], off[DRIFT_Y]});
  for (int i = 0; i < SLAM_DIRECTIONS; i++) {
    filter->direction_rad[i] += off[DIRECTION + i];
  }
}

/** G = P[:, pose] prior; state += G off; P -= G (P[pose, pose] - posterior) G'. */
__attribute__((noinline)) void slam_filter_correct(slam_filter_t *filter, float prior[3][3],
                                                   const float off[3], float posterior[3][3],
                                                   vec2_t pivot_m) {
  float gain[SLAM_STATES][3];
  float told[3][3];
  float states[SLAM_STATES];
  for (int s = 0; s < SLAM_STATES; s++) {
    states[s] = 0.0f;
    for (int a = 0; a < 3; a++) {
      gain[s][a] = cov(filter, s, X) * prior[0][a] + cov(filter, s, Y) * prior[1][a] +
                   cov(filter, s, YAW) * prior[2][a];
      states[s] += gain[s][a] * off[a];
    }
  }
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) {
      told[a][b] = cov(filter, a, b) - posterior[a][b];
    }
  }
  for (int s = 0; s < SLAM_STATES; s++) {
    float row[3];
    for (int b = 0; b < 3; b++) {
      row[b] = gain[s][0] * told[0][b] + gain[s][1] * told[1][b] + gain[s][2] * told[2][b];
    }
    for (int t = 0; t <= s; t++) {
      filter->covariance[pair(s, t)] -=
          row[0] * gain[t][0] + row[1] * gain[t][1] + row[2] * gain[t][2];
    }
  }
  shift(filter, states, pivot_m);
}

/** Covariance of every state with a direction measured by the present yaw and drift.
 *  @return variance of that direction, without the error of the measured line itself */
static float project(const slam_filter_t *filter, const slam_bearing_t *bearing,
                     float seen[SLAM_STATES]) {
  sincos_t across = geometry_sincos(bearing->angle_rad - filter->pose.yaw_rad);
  float slope = geometry_clamp(bearing->s_per_m, -SLOPE_MAX_S_PER_M, SLOPE_MAX_S_PER_M);
  float by_drift_x = slope * across.sin;
  float by_drift_y = -slope * across.cos;
  for (int s = 0; s < SLAM_STATES; s++) {
    seen[s] = cov(filter, s, YAW) + by_drift_x * cov(filter, s, DRIFT_X) +
              by_drift_y * cov(filter, s, DRIFT_Y);
  }
  return seen[YAW] + by_drift_x * seen[DRIFT_X] + by_drift_y * seen[DRIFT_Y];
}

float slam_filter_off_rad(const slam_filter_t *filter, const slam_bearing_t *bearing, int direction,
                          float *sd_rad) {
  float seen[SLAM_STATES];
  float variance = project(filter, bearing, seen) - 2.0f * seen[DIRECTION + direction] +
                   cov(filter, DIRECTION + direction, DIRECTION + direction);
  *sd_rad = sqrtf(geometry_clamp(variance, 0.0f, 10.0f) + square(bearing->sd_rad));
  float off_rad = filter->direction_rad[direction] - bearing->angle_rad;
  return off_rad - QUARTER_RAD * floorf(off_rad / QUARTER_RAD + 0.5f);
}

void slam_filter_learn(slam_filter_t *filter, const slam_bearing_t *bearing, int direction) {
  float seen[SLAM_STATES];
  int own = DIRECTION + direction;
  float variance = project(filter, bearing, seen) + square(bearing->sd_rad);
  for (int s = 0; s < SLAM_STATES; s++) {
    filter->covariance[pair(own, s)] = s == own ? variance : seen[s];
  }
  filter->direction_rad[direction] = bearing->angle_rad;
}

__attribute__((noinline)) void slam_filter_turn(slam_filter_t *filter,
                                                const slam_bearing_t *bearing, int direction) {
  float sd_rad;
  float off_rad = slam_filter_off_rad(filter, bearing, direction, &sd_rad);
  float weight = ROBUST2 / (ROBUST2 + square(off_rad / sd_rad));
  float seen[SLAM_STATES];
  float sum = project(filter, bearing, seen);
  for (int s = 0; s < SLAM_STATES; s++) {
    seen[s] -= cov(filter, s, DIRECTION + direction);
    sum += seen[s];
  }
  if (!geometry_is_finite(sum)) {
    return;
  }
  float own = square(bearing->sd_rad);
  float variance = square(sd_rad) - own + own / square(weight); // an outlier measures less
  float states[SLAM_STATES];
  for (int s = 0; s < SLAM_STATES; s++) {
    states[s] = seen[s] / variance;
    for (int t = 0; t <= s; t++) {
      filter->covariance[pair(s, t)] -= states[s] * seen[t];
    }
    states[s] *= off_rad;
  }
  shift(filter, states, pose2_position(filter->pose));
}

float slam_filter_sd_m(const slam_filter_t *filter) {
  return sqrtf(cov(filter, X, X) + cov(filter, Y, Y));
}
