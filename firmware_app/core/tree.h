// SPDX-License-Identifier: GPL-3.0-or-later
/** @file tree.h  Two trees in one fixed pool of nodes, with buckets to find neighbours.
 *
 * Sides: the tree rooted at the goal, and, until the two have met, the tree rooted at the start.
 * Nodes are sorted into 8 x 8 buckets of 16 x 16 cells, so that a search for neighbours looks at
 * its surroundings alone. The cost of a node is the length along the tree to its root. */
#ifndef TREE_H
#define TREE_H

#include <stdbool.h>
#include <stdint.h>

#include "lattice.h"

enum {
  TREE_NODES = 320, ///< size of the pool
  TREE_NEAR = 24,   ///< most neighbours that tree_near() returns
  TREE_BUCKET_SIDE = 8,
  TREE_BUCKETS = TREE_BUCKET_SIDE * TREE_BUCKET_SIDE,
  TREE_NONE = -1,
};

typedef enum { TREE_OF_GOAL, TREE_OF_START, TREE_SIDES } tree_side_t;

typedef struct {
  lattice_t at;
  int16_t parent;
  int16_t child;    ///< its first child
  int16_t sibling;  ///< next child of its parent
  int16_t next;     ///< next node in its bucket; in a dropped node, the next dropped one
  float cost_cells; ///< length to the root; negative if the node was dropped
} tree_node_t;

typedef struct {
  tree_node_t nodes[TREE_NODES];
  int16_t buckets[TREE_SIDES][TREE_BUCKETS];
  int16_t count;   ///< nodes of the pool that were used at any time
  int16_t dropped; ///< first dropped node, to be used again; TREE_NONE if there is none
} tree_t;

/** The nodes around a point, at most the TREE_NEAR nearest, in no order. */
typedef struct {
  int16_t nodes[TREE_NEAR];
  float distance_cells[TREE_NEAR];
  int count;
} tree_near_t;

void tree_clear(tree_t *tree);
bool tree_is_full(const tree_t *tree);
/** Add a child, or a root (parent TREE_NONE). @return the node, TREE_NONE if the pool is full */
int tree_add(tree_t *tree, tree_side_t side, lattice_t at, int parent);
/** Free a node of the goal's side that has no children and is not the root. */
void tree_drop(tree_t *tree, int node);
/** Move a node and its descendants to another parent, which must not be one of them; updates their
 * costs. */
void tree_move(tree_t *tree, int node, int parent);
/** Join the trees: the start's tree, re-rooted at its node `from_start`, becomes a child of `to`, a
 * node of the goal's side. */
void tree_join(tree_t *tree, int to, int from_start);
/** Nearest node of a side; TREE_NONE if the side is empty. */
int tree_nearest(const tree_t *tree, tree_side_t side, lattice_t at);
/** Nodes of the goal's side that are nearer than radius_cells. */
void tree_near(const tree_t *tree, lattice_t at, int radius_cells, tree_near_t *near);
/** The node of the goal's side exactly at this point, or TREE_NONE. */
int tree_find(const tree_t *tree, lattice_t at);

#endif
