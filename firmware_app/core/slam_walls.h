// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam_walls.h  Directions of walls, measured by single beams.
 *
 *  While the drone flies straight, the end of a beam runs along a wall. A line through these ends
 *  (total least squares by running sums) shows the wall's direction to a fraction of a degree once
 *  it is a metre long. Only near-square incidence counts: a cone reports what is nearest in it, so
 *  a wall seen at 60 degrees appears up to a sixth too near, and its line is tilted. Directions are
 *  used only while most lines agree with a known one: in a square room nearly all do, in a
 *  cluttered one no more than by chance.
 */
#ifndef SLAM_WALLS_H
#define SLAM_WALLS_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "scan.h"
#include "slam_filter.h"

/** Line of one beam's successive ends, in the frame of slam_walls_t.dead. */
typedef struct {
  vec2_t first_m;                      ///< first end
  vec2_t last_m;                       ///< last end, relative to the first
  float x_m, y_m, xx_m2, yy_m2, xy_m2; ///< sums over all ends, relative to the first
  float yaw_rad;                       ///< of the body, at the first end
  uint32_t first_ms;
  uint16_t elapsed_ms; ///< between first and last end
  uint8_t count;       ///< ends
} slam_line_t;

typedef struct {
  pose2_t dead; ///< pose by dead reckoning alone, so that no correction breaks a line
  slam_line_t lines[SCAN_BEAMS];
  uint8_t found[SLAM_DIRECTIONS]; ///< lines counted for each direction; 0: unused
  uint8_t agreeing;               ///< recent lines that agreed with a known direction
  uint8_t differing;              ///< recent lines that did not
} slam_walls_t;

void slam_walls_init(slam_walls_t *walls);
/** Drop all unfinished lines: dead reckoning has jumped. */
void slam_walls_break(slam_walls_t *walls);
/** Take one beam of a set, measured at dead_then in the frame of walls->dead.
 *  @return true if that completed a line; then *bearing is its direction in that frame */
bool slam_walls_add(slam_walls_t *walls, const scan_frame_t *frame, pose2_t dead_then, int beam,
                    slam_bearing_t *bearing);
/** Associate a completed line with a known direction: the filter is corrected by it if directions
 *  have proven themselves. A line near none of them may become a new direction. */
void slam_walls_tell(slam_walls_t *walls, slam_filter_t *filter, slam_bearing_t bearing);

/** Replace a wall's normal by that of the known direction nearest to it.
 *  @return false if none is near, or directions have not proven themselves */
bool slam_walls_know(const slam_walls_t *walls, const slam_filter_t *filter, vec2_t *normal);

#endif
