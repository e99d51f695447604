// SPDX-License-Identifier: GPL-3.0-or-later
/** @file tree.h  Two trees of nodes in one fixed pool, with a table of buckets to find neighbours.
 *  Sides: nodes that hang on the goal, and nodes that hang on the start until the two have met.
 *  Neighbours come from 8 x 8 buckets of 16 x 16 cells, so that a search looks at the surroundings
 * alone. Costs are lengths along the tree to its root. */
#ifndef TREE_H
#define TREE_H

#include <stdbool.h>
#include <stdint.h>

#include "lattice.h"

enum {
  TREE_NODES = 320,
  TREE_NEAR = 24,
  TREE_BUCKET_SIDE = 8,
  TREE_BUCKETS = TREE_BUCKET_SIDE * TREE_BUCKET_SIDE,
  TREE_NONE = -1,
};

typedef enum { TREE_OF_GOAL, TREE_OF_START, TREE_SIDES } tree_side_t;

typedef struct {
  lattice_t at;
  int16_t parent;
  int16_t child;    ///< first of its children
  int16_t sibling;  ///< next child of its parent
  int16_t next;     ///< next node in its bucket; of a dropped node, the next dropped one
  float cost_cells; ///< to the root; negative: the node was dropped
} tree_node_t;

typedef struct {
  tree_node_t nodes[TREE_NODES];
  int16_t buckets[TREE_SIDES][TREE_BUCKETS];
  int16_t count;   ///< of nodes that were ever used
  int16_t dropped; ///< first of the dropped nodes
} tree_t;

/** The nodes about a place, at most the TREE_NEAR nearest, in no order. */
typedef struct {
  int16_t nodes[TREE_NEAR];
  float distance_cells[TREE_NEAR];
  int count;
} tree_near_t;

void tree_clear(tree_t *tree);
bool tree_is_full(const tree_t *tree);
/** A root (parent TREE_NONE) or a child. @return the node, TREE_NONE when the pool is full */
int tree_add(tree_t *tree, tree_side_t side, lattice_t at, int parent);
/** Give up a childless node of the goal's side that is no root. */
void tree_drop(tree_t *tree, int node);
/** Hang a node, with all below it, on another parent, which must not be below it; costs follow. */
void tree_move(tree_t *tree, int node, int parent);
/** Turn the start's tree round so that it hangs by `from_start` on `to`, a node of the goal's side.
 */
void tree_join(tree_t *tree, int to, int from_start);
/** Nearest node of a side, which must not be empty. */
int tree_nearest(const tree_t *tree, tree_side_t side, lattice_t at);
/** Nodes of the goal's side within radius_cells. */
void tree_near(const tree_t *tree, lattice_t at, int radius_cells, tree_near_t *near);
/** The node of the goal's side exactly there, or TREE_NONE. */
int tree_find(const tree_t *tree, lattice_t at);

#endif
