// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Policies: what ends or changes a flight from outside the mission. */
#include "nav.h"
#include "nav_parts.h"

static const uint32_t BATTERY_HOLD_MS = 2000u;    ///< a dip shorter than this is load, not charge
static const float BATTERY_EMPTY_BELOW_V = 0.15f; ///< under the low limit: land where it is
static const uint32_t RANGES_FROZEN_MS = 1000u;
static const uint32_t BAD_ESTIMATE_MS = 300u;

static void watch_battery(nav_t *nav) {
  if (nav->input.battery_v >= nav->cfg.low_battery_v) {
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

static void watch_senses(nav_t *nav) {
  bool blind = scan_age_ms(&nav->scan, nav_now_ms(nav)) > RANGES_FROZEN_MS;
  bool lost = nav_now_ms(nav) - nav->estimate_good_ms > BAD_ESTIMATE_MS;
  if ((blind || lost) && nav->mission.state != MISSION_LAND) {
    nav_fault(nav, blind ? MISSION_RANGES_FROZEN : MISSION_ESTIMATOR);
    nav_apply(nav, MISSION_EV_LAND);
  }
}

void nav_watch(nav_t *nav) {
  if (!mission_airborne(nav->mission.state)) {
    nav->battery_good_ms = nav->link_seen_ms = nav->estimate_good_ms = nav_now_ms(nav);
    nav_watch_lifting(nav);
    return;
  }
  nav->looking.down_ms = nav_now_ms(nav);
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
