// SPDX-License-Identifier: GPL-3.0-or-later
/** @file route.h  The path that is flown, in the map frame, and how far it may be flown.
 *
 * The planner's shortest path touches the corners that it passes. Each of its points is moved
 * towards the middle of the gap that it lies in, by at most ROUTE_STAND_OFF_CELLS (standing off),
 * and then replaced by a short curve (rounding), which shortens the route. Every new piece is
 * checked to be clear; where it is not, the point or corner stays. */
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
  vec2_t points_m[ROUTE_POINTS]; ///< from the start to the goal, map frame
  uint8_t count;                 ///< 0: no route
  uint8_t revision;              ///< incremented with every new route
} route_t;

/** Make the route, in place, from the planner's path, whose `count` points are in points_m in
 * cells: stand off, round, convert to metres. */
void route_build(route_t *route, const grid_t *grid, const clearance_t *clearance, int count);
/** Move points away from the corners that the path turns round, where there is room. */
void route_stand_off(const clearance_t *clearance, vec2_t *path_cells, int count);
/** Round corners where there is room. @return number of points, at most capacity */
int route_round(const clearance_t *clearance, vec2_t *path_cells, int count, int capacity);

float route_length_m(const route_t *route);
/** Arc length [m] up to which the route is clear of blocked cells, beginning at arc length from_m.
 */
float route_clear_m(const route_t *route, const grid_t *grid, const clearance_t *clearance,
                    float from_m);
/** Arc length [m] up to which everything within half_width_m of the route was observed, beginning
 * at from_m; looks no farther than until_m. */
float route_known_m(const route_t *route, const grid_t *grid, float half_width_m, float from_m,
                    float until_m);
/** Arc length [m] up to which beams crossed the route's tiles lately (seen.h), beginning at from_m;
 * looks no farther than until_m. */
float route_seen_m(const route_t *route, const grid_t *grid, const seen_t *seen, float from_m,
                   float until_m);
/** Least free space [m] to all sides of the route between two arc lengths, beyond the clearance; at
 * most ROUTE_ROOM_CELLS cells. */
float route_room_m(const route_t *route, const grid_t *grid, const clearance_t *clearance,
                   float from_m, float until_m);

#endif
