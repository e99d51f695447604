// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "lost.h"

static const float HEIGHT_M = 0.5f;

static lost_said_t say(const reloc_t *reloc, pose2_t odometry) {
  lost_said_t said = {.sure = reloc->sure};
  said.known = reloc_to_map(reloc, odometry, &said.pose);
  said.score = said.known ? reloc->place_list[0].score : 0.0f;
  return said;
}

void lost_fly(lost_t *lost, const grid_t *grid, const scan_config_t *scan, const float *poses,
              const float *ranges_m, int ticks, uint32_t tick_ms, int budget, lost_said_t *said) {
  reloc_t *reloc = &lost->reloc;
  scan_init(&lost->scan, scan);
  reloc_init(reloc);
  for (int i = 0; i < ticks; i++) {
    const float *pose = &poses[3 * i];
    scan_odometry_t odometry = {
        .time_ms = (uint32_t)i * tick_ms,
        .pose = {pose[0], pose[1], geometry_wrap_rad(pose[2])},
        .height_m = HEIGHT_M,
    };
    scan_frame_t frame;
    if (scan_step(&lost->scan, &odometry, &ranges_m[SCAN_RANGES * i], &frame)) {
      reloc_add(reloc, &frame);
    }
    reloc_work(reloc, grid, budget);
    said[i] = say(reloc, odometry.pose);
  }
}
