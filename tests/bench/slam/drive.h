// SPDX-License-Identifier: GPL-3.0-or-later
/** @file drive.h  scan -> slam -> grid over a whole flight, in the order of nav_step(). */
#ifndef DRIVE_H
#define DRIVE_H

#include "grid.h"
#include "scan.h"
#include "slam.h"

typedef struct {
  scan_t scan;
  slam_t slam;
  grid_t grid;
} drive_t;

/** What slam said in one tick. */
typedef struct {
  pose2_t pose;
  float bias_rps;
  float scale;
  float sd_m;
  uint8_t confidence;
} drive_said_t;

/** The map begins at the first pose. */
void drive_start(drive_t *drive, const scan_config_t *scan, const slam_config_t *slam,
                 const grid_config_t *grid, vec2_t centre_m, float cell_m);
/** What the odometry says of a level body with this pose (x, y, yaw). */
scan_odometry_t drive_odometry(const float *pose, uint32_t time_ms);
/** ticks poses of the odometry (x, y, yaw), as many published sets of SCAN_RANGES ranges. */
void drive_fly(drive_t *drive, const float *poses, const float *ranges_m, int ticks,
               uint32_t tick_ms, drive_said_t *said);

#endif
