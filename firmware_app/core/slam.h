// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam.h  SLAM: the drone's pose in the map, from odometry and a few beams.
 *
 *  Stage 2, before the grid. Odometry drives the prediction of a Kalman filter (slam_filter.h).
 *  Measured sets are gathered over a short motion into a mini-scan, whose beam ends are matched
 *  point to line against the grid (slam_match.h), by Gauss-Newton with the prediction as prior
 *  (iterated EKF, Bell and Cathey 1993). Wall directions correct the yaw (slam_walls.h). Only then
 *  are the sets handed on to be drawn, so that a scan never matches itself.
 *  Not implemented: loop closure that deforms the map. What was drawn wrong stays.
 */
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
  SLAM_WINDOW = 8,  ///< sets in a full mini-scan
  SLAM_FRAMES = 13, ///< sets held: also those that arrive while a mini-scan is matched and drawn
};

/** What the slices are at work on. Slicing does not change the result. */
typedef enum { SLAM_GATHERING, SLAM_MATCHING, SLAM_DRAWING } slam_stage_t;

typedef struct {
  float move_m;       ///< a set joins the mini-scan if the body moved this far since the last one
  float turn_rad;     ///< a set joins the mini-scan if the body turned this much since the last one
  uint32_t window_ms; ///< age at which a mini-scan is closed
  float kernel_m;     ///< radius at which a cell near a beam's end has a quarter of its weight
  float range_sd_m;   ///< standard deviation of a beam's end against a wall, at range 0
  float range_sd_per_m; ///< growth of that with range
  float robust;         ///< Geman-McClure bound, in standard deviations
  float information;    ///< share of a match's information that is used: beams share their errors
  slam_noise_t noise;   ///< of the filter's prediction
} slam_config_t;

typedef struct {
  slam_config_t cfg;
  bool enabled;         ///< false: odometry is passed through, all sets are drawn
  pose2_t odometry;     ///< present pose, odometry frame
  slam_filter_t filter; ///< holds the present pose, map frame
  slam_walls_t walls;
  slam_bearing_t waiting; ///< wall direction kept back while a match uses the filter
  bool has_waiting;
  scan_frame_t frames[SLAM_FRAMES]; ///< oldest first
  uint8_t count;                    ///< frames held
  uint8_t closed;                   ///< of these, in the mini-scan that is matched or drawn
  uint8_t taken;                    ///< pairs of beams already drawn, two in each frame
  uint8_t rejected;                 ///< mini-scans in a row that contradicted the map
  slam_stage_t stage;
  uint8_t pass;         ///< of the match, from 0
  uint8_t confidence;   ///< 0..100 [%]
  pose2_t predicted;    ///< map pose of the newest closed frame, before the match
  float prior[3][3];    ///< inverse covariance of `predicted`
  float correction[3];  ///< of `predicted` so far: x, y [m], yaw [rad]
  pose2_t window_start; ///< map pose at the end of the previous mini-scan
  uint32_t window_start_ms;
} slam_t;

slam_config_t slam_config_default(void);

/** Start with nothing estimated; pose_odom in the odometry frame is map_pose in the map. */
void slam_init(slam_t *slam, const slam_config_t *cfg, bool enabled, pose2_t pose_odom,
               pose2_t map_pose);
/** Tie the frames anew after a jump of odometry: bias, scale and covariance stay, sets are dropped.
 */
void slam_tie(slam_t *slam, pose2_t pose_odom, pose2_t map_pose);
/** Tie the frames anew after relocalisation, which knows the pose to a few centimetres. */
void slam_find(slam_t *slam, pose2_t pose_odom, pose2_t map_pose);
/** Predict with the odometry of this tick. */
void slam_predict(slam_t *slam, pose2_t pose_odom, float elapsed_s);
/** Take a measured set. A set that finds no room is neither matched nor drawn. */
void slam_update(slam_t *slam, const scan_frame_t *frame);
/** Run one slice of matching. @return true if there was something to match */
bool slam_work(slam_t *slam, const grid_t *grid);
/** Hand on the next pair of beams to draw (front and back, then left and right of each set) and the
 *  pose to draw them from. @return false if none is ready */
bool slam_take(slam_t *slam, scan_frame_t *frame, pose2_t *map_pose);
/** Present pose, map frame. */
pose2_t slam_pose(const slam_t *slam);
/** Standard deviation of the position along each axis, the map's own error included. The filter
 *  knows the pose relative to the walls nearby. Direction and scale of the frame were uncertain
 *  when these were drawn, so their error grows with the distance from where the map began. NaN if
 *  the filter has broken down. */
float slam_sd_m(const slam_t *slam);
/** Convert a recent pose from the odometry frame to the map frame. */
pose2_t slam_to_map(const slam_t *slam, pose2_t pose_odom);

#endif
