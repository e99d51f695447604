// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "slam.h"

void slam_init(slam_t *slam, pose2_t pose_odom, pose2_t map_pose) {
  slam->map_from_odom = pose2_compose(map_pose, pose2_inverse(pose_odom));
  slam->confidence = 0;
}

void slam_update(slam_t *slam, const grid_t *grid, const scan_frame_t *frame) {
  (void)slam;
  (void)grid;
  (void)frame;
}

pose2_t slam_to_map(const slam_t *slam, pose2_t pose_odom) {
  return pose2_compose(slam->map_from_odom, pose_odom);
}
