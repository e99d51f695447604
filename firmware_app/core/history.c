// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "history.h"

#include <math.h>

static const float STEP_M = 0.15f;   ///< distance flown between two pose records
static const float WORTH_M = 0.005f; ///< smallest correction in a tick worth a record: below it is
                                     ///< SLAM's own scaling of odometry
static const float WORTH_RAD = 0.0045f; ///< the same for yaw
static const float UNIT_PER_M = 1.0e3f;
static const float UNIT_PER_RAD = 1.0e4f;
static const float UNIT_MAX = 32767.0f;

/** A value in integer units, `per` of them to one, rounded and saturated. */
static int16_t units(float value, float per) {
  return (int16_t)floorf(geometry_clamp(value * per, -UNIT_MAX, UNIT_MAX) + 0.5f);
}

static void record(history_t *history, const nav_t *nav, wire_record_kind_t kind, pose2_t pose) {
  history->records[history->next % HISTORY_RECORDS] = (wire_record_t){
      .time_ms = nav->input.odometry.time_ms,
      .x_mm = units(pose.x_m, UNIT_PER_M),
      .y_mm = units(pose.y_m, UNIT_PER_M),
      .yaw_1e4_rad = units(pose.yaw_rad, UNIT_PER_RAD),
      .kind = (uint8_t)kind,
  };
  history->next++;
  if (history->kept < HISTORY_RECORDS) {
    history->kept++;
  }
}

/** Record a correction if the map pose differs from `felt`, where odometry alone would have brought
 * it since the previous tick. */
static void tell_correction(history_t *history, const nav_t *nav, pose2_t felt) {
  bool found = history->lost && !nav->mission.lost;
  vec2_t off_m = vec2_sub(pose2_position(nav->pose), pose2_position(felt));
  float off_rad = geometry_wrap_rad(nav->pose.yaw_rad - felt.yaw_rad);
  if (found || vec2_norm(off_m) > WORTH_M || fabsf(off_rad) > WORTH_RAD) {
    record(history, nav, found ? WIRE_RECORD_FOUND : WIRE_RECORD_MATCHED,
           pose2_compose(nav->pose, pose2_inverse(felt)));
  }
}

void history_step(history_t *history, const nav_t *nav) {
  pose2_t odometry = nav->input.odometry.pose;
  pose2_t step = pose2_compose(pose2_inverse(history->odometry), odometry);
  if (nav->mission.lost && !history->lost) {
    record(history, nav, WIRE_RECORD_LOST, nav->pose);
  } else if (mission_airborne(nav->mission.state)) { // on the ground odometry may be reset
    tell_correction(history, nav, pose2_compose(history->pose, step));
  }
  history->odometry = odometry;
  history->pose = nav->pose;
  history->lost = nav->mission.lost;
  vec2_t here_m = pose2_position(nav->pose);
  if (mission_airborne(nav->mission.state) && vec2_distance(here_m, history->recorded_m) > STEP_M) {
    history->recorded_m = here_m;
    record(history, nav, WIRE_RECORD_POSE, nav->pose);
  }
}

bool history_get(const history_t *history, uint16_t sequence, wire_history_t *found) {
  uint16_t ago = (uint16_t)(history->next - sequence);
  if (ago == 0 || ago > 0x7FFFu) {
    return false;
  }
  if (ago > history->kept) {
    ago = history->kept;
  }
  found->first = (uint16_t)(history->next - ago);
  found->count = (uint8_t)(ago < WIRE_RECORDS_A_PACKET ? ago : WIRE_RECORDS_A_PACKET);
  for (int i = 0; i < found->count; i++) {
    found->records[i] = history->records[(uint16_t)(found->first + i) % HISTORY_RECORDS];
  }
  return found->count > 0;
}
