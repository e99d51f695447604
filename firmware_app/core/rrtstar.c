// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "rrtstar.h"

#include <math.h>
#include <string.h>

enum {
  UNITS_PER_CELL = 512,
  BUCKET_CELLS = GRID_SIDE_CELLS / RRTSTAR_BUCKET_SIDE,
  DRAWS_MAX = 8, ///< of one sample, until it is free
};

static const float HUGE_CELLS = 1.0e9f;
static const float MIN_EDGE_CELLS = 0.05f;
static const float PI = 3.14159265f;

rrtstar_config_t rrtstar_config_default(void) {
  return (rrtstar_config_t){.step_cells = 14.0f, .goal_bias = 0.06f};
}

static vec2_t node_at(const rrtstar_t *rrt, int i) {
  const rrtstar_node_t *node = &rrt->nodes[i];
  return (vec2_t){(float)node->x * (1.0f / UNITS_PER_CELL),
                  (float)node->y * (1.0f / UNITS_PER_CELL)};
}

/** The position as a node can hold it. */
static vec2_t quantised(vec2_t p) {
  return (vec2_t){(float)(uint16_t)(p.x * UNITS_PER_CELL) * (1.0f / UNITS_PER_CELL),
                  (float)(uint16_t)(p.y * UNITS_PER_CELL) * (1.0f / UNITS_PER_CELL)};
}

static int bucket_coordinate(float cells) {
  return (int)geometry_clamp(cells, 0.0f, (float)GRID_SIDE_CELLS - 1.0f) / BUCKET_CELLS;
}

static void link_child(rrtstar_t *rrt, int child, int parent) {
  rrt->nodes[child].parent = (int16_t)parent;
  rrt->nodes[child].sibling = rrt->nodes[parent].child;
  rrt->nodes[parent].child = (int16_t)child;
}

static void unlink_child(rrtstar_t *rrt, int child) {
  int16_t *link = &rrt->nodes[rrt->nodes[child].parent].child;
  while (*link != child) {
    link = &rrt->nodes[*link].sibling;
  }
  *link = rrt->nodes[child].sibling;
}

static int add_node(rrtstar_t *rrt, vec2_t p, int parent, float cost_cells) {
  int i = rrt->count++;
  int16_t *bucket =
      &rrt->buckets[bucket_coordinate(p.y) * RRTSTAR_BUCKET_SIDE + bucket_coordinate(p.x)];
  rrt->nodes[i] = (rrtstar_node_t){
      .x = (uint16_t)(p.x * UNITS_PER_CELL),
      .y = (uint16_t)(p.y * UNITS_PER_CELL),
      .parent = RRTSTAR_NONE,
      .child = RRTSTAR_NONE,
      .sibling = RRTSTAR_NONE,
      .next = *bucket,
      .cost_cells = cost_cells,
  };
  *bucket = (int16_t)i;
  if (parent != RRTSTAR_NONE) {
    link_child(rrt, i, parent);
  }
  return i;
}

/** Let a better way be known if the goal is in sight of node i. */
static void try_goal(rrtstar_t *rrt, const clearance_t *clearance, int i) {
  vec2_t p = node_at(rrt, i);
  float through = rrt->nodes[i].cost_cells + vec2_distance(p, rrt->goal_cells);
  if (through < rrt->best_cells && clearance_segment_free(clearance, p, rrt->goal_cells)) {
    rrt->best_cells = through;
    rrt->goal_parent = (int16_t)i;
    rrt->status = RRTSTAR_FOUND;
  }
}

rrtstar_status_t rrtstar_start(rrtstar_t *rrt, const rrtstar_config_t *cfg,
                               const clearance_t *clearance, vec2_t start_cells, vec2_t goal_cells,
                               uint32_t seed) {
  memset(rrt, 0, sizeof *rrt);
  memset(rrt->buckets, 0xFF, sizeof rrt->buckets);
  rrt->cfg = *cfg;
  rrt->rng = rng_seed(seed);
  rrt->best_cells = HUGE_CELLS;
  rrt->goal_parent = RRTSTAR_NONE;
  rrt->status = RRTSTAR_SEARCHING;
  if (clearance_blocked_at(clearance, start_cells)) {
    rrt->status = RRTSTAR_START_BLOCKED;
  } else if (clearance_blocked_at(clearance, goal_cells)) {
    rrt->status = RRTSTAR_GOAL_BLOCKED;
  } else {
    rrt->start_cells = quantised(start_cells);
    rrt->goal_cells = quantised(goal_cells);
    add_node(rrt, rrt->start_cells, RRTSTAR_NONE, 0.0f);
    try_goal(rrt, clearance, 0);
  }
  return rrt->status;
}

/** Uniform in the ellipse of all points through which a way could beat the best (Gammell 2014,
 * algorithm 2). */
static vec2_t sample_ellipse(rrtstar_t *rrt) {
  vec2_t axis = vec2_sub(rrt->goal_cells, rrt->start_cells);
  float focal = vec2_norm(axis);
  vec2_t along = focal > 0.0f ? vec2_scale(axis, 1.0f / focal) : (vec2_t){1.0f, 0.0f};
  float radius = sqrtf(rng_uniform(&rrt->rng));
  sincos_t turn = geometry_sincos((2.0f * rng_uniform(&rrt->rng) - 1.0f) * PI);
  float minor = rrt->best_cells * rrt->best_cells - focal * focal;
  float u = 0.5f * rrt->best_cells * radius * turn.cos;
  float v = 0.5f * sqrtf(minor > 0.0f ? minor : 0.0f) * radius * turn.sin;
  vec2_t centre = vec2_scale(vec2_add(rrt->start_cells, rrt->goal_cells), 0.5f);
  return (vec2_t){centre.x + along.x * u - along.y * v, centre.y + along.y * u + along.x * v};
}

static vec2_t sample_grid(rrtstar_t *rrt) {
  float x = rng_uniform(&rrt->rng) * (float)GRID_SIDE_CELLS;
  float y = rng_uniform(&rrt->rng) * (float)GRID_SIDE_CELLS;
  return (vec2_t){x, y};
}

/** A free point to grow towards; false if none was drawn in time. */
static bool sample(rrtstar_t *rrt, const clearance_t *clearance, vec2_t *p) {
  if (rrt->goal_parent == RRTSTAR_NONE && rng_uniform(&rrt->rng) < rrt->cfg.goal_bias) {
    *p = rrt->goal_cells;
    return true;
  }
  for (int draw = 0; draw < DRAWS_MAX; draw++) {
    *p = rrt->goal_parent == RRTSTAR_NONE ? sample_grid(rrt) : sample_ellipse(rrt);
    if (!clearance_blocked_at(clearance, *p)) {
      return true;
    }
  }
  return false;
}

static int nearest_in_bucket(const rrtstar_t *rrt, int bx, int by, vec2_t p, int nearest,
                             float *distance) {
  if (bx < 0 || by < 0 || bx >= RRTSTAR_BUCKET_SIDE || by >= RRTSTAR_BUCKET_SIDE) {
    return nearest;
  }
  for (int i = rrt->buckets[by * RRTSTAR_BUCKET_SIDE + bx]; i != RRTSTAR_NONE;
       i = rrt->nodes[i].next) {
    float d = vec2_distance(node_at(rrt, i), p);
    if (d < *distance) {
      *distance = d;
      nearest = i;
    }
  }
  return nearest;
}

/** Search rings of buckets outwards until no nearer node can follow. */
static int nearest_node(const rrtstar_t *rrt, vec2_t p, float *distance) {
  int bx = bucket_coordinate(p.x);
  int by = bucket_coordinate(p.y);
  int nearest = RRTSTAR_NONE;
  *distance = HUGE_CELLS;
  for (int ring = 0; ring < RRTSTAR_BUCKET_SIDE; ring++) {
    if (*distance <= (float)((ring - 1) * BUCKET_CELLS)) {
      break;
    }
    for (int y = by - ring; y <= by + ring; y++) {
      bool whole_row = y == by - ring || y == by + ring;
      for (int x = bx - ring; x <= bx + ring; x += whole_row ? 1 : 2 * ring) {
        nearest = nearest_in_bucket(rrt, x, y, p, nearest, distance);
      }
    }
  }
  return nearest;
}

/** Natural logarithm of a small count, within 1 %: exponent and a parabola through the mantissa. */
static float log_count(int n) {
  float x = (float)n;
  float log2 = 0.0f;
  while (x >= 2.0f) {
    x *= 0.5f;
    log2 += 1.0f;
  }
  float m = x - 1.0f;
  return 0.69314718f * (log2 + m * (1.3465553f - 0.3465553f * m));
}

static void find_near(rrtstar_t *rrt, vec2_t p) {
  float n = (float)rrt->count;
  float area = (float)GRID_CELLS;
  // gamma of eq. (11) for the plane: 2 sqrt(1 + 1/2) sqrt(area / pi), the area being at most the
  // whole grid.
  float radius = 2.0f * sqrtf(1.5f * area / PI * log_count(rrt->count + 1) / (n + 1.0f));
  radius = radius < rrt->cfg.step_cells ? radius : rrt->cfg.step_cells;
  rrt->near_count = 0;
  for (int by = bucket_coordinate(p.y - radius); by <= bucket_coordinate(p.y + radius); by++) {
    for (int bx = bucket_coordinate(p.x - radius); bx <= bucket_coordinate(p.x + radius); bx++) {
      for (int i = rrt->buckets[by * RRTSTAR_BUCKET_SIDE + bx]; i != RRTSTAR_NONE;
           i = rrt->nodes[i].next) {
        if (rrt->near_count < RRTSTAR_NEAR && vec2_distance(node_at(rrt, i), p) < radius) {
          rrt->near[rrt->near_count++] = (int16_t)i;
        }
      }
    }
  }
}

static int choose_parent(const rrtstar_t *rrt, const clearance_t *clearance, vec2_t p, int nearest,
                         float *cost_cells) {
  int parent = nearest;
  for (int k = 0; k < rrt->near_count; k++) {
    int i = rrt->near[k];
    float through = rrt->nodes[i].cost_cells + vec2_distance(node_at(rrt, i), p);
    if (i != nearest && through < *cost_cells &&
        clearance_segment_free(clearance, node_at(rrt, i), p)) {
      *cost_cells = through;
      parent = i;
    }
  }
  return parent;
}

/** Take `saved` off the cost of every node below root, root included. */
static void lower_subtree(rrtstar_t *rrt, int root, float saved) {
  int i = root;
  for (;;) {
    rrt->nodes[i].cost_cells -= saved;
    if (rrt->nodes[i].child != RRTSTAR_NONE) {
      i = rrt->nodes[i].child;
      continue;
    }
    while (i != root && rrt->nodes[i].sibling == RRTSTAR_NONE) {
      i = rrt->nodes[i].parent;
    }
    if (i == root) {
      return;
    }
    i = rrt->nodes[i].sibling;
  }
}

static void rewire(rrtstar_t *rrt, const clearance_t *clearance, int through) {
  vec2_t p = node_at(rrt, through);
  for (int k = 0; k < rrt->near_count; k++) {
    int i = rrt->near[k];
    float saved = rrt->nodes[i].cost_cells - rrt->nodes[through].cost_cells -
                  vec2_distance(p, node_at(rrt, i));
    if (saved > 1.0e-3f && i != rrt->nodes[through].parent &&
        clearance_segment_free(clearance, p, node_at(rrt, i))) {
      unlink_child(rrt, i);
      link_child(rrt, i, through);
      lower_subtree(rrt, i, saved);
    }
  }
  if (rrt->goal_parent != RRTSTAR_NONE) {
    rrt->best_cells = rrt->nodes[rrt->goal_parent].cost_cells +
                      vec2_distance(node_at(rrt, rrt->goal_parent), rrt->goal_cells);
  }
}

/** One iteration of algorithm 6. */
static void grow(rrtstar_t *rrt, const clearance_t *clearance) {
  vec2_t target;
  float distance;
  if (!sample(rrt, clearance, &target)) {
    return;
  }
  int nearest = nearest_node(rrt, target, &distance);
  vec2_t from = node_at(rrt, nearest);
  if (distance > rrt->cfg.step_cells) {
    target = vec2_add(from, vec2_scale(vec2_sub(target, from), rrt->cfg.step_cells / distance));
  }
  target = quantised(target);
  distance = vec2_distance(from, target);
  if (distance < MIN_EDGE_CELLS || !clearance_segment_free(clearance, from, target)) {
    return;
  }
  float cost_cells = rrt->nodes[nearest].cost_cells + distance;
  find_near(rrt, target);
  int parent = choose_parent(rrt, clearance, target, nearest, &cost_cells);
  if (cost_cells + vec2_distance(target, rrt->goal_cells) >= rrt->best_cells) {
    return; // no way through here can beat the best
  }
  int added = add_node(rrt, target, parent, cost_cells);
  rewire(rrt, clearance, added);
  try_goal(rrt, clearance, added);
}

rrtstar_status_t rrtstar_extend(rrtstar_t *rrt, const clearance_t *clearance, int budget) {
  for (int i = 0; i < budget; i++) {
    if (rrt->status != RRTSTAR_SEARCHING && rrt->status != RRTSTAR_FOUND) {
      break;
    }
    if (rrt->count == RRTSTAR_NODES) {
      rrt->status = RRTSTAR_POOL_FULL;
      break;
    }
    rrt->iterations++;
    grow(rrt, clearance);
  }
  return rrt->status;
}

int rrtstar_path(const rrtstar_t *rrt, vec2_t *path_cells, int capacity) {
  int count = 1;
  for (int i = rrt->goal_parent; i != RRTSTAR_NONE; i = rrt->nodes[i].parent) {
    count++;
  }
  if (count < 2 || count > capacity) {
    return 0;
  }
  int at = count - 1;
  path_cells[at--] = rrt->goal_cells;
  for (int i = rrt->goal_parent; i != RRTSTAR_NONE; i = rrt->nodes[i].parent) {
    path_cells[at--] = node_at(rrt, i);
  }
  return count;
}
