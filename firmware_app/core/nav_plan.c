// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Planning in slices. A plan for the goal of the last one goes on from its way. */
#include "nav.h"
#include "nav_parts.h"

enum {
  UNITS_PER_TICK = 16,   ///< of the planner's budget
  BESIDE_CELLS = 6,      ///< so near to the place beside an occupied goal, it has been looked at
  START_FREE_CELLS = 10, ///< how far the way out of an inflated zone may be
};

static vec2_t goal_of_task(const nav_t *nav) {
  return nav->mission.task == MISSION_TASK_HOME ? pose2_position(nav->home) : nav->goal_m;
}

/** What closes the way may be noise: cells that only one hit speaks for are unknown again, and
 * looked at before the drone flies there. */
static void doubt(nav_t *nav) {
  grid_doubt(&nav->grid, GRID_OCCUPIED_MIN - 1 + nav->cfg.grid.hit);
  clearance_mark(&nav->clearance, &nav->grid);
}

/** There is no way now. In the air it may be noise: look around and try again, a few times. */
static void fail(nav_t *nav, mission_reason_t reason, vec2_t place_m) {
  nav->plan.stage = NAV_PLAN_DONE;
  if (mission_airborne(nav->mission.state) && nav->plan.looks_left > 0) {
    nav->plan.looks_left--;
    doubt(nav);
    nav_apply(nav, MISSION_EV_LOOK);
    return;
  }
  nav->mission.fault = reason;
  nav_emit(nav, WIRE_EVENT_REFUSED, (uint8_t)reason, place_m);
  nav_apply(nav, MISSION_EV_NO_ROUTE);
}

/** The goal is occupied. Home is wherever beside it is free; another goal may be occupied by noise
 *  seen from afar, and is looked at from beside it before it is given up. @return false if it is */
static bool aim_beside(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  vec2_t beside = plan->goal_cells;
  bool is_free = clearance_nearest_free(&nav->clearance, beside, START_FREE_CELLS, &beside);
  bool far = vec2_distance(plan->start_cells, beside) > (float)BESIDE_CELLS;
  bool home = nav->mission.task == MISSION_TASK_HOME;
  if (!is_free || !(home || (far && plan->looks_left > 0))) {
    fail(nav, MISSION_GOAL_OCCUPIED, grid_to_metres(&nav->grid, beside));
    return false;
  }
  plan->goal_cells = beside;
  plan->approach = !home;
  return true;
}

static bool exploring(const nav_t *nav) {
  return nav->mission.task == MISSION_TASK_EXPLORE;
}

/** Set the planner to work from plan.start_cells. */
static void start_search(nav_t *nav, vec2_t last_goal_cells) {
  nav_plan_t *plan = &nav->plan;
  pathfinder_t *planner = &nav->planner;
  pathfinder_config_t cfg = nav->cfg.search;
  cfg.grid_only = nav->cfg.planner == NAV_PLANNER_GRID;
  bool same = vec2_distance(last_goal_cells, plan->goal_cells) == 0.0f;
  if (exploring(nav)) {
    pathfinder_start_frontier(planner, &cfg, &nav->clearance, plan->start_cells);
  } else if (same && !cfg.grid_only && planner->grown) {
    pathfinder_repair(planner, &nav->clearance, plan->start_cells);
  } else {
    pathfinder_start(planner, &cfg, &nav->clearance, plan->start_cells, plan->goal_cells,
                     nav->cfg.seed + nav->route.revision);
  }
  plan->stage = NAV_PLAN_SEARCH;
}

/** Begin to plan for the present task, from the present pose. */
static void begin(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  if (nav->mission.lost) { // on the ground: it takes off to find out where it is
    plan->stage = NAV_PLAN_DONE;
    nav_apply(nav, MISSION_EV_WAY_EXISTS);
    return;
  }
  if (clearance_refresh(&nav->clearance, &nav->grid, 0) > 0) {
    return; // a few ticks more until the layer has followed the map
  }
  vec2_t last_goal_cells = plan->goal_cells;
  plan->start_cells = grid_to_cells(&nav->grid, pose2_position(nav->pose));
  plan->goal_cells = grid_to_cells(&nav->grid, goal_of_task(nav));
  if (clearance_blocked_at(&nav->clearance, plan->start_cells) &&
      !clearance_nearest_free(&nav->clearance, plan->start_cells, START_FREE_CELLS,
                              &plan->start_cells)) {
    fail(nav, MISSION_STUCK, pose2_position(nav->pose));
    return;
  }
  plan->approach = false;
  if (!exploring(nav) && clearance_blocked_at(&nav->clearance, plan->goal_cells) &&
      !aim_beside(nav)) {
    return;
  }
  start_search(nav, last_goal_cells);
}

/** The pathfinder's ends lie on its lattice; the route's is the goal itself. */
static void end_at_goal(nav_t *nav, int count) {
  vec2_t *path = nav->route.points_m;
  if (!exploring(nav) &&
      clearance_segment_free(&nav->clearance, path[count - 2], nav->plan.goal_cells)) {
    path[count - 1] = nav->plan.goal_cells;
  }
}

static void finish(nav_t *nav) {
  int count = pathfinder_path(&nav->planner, nav->route.points_m, ROUTE_POINTS);
  end_at_goal(nav, count);
  nav->plan.stage = NAV_PLAN_DONE;
  nav->plan.looks_left = NAV_LOOKS;
  route_build(&nav->route, &nav->grid, &nav->clearance, count);
  if (!nav->plan.approach) {
    nav->goal_m = nav->route.points_m[nav->route.count - 1];
  }
  nav_apply(nav, MISSION_EV_ROUTE);
}

/** Nothing more can be reached: the goal is walled off, or everything is explored. */
static void no_way(nav_t *nav) {
  if (exploring(nav)) {
    nav->plan.stage = NAV_PLAN_DONE;
    nav_emit(nav, WIRE_EVENT_EXPLORED, 0, pose2_position(nav->pose));
    nav_set_task(nav, MISSION_TASK_HOME);
    return;
  }
  fail(nav, MISSION_GOAL_UNREACHABLE,
       grid_to_metres(&nav->grid, pathfinder_nearest(&nav->planner)));
}

/** A way is known. Before take-off that is all that was asked. */
static void found(nav_t *nav) {
  if (nav->mission.state == MISSION_IDLE) {
    nav->plan.stage = NAV_PLAN_DONE;
    nav_apply(nav, MISSION_EV_WAY_EXISTS);
  } else if (pathfinder_enough(&nav->planner)) {
    finish(nav);
  }
}

static void search(nav_t *nav) {
  pathfinder_status_t status =
      pathfinder_extend(&nav->planner, &nav->clearance, &nav->grid, UNITS_PER_TICK);
  nav->status.plan_nodes = (uint16_t)pathfinder_nodes(&nav->planner);
  switch (status) {
  case PATHFINDER_SEARCHING:
    break;
  case PATHFINDER_FOUND:
    found(nav);
    break;
  case PATHFINDER_NO_WAY:
    no_way(nav);
    break;
  case PATHFINDER_TOO_WINDING:
  case PATHFINDER_START_BLOCKED:
  case PATHFINDER_GOAL_BLOCKED:
    fail(nav, MISSION_GOAL_UNREACHABLE, pose2_position(nav->pose));
    break;
  }
}

void nav_plan_step(nav_t *nav) {
  bool checking = nav->mission.state == MISSION_IDLE && nav->mission.task != MISSION_TASK_NONE;
  if (nav->mission.state != MISSION_PLAN && !checking) {
    return;
  }
  switch (nav->plan.stage) {
  case NAV_PLAN_BEGIN:
    begin(nav);
    break;
  case NAV_PLAN_SEARCH:
    search(nav);
    break;
  case NAV_PLAN_DONE:
    break;
  }
}
