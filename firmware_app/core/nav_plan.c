// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Planning in slices: a wave proves that there is a way, then RRT* makes it short. Where the tree's
 * pool ends before it finds the way that exists, the wave's own way is flown. */
#include "nav.h"
#include "nav_parts.h"

enum {
  WAVES_PER_TICK = 6,
  FRONTIER_WAVES_PER_TICK = 1, ///< these also look at what is known
  SAMPLES_PER_TICK = 12,
  SAMPLES_EXTRA = 120, ///< after the first way, at least
  SAMPLES_MAX = 3000,
  BESIDE_CELLS = 6,      ///< so near to the place beside an occupied goal, it has been looked at
  START_FREE_CELLS = 10, ///< how far the way out of an inflated zone may be
};

static vec2_t goal_of_task(const nav_t *nav) {
  return nav->mission.task == MISSION_TASK_HOME ? pose2_position(nav->home) : nav->goal_m;
}

static grid_cell_t cell_of(vec2_t cells) {
  return (grid_cell_t){(int)cells.x, (int)cells.y};
}

/** There is no way now. In the air it may be noise: look around and try again, a few times. */
static void fail(nav_t *nav, mission_reason_t reason, vec2_t place_m) {
  nav->plan.stage = NAV_PLAN_DONE;
  if (mission_airborne(nav->mission.state) && nav->plan.looks_left > 0) {
    nav->plan.looks_left--;
    nav_apply(nav, MISSION_EV_LOOK);
    return;
  }
  nav->mission.fault = reason;
  nav_emit(nav, WIRE_EVENT_REFUSED, (uint8_t)reason, place_m);
  nav_apply(nav, MISSION_EV_NO_ROUTE);
}

static void start_wave(nav_t *nav, nav_plan_stage_t stage) {
  nav->plan.stage = stage;
  bool exploring = nav->mission.task == MISSION_TASK_EXPLORE;
  wavefront_start(&nav->arena.wavefront, exploring ? WAVEFRONT_TO_FRONTIER : WAVEFRONT_TO_GOAL,
                  cell_of(nav->plan.start_cells), cell_of(nav->plan.goal_cells));
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

/** Begin to plan for the present task, from the present pose. */
static void begin(nav_t *nav) {
  nav_plan_t *plan = &nav->plan;
  if (clearance_refresh(&nav->clearance, &nav->grid, 0) > 0) {
    return; // a few ticks more until the layer has followed the map
  }
  plan->first_iterations = 0;
  plan->start_cells = grid_to_cells(&nav->grid, pose2_position(nav->pose));
  plan->goal_cells = grid_to_cells(&nav->grid, goal_of_task(nav));
  if (clearance_blocked_at(&nav->clearance, plan->start_cells) &&
      !clearance_nearest_free(&nav->clearance, plan->start_cells, START_FREE_CELLS,
                              &plan->start_cells)) {
    fail(nav, MISSION_STUCK, pose2_position(nav->pose));
    return;
  }
  plan->approach = false;
  if (nav->mission.task == MISSION_TASK_EXPLORE) {
    plan->goal_cells = plan->start_cells;
  } else if (clearance_blocked_at(&nav->clearance, plan->goal_cells) && !aim_beside(nav)) {
    return;
  }
  start_wave(nav, NAV_PLAN_WAVE);
}

static void finish(nav_t *nav, int count) {
  if (count < 2) {
    fail(nav, MISSION_GOAL_UNREACHABLE, pose2_position(nav->pose));
    return;
  }
  nav->plan.stage = NAV_PLAN_DONE;
  nav->plan.looks_left = NAV_LOOKS;
  route_build(&nav->route, &nav->grid, &nav->clearance, count);
  if (!nav->plan.approach) {
    nav->goal_m = nav->route.points_m[nav->route.count - 1];
  }
  nav_apply(nav, MISSION_EV_ROUTE);
}

static void finish_with_wave(nav_t *nav) {
  finish(nav,
         wavefront_path(&nav->arena.wavefront, &nav->clearance, nav->route.points_m, ROUTE_POINTS));
}

/** Nothing more can be reached: the goal is walled off, or everything is explored. */
static void exhausted(nav_t *nav) {
  grid_cell_t nearest = cell_of(nav->plan.start_cells);
  if (nav->mission.task == MISSION_TASK_EXPLORE) {
    nav->plan.stage = NAV_PLAN_DONE;
    nav_emit(nav, WIRE_EVENT_EXPLORED, 0, pose2_position(nav->pose));
    nav_set_task(nav, MISSION_TASK_HOME);
    return;
  }
  wavefront_nearest(&nav->arena.wavefront, nav->plan.goal_cells, &nearest);
  fail(nav, MISSION_GOAL_UNREACHABLE, grid_centre_m(&nav->grid, nearest));
}

static void wave_done(nav_t *nav) {
  bool by_wave = nav->cfg.planner == NAV_PLANNER_GRID || nav->mission.task == MISSION_TASK_EXPLORE;
  if (nav->mission.state == MISSION_IDLE) {
    nav->plan.stage = NAV_PLAN_DONE;
    nav_apply(nav, MISSION_EV_WAY_EXISTS);
  } else if (by_wave || nav->plan.stage == NAV_PLAN_WAVE_AGAIN) {
    nav->plan.stage = NAV_PLAN_PATH;
  } else {
    nav->plan.stage = NAV_PLAN_TREE;
    rrtstar_start(&nav->arena.rrtstar, &nav->cfg.rrtstar, &nav->clearance, nav->plan.start_cells,
                  nav->plan.goal_cells, nav->cfg.seed + nav->route.revision);
  }
}

static void step_wave(nav_t *nav) {
  bool exploring = nav->mission.task == MISSION_TASK_EXPLORE;
  int waves = exploring ? FRONTIER_WAVES_PER_TICK : WAVES_PER_TICK;
  switch (wavefront_extend(&nav->arena.wavefront, &nav->clearance, &nav->grid, waves)) {
  case WAVEFRONT_REACHED:
    wave_done(nav);
    break;
  case WAVEFRONT_EXHAUSTED:
    exhausted(nav);
    break;
  case WAVEFRONT_RUNNING:
    break;
  }
}

/** Enough: twice the samples that the first way took, and some more. */
static bool tree_done(const rrtstar_t *rrt, const nav_plan_t *plan) {
  if (rrt->status == RRTSTAR_FOUND) {
    return rrt->iterations >= 2u * plan->first_iterations + SAMPLES_EXTRA;
  }
  return rrt->status != RRTSTAR_SEARCHING || rrt->iterations >= SAMPLES_MAX;
}

static void step_tree(nav_t *nav) {
  rrtstar_t *rrt = &nav->arena.rrtstar;
  rrtstar_status_t status = rrtstar_extend(rrt, &nav->clearance, SAMPLES_PER_TICK);
  nav->status.plan_nodes = (uint16_t)rrt->count;
  if (status == RRTSTAR_FOUND && nav->plan.first_iterations == 0u) {
    nav->plan.first_iterations = rrt->iterations;
  }
  if (!tree_done(rrt, &nav->plan)) {
    return;
  }
  int count = rrtstar_path(rrt, nav->route.points_m, ROUTE_POINTS);
  if (count > 0) {
    finish(nav, count);
  } else {
    start_wave(nav, NAV_PLAN_WAVE_AGAIN);
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
  case NAV_PLAN_WAVE:
  case NAV_PLAN_WAVE_AGAIN:
    step_wave(nav);
    break;
  case NAV_PLAN_PATH:
    finish_with_wave(nav);
    break;
  case NAV_PLAN_TREE:
    step_tree(nav);
    break;
  case NAV_PLAN_DONE:
    break;
  }
}
