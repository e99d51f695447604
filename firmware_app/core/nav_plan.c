// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Planning in slices. A plan for the goal of the last one goes on from its way. */
#include "nav.h"
#include "nav_parts.h"
#include "rng.h"

enum {
  UNITS_PER_TICK = 30,   ///< of the planner's budget
  DOUBTS_A_HIT = 2,      ///< before cells of one hit more are doubted
  DOUBTS_MAX = 4,        ///< in a task
  BESIDE_CELLS = 6,      ///< so near to the place beside an occupied goal, it has been looked at
  START_FREE_CELLS = 10, ///< how far the way out of an inflated zone may be
  NEWS_CELLS = 20,       ///< fewer cells that are newly known are no progress
  VAIN_LOOKS = 2,        ///< looks around that show nothing, on the way to a frontier
  GIVE_UP_AFTER = 40,    ///< so many frontiers in vain end an exploration
  DRAWS = 30,            ///< of a random point, until one is free
  ROUNDS = 1,            ///< doubts before an exploration is over
};

static const float SERVED_M = 0.2f; ///< so near to an occupied goal is there
static const float AT_FRONTIER_M = 0.5f;

static const float NARROWEST_M = 0.09f; ///< propeller tips are 0.07 m out

float nav_clearance_m(const nav_t *nav) {
  float kept_m = nav->cfg.clearance_m;
  float narrow_m = geometry_clamp(kept_m - nav->grid.cell_m, NARROWEST_M, kept_m);
  return nav->plan.narrow ? narrow_m : kept_m;
}

/** Cells round what is kept clear upwards, by as much as one of them: where that closes the only
 * way, it is given back. */
static void narrow(nav_t *nav, bool on) {
  if (nav->plan.narrow != on) {
    nav->plan.narrow = on;
    clearance_configure(&nav->clearance, &nav->grid, nav_clearance_m(nav), nav->cfg.area_min_m,
                        nav->cfg.area_max_m);
  }
  nav->plan.stage = NAV_PLAN_BEGIN;
}

static vec2_t goal_of_task(const nav_t *nav) {
  return nav->mission.task == MISSION_TASK_HOME ? pose2_position(nav->home) : nav->goal_m;
}

/** What closes the way may be noise: cells that only one hit speaks for are unknown again, and
 * looked at before the drone flies there; when that does not help, cells of two hits. So the drone
 * looks where its walls are weakest. */
static void doubt(nav_t *nav) {
  narrow(nav, false); // a door is wider, and many of the holes that this makes are not
  int hits = 1 + nav->plan.doubts / DOUBTS_A_HIT;
  grid_doubt(&nav->grid, GRID_OCCUPIED_MIN - 1 + hits * nav->cfg.grid.hit);
  nav->plan.doubts++;
  clearance_mark(&nav->clearance, &nav->grid);
}

/** There is no way now. In the air it may be noise: look around and try again, a few times. */
static void fail(nav_t *nav, mission_reason_t reason, vec2_t place_m) {
  nav->plan.stage = NAV_PLAN_DONE;
  if (nav->clearance.observed_only) { // then not only through what was observed
    clearance_observed_only(&nav->clearance, false);
    nav->plan.stage = NAV_PLAN_BEGIN;
    return;
  }
  if (!nav->plan.narrow && nav->plan.doubts == 0 && nav->plan.looks_left > 0) {
    narrow(nav, true);
    return;
  }
  bool may_look = nav->plan.looks_left > 0 && nav->plan.doubts < DOUBTS_MAX;
  if (mission_airborne(nav->mission.state) && may_look) {
    nav->plan.looks_left--;
    doubt(nav);
    nav_apply(nav, MISSION_EV_LOOK);
    return;
  }
  if (nav_skip_waypoint(nav, reason)) {
    nav->plan.stage = NAV_PLAN_BEGIN;
    return;
  }
  nav->mission.fault = reason;
  nav_emit(nav, WIRE_EVENT_REFUSED, (uint8_t)reason, place_m);
  nav_apply(nav, MISSION_EV_NO_ROUTE);
}

/** The goal is occupied. Home is wherever beside it is free; another goal may be occupied by noise
 *  seen from afar, and is looked at from beside it before it is given up; what is free as near as
 *  SERVED_M serves. @return false if it is given up */
static bool aim_beside(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  vec2_t beside = plan->goal_cells;
  bool is_free = clearance_nearest_free(&nav->clearance, beside, START_FREE_CELLS, &beside);
  bool far = vec2_distance(plan->start_cells, beside) > (float)BESIDE_CELLS;
  bool home = nav->mission.task == MISSION_TASK_HOME;
  bool serves = home || (mission_airborne(nav->mission.state) &&
                         vec2_distance(plan->goal_cells, beside) * nav->grid.cell_m < SERVED_M);
  plan->approach = !home && far && plan->looks_left > 0;
  if (!is_free || !(serves || plan->approach)) {
    fail(nav, MISSION_GOAL_OCCUPIED, grid_to_metres(&nav->grid, beside));
    return false;
  }
  plan->goal_cells = beside;
  return true;
}

static bool exploring(const nav_t *nav) {
  return nav->mission.task == MISSION_TASK_EXPLORE;
}

void nav_plan_afresh(nav_t *nav) {
  narrow(nav, false);
  nav->plan.stalls = 0;
  nav->plan.known_cells = 0;
  nav->plan.rounds_left = ROUNDS;
  nav->plan.doubts = 0;
  nav->plan.given_up = 0;
  nav->plan.looked = nav->plan.wandering = false;
  nav->plan.vain = (frontier_vain_t){.count = 0};
}

/** After a look around: did it show anything? A frontier where it does not is left alone. */
static void judge_look(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  if (!plan->looked) {
    return;
  }
  bool news = nav->grid.known >= plan->known_cells + NEWS_CELLS;
  bool there = vec2_distance(pose2_position(nav->pose), nav->goal_m) < AT_FRONTIER_M;
  plan->looked = false;
  plan->known_cells = nav->grid.known;
  plan->stalls = news ? 0u : (uint8_t)(plan->stalls + 1u);
  grid_cell_t cell;
  if (!news && (there || plan->stalls >= VAIN_LOOKS) &&
      grid_locate(&nav->grid, nav->goal_m, &cell)) {
    frontier_vain_add(&plan->vain, cell);
    plan->wandering = false;
    plan->given_up++;
    plan->stalls = 0;
  }
}

/** Set the planner to work from plan.start_cells. */
static void start_search(nav_t *nav, vec2_t last_goal_cells) {
  nav_plan_t *plan = &nav->plan;
  pathfinder_t *planner = &nav->planner;
  pathfinder_config_t cfg = nav->cfg.search;
  cfg.grid_only = nav->cfg.planner == NAV_PLANNER_GRID || plan->narrow; // trees fail there
  bool same = vec2_distance(last_goal_cells, plan->goal_cells) == 0.0f;
  if (exploring(nav)) {
    judge_look(nav);
  }
  if (exploring(nav) && !plan->wandering) {
    pathfinder_start_frontier(planner, &cfg, &nav->clearance, plan->start_cells, nav->cfg.frontier,
                              &plan->vain, plan->goal_cells);
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

/** No frontier is left. Noise may have closed a door: what little speaks for is looked at again. */
static void end_exploring(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  plan->stage = NAV_PLAN_DONE;
  if (plan->rounds_left > 0 && plan->given_up < GIVE_UP_AFTER &&
      mission_airborne(nav->mission.state)) {
    plan->rounds_left--;
    plan->vain.count = 0;
    doubt(nav);
    nav_apply(nav, MISSION_EV_LOOK);
    return;
  }
  nav_emit(nav, WIRE_EVENT_EXPLORED, plan->given_up >= GIVE_UP_AFTER, pose2_position(nav->pose));
  nav_set_task(nav, MISSION_TASK_HOME);
}

/** Something is left to explore: look for it at a random point of the area. */
static void wander(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  rng_t rng = rng_seed(nav->cfg.seed + nav_now_ms(nav));
  for (int i = 0; i < DRAWS; i++) {
    plan->goal_cells.x = rng_uniform(&rng) * (float)GRID_SIDE_CELLS;
    plan->goal_cells.y = rng_uniform(&rng) * (float)GRID_SIDE_CELLS;
    if (!clearance_blocked_at(&nav->clearance, plan->goal_cells)) {
      plan->wandering = true;
      nav->goal_m = grid_to_metres(&nav->grid, plan->goal_cells);
      break;
    }
  }
  plan->stage = NAV_PLAN_BEGIN;
}

/** Nothing more can be reached: the goal is walled off, or everything is explored. */
static void no_way(nav_t *nav) {
  if (nav->plan.wandering) {
    wander(nav);
    return;
  }
  if (exploring(nav)) {
    end_exploring(nav);
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
  } else if (exploring(nav) && nav->plan.given_up >= GIVE_UP_AFTER) {
    end_exploring(nav);
  } else if (exploring(nav) && nav->cfg.frontier == FRONTIER_RANDOM && !nav->plan.wandering) {
    wander(nav);
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
