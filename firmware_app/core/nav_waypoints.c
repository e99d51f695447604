// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* The waypoint list: receiving it, and choosing the next waypoint. */
#include <string.h>

#include "nav.h"
#include "nav_parts.h"

mission_reason_t nav_take_waypoints(nav_t *nav, const wire_waypoints_t *given) {
  nav_waypoints_t *held = &nav->waypoints;
  if (given->count > WIRE_WAYPOINTS_A_PACKET || given->total > NAV_WAYPOINTS ||
      given->first + given->count > given->total) {
    return MISSION_BAD_VALUE;
  }
  if (given->list != held->list || given->total != held->total) {
    *held = (nav_waypoints_t){.list = given->list, .total = given->total};
  }
  memcpy(held->points_mm[given->first], given->points_mm, given->count * sizeof *given->points_mm);
  held->got |= (uint16_t)(((1u << given->count) - 1u) << given->first);
  return MISSION_OK;
}

static vec2_t waypoint_m(const nav_t *nav, int at) {
  const nav_waypoints_t *held = &nav->waypoints;
  return (vec2_t){0.001f * (float)held->points_mm[at][0], 0.001f * (float)held->points_mm[at][1]};
}

/** Have all waypoints of the list arrived? */
static bool complete(const nav_waypoints_t *held) {
  return held->total > 0 && held->got == (1u << held->total) - 1u;
}

mission_reason_t nav_start_waypoints(nav_t *nav, mission_task_t task) {
  nav_waypoints_t *held = &nav->waypoints;
  mission_reason_t reason = complete(held) ? MISSION_OK : MISSION_NO_WAYPOINTS;
  for (int i = 0; i < held->total && reason == MISSION_OK; i++) {
    reason = nav_check_place(nav, waypoint_m(nav, i));
  }
  if (reason == MISSION_OK) {
    held->next = held->skipped = 0;
    nav->goal_m = waypoint_m(nav, 0);
    nav_set_task(nav, task);
  }
  return reason;
}

/** Make the following waypoint the goal; a patrol starts over. @return false if there is none */
static bool advance(nav_t *nav) {
  nav_waypoints_t *held = &nav->waypoints;
  bool last = held->next + 1 >= held->total;
  if (!complete(held) || (last && nav->mission.task != MISSION_TASK_PATROL)) {
    return false;
  }
  held->next = last ? 0u : (uint8_t)(held->next + 1u);
  nav->goal_m = waypoint_m(nav, held->next);
  return true;
}

static bool on_a_list(const nav_t *nav) {
  return nav->mission.task == MISSION_TASK_FLY || nav->mission.task == MISSION_TASK_PATROL;
}

bool nav_pass_waypoint(nav_t *nav) {
  if (!on_a_list(nav)) {
    return false;
  }
  nav_emit(nav, WIRE_EVENT_WAYPOINT, nav->waypoints.next, pose2_position(nav->pose));
  nav->waypoints.skipped = 0;
  if (!advance(nav)) {
    return false;
  }
  nav_set_task(nav, nav->mission.task);
  return true;
}

bool nav_skip_waypoint(nav_t *nav, mission_reason_t reason) {
  nav_waypoints_t *held = &nav->waypoints;
  if (nav->mission.task != MISSION_TASK_PATROL || held->skipped + 1 >= held->total) {
    return false;
  }
  nav_emit(nav, WIRE_EVENT_SKIPPED, (uint8_t)reason, waypoint_m(nav, held->next));
  held->skipped++;
  nav->plan.looks_left = NAV_LOOKS;
  nav->plan.stalls = 0;
  return advance(nav);
}
