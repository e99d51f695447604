// SPDX-License-Identifier: GPL-3.0-or-later
/* The scan stage, fed with odometry and ranges of any bits for any time. */
#include "any.h"
#include "scan.h"

static scan_t scan;

int main(void) {
  scan_config_t cfg = scan_config_default();
  scan_init(&scan, &cfg);
  while (any_int) {
    float range_m[SCAN_RANGES];
    scan_frame_t frame;
    for (int i = 0; i < SCAN_RANGES; i++) {
      range_m[i] = any_float;
    }
    scan_odometry_t odometry = {any_u32, any_pose2(), any_float, any_float, any_float};
    scan_step(&scan, &odometry, range_m, &frame);
    (void)scan_age_ms(&scan, any_u32);
  }
  (void)scan_bearing_rad(any_int);
  return 0;
}
