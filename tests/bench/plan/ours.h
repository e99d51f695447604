// SPDX-License-Identifier: GPL-3.0-or-later
/** @file ours.h  The project's planner as the planning bench uses it, on this machine and on the
 * chip. ours.c alone knows the core's interface. One planner, in static memory. */
#ifndef OURS_H
#define OURS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "geometry.h"

enum { OURS_SIDE = 128, OURS_ROW_WORDS = OURS_SIDE / 32, OURS_WORDS = OURS_SIDE * OURS_ROW_WORDS };

typedef struct {
  size_t planner; ///< all of its state
  size_t bits;    ///< of the blocked cells
} ours_sizes_t;

/** The map and its inflated layer as they stand before anybody plans: bit ix % 32 of word
 * iy * 4 + ix / 32. @return false if the core does not block just these cells */
bool ours_set_blocked(const uint32_t bits[OURS_WORDS]);
/** The same while a plan stands: the core hears of what changed. */
bool ours_change_blocked(const uint32_t bits[OURS_WORDS]);

void ours_start(vec2_t start_cells, vec2_t goal_cells, uint32_t seed);
/** Go on for so many units of work; a sample is one. @return false when the planner has ended */
bool ours_search(int units);
/** Drawn since the start. */
long ours_samples(void);
/** After ours_change_blocked: keep of the plan what still holds. Then go on with ours_search. */
void ours_repair(void);

/** True when the drone would stop planning and fly. */
bool ours_enough(void);

/** Length of the best way in cells; infinite without one. */
float ours_cost(void);
int ours_nodes(void);
/** @return points written, 0 without a way or with more than capacity */
int ours_way(vec2_t *way_cells, int capacity);
/** The route that would be flown along the best way. @return points, 0 without a way */
int ours_route(vec2_t *way_cells, int capacity);

/** Look whether there is a way at all. @return true if there is none */
bool ours_no_way(vec2_t start_cells, vec2_t goal_cells, uint32_t seed);

ours_sizes_t ours_sizes(void);

#endif
