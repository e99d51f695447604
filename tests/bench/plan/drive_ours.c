// SPDX-License-Identifier: GPL-3.0-or-later
/* The project's own planner under the bench's clock.
 *   drive_ours plan|prove|repair|anew PROBLEMS SEED BUDGET_MS SAMPLES | drive_ours sizes
 * plan: the best way within SAMPLES samples, and on until within 1.02 and content, or out of
 * time. prove: time until it knows that
 * there is no way. repair, anew: problems come in pairs, before and after something closed; what
 * counts is the way after it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drive.h"
#include "ours.h"

enum {
  SLICE_BEFORE = 1, ///< units of work between two looks, until the first way
  SLICE_AFTER = 4,
  CLOCK_EVERY = 256, ///< slices
  CLAIMS = 512,
  CLAIM_POINTS = 1024,
  ROUTE_SHRINK = 4194, ///< 1/1000 cell: a route's points have been metres
};

typedef struct {
  uint32_t seed;
  double budget_s;
  long samples;
} terms_t;

/** What the planner said during a run, to be verified after it. */
typedef struct {
  float cost;
  int count;
  vec2_t way[CLAIM_POINTS];
} claim_t;

static claim_t claims[CLAIMS];
static int claim_count;

static void pack(const uint8_t *blocked, uint32_t bits[OURS_WORDS]) {
  memset(bits, 0, OURS_WORDS * sizeof *bits);
  for (int cell = 0; cell < DRIVE_CELLS; cell++) {
    bits[cell / 32] |= (blocked[cell] ? 1u : 0u) << (cell % 32);
  }
}

static void expect(bool alike) {
  if (!alike) {
    fprintf(stderr, "the core blocks other cells than the bench\n");
    exit(1);
  }
}

static vec2_t to_vec2(const double place[2]) {
  return (vec2_t){(float)place[0], (float)place[1]};
}

/** @return the way's length, or -1; a final way is also held against the obstacles themselves. */
static double verified(drive_run_t *run, const vec2_t *way, int count, int64_t shrink, bool final) {
  static double xy[2 * CLAIM_POINTS];
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
    bool final = i + 1 == claim_count;
    double length = verified(run, claims[i].way, claims[i].count, 0, final);
    if (length >= 0.0 && fabs(length - (double)claims[i].cost) > 1.0e-3 * length + 1.0e-2) {
      run->invalid++;
    }
  }
}

/** The best way within the samples, and the route that would be flown along it. */
static void take_route(drive_run_t *run) {
  static vec2_t route[CLAIM_POINTS];
  int count = ours_route(route, CLAIM_POINTS);
  run->fixed_cost = run->cost;
  if (count > 0) {
    double length = verified(run, route, count, ROUTE_SHRINK, true);
    run->flown_cost = length >= 0.0 ? length : HUGE_VAL;
  }
}

/** Take down what the last slice found, if it is better. Only the look itself is on the clock. */
static void look(drive_run_t *run) {
  if ((double)ours_cost() < run->cost) {
    double now_s = drive_pause(run);
    if (drive_note(run, now_s, (double)ours_cost())) {
      run->nodes_105 = ours_nodes();
    }
    claim_count += claim_count < CLAIMS; // once full, the newest takes the place of the last
    claim_t *claim = &claims[claim_count - 1];
    claim->cost = ours_cost();
    claim->count = ours_way(claim->way, CLAIM_POINTS);
    drive_resume(run, now_s);
  }
  if (!isfinite(run->enough_s) && ours_enough()) {
    run->enough_s = drive_time_s(run);
    run->enough_cost = run->cost;
  }
}

static bool done(const drive_run_t *run) {
  return isfinite(run->within_102_s) && isfinite(run->enough_s);
}

/** On until it is done, if there is time; and the best way within the samples. */
static void search(drive_run_t *run, const terms_t *terms) {
  bool going = true;
  bool taken = false;
  for (long slices = 0; going && !(taken && done(run)); slices++) {
    going = ours_search(isfinite(run->cost) ? SLICE_AFTER : SLICE_BEFORE);
    run->samples = ours_samples();
    look(run);
    if (!taken && (run->samples >= terms->samples || !going)) {
      double paused_s = drive_pause(run);
      take_route(run);
      drive_resume(run, paused_s);
      taken = true;
    }
    if (slices % CLOCK_EVERY == 0 && drive_time_s(run) > terms->budget_s) {
      return;
    }
  }
}

static void plan(drive_run_t *run, const terms_t *terms) {
  search(run, terms);
  run->end_s = drive_time_s(run);
  run->nodes_end = ours_nodes();
  ours_sizes_t sizes = ours_sizes();
  run->bytes_105 = run->bytes_end = (long)(sizes.planner + sizes.bits);
  verify_claims(run);
}

static void plan_anew(drive_run_t *run, const drive_problem_t *problem, const terms_t *terms) {
  uint32_t bits[OURS_WORDS];
  pack(problem->blocked, bits);
  expect(ours_set_blocked(bits));
  claim_count = 0;
  drive_begin(run, problem);
  ours_start(to_vec2(problem->start), to_vec2(problem->goal), terms->seed);
  look(run);
  plan(run, terms);
}

/** The plan of the problem before stands when the change comes. */
static void repair(drive_run_t *run, const drive_problem_t *after, const terms_t *terms) {
  uint32_t bits[OURS_WORDS];
  plan_anew(run, after - 1, terms);
  pack(after->blocked, bits);
  expect(ours_change_blocked(bits));
  claim_count = 0;
  drive_begin(run, after);
  ours_repair();
  look(run);
  plan(run, terms);
}

/** end_s: when it was known that there is no way; cost 0: a way was claimed. */
static void prove(drive_run_t *run, const drive_problem_t *problem, const terms_t *terms) {
  uint32_t bits[OURS_WORDS];
  pack(problem->blocked, bits);
  expect(ours_set_blocked(bits));
  drive_begin(run, problem);
  bool none = ours_no_way(to_vec2(problem->start), to_vec2(problem->goal), terms->seed);
  run->end_s = drive_time_s(run);
  run->cost = none ? HUGE_VAL : 0.0;
}

static void run_all(const char *mode, const char *path, const terms_t *terms) {
  int count;
  drive_problem_t *problems = drive_read(path, &count);
  drive_run_t run;
  bool repairs = strcmp(mode, "repair") == 0;
  bool pairs = repairs || strcmp(mode, "anew") == 0;
  drive_print_header();
  for (int i = pairs ? 1 : 0; i < count; i += pairs ? 2 : 1) {
    terms_t own = *terms;
    own.seed = terms->seed * 7919u + (uint32_t)i;
    for (int again = i < 2 ? 0 : 1; again < 2; again++) { // the first runs twice, to warm up
      if (strcmp(mode, "prove") == 0) {
        prove(&run, &problems[i], &own);
      } else if (repairs) {
        repair(&run, &problems[i], &own);
      } else {
        plan_anew(&run, &problems[i], &own);
      }
    }
    drive_print(i, &run);
  }
  free(problems);
}

int main(int argc, char **argv) {
  if (argc == 2 && strcmp(argv[1], "sizes") == 0) {
    ours_sizes_t sizes = ours_sizes();
    printf("%zu,%zu\n", sizes.planner, sizes.bits);
    return 0;
  }
  if (argc != 6) {
    fprintf(stderr, "usage: drive_ours plan|prove|repair|anew PROBLEMS SEED BUDGET_MS SAMPLES\n");
    return 2;
  }
  terms_t terms = {(uint32_t)strtoul(argv[3], 0, 10), 1.0e-3 * strtod(argv[4], 0),
                   strtol(argv[5], 0, 10)};
  run_all(argv[1], argv[2], &terms);
  return 0;
}
