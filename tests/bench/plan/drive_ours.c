// SPDX-License-Identifier: GPL-3.0-or-later
#define _POSIX_C_SOURCE 200809L
/* The project's own planner under the bench's clock. The only file that knows its interface.
 *   drive_ours plan|prove|replan PROBLEMS SEED BUDGET_MS SAMPLES | drive_ours sizes
 * plan: SAMPLES samples, then on until within 1.02 or out of time. prove: time to know that there
 * is no way. replan: problems come in pairs, before and after something closed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clearance.h"
#include "drive.h"
#include "grid.h"
#include "route.h"
#include "rrtstar.h"
#include "wavefront.h"

enum {
  SLICE_BEFORE = 1,
  SLICE_AFTER = 4,
  CLAIMS = 512,
  CLAIM_POINTS = 1 << 16,
  CLOCK_EVERY = 256, ///< slices between looks at the clock
};

static grid_t grid;
static clearance_t clearance;
static rrtstar_t rrt;
static route_t route;

/** What the planner said during a run, to be verified after it. */
typedef struct {
  float cost;
  int first, count;
} claim_t;

static claim_t claims[CLAIMS];
static vec2_t claimed[CLAIM_POINTS];
static int claim_count, point_count;

/** As the map and its inflated layer stand before anybody plans: not charged. */
static void set_blocked(const uint8_t *blocked) {
  grid_config_t cfg = grid_config_default();
  const vec2_t reach = {10.0f, 10.0f};
  grid_init(&grid, &cfg, (vec2_t){0.0f, 0.0f}, 0.05f);
  for (int cell = 0; cell < GRID_CELLS; cell++) {
    grid_set_value(&grid, cell % GRID_SIDE_CELLS, cell / GRID_SIDE_CELLS,
                   blocked[cell] ? GRID_VALUE_MAX : GRID_FREE_MIN);
  }
  clearance_init(&clearance, &grid, 0.0f, vec2_scale(reach, -1.0f), reach);
  clearance_mark(&clearance, &grid);
  clearance_refresh(&clearance, &grid, GRID_SIDE_CELLS);
  for (int cell = 0; cell < GRID_CELLS; cell++) {
    uint32_t *word = &clearance.bits[cell / 32];
    uint32_t bit = 1u << (cell % 32);
    *word = blocked[cell] ? *word | bit : *word & ~bit;
  }
}

static vec2_t to_vec2(const double place[2]) {
  return (vec2_t){(float)place[0], (float)place[1]};
}

/** Keep the best way, out of the clock. */
static void keep_claim(void) {
  int room = CLAIM_POINTS - point_count;
  if (claim_count == CLAIMS) { // the newest matter most: the last is replaced
    claim_count--;
    point_count = claims[claim_count].first;
  }
  int count = rrtstar_path(&rrt, &claimed[point_count], room < 1024 ? room : 1024);
  claims[claim_count++] = (claim_t){rrt.best_cells, point_count, count};
  point_count += count;
}

/** @return its length, or -1; a final way is also held against the obstacles themselves. */
static double verified(drive_run_t *run, const vec2_t *way, int count, int64_t shrink, bool final) {
  static double xy[2 * DRIVE_WAY_POINTS];
  for (int i = 0; i < count; i++) {
    xy[2 * i] = (double)way[i].x;
    xy[2 * i + 1] = (double)way[i].y;
  }
  double length = drive_verify(run, xy, count, shrink);
  if (length >= 0.0 && final) {
    drive_finish(run, xy, count);
  }
  return length;
}

/** Every way that was claimed must be one, as long as claimed. */
static void verify_claims(drive_run_t *run) {
  for (int i = 0; i < claim_count; i++) {
    double length =
        verified(run, &claimed[claims[i].first], claims[i].count, 0, i + 1 == claim_count);
    if (length >= 0.0 && fabs(length - (double)claims[i].cost) > 1.0e-3 * length + 1.0e-2) {
      run->invalid++;
    }
  }
}

/** The route that would be flown: no longer than the way, and as clear. Its length is what counts
 * in the end. */
static void verify_route(drive_run_t *run) {
  static vec2_t way[ROUTE_POINTS];
  const int64_t shrink = 4194; // 1/1000 cell: its points have been metres
  int count = rrtstar_path(&rrt, route.points_m, ROUTE_POINTS);
  if (count < 2) {
    return;
  }
  route_build(&route, &grid, &clearance, count);
  for (int i = 0; i < route.count; i++) {
    way[i] = grid_to_cells(&grid, route.points_m[i]);
  }
  double length = verified(run, way, route.count, shrink, true);
  if (length > (double)rrt.best_cells * 1.001) {
    run->invalid++;
  }
  if (length >= 0.0) {
    run->fixed_cost = length;
  }
}

/** Look whether the last slice found something better. */
static void look(drive_run_t *run) {
  if ((double)rrt.best_cells < run->cost && rrt.goal_parent != RRTSTAR_NONE) {
    double now_s = drive_pause(run);
    if (drive_note(run, now_s, (double)rrt.best_cells)) {
      run->nodes_105 = rrt.count;
    }
    keep_claim();
    drive_resume(run, now_s);
  }
}

static bool searching(const rrtstar_t *tree) {
  return tree->status == RRTSTAR_SEARCHING || tree->status == RRTSTAR_FOUND;
}

/** Extend up to a number of samples in all. */
static void search(drive_run_t *run, long samples, double until_s, double good_cost) {
  for (long slices = 0; searching(&rrt) && run->samples < samples && run->cost > good_cost;
       slices++) {
    int slice = isfinite(run->cost) ? SLICE_AFTER : SLICE_BEFORE;
    rrtstar_extend(&rrt, &clearance, slice);
    run->samples += slice;
    look(run);
    if (slices % CLOCK_EVERY == 0 && drive_time_s(run) > until_s) {
      break;
    }
  }
}

static void plan(drive_run_t *run, const drive_problem_t *problem, uint32_t seed, double budget_s,
                 long samples) {
  rrtstar_config_t cfg = rrtstar_config_default();
  claim_count = point_count = 0;
  set_blocked(problem->blocked);
  drive_begin(run, problem);
  rrtstar_start(&rrt, &cfg, &clearance, to_vec2(problem->start), to_vec2(problem->goal), seed);
  look(run);
  search(run, samples, budget_s, 0.0);
  double paused_s = drive_pause(run);
  run->fixed_cost = run->cost;
  verify_route(run);
  drive_resume(run, paused_s);
  search(run, 1L << 40, budget_s, 1.02 * problem->optimum);
  run->end_s = drive_time_s(run);
  run->nodes_end = rrt.count;
  run->bytes_105 = run->bytes_end = sizeof rrt + sizeof clearance;
  verify_claims(run);
}

/** end_s: when it was known that there is no way; cost 0: a way was claimed. */
static void prove(drive_run_t *run, const drive_problem_t *problem) {
  static wavefront_t wave;
  vec2_t start = to_vec2(problem->start);
  vec2_t goal = to_vec2(problem->goal);
  set_blocked(problem->blocked);
  drive_begin(run, problem);
  wavefront_start(&wave, WAVEFRONT_TO_GOAL, (grid_cell_t){(int)start.x, (int)start.y},
                  (grid_cell_t){(int)goal.x, (int)goal.y});
  while (wavefront_extend(&wave, &clearance, &grid, GRID_CELLS) == WAVEFRONT_RUNNING) {
  }
  run->end_s = drive_time_s(run);
  run->cost = wave.status == WAVEFRONT_EXHAUSTED ? INFINITY : 0.0;
}

/** Run on the map before the change, then find a way on the map after it. */
static void replan(drive_run_t *run, const drive_problem_t *before, const drive_problem_t *after,
                   uint32_t seed, double budget_s, long samples) {
  plan(run, before, seed, budget_s, samples);
  plan(run, after, seed, budget_s, samples);
}

static void run_all(const char *mode, const char *path, uint32_t seed, double budget_s,
                    long samples) {
  int count;
  drive_problem_t *problems = drive_read(path, &count);
  drive_run_t run;
  drive_print_header();
  bool pairs = strcmp(mode, "replan") == 0;
  for (int i = -1; i < count; i++) { // the first is run once more before, to warm up
    const drive_problem_t *problem = &problems[i < 0 ? 0 : i];
    uint32_t own_seed = seed * 7919u + (uint32_t)(i < 0 ? 0 : i);
    if (strcmp(mode, "prove") == 0) {
      prove(&run, problem);
    } else if (!pairs) {
      plan(&run, problem, own_seed, budget_s, samples);
    } else if (i < 0 || i % 2 == 1) {
      const drive_problem_t *before = &problems[i < 0 ? 0 : i - 1];
      replan(&run, before, before + 1, own_seed, budget_s, samples);
    }
    if (i >= 0 && (!pairs || i % 2 == 1)) {
      drive_print(i, &run);
    }
  }
  free(problems);
}

int main(int argc, char **argv) {
  if (argc == 2 && strcmp(argv[1], "sizes") == 0) {
    printf("%zu,%zu,%zu\n", sizeof(rrtstar_t), sizeof clearance.bits, sizeof(wavefront_t));
    return 0;
  }
  if (argc != 6) {
    fprintf(stderr, "usage: drive_ours plan|prove|replan PROBLEMS SEED BUDGET_MS SAMPLES\n");
    return 2;
  }
  run_all(argv[1], argv[2], (uint32_t)strtoul(argv[3], 0, 10), 1.0e-3 * strtod(argv[4], 0),
          strtol(argv[5], 0, 10));
  return 0;
}
