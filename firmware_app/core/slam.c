// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "slam.h"

#include <math.h>
#include <string.h>

#include "slam_match.h"

enum { X, Y, YAW, BIAS, SCALE, ITERATIONS = 3, MATCHED_MIN = 8, REJECTED_MAX = 2 };

enum {
  PAIRS = 2, ///< of beams in a set: what is drawn in one go
  FRONT_AND_BACK = 1 << SCAN_FRONT | 1 << SCAN_BACK,
  LEFT_AND_RIGHT = 1 << SCAN_LEFT | 1 << SCAN_RIGHT,
};

static const float DEG = 0.0174532925f;
static const float BIAS_WALK_RPS = 5.2e-5f; ///< 0.003 deg/s per square root of a second
static const float SCALE_WALK = 0.002f;
static const float EXPLORING = 0.2f; ///< fewer matched ends than this share: new ground
static const float FITTING = 0.5f;   ///< share of the matched ends that must agree

slam_config_t slam_config_default(void) {
  return (slam_config_t){
      .move_m = 0.03f,
      .turn_rad = 2.0f * DEG,
      .window_ms = 1500u,
      .kernel_m = 0.15f,
      .range_sd_m = 0.04f,
      .range_sd_per_m = 0.015f,
      .robust = 4.0f,
      .information = 0.25f,
      .flow_sd_per_m = 0.01f,
      .flow_sd_mps = 0.012f,
      .yaw_sd_rps = 0.03f * DEG,
      .bias_sd_rps = 0.1f * DEG,
      .scale_sd = 0.06f,
  };
}

static void reset_covariance(slam_t *slam) {
  memset(slam->covariance, 0, sizeof slam->covariance);
  slam->covariance[X][X] = slam->covariance[Y][Y] = 1.0e-4f;
  slam->covariance[YAW][YAW] = 0.25f * DEG * DEG;
  slam->covariance[BIAS][BIAS] = slam->cfg.bias_sd_rps * slam->cfg.bias_sd_rps;
  slam->covariance[SCALE][SCALE] = slam->cfg.scale_sd * slam->cfg.scale_sd;
}

void slam_init(slam_t *slam, const slam_config_t *cfg, bool enabled, pose2_t pose_odom,
               pose2_t map_pose) {
  memset(slam, 0, sizeof *slam);
  slam->cfg = *cfg;
  slam->enabled = enabled;
  slam_tie(slam, pose_odom, map_pose);
  reset_covariance(slam);
}

void slam_tie(slam_t *slam, pose2_t pose_odom, pose2_t map_pose) {
  slam->pose = map_pose;
  slam->odometry = pose_odom;
  slam->count = slam->closed = slam->taken = 0;
  slam->stage = SLAM_GATHERING;
}

pose2_t slam_to_map(const slam_t *slam, pose2_t pose_odom) {
  return pose2_compose(slam->pose, pose2_compose(pose2_inverse(slam->odometry), pose_odom));
}

void slam_predict(slam_t *slam, pose2_t pose_odom, float elapsed_s) {
  pose2_t step = pose2_compose(pose2_inverse(slam->odometry), pose_odom);
  step.x_m *= 1.0f - slam->scale;
  step.y_m *= 1.0f - slam->scale;
  step.yaw_rad -= slam->bias_rps * elapsed_s;
  slam->pose = pose2_compose(slam->pose, step);
  slam->odometry = pose_odom;
}

/** covariance = F covariance F' + Q over the motion of one mini-scan; F is the identity plus a few
 * terms. */
__attribute__((noinline)) static void predict_covariance(slam_t *slam, vec2_t moved_m,
                                                         float elapsed_s) {
  const float row_x[SLAM_STATES] = {1.0f, 0.0f, -moved_m.y, 0.5f * moved_m.y * elapsed_s,
                                    -moved_m.x};
  const float row_y[SLAM_STATES] = {0.0f, 1.0f, moved_m.x, -0.5f * moved_m.x * elapsed_s,
                                    -moved_m.y};
  const float row_yaw[SLAM_STATES] = {0.0f, 0.0f, 1.0f, -elapsed_s, 0.0f};
  const float *rows[3] = {row_x, row_y, row_yaw};
  for (int pass = 0; pass < 2; pass++) {
    for (int column = 0; column < SLAM_STATES; column++) {
      float result[3];
      for (int a = 0; a < 3; a++) {
        result[a] = 0.0f;
        for (int k = 0; k < SLAM_STATES; k++) {
          float c = pass == 0 ? slam->covariance[k][column] : slam->covariance[column][k];
          result[a] += rows[a][k] * c;
        }
      }
      for (int a = 0; a < 3; a++) {
        *(pass == 0 ? &slam->covariance[a][column] : &slam->covariance[column][a]) = result[a];
      }
    }
  }
  float along_m = slam->cfg.flow_sd_per_m * vec2_norm(moved_m);
  float flow_m2 = slam->cfg.flow_sd_mps * slam->cfg.flow_sd_mps * elapsed_s + along_m * along_m;
  slam->covariance[X][X] += flow_m2;
  slam->covariance[Y][Y] += flow_m2;
  slam->covariance[YAW][YAW] += slam->cfg.yaw_sd_rps * slam->cfg.yaw_sd_rps * elapsed_s;
  slam->covariance[BIAS][BIAS] += BIAS_WALK_RPS * BIAS_WALK_RPS * elapsed_s;
  slam->covariance[SCALE][SCALE] += SCALE_WALK * SCALE_WALK * elapsed_s;
}

/** @return false if the matrix cannot be inverted */
static bool invert3(const float *const m[3], float inverse[3][3]) {
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
  if (!(fabsf(determinant) > 1.0e-30f)) {
    return false;
  }
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) {
      inverse[a][b] /= determinant;
    }
  }
  return true;
}

static void multiply3(float m[3][3], const float v[3], float result[3]) {
  for (int a = 0; a < 3; a++) {
    result[a] = m[a][0] * v[0] + m[a][1] * v[1] + m[a][2] * v[2];
  }
}

/** Where the last closed set was measured, by the present estimate. */
static pose2_t newest_pose(const slam_t *slam) {
  return slam_to_map(slam, slam->frames[slam->closed - 1].pose);
}

/** The mini-scan is complete: from here on it is matched, a pass at a time. */
static void close_window(slam_t *slam) {
  slam->closed = slam->count < SLAM_WINDOW ? slam->count : SLAM_WINDOW;
  slam->taken = 0;
  slam->stage = slam->enabled ? SLAM_MATCHING : SLAM_DRAWING;
  slam->predicted = newest_pose(slam);
  memset(slam->correction, 0, sizeof slam->correction);
  slam->pass = 0;
}

/** Prediction of the covariance to the closed window's end. @return false if it cannot be inverted
 */
static bool begin_match(slam_t *slam) {
  uint32_t elapsed_ms = slam->frames[slam->closed - 1].time_ms - slam->frames[0].time_ms;
  vec2_t moved_m = vec2_sub(pose2_position(slam->predicted), pose2_position(slam->window_start));
  predict_covariance(slam, moved_m, (float)elapsed_ms * 0.001f);
  const float *pose_covariance[3] = {slam->covariance[X], slam->covariance[Y],
                                     slam->covariance[YAW]};
  return invert3(pose_covariance, slam->prior);
}

/** One Gauss-Newton step from the prediction; the last pass only judges. @return false if singular
 */
__attribute__((noinline)) static bool match_pass(slam_t *slam, const grid_t *grid,
                                                 float posterior[3][3], slam_match_t *match) {
  pose2_t pose = {slam->predicted.x_m + slam->correction[X],
                  slam->predicted.y_m + slam->correction[Y],
                  slam->predicted.yaw_rad + slam->correction[YAW]};
  slam_match(slam, grid, pose, match);
  float pull[3];
  float total[3][3];
  multiply3(slam->prior, slam->correction, pull);
  for (int a = 0; a < 3; a++) {
    pull[a] = slam->cfg.information * match->gradient[a] - pull[a];
    for (int b = 0; b < 3; b++) {
      total[a][b] = slam->cfg.information * match->hessian[a][b] + slam->prior[a][b];
    }
  }
  const float *rows[3] = {total[0], total[1], total[2]};
  if (!invert3(rows, posterior)) {
    return false;
  }
  float step[3];
  multiply3(posterior, pull, step);
  for (int a = 0; a < 3 && slam->pass < ITERATIONS; a++) {
    slam->correction[a] += step[a];
  }
  return true;
}

/** Spread the correction of the pose over all states, and shrink the covariance by what the fit
 * told: gain = covariance[:, pose] prior; covariance -= gain (prior^-1 - posterior) gain'. */
__attribute__((noinline)) static void correct(slam_t *slam, float posterior[3][3]) {
  float(*prior)[3] = slam->prior;
  const float *correction = slam->correction;
  float gain[SLAM_STATES][3];
  float told[3][3];
  for (int s = 0; s < SLAM_STATES; s++) {
    for (int a = 0; a < 3; a++) {
      gain[s][a] = slam->covariance[s][0] * prior[0][a] + slam->covariance[s][1] * prior[1][a] +
                   slam->covariance[s][2] * prior[2][a];
    }
  }
  for (int a = 0; a < 3; a++) {
    for (int b = 0; b < 3; b++) {
      told[a][b] = slam->covariance[a][b] - posterior[a][b];
    }
  }
  for (int s = 0; s < SLAM_STATES; s++) {
    float row[3];
    for (int b = 0; b < 3; b++) {
      row[b] = gain[s][0] * told[0][b] + gain[s][1] * told[1][b] + gain[s][2] * told[2][b];
    }
    for (int t = 0; t < SLAM_STATES; t++) {
      slam->covariance[s][t] -= row[0] * gain[t][0] + row[1] * gain[t][1] + row[2] * gain[t][2];
    }
  }
  slam->bias_rps +=
      gain[BIAS][0] * correction[0] + gain[BIAS][1] * correction[1] + gain[BIAS][2] * correction[2];
  slam->scale += gain[SCALE][0] * correction[0] + gain[SCALE][1] * correction[1] +
                 gain[SCALE][2] * correction[2];
  slam->scale = geometry_clamp(slam->scale, -0.3f, 0.3f);
  slam->bias_rps = geometry_clamp(slam->bias_rps, -2.0f * DEG, 2.0f * DEG);
  pose2_t before = newest_pose(slam);
  pose2_t after = {before.x_m + correction[X], before.y_m + correction[Y],
                   geometry_wrap_rad(before.yaw_rad + correction[YAW])};
  slam->pose = pose2_compose(after, pose2_compose(pose2_inverse(before), slam->pose));
}

/** Believe the match or not, and let the sets be drawn unless they contradict the map. */
static void end_match(slam_t *slam, bool solved, const slam_match_t *match, float posterior[3][3]) {
  bool enough = match->matched >= MATCHED_MIN;
  bool fits = solved && enough && (float)match->inliers >= FITTING * (float)match->matched;
  bool known_ground = enough && (float)match->matched >= EXPLORING * (float)match->ends;
  slam->stage = SLAM_DRAWING;
  if (fits) {
    correct(slam, posterior);
    slam->rejected = 0;
  } else if (known_ground && ++slam->rejected <= REJECTED_MAX) {
    slam->taken = (uint8_t)(PAIRS * slam->closed);
  }
  float sd_m = sqrtf(geometry_clamp(slam->covariance[X][X] + slam->covariance[Y][Y], 0.0f, 100.0f));
  slam->confidence = (uint8_t)(100.0f / (1.0f + 10.0f * sd_m));
}

/** The closed sets are drawn: those that came meanwhile begin the next mini-scan. */
static void reopen(slam_t *slam) {
  slam->count = (uint8_t)(slam->count - slam->closed);
  memmove(slam->frames, &slam->frames[slam->closed], slam->count * sizeof slam->frames[0]);
  slam->closed = slam->taken = 0;
  slam->stage = SLAM_GATHERING;
  slam->window_start = slam_to_map(slam, slam->frames[0].pose);
}

bool slam_work(slam_t *slam, const grid_t *grid) {
  if (slam->stage == SLAM_DRAWING && slam->taken == PAIRS * slam->closed) {
    reopen(slam);
  }
  if (slam->stage != SLAM_MATCHING) {
    return false;
  }
  slam_match_t match = {0};
  float posterior[3][3];
  bool solved = slam->pass > 0 || begin_match(slam);
  solved = solved && match_pass(slam, grid, posterior, &match);
  slam->pass++;
  if (!solved || slam->pass > ITERATIONS) {
    end_match(slam, solved, &match, posterior);
  }
  return true;
}

static bool moved_enough(const slam_t *slam, const scan_frame_t *frame) {
  if (slam->count == 0) {
    return true;
  }
  pose2_t step = pose2_compose(pose2_inverse(slam->frames[slam->count - 1].pose), frame->pose);
  return vec2_norm(pose2_position(step)) > slam->cfg.move_m ||
         fabsf(step.yaw_rad) > slam->cfg.turn_rad;
}

void slam_update(slam_t *slam, const scan_frame_t *frame) {
  if (slam->count < SLAM_FRAMES && (!slam->enabled || moved_enough(slam, frame))) {
    if (slam->count == 0) {
      slam->window_start = slam_to_map(slam, frame->pose);
    }
    slam->frames[slam->count++] = *frame;
  }
  if (slam->stage != SLAM_GATHERING || slam->count == 0) {
    return;
  }
  bool old = frame->time_ms - slam->frames[0].time_ms > slam->cfg.window_ms;
  if (!slam->enabled || slam->count >= SLAM_WINDOW || old) {
    close_window(slam);
  }
}

bool slam_take(slam_t *slam, scan_frame_t *frame, pose2_t *map_pose) {
  if (slam->stage != SLAM_DRAWING || slam->taken >= PAIRS * slam->closed) {
    return false;
  }
  uint8_t beams = slam->taken % PAIRS == 0 ? FRONT_AND_BACK : LEFT_AND_RIGHT;
  *frame = slam->frames[slam->taken / PAIRS];
  frame->hit &= beams;
  frame->clear &= beams;
  slam->taken++;
  *map_pose = slam_to_map(slam, frame->pose);
  return true;
}
