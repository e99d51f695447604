// SPDX-License-Identifier: GPL-3.0-or-later
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "exact.h"

/** A vertex of the visibility graph. */
typedef struct {
  exact_point_t at;
  double from_start, to_goal; ///< cells: shortest way found, straight line
  int before;
  bool done;
} vertex_t;

typedef struct {
  const exact_map_t *map;
  vertex_t *vertices; ///< start, goal, convex corners
  int count;
} graph_t;

static double distance(exact_point_t a, exact_point_t b) {
  return hypot((double)(a.x - b.x), (double)(a.y - b.y)) / EXACT_UNIT;
}

static void add(graph_t *graph, exact_point_t at, exact_point_t goal) {
  graph->vertices[graph->count++] = (vertex_t){at, INFINITY, distance(at, goal), -1, false};
}

static bool make_graph(graph_t *graph, const exact_map_t *map, exact_point_t start,
                       exact_point_t goal) {
  size_t corners = (size_t)(map->width + 1) * (size_t)(map->height + 1);
  *graph = (graph_t){map, malloc((corners + 2) * sizeof *graph->vertices), 0};
  if (graph->vertices == 0) {
    return false;
  }
  add(graph, start, goal);
  add(graph, goal, goal);
  for (int y = 0; y <= map->height; y++) {
    for (int x = 0; x <= map->width; x++) {
      if (map->corners[y * (map->width + 1) + x] == EXACT_CONVEX) {
        add(graph, (exact_point_t){(int64_t)x * EXACT_UNIT, (int64_t)y * EXACT_UNIT}, goal);
      }
    }
  }
  graph->vertices[0].from_start = 0.0;
  return true;
}

/** The vertex to expand next, -1 when none is left. */
static int most_promising(const graph_t *graph) {
  int best = -1;
  double least = INFINITY;
  for (int i = 0; i < graph->count; i++) {
    const vertex_t *vertex = &graph->vertices[i];
    if (!vertex->done && vertex->from_start + vertex->to_goal < least) {
      least = vertex->from_start + vertex->to_goal;
      best = i;
    }
  }
  return best;
}

static void expand(graph_t *graph, int from) {
  const vertex_t *vertex = &graph->vertices[from];
  const vertex_t *goal = &graph->vertices[1];
  for (int i = 0; i < graph->count; i++) {
    vertex_t *next = &graph->vertices[i];
    double through = vertex->from_start + distance(vertex->at, next->at);
    if (!next->done && through < next->from_start &&
        through + next->to_goal < goal->from_start + 1.0e-9 &&
        exact_segment_free(graph->map, vertex->at, next->at, 0)) {
      next->from_start = through;
      next->before = from;
    }
  }
}

static int write_way(const graph_t *graph, double *xy_cells, int capacity) {
  int count = 0;
  for (int i = 1; i >= 0; i = graph->vertices[i].before) {
    count++;
  }
  int at = count;
  for (int i = 1; i >= 0 && xy_cells != 0; i = graph->vertices[i].before) {
    at--;
    if (at < capacity) {
      xy_cells[2 * at] = (double)graph->vertices[i].at.x / EXACT_UNIT;
      xy_cells[2 * at + 1] = (double)graph->vertices[i].at.y / EXACT_UNIT;
    }
  }
  return count;
}

double exact_optimum(const exact_map_t *map, exact_point_t start, exact_point_t goal,
                     double *xy_cells, int capacity, int *count) {
  graph_t graph;
  *count = 0;
  if (!make_graph(&graph, map, start, goal)) {
    return -1.0;
  }
  int from = most_promising(&graph);
  while (from > 1 || from == 0) {
    graph.vertices[from].done = true;
    expand(&graph, from);
    from = most_promising(&graph);
  }
  double length = from == 1 ? graph.vertices[1].from_start : -1.0;
  if (from == 1) {
    *count = write_way(&graph, xy_cells, capacity);
  }
  free(graph.vertices);
  return length;
}

int exact_reach(const exact_map_t *map, int x, int y, uint8_t *reached) {
  static const int STEPS[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  size_t size = (size_t)map->width * (size_t)map->height;
  int *queue = malloc(size * sizeof *queue);
  int first = 0;
  int count = 0;
  memset(reached, 0, size);
  if (queue == 0 || exact_blocked(map, x, y)) {
    free(queue);
    return 0;
  }
  queue[count++] = y * map->width + x;
  reached[queue[0]] = 1;
  while (first < count) {
    int cell = queue[first++];
    for (int k = 0; k < 4; k++) {
      int nx = cell % map->width + STEPS[k][0];
      int ny = cell / map->width + STEPS[k][1];
      if (!exact_blocked(map, nx, ny) && !reached[ny * map->width + nx]) {
        reached[ny * map->width + nx] = 1;
        queue[count++] = ny * map->width + nx;
      }
    }
  }
  free(queue);
  return count;
}

static double to_box(double x, double y, int cell_x, int cell_y) {
  double dx = fmax(fmax(cell_x - x, x - cell_x - 1.0), 0.0);
  double dy = fmax(fmax(cell_y - y, y - cell_y - 1.0), 0.0);
  return hypot(dx, dy);
}

static double to_segment(double x, double y, const double leg[4]) {
  double dx = leg[2] - leg[0];
  double dy = leg[3] - leg[1];
  double square = dx * dx + dy * dy;
  double part = square > 0.0 ? ((x - leg[0]) * dx + (y - leg[1]) * dy) / square : 0.0;
  part = fmin(fmax(part, 0.0), 1.0);
  return hypot(leg[0] + part * dx - x, leg[1] + part * dy - y);
}

/** Of a leg that does not cross the cell: then an end or a corner is nearest. */
static double leg_to_cell(const double leg[4], int x, int y) {
  double nearest = fmin(to_box(leg[0], leg[1], x, y), to_box(leg[2], leg[3], x, y));
  for (int corner = 0; corner < 4; corner++) {
    nearest = fmin(nearest, to_segment(x + corner % 2, y + corner / 2, leg));
  }
  return nearest;
}

double exact_way_clearance(const exact_map_t *map, const double *xy_cells, int count) {
  double nearest = INFINITY;
  for (int i = 0; i + 1 < count; i++) {
    const double *leg = &xy_cells[2 * i];
    if (exact_way_length(map, leg, 2, 0) < 0.0) {
      return 0.0;
    }
    for (int cell = 0; cell < map->width * map->height; cell++) {
      if (map->cells[cell]) {
        nearest = fmin(nearest, leg_to_cell(leg, cell % map->width, cell / map->width));
      }
    }
  }
  return nearest;
}
