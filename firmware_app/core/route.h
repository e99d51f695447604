// SPDX-License-Identifier: GPL-3.0-or-later
/** @file route.h  A way to fly: way points in the map frame, off the corners and rounded, each
 * piece checked. A planner's shortest way touches the corners that it passes. Standing off: each
 * way point goes towards the middle of the gap that it lies in, at most ROUTE_STAND_OFF_CELLS.
 * Rounding: a curve in place of a corner, where it stays clear; that makes the way shorter, never
 * longer. */
#ifndef ROUTE_H
#define ROUTE_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "geometry.h"
#include "grid.h"
#include "seen.h"

enum { ROUTE_POINTS = 64, ROUTE_STAND_OFF_CELLS = 4, ROUTE_ROOM_CELLS = 3 };

typedef struct {
  vec2_t points_m[ROUTE_POINTS]; ///< the first is where it starts, the last the goal
  uint8_t count;                 ///< 0: no route
  uint8_t revision;              ///< grows with every new route
} route_t;

/** Make the route from a planner's way, which stands in points_m in cells: stand off, round,
 * convert in place. */
void route_build(route_t *route, const grid_t *grid, const clearance_t *clearance, int count);
/** Move way points off the corners that the way turns round, where there is room. */
void route_stand_off(const clearance_t *clearance, vec2_t *path_cells, int count);
/** Round the corners where there is room. @return points, at most capacity */
int route_round(const clearance_t *clearance, vec2_t *path_cells, int count, int capacity);

float route_length_m(const route_t *route);
/** How far along the route [m], looking from arc length from_m on, it stays clear of blocked cells.
 */
float route_clear_m(const route_t *route, const grid_t *grid, const clearance_t *clearance,
                    float from_m);
/** How far along the route [m], looking from from_m on to until_m at most, everything within
 * half_width_m was observed. */
float route_known_m(const route_t *route, const grid_t *grid, float half_width_m, float from_m,
                    float until_m);
/** Likewise, looked at lately. */
float route_seen_m(const route_t *route, const grid_t *grid, const seen_t *seen, float from_m,
                   float until_m);
/** The least room [m] around the route between two arc lengths: how far blocked cells keep away,
 * ROUTE_ROOM_CELLS of them at most. */
float route_room_m(const route_t *route, const grid_t *grid, const clearance_t *clearance,
                   float from_m, float until_m);

#endif
