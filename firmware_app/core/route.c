// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "route.h"

#include <string.h>

enum { TRIES = 3, POINTS_PER_CORNER = 3 };

static const float ROUND_CUT_CELLS = 6.0f; ///< how far from a corner rounding may begin
static const float LEAST_CELLS = 1.0e-3f;  ///< shorter vectors have no direction
static const float PIECE_M = 0.1f;         ///< the route is looked at in pieces of this length

/** Round to the lattice, so that the line of sight was checked for the very point that is flown. */
static vec2_t on_lattice(vec2_t cells) {
  return lattice_to_cells(lattice_from_cells(cells));
}

static bool in_sight(const clearance_t *clearance, vec2_t a, vec2_t b) {
  return clearance_sees(clearance, lattice_from_cells(a), lattice_from_cells(b));
}

/** Unit vector away from the obstacle that the path a, b, c turns round at b; zero if it does not
 * turn. */
static vec2_t outwards(vec2_t a, vec2_t b, vec2_t c) {
  vec2_t to_a = vec2_sub(a, b);
  vec2_t to_c = vec2_sub(c, b);
  vec2_t inwards = vec2_add(vec2_scale(to_a, 1.0f / (vec2_norm(to_a) + LEAST_CELLS)),
                            vec2_scale(to_c, 1.0f / (vec2_norm(to_c) + LEAST_CELLS)));
  float norm = vec2_norm(inwards);
  return norm > LEAST_CELLS ? vec2_scale(inwards, -1.0f / norm) : (vec2_t){0.0f, 0.0f};
}

/** Free space from p in a direction [cells], at most twice the stand-off. */
static float room_cells(const clearance_t *clearance, vec2_t p, vec2_t direction) {
  int steps = 0;
  while (steps < 2 * ROUTE_STAND_OFF_CELLS &&
         !clearance_blocked_at(clearance, vec2_add(p, vec2_scale(direction, (float)(steps + 1))))) {
    steps++;
  }
  return (float)steps;
}

void route_stand_off(const clearance_t *clearance, vec2_t *path_cells, int count) {
  for (int i = 1; i + 1 < count; i++) {
    vec2_t a = path_cells[i - 1];
    vec2_t b = path_cells[i];
    vec2_t c = path_cells[i + 1];
    vec2_t direction = outwards(a, b, c);
    float off_cells = 0.5f * room_cells(clearance, b, direction);
    for (int k = 0; k < TRIES; k++) {
      vec2_t moved = on_lattice(vec2_add(b, vec2_scale(direction, off_cells)));
      if (in_sight(clearance, a, moved) && in_sight(clearance, moved, c)) {
        path_cells[i] = moved;
        break;
      }
      off_cells *= 0.5f;
    }
  }
}

/** Three points in place of corner b of the path a, b, c: both ends and the middle of a quadratic
 * Bezier curve with b as its control point. @return false if no curve is clear */
static bool round_corner(const clearance_t *clearance, vec2_t a, vec2_t b, vec2_t c, vec2_t *out) {
  vec2_t to_a = vec2_sub(a, b);
  vec2_t to_c = vec2_sub(c, b);
  float length_a = vec2_norm(to_a);
  float length_c = vec2_norm(to_c);
  float cut = 0.5f * (length_a < length_c ? length_a : length_c);
  cut = cut < ROUND_CUT_CELLS ? cut : ROUND_CUT_CELLS;
  for (int i = 0; i < TRIES && cut > 0.1f; i++) {
    out[0] = on_lattice(vec2_add(b, vec2_scale(to_a, cut / length_a)));
    out[2] = on_lattice(vec2_add(b, vec2_scale(to_c, cut / length_c)));
    vec2_t chord = vec2_scale(vec2_add(out[0], out[2]), 0.5f);
    out[1] = on_lattice(vec2_scale(vec2_add(b, chord), 0.5f));
    if (in_sight(clearance, out[0], out[1]) && in_sight(clearance, out[1], out[2])) {
      return true;
    }
    cut *= 0.5f;
  }
  return false;
}

int route_round(const clearance_t *clearance, vec2_t *path_cells, int count, int capacity) {
  if (count < 3 || count + (count - 2) * (POINTS_PER_CORNER - 1) > capacity) {
    return count;
  }
  vec2_t previous = path_cells[0];
  int at = 1;
  while (at < count - 1) {
    vec2_t corner = path_cells[at];
    vec2_t curve[POINTS_PER_CORNER];
    if (round_corner(clearance, previous, corner, path_cells[at + 1], curve)) {
      memmove(&path_cells[at + POINTS_PER_CORNER], &path_cells[at + 1],
              (size_t)(count - at - 1) * sizeof *path_cells);
      memcpy(&path_cells[at], curve, sizeof curve);
      count += POINTS_PER_CORNER - 1;
      at += POINTS_PER_CORNER - 1;
    }
    previous = corner;
    at++;
  }
  return count;
}

void route_build(route_t *route, const grid_t *grid, const clearance_t *clearance, int count) {
  route_stand_off(clearance, route->points_m, count);
  count = route_round(clearance, route->points_m, count, ROUTE_POINTS);
  route->count = (uint8_t)count;
  route->revision++;
  for (int i = 0; i < count; i++) {
    route->points_m[i] = grid_to_metres(grid, route->points_m[i]);
  }
}

float route_length_m(const route_t *route) {
  float length_m = 0.0f;
  for (int i = 1; i < route->count; i++) {
    length_m += vec2_distance(route->points_m[i - 1], route->points_m[i]);
  }
  return length_m;
}

/** A piece of the route, at most PIECE_M long, from a_m to b_m. */
typedef struct {
  int leg;         ///< the piece lies between the points leg - 1 and leg
  float leg_end_m; ///< arc length at point leg
  float at_m;      ///< arc length at the end of the piece
  vec2_t a_m;
  vec2_t b_m;
} piece_t;

/** Go on to the next piece. @return false at the end of the route */
static bool next_piece(const route_t *route, piece_t *piece) {
  while (piece->leg == 0 || piece->at_m >= piece->leg_end_m - 1.0e-4f) {
    if (piece->leg + 1 >= route->count) {
      return false;
    }
    piece->leg++;
    piece->leg_end_m += vec2_distance(route->points_m[piece->leg - 1], route->points_m[piece->leg]);
  }
  vec2_t a = route->points_m[piece->leg - 1];
  vec2_t b = route->points_m[piece->leg];
  float leg_m = vec2_distance(a, b);
  float left_m = piece->leg_end_m - piece->at_m;
  float step_m = left_m < PIECE_M ? left_m : PIECE_M;
  piece->a_m = vec2_add(b, vec2_scale(vec2_sub(a, b), left_m / leg_m));
  piece->b_m = vec2_add(b, vec2_scale(vec2_sub(a, b), (left_m - step_m) / leg_m));
  piece->at_m += step_m;
  return true;
}

float route_clear_m(const route_t *route, const grid_t *grid, const clearance_t *clearance,
                    float from_m) {
  piece_t piece = {.at_m = from_m};
  float clear_m = from_m;
  while (next_piece(route, &piece)) {
    vec2_t a = grid_to_cells(grid, piece.a_m);
    vec2_t b = grid_to_cells(grid, piece.b_m);
    if (!clearance_segment_free(clearance, a, b)) {
      return clear_m;
    }
    clear_m = piece.at_m;
  }
  return clear_m;
}

float route_known_m(const route_t *route, const grid_t *grid, float half_width_m, float from_m,
                    float until_m) {
  piece_t piece = {.at_m = from_m};
  float known_m = from_m;
  while (known_m < until_m && next_piece(route, &piece)) {
    if (!grid_segment_known(grid, piece.a_m, piece.b_m, half_width_m)) {
      return known_m;
    }
    known_m = piece.at_m;
  }
  return known_m;
}

float route_seen_m(const route_t *route, const grid_t *grid, const seen_t *seen, float from_m,
                   float until_m) {
  piece_t piece = {.at_m = from_m};
  float seen_m = from_m;
  while (seen_m < until_m && next_piece(route, &piece) && seen_lately(seen, grid, piece.b_m)) {
    seen_m = piece.at_m;
  }
  return seen_m;
}

float route_room_m(const route_t *route, const grid_t *grid, const clearance_t *clearance,
                   float from_m, float until_m) {
  piece_t piece = {.at_m = from_m};
  int free_cells = ROUTE_ROOM_CELLS;
  while (piece.at_m < until_m && next_piece(route, &piece)) {
    vec2_t at_cells = grid_to_cells(grid, piece.b_m);
    while (free_cells > 0 && !clearance_square_free(clearance, at_cells, free_cells)) {
      free_cells--;
    }
  }
  return (float)free_cells * grid->cell_m;
}
