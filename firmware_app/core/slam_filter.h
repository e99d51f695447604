// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam_filter.h  The extended Kalman filter of slam.h: x, y, yaw, gyro bias, flow scale,
 * slow drift of the flow's velocity, and the directions of walls. The drift is a first-order
 * Gauss-Markov process along the body's axes; without it the filter takes a wind of 1 cm/s for a
 * turned map. Its size is learned from the flight (expectation maximisation, Shumway and Stoffer
 * 1982), so that odometry that is good is left alone. The directions of walls are landmarks (Smith,
 * Self, Cheeseman 1990): what correlates them with the yaw at which they were first seen makes one
 * old wall tell the gyro's bias. */
#ifndef SLAM_FILTER_H
#define SLAM_FILTER_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"

enum {
  SLAM_DIRECTIONS = 2,               ///< of walls; turned by a right angle they count as the same
  SLAM_STATES = 7 + SLAM_DIRECTIONS, ///< pose 3, bias, scale, drift 2, directions
  SLAM_PAIRS = SLAM_STATES * (SLAM_STATES + 1) / 2,
};

typedef struct {
  float flow_sd_per_m; ///< random part of odometry, per metre flown
  float flow_sd_mps;   ///< and per square root of a second
  float yaw_sd_rps;    ///< per square root of a second
  float bias_sd_rps;   ///< of the gyro bias at the start
  float scale_sd;      ///< of the flow scale at the start
  float drift_sd_mps;  ///< of the slow drift, before anything is known of it
} slam_noise_t;

typedef struct {
  pose2_t pose; ///< map frame, now
  float bias_rps;
  float scale;                          ///< odometry reads this share too long
  vec2_t drift_mps;                     ///< and drifts so fast, body frame
  float drift_m2ps2;                    ///< how strong the drift is, as learned
  float direction_rad[SLAM_DIRECTIONS]; ///< map frame
  float covariance[SLAM_PAIRS];         ///< lower triangle, row by row
} slam_filter_t;

/** A wall's direction as measured, in the map as it is believed now. */
typedef struct {
  float angle_rad;
  float sd_rad;
  float s_per_m; ///< seconds over metres along the wall, signed: how drift tilts the measurement
} slam_bearing_t;

void slam_filter_init(slam_filter_t *filter, const slam_noise_t *noise, pose2_t map_pose);
/** Nothing is known of the errors any more but what noise says; the state stays. */
void slam_filter_forget(slam_filter_t *filter, const slam_noise_t *noise);
/** The pose comes from elsewhere, this sure; what else is known stays. */
void slam_filter_place(slam_filter_t *filter, float sd_m, float sd_rad);
/** Take a tick's motion by odometry, body frame. @return it as corrected */
pose2_t slam_filter_move(slam_filter_t *filter, pose2_t step, float elapsed_s);
/** Let uncertainty grow over a motion of so much in the map frame. */
void slam_filter_grow(slam_filter_t *filter, const slam_noise_t *noise, vec2_t moved_m,
                      float turned_rad, float elapsed_s);
/** Inverse covariance of the pose. @return false if it has none */
bool slam_filter_information(const slam_filter_t *filter, float inverse[3][3]);
/** The pose at pivot_m, a moment ago, is off by this much, and posterior is left of its covariance:
 * spread both over all states. prior is what slam_filter_information gave. */
void slam_filter_correct(slam_filter_t *filter, float prior[3][3], const float off[3],
                         float posterior[3][3], vec2_t pivot_m);
/** How far a measured direction is from the known one, and the standard deviation of that. */
float slam_filter_off_rad(const slam_filter_t *filter, const slam_bearing_t *bearing, int direction,
                          float *sd_rad);
/** Remember a new direction. */
void slam_filter_learn(slam_filter_t *filter, const slam_bearing_t *bearing, int direction);
/** Turn by a known direction. */
void slam_filter_turn(slam_filter_t *filter, const slam_bearing_t *bearing, int direction);
/** Standard deviation of the position; not a number if the filter has broken down. */
float slam_filter_sd_m(const slam_filter_t *filter);

/** @return false if the matrix cannot be inverted */
bool slam_filter_invert(float m[3][3], float inverse[3][3]);

#endif
