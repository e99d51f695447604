// SPDX-License-Identifier: GPL-3.0-or-later
/* What people use on grids, as fast as plain C makes it: A* on 8 neighbours with string pulling,
 * and lazy Theta* (Nash, Koenig and Tovey, AAAI 2010).
 *   drive_grid astar|theta PROBLEMS */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drive.h"

enum {
  STRIDE = DRIVE_SIDE + 2, ///< a frame of blocked cells spares the check of borders
  CELLS = STRIDE * STRIDE,
  HEAP = 8 * CELLS,
};

typedef enum { FRESH, OPEN, CLOSED } state_t;

typedef struct {
  float estimate, cost;
  int cell;
} entry_t;

static const int STEP[8] = {1,          -1,         STRIDE,     -STRIDE,
                            STRIDE + 1, STRIDE - 1, 1 - STRIDE, -1 - STRIDE};
static const float DIAGONAL = 1.41421356f;

static uint8_t blocked[CELLS];
static uint8_t state[CELLS];
static float cost[CELLS];
static int parent[CELLS];
static entry_t heap[HEAP];
static int heap_count, closed_count;

static bool before(const entry_t *a, const entry_t *b) {
  return a->estimate < b->estimate || (a->estimate == b->estimate && a->cost > b->cost);
}

static void push(entry_t entry) {
  int i = heap_count++;
  while (i > 0 && before(&entry, &heap[(i - 1) / 2])) {
    heap[i] = heap[(i - 1) / 2];
    i = (i - 1) / 2;
  }
  heap[i] = entry;
}

static int pop(void) {
  int cell = heap[0].cell;
  entry_t last = heap[--heap_count];
  int i = 0;
  for (int child = 1; child < heap_count; child = 2 * i + 1) {
    if (child + 1 < heap_count && before(&heap[child + 1], &heap[child])) {
      child++;
    }
    if (!before(&heap[child], &last)) {
      break;
    }
    heap[i] = heap[child];
    i = child;
  }
  heap[i] = last;
  return cell;
}

/** From centre to centre of two cells, through every cell that the line enters. */
static bool in_sight(int from, int to) {
  int dx = to % STRIDE - from % STRIDE;
  int dy = to / STRIDE - from / STRIDE;
  int step_x = dx > 0 ? 1 : -1;
  int step_y = dy > 0 ? STRIDE : -STRIDE;
  dx = abs(dx);
  dy = abs(dy);
  int lead = dx - dy;
  for (int cell = from; cell != to;) {
    if (lead == 0 && (blocked[cell + step_x] || blocked[cell + step_y])) {
      return false;
    }
    int turn = lead;
    if (turn >= 0) {
      cell += step_x;
      lead -= 2 * dy;
    }
    if (turn <= 0) {
      cell += step_y;
      lead += 2 * dx;
    }
    if (blocked[cell]) {
      return false;
    }
  }
  return true;
}

static bool can_step(int cell, int k) {
  int next = cell + STEP[k];
  if (blocked[next]) {
    return false;
  }
  int up = k < 6 ? STRIDE : -STRIDE;
  return k < 4 || !(blocked[cell + up] || blocked[next - up]);
}

static float straight(int a, int b) {
  float dx = (float)(a % STRIDE - b % STRIDE);
  float dy = (float)(a / STRIDE - b / STRIDE);
  return sqrtf(dx * dx + dy * dy);
}

static float octile(int a, int b) {
  float dx = fabsf((float)(a % STRIDE - b % STRIDE));
  float dy = fabsf((float)(a / STRIDE - b / STRIDE));
  return dx > dy ? dx + (DIAGONAL - 1.0f) * dy : dy + (DIAGONAL - 1.0f) * dx;
}

/** Lazy Theta* took for granted that the parent is in sight; else the best closed neighbour is. */
static void settle_parent(int cell) {
  float best = INFINITY;
  if (parent[cell] == cell || in_sight(parent[cell], cell)) {
    return;
  }
  for (int k = 0; k < 8; k++) {
    int beside = cell + STEP[k];
    float through = cost[beside] + (k < 4 ? 1.0f : DIAGONAL);
    if (state[beside] == CLOSED && can_step(cell, k) && through < best) {
      best = through;
      parent[cell] = beside;
    }
  }
  cost[cell] = best;
}

static void look_around(int cell, int goal, bool any_angle) {
  int from = any_angle ? parent[cell] : cell;
  for (int k = 0; k < 8; k++) {
    int next = cell + STEP[k];
    if (state[next] == CLOSED || !can_step(cell, k)) {
      continue;
    }
    float through =
        any_angle ? cost[from] + straight(from, next) : cost[cell] + (k < 4 ? 1.0f : DIAGONAL);
    if (state[next] == FRESH || through < cost[next]) {
      state[next] = OPEN;
      cost[next] = through;
      parent[next] = from;
      float to_goal = any_angle ? straight(next, goal) : octile(next, goal);
      push((entry_t){through + to_goal, through, next});
    }
  }
}

static int cell_at(const double place[2]) {
  return ((int)place[1] + 1) * STRIDE + (int)place[0] + 1;
}

static bool search(int start, int goal, bool any_angle) {
  memset(state, FRESH, sizeof state);
  heap_count = closed_count = 0;
  cost[start] = 0.0f;
  parent[start] = start;
  state[start] = OPEN;
  push((entry_t){0.0f, 0.0f, start});
  while (heap_count > 0) {
    int cell = pop();
    if (state[cell] == CLOSED) {
      continue;
    }
    if (any_angle) {
      settle_parent(cell);
    }
    state[cell] = CLOSED;
    closed_count++;
    if (cell == goal) {
      return true;
    }
    look_around(cell, goal, any_angle);
  }
  return false;
}

/** From goal to start, each point the farthest in sight of the one before. @return how many */
static int pulled_way(int start, int goal, double *xy_cells) {
  int count = 0;
  for (int cell = goal;;) {
    xy_cells[2 * count] = cell % STRIDE - 0.5;
    xy_cells[2 * count + 1] = cell / STRIDE - 0.5;
    count++;
    if (cell == start) {
      return count;
    }
    int next = parent[cell];
    while (next != start && in_sight(cell, parent[next])) {
      next = parent[next];
    }
    cell = next;
  }
}

static double reverse_and_measure(double *xy_cells, int count) {
  double length = 0.0;
  for (int a = 0, b = count - 1; a < b; a++, b--) {
    for (int axis = 0; axis < 2; axis++) {
      double kept = xy_cells[2 * a + axis];
      xy_cells[2 * a + axis] = xy_cells[2 * b + axis];
      xy_cells[2 * b + axis] = kept;
    }
  }
  for (int i = 1; i < count; i++) {
    length +=
        hypot(xy_cells[2 * i] - xy_cells[2 * i - 2], xy_cells[2 * i + 1] - xy_cells[2 * i - 1]);
  }
  return length;
}

static void plan(drive_run_t *run, const drive_problem_t *problem, bool any_angle) {
  static double way[2 * CELLS];
  int start = cell_at(problem->start);
  int goal = cell_at(problem->goal);
  int count = 0;
  memset(blocked, 1, sizeof blocked); // the map stands before anybody plans: not charged
  for (int y = 0; y < DRIVE_SIDE; y++) {
    memcpy(&blocked[(y + 1) * STRIDE + 1], &problem->blocked[y * DRIVE_SIDE], DRIVE_SIDE);
  }
  drive_begin(run, problem);
  if (search(start, goal, any_angle)) {
    count = pulled_way(start, goal, way);
  }
  run->end_s = drive_time_s(run);
  run->nodes_105 = run->nodes_end = closed_count;
  run->bytes_105 = run->bytes_end =
      (long)(sizeof state + sizeof cost + sizeof parent + sizeof heap);
  if (count > 0) {
    drive_note(run, run->end_s, reverse_and_measure(way, count));
    drive_verify(run, way, count, 0);
    drive_finish(run, way, count);
  }
}

int main(int argc, char **argv) {
  drive_run_t run;
  int count;
  if (argc != 3) {
    fprintf(stderr, "usage: drive_grid astar|theta PROBLEMS\n");
    return 2;
  }
  drive_problem_t *problems = drive_read(argv[2], &count);
  bool any_angle = strcmp(argv[1], "theta") == 0;
  drive_print_header();
  for (int i = -1; i < count; i++) { // the first is run once more before, to warm up
    plan(&run, &problems[i < 0 ? 0 : i], any_angle);
    if (i >= 0) {
      drive_print(i, &run);
    }
  }
  free(problems);
  return 0;
}
