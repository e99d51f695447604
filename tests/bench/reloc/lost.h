// SPDX-License-Identifier: GPL-3.0-or-later
/** @file lost.h  A lost drone's flight: scan -> reloc, in a map that stays as it is. */
#ifndef LOST_H
#define LOST_H

#include "grid.h"
#include "reloc.h"
#include "scan.h"

typedef struct {
  scan_t scan;
  reloc_t reloc;
} lost_t;

/** What reloc said in one tick. */
typedef struct {
  pose2_t pose;
  float score;
  uint32_t known;
  uint32_t sure;
} lost_said_t;

/** ticks poses of the odometry (x, y, yaw), as many published sets of SCAN_RANGES ranges; budget is
 * of a tick. */
void lost_fly(lost_t *lost, const grid_t *grid, const scan_config_t *scan, const float *poses,
              const float *ranges_m, int ticks, uint32_t tick_ms, int budget, lost_said_t *said);

#endif
