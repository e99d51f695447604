// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "slam.h"

#include <math.h>
#include <string.h>

#include "slam_match.h"

enum {
  ITERATIONS = 3,  ///< Gauss-Newton steps of a match
  MATCHED_MIN = 3, ///< matched beam ends without which a match is not used
  REJECTED_MAX = 2 ///< mini-scans in a row that may contradict the map before they are drawn
};

enum {
  PAIRS = 2, ///< pairs of beams in a set; one slice draws one pair
  FRONT_AND_BACK = 1 << SCAN_FRONT | 1 << SCAN_BACK,
  LEFT_AND_RIGHT = 1 << SCAN_LEFT | 1 << SCAN_RIGHT,
};

static const float DEG = 0.0174532925f;
static const float EXPLORING = 0.2f;      ///< share of matched ends below which ground is new
static const float FITTING = 0.44f;       ///< share of the matched ends that must be inliers
static const float YAW_CAP_RAD = 0.070f;  ///< standard deviation of a mini-scan's yaw, at least
static const float FOUND_SD_M = 0.05f;    ///< standard deviation of a relocalised position
static const float FOUND_SD_RAD = 0.035f; ///< standard deviation of a relocalised yaw
static const float LOST_M = 0.2f;         ///< standard deviation at which confidence is 50 %
static const float MAP_SD_M = 0.05f;      ///< standard deviation of a wall where the map began
static const float MAP_SD_RAD = 0.04f;    ///< growth of that per metre from where the map began

/** Tuned on simulated flights, seeds 100 to 171 and 5000 to 5107 of `wayflie bench slam`. */
slam_config_t slam_config_default(void) {
  return (slam_config_t){
      .move_m = 0.022f,
      .turn_rad = 1.5f * DEG,
      .window_ms = 2000u,
      .kernel_m = 0.15f,
      .range_sd_m = 0.039f,
      .range_sd_per_m = 0.0063f,
      .robust = 6.0f,
      .information = 0.3f,
      .noise =
          {
              .flow_sd_per_m = 0.010f,
              .flow_sd_mps = 0.019f,
              .yaw_sd_rps = 0.03f * DEG,
              .bias_sd_rps = 0.20f * DEG,
              .scale_sd = 0.050f,
              .drift_sd_mps = 0.012f,
          },
  };
}

void slam_init(slam_t *slam, const slam_config_t *cfg, bool enabled, pose2_t pose_odom,
               pose2_t map_pose) {
  memset(slam, 0, sizeof *slam);
  slam->cfg = *cfg;
  slam->enabled = enabled;
  slam_filter_init(&slam->filter, &cfg->noise, map_pose);
  slam_walls_init(&slam->walls);
  slam_tie(slam, pose_odom, map_pose);
}

void slam_tie(slam_t *slam, pose2_t pose_odom, pose2_t map_pose) {
  slam->filter.pose = map_pose;
  slam->odometry = pose_odom;
  slam->count = slam->closed = slam->taken = 0;
  slam->stage = SLAM_GATHERING;
  slam->window_start_ms = 0;
  slam->has_waiting = false;
  slam_walls_break(&slam->walls);
}

void slam_find(slam_t *slam, pose2_t pose_odom, pose2_t map_pose) {
  slam_tie(slam, pose_odom, map_pose);
  slam_filter_place(&slam->filter, FOUND_SD_M, FOUND_SD_RAD);
}

pose2_t slam_pose(const slam_t *slam) {
  return slam->filter.pose;
}

float slam_sd_m(const slam_t *slam) {
  float filter_m = slam_filter_sd_m(&slam->filter);
  vec2_t far_m = pose2_position(slam->filter.pose);
  float turned_m2 = MAP_SD_RAD * MAP_SD_RAD * vec2_dot(far_m, far_m);
  return sqrtf(0.5f * filter_m * filter_m + MAP_SD_M * MAP_SD_M + turned_m2);
}

pose2_t slam_to_map(const slam_t *slam, pose2_t pose_odom) {
  return pose2_compose(slam->filter.pose, pose2_compose(pose2_inverse(slam->odometry), pose_odom));
}

void slam_predict(slam_t *slam, pose2_t pose_odom, float elapsed_s) {
  pose2_t step = pose2_compose(pose2_inverse(slam->odometry), pose_odom);
  step = slam_filter_move(&slam->filter, step, elapsed_s);
  slam->walls.dead = pose2_compose(slam->walls.dead, step);
  slam->odometry = pose_odom;
}

static void multiply3(float m[3][3], const float v[3], float result[3]) {
  for (int a = 0; a < 3; a++) {
    result[a] = m[a][0] * v[0] + m[a][1] * v[1] + m[a][2] * v[2];
  }
}

static const scan_frame_t *newest(const slam_t *slam) {
  return &slam->frames[slam->closed - 1];
}

/** The mini-scan is complete: match it from here on, one pass per slice. */
static void close_window(slam_t *slam) {
  slam->closed = slam->count < SLAM_WINDOW ? slam->count : SLAM_WINDOW;
  slam->taken = 0;
  slam->stage = slam->enabled ? SLAM_MATCHING : SLAM_DRAWING;
  slam->predicted = slam_to_map(slam, newest(slam)->pose);
  memset(slam->correction, 0, sizeof slam->correction);
  slam->pass = 0;
}

/** Grow the filter's covariance to the end of the mini-scan and take the prior from it.
 *  @return false if the filter had broken down; it was reset then */
static bool begin_match(slam_t *slam) {
  uint32_t elapsed_ms = newest(slam)->time_ms - slam->window_start_ms;
  vec2_t moved_m = vec2_sub(pose2_position(slam->predicted), pose2_position(slam->window_start));
  float turned_rad = geometry_wrap_rad(slam->predicted.yaw_rad - slam->window_start.yaw_rad);
  slam->window_start_ms = newest(slam)->time_ms;
  slam_filter_grow(&slam->filter, &slam->cfg.noise, moved_m, turned_rad,
                   (float)elapsed_ms * 0.001f);
  if (slam_filter_information(&slam->filter, slam->prior)) {
    return true;
  }
  slam_filter_forget(&slam->filter, &slam->cfg.noise);
  slam_walls_init(&slam->walls);
  return false;
}

/** Give the mini-scan a yaw error that all its beams share: H becomes (H^-1 + D)^-1, where D is
 *  YAW_CAP_RAD^2 at the yaw and zero elsewhere (Sherman-Morrison). */
static void cap_yaw(slam_match_t *match) {
  const float *row = match->hessian[2];
  const float column[3] = {row[0], row[1], row[2]};
  float scale = 1.0f / (1.0f / (YAW_CAP_RAD * YAW_CAP_RAD) + column[2]);
  float pull = scale * match->gradient[2];
  for (int a = 0; a < 3; a++) {
    match->gradient[a] -= column[a] * pull;
    for (int b = 0; b < 3; b++) {
      match->hessian[a][b] -= column[a] * column[b] * scale;
    }
  }
}

/** One Gauss-Newton step; the last pass evaluates the result without another step.
 *  @return false if the equations are singular */
__attribute__((noinline)) static bool match_pass(slam_t *slam, const grid_t *grid,
                                                 float posterior[3][3], slam_match_t *match) {
  pose2_t pose = {slam->predicted.x_m + slam->correction[0],
                  slam->predicted.y_m + slam->correction[1],
                  slam->predicted.yaw_rad + slam->correction[2]};
  slam_match(slam, grid, pose, match);
  cap_yaw(match);
  float pull[3];
  float total[3][3];
  multiply3(slam->prior, slam->correction, pull);
  for (int a = 0; a < 3; a++) {
    pull[a] = match->gradient[a] - pull[a];
    for (int b = 0; b < 3; b++) {
      total[a][b] = match->hessian[a][b] + slam->prior[a][b];
    }
  }
  if (!slam_filter_invert(total, posterior)) {
    return false;
  }
  float step[3];
  multiply3(posterior, pull, step);
  for (int a = 0; a < 3 && slam->pass < ITERATIONS; a++) {
    slam->correction[a] += step[a];
  }
  return true;
}

/** Confidence [%]: 100 without uncertainty, 50 at LOST_M; halved for each mini-scan in a row that
 *  contradicted the map; 0 if the filter has broken down. */
static uint8_t confidence(const slam_t *slam) {
  float off = slam_sd_m(slam) / LOST_M;
  float percent = 100.0f / (1.0f + off * off);
  return percent >= 0.0f ? (uint8_t)((uint32_t)percent >> slam->rejected) : 0;
}

/** Accept or reject the match. Rejected sets are drawn on new ground, and where they contradict the
 *  map for longer than REJECTED_MAX mini-scans. */
static void end_match(slam_t *slam, bool solved, const slam_match_t *match, float posterior[3][3]) {
  bool enough = match->matched >= MATCHED_MIN;
  bool fits = solved && enough && (float)match->inliers >= FITTING * (float)match->matched;
  bool known_ground = enough && (float)match->matched >= EXPLORING * (float)match->ends;
  slam->stage = SLAM_DRAWING;
  if (fits) {
    pose2_t before = slam_to_map(slam, newest(slam)->pose);
    slam_filter_correct(&slam->filter, slam->prior, slam->correction, posterior,
                        pose2_position(before));
    slam->rejected = 0;
  } else if (known_ground && slam->rejected < REJECTED_MAX) {
    slam->rejected++;
    slam->taken = (uint8_t)(PAIRS * slam->closed);
  }
  if (slam->has_waiting) {
    slam_walls_tell(&slam->walls, &slam->filter, slam->waiting);
    slam->has_waiting = false;
  }
  slam->confidence = solved ? confidence(slam) : 0;
}

/** The mini-scan was drawn: the sets that came meanwhile begin the next one. */
static void reopen(slam_t *slam) {
  slam->window_start = slam_to_map(slam, newest(slam)->pose);
  slam->count = (uint8_t)(slam->count - slam->closed);
  memmove(slam->frames, &slam->frames[slam->closed], slam->count * sizeof slam->frames[0]);
  slam->closed = slam->taken = 0;
  slam->stage = SLAM_GATHERING;
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

/** Extend the line that each beam draws along a wall, and tell the filter about complete ones. */
static void look_for_walls(slam_t *slam, const scan_frame_t *frame) {
  pose2_t since = pose2_compose(pose2_inverse(slam->odometry), frame->pose);
  pose2_t dead_then = pose2_compose(slam->walls.dead, since);
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    slam_bearing_t bearing;
    if (!slam_walls_add(&slam->walls, frame, dead_then, beam, &bearing)) {
      continue;
    }
    if (slam->stage == SLAM_MATCHING) {
      slam->waiting = bearing;
      slam->has_waiting = true;
    } else {
      slam_walls_tell(&slam->walls, &slam->filter, bearing);
    }
  }
}

void slam_update(slam_t *slam, const scan_frame_t *frame) {
  if (slam->enabled) {
    look_for_walls(slam, frame);
  }
  if (slam->count < SLAM_FRAMES && (!slam->enabled || moved_enough(slam, frame))) {
    if (slam->window_start_ms == 0) {
      slam->window_start = slam_to_map(slam, frame->pose);
      slam->window_start_ms = frame->time_ms;
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
