// SPDX-License-Identifier: GPL-3.0-or-later
/* Angles, vectors and poses of any bits. */
#include "any.h"

int main(void) {
  (void)geometry_sincos(any_float);
  (void)geometry_atan2(any_float, any_float);
  (void)geometry_wrap_rad(any_float);
  (void)geometry_clamp(any_float, any_float, any_float);
  (void)vec2_limit(any_vec2(), any_float);
  (void)pose2_compose(any_pose2(), any_pose2());
  (void)pose2_inverse(any_pose2());
  (void)pose2_apply(any_pose2(), any_vec2());
  (void)pose2_interpolate(any_pose2(), any_pose2(), any_float);
  return 0;
}
