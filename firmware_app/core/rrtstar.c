// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "rrtstar.h"

#include <math.h>

enum {
  NEAR_CELLS = 24,  ///< radius within which RRT* rewires
  MEETINGS_MAX = 8, ///< most steps of one tree towards the new node of the other
  DRAWS_MAX = 8,    ///< most draws for a sample that is free
  WORST_OF = 24,    ///< nodes among which make_room() looks for one to drop
  COORDINATE_MASK = LATTICE_MAX,
};

static const float HUGE_CELLS = 1.0e9f;
static const float FOCUS_CELLS = 10.0f;              ///< rrtstar_mend: focus_cells at first
static const float FOCUS_GROWTH_CELLS = 2.0f;        ///< growth of focus_cells with every sample
static const float LEAST_GAIN_CELLS = 1.0f / 128.0f; ///< a smaller one is not worth rewiring
static const float PI = 3.14159265f;

static const tree_node_t *node_of(const rrtstar_t *rrt, int i) {
  return &rrt->tree.nodes[i];
}

void rrtstar_start(rrtstar_t *rrt, lattice_t start, lattice_t goal, float step_cells,
                   uint32_t seed) {
  tree_clear(&rrt->tree);
  rrt->rng = rng_seed(seed);
  rrt->start = start;
  rrt->goal = goal;
  rrt->step_cells = step_cells;
  rrt->focus_cells = HUGE_CELLS;
  rrt->best_cells = HUGE_CELLS;
  rrt->connected = false;
  rrt->steps = 0;
  (void)tree_add(&rrt->tree, TREE_OF_GOAL, goal, TREE_NONE);
  rrt->start_node = (int16_t)tree_add(&rrt->tree, TREE_OF_START, start, TREE_NONE);
}

bool rrtstar_stuck(const rrtstar_t *rrt) {
  return !rrt->connected && tree_is_full(&rrt->tree);
}

/** The point a step from a towards b, or b if that is nearer. */
static lattice_t towards(lattice_t a, lattice_t b, float step_cells) {
  float distance_cells = lattice_distance(a, b);
  if (distance_cells <= step_cells) {
    return b;
  }
  float t = step_cells / distance_cells;
  return (lattice_t){(int16_t)(a.x + (int)((float)(b.x - a.x) * t)),
                     (int16_t)(a.y + (int)((float)(b.y - a.y) * t))};
}

static bool is_blocked(const clearance_t *clearance, lattice_t p) {
  return clearance_blocked(clearance, p.x >> LATTICE_BITS, p.y >> LATTICE_BITS);
}

/** Uniform in the square about the focus. */
static lattice_t draw_about_focus(rrtstar_t *rrt) {
  float dx = (2.0f * rng_uniform(&rrt->rng) - 1.0f) * rrt->focus_cells;
  float dy = (2.0f * rng_uniform(&rrt->rng) - 1.0f) * rrt->focus_cells;
  return lattice_from_cells(vec2_add(lattice_to_cells(rrt->focus), (vec2_t){dx, dy}));
}

/** Draw a free point, uniformly from the grid or from around the focus. @return false if none of
 * DRAWS_MAX points was free */
static bool draw_free(rrtstar_t *rrt, const clearance_t *clearance, lattice_t *p) {
  bool focused = rrt->focus_cells < (float)GRID_SIDE_CELLS;
  rrt->focus_cells += focused ? FOCUS_GROWTH_CELLS : 0.0f;
  for (int i = 0; i < DRAWS_MAX; i++) {
    if (focused) {
      *p = draw_about_focus(rrt);
    } else {
      uint32_t bits = rng_next(&rrt->rng);
      *p = (lattice_t){(int16_t)(bits & COORDINATE_MASK), (int16_t)(bits >> 16 & COORDINATE_MASK)};
    }
    if (!is_blocked(clearance, *p)) {
      return true;
    }
  }
  return false;
}

/** Find the node of a side that is nearest to `to`, and the point *at up to a step from it.
 * @return the node, TREE_NONE if the point is not in its sight */
static int reach(const rrtstar_t *rrt, const clearance_t *clearance, tree_side_t side, lattice_t to,
                 lattice_t *at) {
  int nearest = tree_nearest(&rrt->tree, side, to);
  lattice_t from = node_of(rrt, nearest)->at;
  *at = towards(from, to, rrt->step_cells);
  return clearance_sees(clearance, from, *at) ? nearest : TREE_NONE;
}

/** Add a node up to a step from the nearest node of a side. @return it, or TREE_NONE */
static int extend(rrtstar_t *rrt, const clearance_t *clearance, tree_side_t side, lattice_t to) {
  lattice_t at;
  int nearest = reach(rrt, clearance, side, to, &at);
  bool new_place = nearest != TREE_NONE && !lattice_equal(node_of(rrt, nearest)->at, at);
  return new_place ? tree_add(&rrt->tree, side, at, nearest) : TREE_NONE;
}

/** Make one tree of the two, which meet at a node of each. */
static void join(rrtstar_t *rrt, int of_goal, int of_start) {
  tree_join(&rrt->tree, of_goal, of_start);
  rrt->connected = true;
}

/** Grow the tree of a side step by step towards a node of the other. @return true if they met */
static bool meet(rrtstar_t *rrt, const clearance_t *clearance, tree_side_t side, int node) {
  lattice_t to = node_of(rrt, node)->at;
  for (int i = 0; i < MEETINGS_MAX; i++) {
    rrt->steps++;
    lattice_t at;
    int nearest = reach(rrt, clearance, side, to, &at);
    if (nearest == TREE_NONE) {
      return false;
    }
    if (lattice_equal(at, to)) {
      join(rrt, side == TREE_OF_GOAL ? nearest : node, side == TREE_OF_GOAL ? node : nearest);
      return true;
    }
    if (tree_add(&rrt->tree, side, at, nearest) == TREE_NONE) {
      return false;
    }
  }
  return false;
}

/** One iteration of RRT-Connect; which tree grows first is random. */
static bool connect(rrtstar_t *rrt, const clearance_t *clearance) {
  lattice_t p;
  if (!draw_free(rrt, clearance, &p)) {
    return false;
  }
  tree_side_t side = rng_next(&rrt->rng) >> 31 != 0u ? TREE_OF_START : TREE_OF_GOAL;
  int node = extend(rrt, clearance, side, p);
  return node != TREE_NONE &&
         meet(rrt, clearance, side == TREE_OF_GOAL ? TREE_OF_START : TREE_OF_GOAL, node);
}

/** Draw a point uniformly from the ellipse of all points that a path shorter than the best one may
 * pass (Gammell 2014, algorithm 2). @return false if the point is outside the grid or blocked */
__attribute__((noinline)) static bool draw_informed(rrtstar_t *rrt, const clearance_t *clearance,
                                                    lattice_t *p) {
  vec2_t start = lattice_to_cells(rrt->start);
  vec2_t goal = lattice_to_cells(rrt->goal);
  vec2_t axis = vec2_sub(goal, start);
  float focal = vec2_norm(axis);
  vec2_t along = focal > 0.0f ? vec2_scale(axis, 1.0f / focal) : (vec2_t){1.0f, 0.0f};
  float radius = sqrtf(rng_uniform(&rrt->rng));
  sincos_t turn = geometry_sincos((2.0f * rng_uniform(&rrt->rng) - 1.0f) * PI);
  float minor = rrt->best_cells * rrt->best_cells - focal * focal;
  float u = 0.5f * rrt->best_cells * radius * turn.cos;
  float v = 0.5f * sqrtf(minor > 0.0f ? minor : 0.0f) * radius * turn.sin;
  vec2_t at = vec2_add(vec2_scale(vec2_add(start, goal), 0.5f),
                       (vec2_t){along.x * u - along.y * v, along.y * u + along.x * v});
  if (clearance_blocked_at(clearance, at)) {
    return false;
  }
  *p = lattice_from_cells(at);
  return true;
}

/** Lower bound of the length of a path from the start to the goal through a node. */
static float hope_cells(const rrtstar_t *rrt, int i) {
  return node_of(rrt, i)->cost_cells + lattice_distance(node_of(rrt, i)->at, rrt->start);
}

/** True if a node may be dropped: a leaf, but not the start, the root or `kept`. */
static bool droppable(const rrtstar_t *rrt, int i, int kept) {
  const tree_node_t *node = node_of(rrt, i);
  return node->cost_cells >= 0.0f && node->child == TREE_NONE && node->parent != TREE_NONE &&
         i != rrt->start_node && i != kept;
}

/** Make room for a node: of a few leaves, drop the one with the longest path through it. `kept` is
 * spared. */
static void make_room(rrtstar_t *rrt, int kept) {
  int worst = TREE_NONE;
  float longest_cells = 0.0f;
  const uint32_t count = (uint32_t)rrt->tree.count;
  uint32_t at = rng_next(&rrt->rng) % count;
  for (int k = 0; k < rrt->tree.count && (k < WORST_OF || worst == TREE_NONE); k++) {
    int i = (int)((at + (uint32_t)k) % count);
    if (droppable(rrt, i, kept) && hope_cells(rrt, i) > longest_cells) {
      longest_cells = hope_cells(rrt, i);
      worst = i;
    }
  }
  if (worst != TREE_NONE) {
    tree_drop(&rrt->tree, worst);
  }
}

/** The parent for a new node at p: of the near nodes in sight, the one by which p costs least;
 * TREE_NONE if it costs cost_cells or more by all of them. */
static int choose_parent(const rrtstar_t *rrt, const clearance_t *clearance, lattice_t p,
                         const tree_near_t *near, float cost_cells) {
  uint32_t tried = 0u;
  for (;;) {
    int best = TREE_NONE;
    float least = cost_cells;
    for (int k = 0; k < near->count; k++) {
      float through = node_of(rrt, near->nodes[k])->cost_cells + near->distance_cells[k];
      if ((tried >> k & 1u) == 0u && through < least) {
        least = through;
        best = k;
      }
    }
    if (best == TREE_NONE) {
      return TREE_NONE;
    }
    int node = near->nodes[best];
    if (node != rrt->start_node && clearance_sees(clearance, node_of(rrt, node)->at, p)) {
      return node;
    }
    tried |= 1u << best;
  }
}

/** True if node i would cost less as a child of `parent`. */
static bool is_cheaper(const rrtstar_t *rrt, int i, int parent) {
  float through = node_of(rrt, parent)->cost_cells +
                  lattice_distance(node_of(rrt, parent)->at, node_of(rrt, i)->at);
  return i != parent && through < node_of(rrt, i)->cost_cells - LEAST_GAIN_CELLS;
}

/** Make node i a child of `parent` if that is cheaper and `parent` is in sight. */
static void improve(rrtstar_t *rrt, const clearance_t *clearance, int i, int parent) {
  if (is_cheaper(rrt, i, parent) &&
      clearance_sees(clearance, node_of(rrt, i)->at, node_of(rrt, parent)->at)) {
    tree_move(&rrt->tree, i, parent);
  }
}

/** One iteration of informed RRT*. */
static void optimise(rrtstar_t *rrt, const clearance_t *clearance) {
  lattice_t p;
  tree_near_t near;
  if (!draw_informed(rrt, clearance, &p)) {
    return;
  }
  float left_cells = rrt->best_cells - lattice_distance(p, rrt->start);
  if (left_cells <= lattice_distance(p, rrt->goal)) {
    return;
  }
  if (tree_is_full(&rrt->tree)) {
    make_room(rrt, TREE_NONE);
  }
  tree_near(&rrt->tree, p, NEAR_CELLS, &near);
  int parent = choose_parent(rrt, clearance, p, &near, left_cells);
  int node = parent == TREE_NONE ? TREE_NONE : tree_add(&rrt->tree, TREE_OF_GOAL, p, parent);
  if (node == TREE_NONE) {
    return;
  }
  for (int k = 0; k < near.count; k++) {
    improve(rrt, clearance, near.nodes[k], node);
  }
  improve(rrt, clearance, rrt->start_node, node);
}

bool rrtstar_sample(rrtstar_t *rrt, const clearance_t *clearance) {
  rrt->steps = 1;
  if (!rrt->connected) {
    return connect(rrt, clearance);
  }
  float before_cells = node_of(rrt, rrt->start_node)->cost_cells;
  optimise(rrt, clearance);
  return node_of(rrt, rrt->start_node)->cost_cells < before_cells;
}

int rrtstar_way(const rrtstar_t *rrt, const clearance_t *clearance, lattice_t *way, int capacity) {
  int count = 0;
  if (!rrt->connected) {
    return 0;
  }
  for (int i = rrt->start_node; i != TREE_NONE; i = node_of(rrt, i)->parent) {
    lattice_t at = node_of(rrt, i)->at;
    if (count >= 2 && clearance_sees(clearance, way[count - 2], at)) {
      count--;
    } else if (count == capacity) {
      return 0;
    }
    way[count++] = at;
  }
  return count;
}

void rrtstar_graft(rrtstar_t *rrt, const lattice_t *way, int count) {
  int above = 0; // the root at the goal is the pool's first node
  for (int k = count - 2; k >= 0; k--) {
    int node = k == 0 ? rrt->start_node : tree_find(&rrt->tree, way[k]);
    if (node == TREE_NONE) {
      if (tree_is_full(&rrt->tree)) {
        make_room(rrt, above);
      }
      node = tree_add(&rrt->tree, TREE_OF_GOAL, way[k], above);
    } else if (is_cheaper(rrt, node, above)) {
      tree_move(&rrt->tree, node, above);
    }
    if (node == TREE_NONE) {
      return; // no node could be dropped to make room for this one
    }
    above = node;
  }
}

void rrtstar_restart_from(rrtstar_t *rrt, const lattice_t *way, int count) {
  tree_clear(&rrt->tree);
  int node = tree_add(&rrt->tree, TREE_OF_GOAL, way[count - 1], TREE_NONE);
  for (int k = count - 2; k >= 0; k--) {
    node = tree_add(&rrt->tree, TREE_OF_GOAL, way[k], node);
  }
  rrt->start_node = (int16_t)node;
  rrt->connected = true;
}

void rrtstar_mend(rrtstar_t *rrt, const lattice_t *way, int count, int before, int after) {
  int near = rrt->start_node;
  for (int k = 1; k <= before; k++) {
    near = tree_add(&rrt->tree, TREE_OF_START, way[k], near);
  }
  int far = 0;
  for (int k = 1; k <= after; k++) {
    far = tree_add(&rrt->tree, TREE_OF_GOAL, way[count - 1 - k], far);
  }
  lattice_t a = node_of(rrt, near)->at;
  lattice_t b = node_of(rrt, far)->at;
  rrt->focus = (lattice_t){(int16_t)((a.x + b.x) / 2), (int16_t)((a.y + b.y) / 2)};
  rrt->focus_cells = FOCUS_CELLS;
}
