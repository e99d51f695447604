// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam.h  Where the drone stands in the map, from odometry and a few beams. Stage 2, before
 * the grid. Odometry predicts a Kalman filter (slam_filter.h). Measured sets are gathered over a
 * short motion into a mini-scan; its beam ends are matched point to line against the grid
 * (slam_match.h) by Gauss-Newton with the prediction as prior (iterated EKF, Bell and Cathey 1993).
 * Directions of walls turn it (slam_walls.h). Only afterwards are the sets handed on to be drawn: a
 * scan never matches itself. Not here: a map drawn wrong is not
 * bent when a loop closes. */
#ifndef SLAM_H
#define SLAM_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "scan.h"
#include "slam_filter.h"
#include "slam_walls.h"

enum {
  SLAM_WINDOW = 8,  ///< sets of a mini-scan
  SLAM_FRAMES = 13, ///< and room for those that come while it is matched and drawn
};

/** What is done with the mini-scan now; the slices do not change the result. */
typedef enum { SLAM_GATHERING, SLAM_MATCHING, SLAM_DRAWING } slam_stage_t;

typedef struct {
  float move_m;       ///< a set joins the mini-scan when the body moved this far since the last one
  float turn_rad;     ///< or turned this much
  uint32_t window_ms; ///< a mini-scan is closed at this age
  float kernel_m;     ///< reach of the local mean around a beam's end
  float range_sd_m;   ///< of a beam's end against a drawn wall, at no distance
  float range_sd_per_m; ///< and what each metre adds
  float robust;         ///< Geman-McClure bound, in standard deviations
  float information;    ///< share of the match's information that is believed: beams of a set share
                        ///< their errors
  slam_noise_t noise;
} slam_config_t;

typedef struct {
  slam_config_t cfg;
  bool enabled;     ///< else a pass-through: odometry as it is
  pose2_t odometry; ///< odometry frame, now
  slam_filter_t filter;
  slam_walls_t walls;
  slam_bearing_t waiting; ///< until the match is over: the filter must not change under it
  bool has_waiting;
  scan_frame_t frames[SLAM_FRAMES];
  uint8_t count;    ///< frames held
  uint8_t closed;   ///< of these, in the mini-scan that is matched or drawn
  uint8_t taken;    ///< pairs of beams of these drawn already, two a frame
  uint8_t rejected; ///< mini-scans in a row that did not fit
  slam_stage_t stage;
  uint8_t pass;         ///< of the match
  uint8_t confidence;   ///< 0..100 [%]
  pose2_t predicted;    ///< of the newest closed frame, map frame, when the window closed
  float prior[3][3];    ///< inverse covariance of the predicted pose
  float correction[3];  ///< of the predicted pose, so far
  pose2_t window_start; ///< map frame, where the mini-scan before ended
  uint32_t window_start_ms;
} slam_t;

slam_config_t slam_config_default(void);

/** Let the pose pose_odom be map_pose from now on, and forget what was estimated. */
void slam_init(slam_t *slam, const slam_config_t *cfg, bool enabled, pose2_t pose_odom,
               pose2_t map_pose);
/** Tied anew, bias and scale kept, waiting sets dropped: after a jump of the odometry. */
void slam_tie(slam_t *slam, pose2_t pose_odom, pose2_t map_pose);
/** Found again, after having been lost: tied anew, sure of the place to a few centimetres. */
void slam_find(slam_t *slam, pose2_t pose_odom, pose2_t map_pose);
/** Odometry of this tick. */
void slam_predict(slam_t *slam, pose2_t pose_odom, float elapsed_s);
/** Take a measured set. One that comes while there is no room is not drawn. */
void slam_update(slam_t *slam, const scan_frame_t *frame);
/** One slice of matching, if there is anything to match. @return true if it worked */
bool slam_work(slam_t *slam, const grid_t *grid);
/** The next pair of beams to draw (front and back, then left and right of a set) and the pose to
 * draw them at; false if there is none now. */
bool slam_take(slam_t *slam, scan_frame_t *frame, pose2_t *map_pose);
/** Map frame, now. */
pose2_t slam_pose(const slam_t *slam);
/** Standard deviation of the position along each axis, the map's own error included. The filter
 * knows the pose beside the walls nearby; those were drawn in a frame whose direction and scale
 * were not known yet, so that the error grows with the distance from where the map began. Not a
 * number if the filter has broken down. */
float slam_sd_m(const slam_t *slam);
/** A recent pose of the odometry frame in the map. */
pose2_t slam_to_map(const slam_t *slam, pose2_t pose_odom);

#endif
