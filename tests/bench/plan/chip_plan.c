// SPDX-License-Identifier: GPL-3.0-or-later
/* The bench's problems on the chip: from the start of a plan to its first route, in slices, each of
 * which is watched: what one tick would bear. */
#include <math.h>

#include "ours.h"
#include "port.h"

enum { SLICE_SAMPLES = 4, SLICES_MAX = 5000, WAY_POINTS = 64 };

typedef struct {
  uint32_t bits[OURS_WORDS];
  vec2_t start_cells, goal_cells;
  uint32_t seed;
} problem_t;

typedef enum { START, SEARCH, ROUTE } step_t;

static problem_t problem;
static vec2_t way[WAY_POINTS];
static int points, slices;
static bool searching;

/** What one tick does. */
__attribute__((noinline)) void chip_slice(step_t step) {
  slices++;
  if (step == START) {
    ours_start(problem.start_cells, problem.goal_cells, problem.seed);
  } else if (step == SEARCH) {
    searching = ours_search(SLICE_SAMPLES);
  } else {
    points = ours_route(way, WAY_POINTS);
  }
}

static void first_route(void) {
  points = slices = 0;
  searching = true;
  chip_slice(START);
  while (searching && isinf(ours_cost()) && slices < SLICES_MAX) {
    chip_slice(SEARCH);
  }
  if (!isinf(ours_cost())) {
    chip_slice(ROUTE);
  }
}

/** For each problem: the length of its first way, the slices, and its route. */
void port_main(void) {
  while (port_read(&problem, sizeof problem)) {
    ours_set_blocked(problem.bits);
    first_route();
    float cost_cells = ours_cost();
    port_write(&cost_cells, sizeof cost_cells);
    port_write(&slices, sizeof slices);
    port_write(&points, sizeof points);
    port_write(way, (size_t)points * sizeof *way);
  }
}
