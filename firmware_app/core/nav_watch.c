// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Policies that end or change a flight: supervisor, battery, link and sensors. */
#include <string.h>

#include "nav.h"
#include "nav_parts.h"
#include "ray.h"

static const uint32_t BATTERY_HOLD_MS = 2000u;    ///< a shorter dip is load, not charge
static const float BATTERY_EMPTY_BELOW_V = 0.15f; ///< below low_battery_v: land at once
static const uint32_t SAGGED_MS = 5000u; ///< from take-off until the load on the battery is steady
static const float FAST_S = 3.0f;        ///< time constant of the fast voltage filter
static const float SLOW_S = 30.0f;       ///< time constant of the slow voltage filter
static const float LEAST_FALL_VPS = 0.001f; ///< least discharge assumed: half that of hovering
static const float DETOUR = 1.6f;         ///< longest way home assumed, over the straight distance
static const float DETOUR_M = 2.0f;       ///< added to that longest way
static const float SHARE_OF_SPEED = 0.6f; ///< mean speed, corners included, over cruise speed
static const float LOOKING_S = 5.0f;      ///< time to turn, look and plan on the way home
static const uint32_t RANGES_FROZEN_MS = 1000u; ///< no new set for this long: the deck has failed
static const uint32_t SILENT_MS = 3000u;        ///< no return of any sensor for this long: blind
static const uint32_t BAD_ESTIMATE_MS = 1000u;  ///< tolerated; longer than to cross a dark tile

enum {
  LOOK_SETS = 12,  ///< sets without return where it flies to: stop and look with another beam
  DEAD_SETS = 99,  ///< sets without return in one beam, while others have some: dead
  MISSED_SETS = 9, ///< the last ones of DEAD_SETS; they count only where the map has an obstacle
};

static const float ANSWERS_M = 2.5f;  ///< range within which a wall has a return
static const float FLYING_MPS = 0.1f; ///< speed along a beam that counts as flying there

/** Learn the discharge rate. A filter lags behind a falling voltage by its time constant times the
 *  slope, so the difference of a fast and a slow filter tells the slope. Steady load shifts both
 *  alike. */
static void learn_discharge(nav_t *nav) {
  nav_endurance_t *known = &nav->endurance;
  float voltage_v = nav->input.battery_v;
  if (nav_now_ms(nav) - known->grounded_ms < SAGGED_MS) {
    known->fast_v = known->slow_v = voltage_v;
  }
  known->fast_v += (voltage_v - known->fast_v) * nav->tick_s / FAST_S;
  known->slow_v += (voltage_v - known->slow_v) * nav->tick_s / SLOW_S;
  known->flown_m += vec2_norm(nav->input.velocity_mps) * nav->tick_s;
}

/** Voltage needed now to fly home and land with low_battery_v left, which is the reserve for the
 *  knee of the discharge curve. The way home is taken for as long as what was flown, but no longer
 *  than the detour allowed. */
static float needed_v(const nav_t *nav) {
  const nav_endurance_t *known = &nav->endurance;
  float learned_vps = (known->slow_v - known->fast_v) / (SLOW_S - FAST_S);
  float fall_vps = learned_vps > LEAST_FALL_VPS ? learned_vps : LEAST_FALL_VPS;
  float straight_m = vec2_distance(pose2_position(nav->pose), pose2_position(nav->home));
  float way_m = geometry_clamp(known->flown_m, straight_m, DETOUR * straight_m + DETOUR_M);
  float home_s = way_m / (SHARE_OF_SPEED * nav->cfg.follower.speed_mps) + LOOKING_S +
                 nav->cfg.height_m / nav->cfg.descend_mps;
  return nav->cfg.low_battery_v + fall_vps * home_s;
}

static void watch_battery(nav_t *nav) {
  learn_discharge(nav);
  if (nav->input.battery_v >= (nav->battery_low ? nav->cfg.low_battery_v : needed_v(nav))) {
    nav->battery_good_ms = nav_now_ms(nav);
  }
  bool low = nav_now_ms(nav) - nav->battery_good_ms > BATTERY_HOLD_MS;
  if (!low || nav->mission.state == MISSION_LAND) {
    return;
  }
  if (nav->input.battery_v < nav->cfg.low_battery_v - BATTERY_EMPTY_BELOW_V) {
    nav_fault(nav, MISSION_BATTERY_EMPTY);
    nav_apply(nav, MISSION_EV_LAND);
  } else if (!nav->battery_low) {
    nav->battery_low = true;
    nav_fault(nav, MISSION_BATTERY_LOW);
    nav_set_task(nav, MISSION_TASK_HOME);
  }
}

static void watch_link(nav_t *nav) {
  if ((nav->input.flags & NAV_LINK_ALIVE) != 0) {
    nav->link_seen_ms = nav_now_ms(nav);
    nav->link_lost = false;
    return;
  }
  if (nav->link_lost && nav->cfg.lost == NAV_LOST_HOME && nav->mission.state == MISSION_HOVER) {
    nav_apply(nav, MISSION_EV_LAND); // it hovers because there is no way home
  }
  bool late = (float)(nav_now_ms(nav) - nav->link_seen_ms) > nav->cfg.lost_time_s * 1000.0f;
  if (!late || nav->link_lost || nav->cfg.lost == NAV_LOST_GO_ON ||
      nav->mission.state == MISSION_LAND) {
    return;
  }
  nav->link_lost = true;
  nav_fault(nav, MISSION_LINK_LOST);
  if (nav->cfg.lost == NAV_LOST_HOLD) {
    nav_apply(nav, MISSION_EV_HOLD);
  } else if (nav->cfg.lost == NAV_LOST_LAND) {
    nav_apply(nav, MISSION_EV_LAND);
  } else if (nav->mission.task != MISSION_TASK_HOME) {
    nav_set_task(nav, MISSION_TASK_HOME);
  }
}

/** Does the map have an obstacle within ANSWERS_M along a beam? While lost: assumed. */
static bool should_answer(const nav_t *nav, pose2_t pose, int beam) {
  vec2_t reach_m = vec2_rotate((vec2_t){ANSWERS_M, 0.0f}, scan_bearing_rad(beam));
  ray_t ray = ray_start(grid_to_cells(&nav->grid, pose2_position(pose)),
                        grid_to_cells(&nav->grid, pose2_apply(pose, reach_m)));
  bool met = nav->mission.lost;
  do {
    met = met || grid_value(&nav->grid, ray.ix, ray.iy) >= GRID_OCCUPIED_MIN;
  } while (!met && ray_next(&ray));
  return met;
}

void nav_check_beams(nav_t *nav, const scan_frame_t *frame, pose2_t map_pose) {
  mission_state_t state = nav->mission.state;
  bool follows = state == MISSION_FOLLOW || state == MISSION_RETURN;
  if ((!follows && state != MISSION_SCAN) || frame->hit == 0) {
    return;
  }
  vec2_t body_mps = vec2_rotate(nav->input.velocity_mps, -nav->input.odometry.pose.yaw_rad);
  const float towards_mps[SCAN_BEAMS] = {body_mps.x, -body_mps.x, body_mps.y, -body_mps.y};
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    uint8_t *silent = &nav->silent[beam];
    if ((frame->clear >> beam & 1u) == 0) {
      *silent = 0;
    } else if (*silent < DEAD_SETS - MISSED_SETS || should_answer(nav, map_pose, beam)) {
      *silent = (uint8_t)(*silent + (*silent < DEAD_SETS));
    }
    if (*silent % LOOK_SETS == LOOK_SETS - 1 && towards_mps[beam] > FLYING_MPS && follows) {
      nav_apply(nav, MISSION_EV_LOOK);
    }
  }
}

bool nav_half_blind(const nav_t *nav) {
  bool on_ground = !mission_airborne(nav->mission.state); // where each sensor sees the floor
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    bool stuck = scan_unchanged(&nav->scan, beam) && (on_ground || nav->scan.last_m[beam] >= 0.0f);
    bool restless = nav->guard.restless[beam] >= GUARD_RESTLESS;
    if (stuck || restless || nav->silent[beam] >= DEAD_SETS) {
      return true;
    }
  }
  return scan_silent_ms(&nav->scan, nav_now_ms(nav)) > SILENT_MS;
}

/** Sensor failure for which the drone must land where it is; MISSION_OK if there is none. */
static mission_reason_t failed_sense(nav_t *nav) {
  uint32_t now_ms = nav_now_ms(nav);
  bool settled = (nav->input.flags & NAV_ESTIMATOR_SETTLED) != 0;
  bool flow =
      (nav->input.flags & NAV_FLOW_LOST) == 0 || nav->input.positioning != NAV_POSITIONING_NONE;
  if (settled && flow) {
    nav->estimate_good_ms = now_ms;
  }
  if (scan_age_ms(&nav->scan, now_ms) > RANGES_FROZEN_MS) {
    return MISSION_RANGES_FROZEN;
  }
  if (now_ms - nav->estimate_good_ms > BAD_ESTIMATE_MS) {
    return flow ? MISSION_ESTIMATOR : MISSION_FLOW_LOST;
  }
  return nav_half_blind(nav) ? MISSION_BLIND : MISSION_OK;
}

static void watch_senses(nav_t *nav) {
  mission_reason_t reason = failed_sense(nav);
  if (reason != MISSION_OK && nav->mission.state != MISSION_LAND) {
    nav_fault(nav, reason);
    nav_apply(nav, MISSION_EV_LAND);
  }
}

void nav_watch(nav_t *nav) {
  if (!mission_airborne(nav->mission.state)) {
    nav->battery_good_ms = nav->link_seen_ms = nav->estimate_good_ms = nav_now_ms(nav);
    nav->endurance.grounded_ms = nav_now_ms(nav);
    nav->endurance.flown_m = 0.0f;
    memset(nav->silent, 0, sizeof nav->silent);
    nav_watch_lifting(nav);
    return;
  }
  nav->reloc_motion.down_ms = nav_now_ms(nav);
  bool tumbled = (nav->input.flags & NAV_TUMBLED) != 0;
  if (tumbled || (nav->input.flags & NAV_CAN_FLY) == 0) {
    nav_fault(nav, tumbled ? MISSION_TUMBLED : MISSION_CANNOT_FLY);
    nav_lose(nav);
    nav_apply(nav, MISSION_EV_FAILED);
    return;
  }
  watch_battery(nav);
  watch_link(nav);
  watch_senses(nav);
}
