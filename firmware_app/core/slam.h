// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam.h  Pose correction: where the odometry frame stands in the map. Stage 2, before the
 * grid. Here a pass-through: the map frame is the odometry frame at take-off. */
#ifndef SLAM_H
#define SLAM_H

#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "scan.h"

typedef struct {
  pose2_t map_from_odom; ///< the odometry frame's origin, seen in the map
  uint8_t confidence;    ///< 0..100 [%]
} slam_t;

/** Let the pose pose_odom be map_pose from now on. */
void slam_init(slam_t *slam, pose2_t pose_odom, pose2_t map_pose);
/** Correct by one measured set, against the grid as it was before. */
void slam_update(slam_t *slam, const grid_t *grid, const scan_frame_t *frame);
pose2_t slam_to_map(const slam_t *slam, pose2_t pose_odom);

#endif
