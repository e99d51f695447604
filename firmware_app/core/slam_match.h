// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam_match.h  Point-to-line match of beam ends against the grid: the measurement half of
 * slam.h. */
#ifndef SLAM_MATCH_H
#define SLAM_MATCH_H

#include "slam.h"

/** Sum over the mini-scan's beam ends at one pose: normal equations of a Gauss-Newton step. */
typedef struct {
  float hessian[3][3]; ///< information about x, y, yaw
  float gradient[3];   ///< step = (hessian + prior)^-1 (gradient + prior's pull)
  int ends;            ///< beam ends looked at
  int matched;         ///< of these, with a wall nearby
  int inliers;         ///< of these, within the robust bound
} slam_match_t;

/** Match the mini-scan as seen with the body at `pose` (map frame) when its last set was measured.
 *  Frames' poses are odometry; they are chained to `pose` by the odometry between them. */
void slam_match(const slam_t *slam, const grid_t *grid, pose2_t pose, slam_match_t *match);

#endif
