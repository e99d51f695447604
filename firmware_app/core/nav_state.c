// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Entering the mission's states, and reporting them. */
#include "nav.h"
#include "nav_parts.h"

void nav_fault(nav_t *nav, mission_reason_t reason) {
  nav->mission.fault = reason;
  nav_emit(nav, WIRE_EVENT_FAULT, (uint8_t)reason, pose2_position(nav->pose));
}

/** A goal that the map rules out when it is given is refused at once (no looks left); other tasks
 *  stop and look first. */
void nav_set_task(nav_t *nav, mission_task_t task) {
  nav->mission.task = task;
  nav->plan.looks_left = task == MISSION_TASK_GOTO ? 0 : NAV_LOOKS;
  nav_plan_afresh(nav);
  clearance_observed_only(&nav->clearance, task == MISSION_TASK_HOME);
  nav_apply(nav, MISSION_EV_TASK);
}

static void leave_ground(nav_t *nav) {
  nav->mapped = true;
  nav->home = nav->pose;
  nav->reloc_motion.home_too = nav->mission.lost;
  nav->height_sp_m = geometry_clamp(nav->input.odometry.height_m, 0.0f, nav->cfg.height_m);
  nav->link_lost = false;
  nav->battery_low = false;
  nav->mission.fault = MISSION_OK;
  nav->plan.looks_left = NAV_LOOKS;
  nav_plan_afresh(nav);
}

static void enter_state(nav_t *nav, mission_state_t before, mission_event_t event) {
  nav->state_since_ms = nav_now_ms(nav);
  mission_state_t state = nav->mission.state;
  bool keeps_post = (before == MISSION_HOVER && state == MISSION_AVOID) ||
                    (before == MISSION_AVOID && state == MISSION_HOVER);
  if (!keeps_post) {
    nav->post = nav->pose;
    nav->by_hand = false;
  }
  nav->rolling = event == MISSION_EV_BLOCKED;
  if (before == MISSION_RELOCALISE) {
    nav_reloc_stop(nav);
  }
  switch (nav->mission.state) {
  case MISSION_IDLE:
  case MISSION_PLAN:
    nav->plan.stage = NAV_PLAN_BEGIN;
    break;
  case MISSION_TAKEOFF:
    if (!mission_airborne(before)) {
      leave_ground(nav);
    }
    break;
  case MISSION_SCAN:
    nav->turned_rad = 0.0f;
    nav->plan.looked = true;
    break;
  case MISSION_FOLLOW:
  case MISSION_RETURN:
    follower_start(&nav->follower, nav->pose.yaw_rad);
    nav->best_progress_m = 0.0f;
    nav->glances = 0;
    nav_look_along(nav);
    break;
  case MISSION_RELOCALISE:
    nav_reloc_start(nav);
    break;
  case MISSION_SPIN:
  case MISSION_AVOID:
  case MISSION_HOVER:
  case MISSION_LAND:
  case MISSION_FAULT:
  case MISSION_STATES:
    break;
  }
}

void nav_apply(nav_t *nav, mission_event_t event) {
  mission_state_t before = nav->mission.state;
  if (!mission_step(&nav->mission, event)) {
    return;
  }
  if (nav->mission.state != before) {
    nav_emit(nav, WIRE_EVENT_STATE, (uint8_t)nav->mission.state, pose2_position(nav->pose));
  }
  enter_state(nav, before, event);
}

uint32_t nav_now_ms(const nav_t *nav) {
  return nav->input.odometry.time_ms;
}
