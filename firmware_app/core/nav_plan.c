// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Planning in slices. A new plan for the same goal reuses the trees of the last one. */
#include "nav.h"
#include "nav_parts.h"
#include "rng.h"

enum {
  UNITS_PER_TICK = 30,   ///< budget of pathfinder_extend()
  DOUBTS_A_HIT = 2,      ///< doubts at one number of hits, before cells of one hit more are doubted
  DOUBTS_MAX = 4,        ///< doubts in a task
  BESIDE_CELLS = 6,      ///< an occupied goal is approached down to this distance
  START_FREE_CELLS = 10, ///< farthest free cell that stands for a blocked start or goal
  NEWS_CELLS = 20,       ///< newly known cells that count as progress
  VAIN_LOOKS = 2,        ///< stop-and-looks without news, on the way to one frontier
  GIVE_UP_AFTER = 40,    ///< frontiers given up that end an exploration
  DRAWS = 30,            ///< attempts to draw a free random point
  ROUNDS = 1,            ///< doubts before an exploration ends
};

static const float SERVED_M = 0.2f;      ///< an occupied goal is reached this near to it
static const float AT_FRONTIER_M = 0.5f; ///< this near, a look without news gives a frontier up
static const float NARROWEST_M = 0.09f;  ///< least clearance: propeller tips are 0.07 m out

float nav_clearance_m(const nav_t *nav) {
  float kept_m = nav->cfg.clearance_m;
  float narrow_m = geometry_clamp(kept_m - nav->grid.cell_m, NARROWEST_M, kept_m);
  return nav->plan.narrow ? narrow_m : kept_m;
}

/** Switch the reduced clearance on or off, and plan anew. In cells the clearance is rounded up, by
 *  up to one cell; where that closes the only way, it is taken back. */
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

/** What closes the way may be noise: make cells with one hit unknown again, so that the drone looks
 *  at them before it flies there; when that did not help, cells with two hits. Thus it looks where
 *  its walls are weakest. */
static void doubt(nav_t *nav) {
  narrow(nav, false); // doors pass the full clearance, which few of the holes made here do
  int hits = 1 + nav->plan.doubts / DOUBTS_A_HIT;
  grid_doubt(&nav->grid, GRID_OCCUPIED_MIN - 1 + hits * nav->cfg.grid.hit);
  nav->plan.doubts++;
  clearance_mark(&nav->clearance, &nav->grid);
}

/** No route was found: try what is left before it is final. In this order: through unknown cells,
 *  with reduced clearance, in the air after weak obstacles were doubted, to the next waypoint. */
static void fail(nav_t *nav, mission_reason_t reason, vec2_t place_m) {
  nav->plan.stage = NAV_PLAN_DONE;
  if (nav->clearance.observed_only) {
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

/** The goal is occupied: choose the nearest free place instead. Home accepts any. Another goal may
 *  be occupied by noise seen from afar, so it is first observed from beside it; then a place within
 *  SERVED_M of it is accepted. @return false if the goal is given up */
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

/** After a stop-and-look while exploring: give the frontier up if it showed nothing new. */
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

/** Start the pathfinder from plan.start_cells. */
static void start_search(nav_t *nav, vec2_t last_goal_cells) {
  nav_plan_t *plan = &nav->plan;
  pathfinder_t *planner = &nav->planner;
  pathfinder_config_t cfg = nav->cfg.search;
  cfg.grid_only = nav->cfg.planner == NAV_PLANNER_GRID || plan->narrow; // trees seldom find gaps
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

/** Start a plan for the present task, from the present pose. */
static void begin(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  if (nav->mission.lost) { // on the ground: take off, then relocalise
    plan->stage = NAV_PLAN_DONE;
    nav_apply(nav, MISSION_EV_WAY_EXISTS);
    return;
  }
  if (clearance_refresh(&nav->clearance, &nav->grid, 0) > 0) {
    return; // wait a few ticks until the clearance layer has followed the map
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

/** End the route at the goal itself, as the pathfinder's end lies on its lattice. */
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

/** No frontier is left. Noise may have closed a door, so doubt weak obstacles once before the
 *  exploration ends. */
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

/** Explore by random points: make a free one the goal. */
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

/** The pathfinder found no route: the goal is walled off, or everything is explored. */
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

/** The pathfinder has a route. Before take-off it was only asked whether there is one. */
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
