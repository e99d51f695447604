// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam_match.h  Point-to-line match of beam ends against the grid: slam.h's measurement. */
#ifndef SLAM_MATCH_H
#define SLAM_MATCH_H

#include "slam.h"

/** Normal equations of a Gauss-Newton step, summed over a mini-scan's beam ends. */
typedef struct {
  float hessian[3][3]; ///< information on x, y, yaw
  float gradient[3];   ///< step = (hessian + prior)^-1 (gradient - prior correction)
  int ends;            ///< number of beam ends
  int matched;         ///< of these, near a wall and usable
  int inliers;         ///< of these, within the robust bound
} slam_match_t;

/** Evaluate the match of the mini-scan if the body was at `pose` (map frame) at its newest set; the
 *  older sets follow by the odometry between them. */
void slam_match(const slam_t *slam, const grid_t *grid, pose2_t pose, slam_match_t *match);

#endif
