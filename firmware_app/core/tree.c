// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("O2", "fp-contract=off")
#include "tree.h"

#include <math.h>
#include <string.h>

enum { BUCKET_BITS = 15 - 3 /* a coordinate has 15 bits, its upper 3 choose the bucket */ };

static const float DROPPED = -1.0f; ///< cost of a dropped node
static const float CELLS_PER_STEP = 1.0f / LATTICE_PER_CELL;

static int bucket_of(lattice_t at) {
  return (at.y >> BUCKET_BITS) * TREE_BUCKET_SIDE + (at.x >> BUCKET_BITS);
}

static uint32_t squared_steps(lattice_t a, lattice_t b) {
  int32_t dx = a.x - b.x;
  int32_t dy = a.y - b.y;
  return (uint32_t)(dx * dx) + (uint32_t)(dy * dy);
}

void tree_clear(tree_t *tree) {
  memset(tree->buckets, 0xFF, sizeof tree->buckets);
  tree->count = 0;
  tree->dropped = TREE_NONE;
}

bool tree_is_full(const tree_t *tree) {
  return tree->dropped == TREE_NONE && tree->count == TREE_NODES;
}

static void link_child(tree_t *tree, int child, int parent) {
  tree->nodes[child].parent = (int16_t)parent;
  tree->nodes[child].sibling = tree->nodes[parent].child;
  tree->nodes[parent].child = (int16_t)child;
}

static void unlink_child(tree_t *tree, int child) {
  int16_t *link = &tree->nodes[tree->nodes[child].parent].child;
  while (*link != child) {
    link = &tree->nodes[*link].sibling;
  }
  *link = tree->nodes[child].sibling;
}

/** Cost of a node, from the cost of its parent. */
static float cost_of(const tree_t *tree, int node) {
  const tree_node_t *below = &tree->nodes[node];
  const tree_node_t *above = &tree->nodes[below->parent];
  return above->cost_cells + lattice_distance(below->at, above->at);
}

int tree_add(tree_t *tree, tree_side_t side, lattice_t at, int parent) {
  int i = tree->dropped;
  if (i != TREE_NONE) {
    tree->dropped = tree->nodes[i].next;
  } else if (tree->count < TREE_NODES) {
    i = tree->count++;
  } else {
    return TREE_NONE;
  }
  int16_t *bucket = &tree->buckets[side][bucket_of(at)];
  tree->nodes[i] = (tree_node_t){
      .at = at,
      .parent = TREE_NONE,
      .child = TREE_NONE,
      .sibling = TREE_NONE,
      .next = *bucket,
  };
  *bucket = (int16_t)i;
  if (parent != TREE_NONE) {
    link_child(tree, i, parent);
    tree->nodes[i].cost_cells = cost_of(tree, i);
  }
  return i;
}

void tree_drop(tree_t *tree, int node) {
  int16_t *link = &tree->buckets[TREE_OF_GOAL][bucket_of(tree->nodes[node].at)];
  while (*link != node) {
    link = &tree->nodes[*link].next;
  }
  *link = tree->nodes[node].next;
  unlink_child(tree, node);
  tree->nodes[node].cost_cells = DROPPED;
  tree->nodes[node].next = tree->dropped;
  tree->dropped = (int16_t)node;
}

/** The node after i in a depth-first walk through the subtree of root; TREE_NONE at its end. */
static int next_below(const tree_t *tree, int root, int i) {
  if (tree->nodes[i].child != TREE_NONE) {
    return tree->nodes[i].child;
  }
  while (i != root && tree->nodes[i].sibling == TREE_NONE) {
    i = tree->nodes[i].parent;
  }
  return i == root ? TREE_NONE : tree->nodes[i].sibling;
}

/** Add to the costs of a node and its descendants. */
static void add_cost(tree_t *tree, int top, float cost_cells) {
  for (int i = top; i != TREE_NONE; i = next_below(tree, top, i)) {
    tree->nodes[i].cost_cells += cost_cells;
  }
}

/** Compute the costs of a node and its descendants from that of its parent. */
static void update_costs(tree_t *tree, int top) {
  for (int i = top; i != TREE_NONE; i = next_below(tree, top, i)) {
    tree->nodes[i].cost_cells = cost_of(tree, i);
  }
}

void tree_move(tree_t *tree, int node, int parent) {
  unlink_child(tree, node);
  link_child(tree, node, parent);
  add_cost(tree, node, cost_of(tree, node) - tree->nodes[node].cost_cells);
}

void tree_join(tree_t *tree, int to, int from_start) {
  // Reverse the edges from from_start up to the root of its tree.
  int above = to;
  int i = from_start;
  while (i != TREE_NONE) {
    int parent = tree->nodes[i].parent;
    if (parent != TREE_NONE) {
      unlink_child(tree, i);
    }
    link_child(tree, i, above);
    above = i;
    i = parent;
  }
  // Append the start's buckets to those of the goal.
  for (int b = 0; b < TREE_BUCKETS; b++) {
    int16_t *link = &tree->buckets[TREE_OF_GOAL][b];
    while (*link != TREE_NONE) {
      link = &tree->nodes[*link].next;
    }
    *link = tree->buckets[TREE_OF_START][b];
    tree->buckets[TREE_OF_START][b] = TREE_NONE;
  }
  update_costs(tree, from_start);
}

/** A search for the nearest node. */
typedef struct {
  const tree_t *tree;
  const int16_t *buckets;
  lattice_t at;
  uint32_t squared; ///< squared distance of the nearest node so far [lattice steps^2]
  int node;
} nearest_t;

static void look_in_bucket(nearest_t *nearest, int bx, int by) {
  const tree_node_t *nodes = nearest->tree->nodes;
  for (int i = nearest->buckets[by * TREE_BUCKET_SIDE + bx]; i != TREE_NONE; i = nodes[i].next) {
    uint32_t squared = squared_steps(nodes[i].at, nearest->at);
    if (squared < nearest->squared) {
      nearest->squared = squared;
      nearest->node = i;
    }
  }
}

/** Search the square ring of buckets that are `ring` buckets away from (bx, by). */
static void look_in_ring(nearest_t *nearest, int bx, int by, int ring) {
  for (int y = by - ring; y <= by + ring; y++) {
    if (y < 0 || y >= TREE_BUCKET_SIDE) {
      continue;
    }
    int step = y == by - ring || y == by + ring ? 1 : 2 * ring;
    for (int x = bx - ring; x <= bx + ring; x += step) {
      if (x >= 0 && x < TREE_BUCKET_SIDE) {
        look_in_bucket(nearest, x, y);
      }
    }
  }
}

static int32_t smaller(int32_t a, int32_t b) {
  return a < b ? a : b;
}

/** Distance from a point to the nearest bucket of a ring around it [lattice steps]. */
static int32_t steps_to_ring(lattice_t at, int ring) {
  const int32_t side = 1 << BUCKET_BITS;
  int32_t x = at.x & (side - 1);
  int32_t y = at.y & (side - 1);
  return (ring - 1) * side + smaller(smaller(x, side - x), smaller(y, side - y));
}

int tree_nearest(const tree_t *tree, tree_side_t side, lattice_t at) {
  nearest_t nearest = {tree, tree->buckets[side], at, UINT32_MAX, TREE_NONE};
  int bx = at.x >> BUCKET_BITS;
  int by = at.y >> BUCKET_BITS;
  look_in_bucket(&nearest, bx, by);
  for (int ring = 1; ring < TREE_BUCKET_SIDE; ring++) {
    int32_t away = steps_to_ring(at, ring);
    if (nearest.squared <= (uint32_t)(away * away)) {
      break;
    }
    look_in_ring(&nearest, bx, by, ring);
  }
  return nearest.node;
}

/** Add a node to the near ones; if there are too many, the farthest is left out. */
static void take(tree_near_t *near, int node, float distance_cells) {
  int place = near->count;
  if (place == TREE_NEAR) {
    place = 0;
    for (int i = 1; i < TREE_NEAR; i++) {
      place = near->distance_cells[i] > near->distance_cells[place] ? i : place;
    }
    if (near->distance_cells[place] <= distance_cells) {
      return;
    }
  } else {
    near->count++;
  }
  near->nodes[place] = (int16_t)node;
  near->distance_cells[place] = distance_cells;
}

/** Bucket column or row of a coordinate, clamped to the grid. */
static int bucket_within(int32_t steps) {
  return steps < 0 ? 0 : steps > LATTICE_MAX ? TREE_BUCKET_SIDE - 1 : steps >> BUCKET_BITS;
}

void tree_near(const tree_t *tree, lattice_t at, int radius_cells, tree_near_t *near) {
  int32_t radius = radius_cells * LATTICE_PER_CELL;
  uint32_t limit = (uint32_t)(radius * radius);
  near->count = 0;
  for (int y = bucket_within(at.y - radius); y <= bucket_within(at.y + radius); y++) {
    for (int x = bucket_within(at.x - radius); x <= bucket_within(at.x + radius); x++) {
      for (int i = tree->buckets[TREE_OF_GOAL][y * TREE_BUCKET_SIDE + x]; i != TREE_NONE;
           i = tree->nodes[i].next) {
        uint32_t squared = squared_steps(tree->nodes[i].at, at);
        if (squared < limit) {
          take(near, i, sqrtf((float)squared) * CELLS_PER_STEP);
        }
      }
    }
  }
}

int tree_find(const tree_t *tree, lattice_t at) {
  int i = tree->buckets[TREE_OF_GOAL][bucket_of(at)];
  while (i != TREE_NONE && !lattice_equal(tree->nodes[i].at, at)) {
    i = tree->nodes[i].next;
  }
  return i;
}
