// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam_filter.h  The extended Kalman filter of slam.h.
 *
 *  States: x, y, yaw, gyro bias, scale of the flow, slow drift of the flow's velocity, wall
 *  directions. The drift is a first-order Gauss-Markov process along the body's axes; without it
 *  the filter takes a velocity error of 1 cm/s for a turned map. Its variance is learned in flight
 *  (expectation maximisation, Shumway and Stoffer 1982), so that good odometry is left alone. Wall
 *  directions are landmarks (Smith, Self, Cheeseman 1990): as they are correlated with the yaw at
 *  which they were first seen, a wall that is seen again tells the gyro bias.
 */
#ifndef SLAM_FILTER_H
#define SLAM_FILTER_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"

enum {
  SLAM_DIRECTIONS = 2,               ///< wall directions kept, each modulo a right angle
  SLAM_STATES = 7 + SLAM_DIRECTIONS, ///< pose 3, bias, scale, drift 2, directions
  SLAM_PAIRS = SLAM_STATES * (SLAM_STATES + 1) / 2, ///< elements of the covariance
};

/** Standard deviations of the process noise and of the initial states. */
typedef struct {
  float flow_sd_per_m; ///< random error of odometry, per metre flown
  float flow_sd_mps;   ///< random error of odometry, per square root of a second
  float yaw_sd_rps;    ///< random error of the yaw, per square root of a second
  float bias_sd_rps;   ///< initial gyro bias
  float scale_sd;      ///< initial error of the flow's scale
  float drift_sd_mps;  ///< slow drift, before its variance has been learned
} slam_noise_t;

typedef struct {
  pose2_t pose;                         ///< present pose, map frame
  float bias_rps;                       ///< gyro bias
  float scale;                          ///< odometry reads too long by this share
  vec2_t drift_mps;                     ///< slow velocity error of odometry, body frame
  float drift_m2ps2;                    ///< variance of the drift, as learned
  float direction_rad[SLAM_DIRECTIONS]; ///< of walls, map frame
  float covariance[SLAM_PAIRS];         ///< lower triangle, row by row
} slam_filter_t;

/** Measured direction of a wall. */
typedef struct {
  float angle_rad; ///< map frame, by the present yaw
  float sd_rad;
  float s_per_m; ///< duration over signed length along the wall: how drift tilts the line
} slam_bearing_t;

void slam_filter_init(slam_filter_t *filter, const slam_noise_t *noise, pose2_t map_pose);
/** Reset the covariance and the drift's variance to their initial values; the state stays. */
void slam_filter_forget(slam_filter_t *filter, const slam_noise_t *noise);
/** Set the covariance of a pose that was found by other means; the rest of the covariance stays. */
void slam_filter_place(slam_filter_t *filter, float sd_m, float sd_rad);
/** Predict the state by a tick's odometry, body frame. @return the motion as corrected */
pose2_t slam_filter_move(slam_filter_t *filter, pose2_t step, float elapsed_s);
/** Predict the covariance over a motion that slam_filter_move() has made, map frame. */
void slam_filter_grow(slam_filter_t *filter, const slam_noise_t *noise, vec2_t moved_m,
                      float turned_rad, float elapsed_s);
/** Inverse covariance of the pose. @return false if it is singular */
bool slam_filter_information(const slam_filter_t *filter, float inverse[3][3]);
/** Apply a matched pose to all states. The pose at pivot_m, a moment ago, was off by `off` (x, y,
 *  yaw); posterior is its covariance after the match, prior the inverse before it, as
 *  slam_filter_information() gave it. */
void slam_filter_correct(slam_filter_t *filter, float prior[3][3], const float off[3],
                         float posterior[3][3], vec2_t pivot_m);
/** Known minus measured direction, modulo a right angle, and its standard deviation. */
float slam_filter_off_rad(const slam_filter_t *filter, const slam_bearing_t *bearing, int direction,
                          float *sd_rad);
/** Make a measured direction the state `direction`. */
void slam_filter_learn(slam_filter_t *filter, const slam_bearing_t *bearing, int direction);
/** Correct all states by measuring a known direction again. */
void slam_filter_turn(slam_filter_t *filter, const slam_bearing_t *bearing, int direction);
/** Standard deviation of the position, both axes together: sqrt(var x + var y). NaN if the filter
 *  has broken down. */
float slam_filter_sd_m(const slam_filter_t *filter);

/** @return false if the matrix cannot be inverted */
bool slam_filter_invert(float m[3][3], float inverse[3][3]);

#endif
