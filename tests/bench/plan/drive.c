// SPDX-License-Identifier: GPL-3.0-or-later
#define _POSIX_C_SOURCE 200809L
#include "drive.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "exact.h"

static const char MAGIC[8] = "WAYPLAN1";
static const double END_TOLERANCE_CELLS = 2.0e-3; ///< a node is held in 1/512 cell

static double cpu_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1.0e-9 * (double)now.tv_nsec;
}

static void give_up(const char *path) {
  fprintf(stderr, "%s is no problem file\n", path);
  exit(2);
}

drive_problem_t *drive_read(const char *path, int *count) {
  char magic[sizeof MAGIC];
  uint32_t number = 0;
  FILE *file = fopen(path, "rb");
  if (file == 0 || fread(magic, sizeof magic, 1, file) != 1 ||
      memcmp(magic, MAGIC, sizeof magic) != 0 || fread(&number, sizeof number, 1, file) != 1) {
    give_up(path);
  }
  drive_problem_t *problems = calloc(number + 1u, sizeof *problems);
  if (problems == 0 || fread(problems, sizeof *problems, number, file) != number) {
    give_up(path);
  }
  fclose(file);
  *count = (int)number;
  return problems;
}

void drive_begin(drive_run_t *run, const drive_problem_t *problem) {
  memset(run, 0, sizeof *run);
  run->problem = problem;
  run->cost = INFINITY;
  run->first_s = run->within_105_s = run->within_102_s = INFINITY;
  run->enough_s = run->enough_cost = INFINITY;
  run->first_cost = run->fixed_cost = run->flown_cost = INFINITY;
  run->clearance = INFINITY;
  run->nodes_105 = run->bytes_105 = -1;
  run->began_s = cpu_s();
}

double drive_time_s(const drive_run_t *run) {
  return cpu_s() - run->began_s - run->unpaid_s;
}

double drive_pause(drive_run_t *run) {
  return drive_time_s(run);
}

void drive_resume(drive_run_t *run, double paused_s) {
  run->unpaid_s += drive_time_s(run) - paused_s;
}

bool drive_note(drive_run_t *run, double time_s, double cost) {
  double optimum = run->problem->optimum;
  bool within_105_before = isfinite(run->within_105_s);
  if (!(cost < run->cost)) {
    return false;
  }
  if (!isfinite(run->first_s)) {
    run->first_s = time_s;
    run->first_cost = cost;
  }
  run->cost = cost;
  if (cost <= 1.05 * optimum && !within_105_before) {
    run->within_105_s = time_s;
  }
  if (cost <= 1.02 * optimum && !isfinite(run->within_102_s)) {
    run->within_102_s = time_s;
  }
  return !within_105_before && isfinite(run->within_105_s);
}

static bool at(const double *xy_cells, const double place[2]) {
  return hypot(xy_cells[0] - place[0], xy_cells[1] - place[1]) <= END_TOLERANCE_CELLS;
}

/** The blocked cells of a problem, kept until another is asked for. */
static const exact_map_t *map_of(const drive_problem_t *problem) {
  static const drive_problem_t *kept_for;
  static exact_map_t *kept;
  if (problem != kept_for) {
    exact_map_free(kept);
    kept = exact_map_new(problem->blocked, DRIVE_SIDE, DRIVE_SIDE);
    kept_for = problem;
  }
  return kept;
}

double drive_verify(drive_run_t *run, const double *xy_cells, int count, int64_t shrink) {
  const drive_problem_t *problem = run->problem;
  double length = -1.0;
  if (count >= 2 && at(xy_cells, problem->start) && at(&xy_cells[2 * count - 2], problem->goal)) {
    length = exact_way_length(map_of(problem), xy_cells, count, shrink);
  }
  bool too_short = problem->optimum >= 0.0 && length < problem->optimum - 0.01;
  if (length < 0.0 || too_short || problem->optimum < 0.0) {
    run->invalid++;
    return -1.0;
  }
  return length;
}

void drive_finish(drive_run_t *run, const double *xy_cells, int count) {
  exact_map_t *obstacles = exact_map_new(run->problem->raw, DRIVE_SIDE, DRIVE_SIDE);
  run->clearance = fmin(run->clearance, exact_way_clearance(obstacles, xy_cells, count));
  exact_map_free(obstacles);
}

void drive_print_header(void) {
  printf("problem,first_s,first_cost,within_105_s,within_102_s,enough_s,enough_cost,end_s,cost,"
         "fixed_cost,flown_cost,"
         "clearance,"
         "nodes_105,nodes_end,bytes_105,bytes_end,samples,invalid\n");
}

void drive_print(int problem, const drive_run_t *run) {
  printf("%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%ld,%ld,%ld,%ld,%ld,%d\n",
         problem, run->first_s, run->first_cost, run->within_105_s, run->within_102_s,
         run->enough_s, run->enough_cost, run->end_s, run->cost, run->fixed_cost, run->flown_cost,
         run->clearance, run->nodes_105, run->nodes_end, run->bytes_105, run->bytes_end,
         run->samples, run->invalid);
}
