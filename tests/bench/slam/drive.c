// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "drive.h"

#include <string.h>

static const float HEIGHT_M = 0.5f;

void drive_start(drive_t *drive, const scan_config_t *scan, const slam_config_t *slam,
                 const grid_config_t *grid, vec2_t centre_m, float cell_m) {
  memset(drive, 0, sizeof *drive);
  scan_init(&drive->scan, scan);
  slam_init(&drive->slam, slam, true, (pose2_t){0}, (pose2_t){0});
  grid_init(&drive->grid, grid, centre_m, cell_m);
}

scan_odometry_t drive_odometry(const float *pose, uint32_t time_ms) {
  return (scan_odometry_t){
      .time_ms = time_ms,
      .pose = {pose[0], pose[1], geometry_wrap_rad(pose[2])},
      .height_m = HEIGHT_M,
  };
}

static void map_slice(drive_t *drive) {
  scan_frame_t frame;
  pose2_t map_pose;
  if (!slam_work(&drive->slam, &drive->grid) && slam_take(&drive->slam, &frame, &map_pose)) {
    grid_insert(&drive->grid, &frame, map_pose);
  }
}

void drive_fly(drive_t *drive, const float *poses, const float *ranges_m, int ticks,
               uint32_t tick_ms, drive_said_t *said) {
  for (int i = 0; i < ticks; i++) {
    scan_odometry_t odometry = drive_odometry(&poses[3 * i], (uint32_t)i * tick_ms);
    slam_predict(&drive->slam, odometry.pose, i > 0 ? (float)tick_ms * 0.001f : 0.0f);
    scan_frame_t frame;
    if (scan_step(&drive->scan, &odometry, &ranges_m[SCAN_RANGES * i], &frame)) {
      slam_update(&drive->slam, &frame);
    } else {
      map_slice(drive);
    }
    grid_fade(&drive->grid, odometry.time_ms);
    said[i] =
        (drive_said_t){drive->slam.filter.pose, drive->slam.filter.bias_rps,
                       drive->slam.filter.scale, slam_sd_m(&drive->slam), drive->slam.confidence};
  }
}
