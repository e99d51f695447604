// SPDX-License-Identifier: GPL-3.0-or-later
/** @file slam_walls.h  Directions of walls, from single beams. While the drone flies straight, the
 * end of a beam runs along a wall; a line through these ends (total least squares by running sums)
 * shows the wall's direction to a fraction of a degree once it is a metre long. Only near-square
 * incidence counts: a cone reports what is nearest in it, so that a wall seen at 60 degrees stands
 * up to a sixth too near, and its line is tilted. Whether directions are worth listening to is
 * decided by how many agree: in a square room nearly all, in a cluttered one no more than chance.
 */
#ifndef SLAM_WALLS_H
#define SLAM_WALLS_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "scan.h"
#include "slam_filter.h"

/** The line that a beam is drawing. Sums are of points relative to the first. */
typedef struct {
  vec2_t first_m;
  vec2_t last_m; ///< relative to the first
  float x_m, y_m, xx_m2, yy_m2, xy_m2;
  float yaw_rad; ///< of the body, at the first point
  uint32_t first_ms;
  uint16_t elapsed_ms; ///< between first and last point
  uint8_t count;
} slam_line_t;

typedef struct {
  pose2_t dead; ///< dead reckoning that no correction of the pose breaks: the lines' frame
  slam_line_t lines[SCAN_BEAMS];
  uint8_t found[SLAM_DIRECTIONS]; ///< lines that spoke for each direction
  uint8_t agreeing;               ///< lines that agreed with a known direction, lately
  uint8_t differing;              ///< and that did not
} slam_walls_t;

void slam_walls_init(slam_walls_t *walls);
/** The lines end here: dead reckoning has jumped. */
void slam_walls_break(slam_walls_t *walls);
/** Take the end of one beam. @return true if a line was completed; then *bearing holds its
 * direction in the frame of walls->dead */
bool slam_walls_add(slam_walls_t *walls, const scan_frame_t *frame, pose2_t dead_then, int beam,
                    slam_bearing_t *bearing);
/** Let the filter learn from a line, or turn by it if directions have proven themselves. */
void slam_walls_tell(slam_walls_t *walls, slam_filter_t *filter, slam_bearing_t bearing);

/** The normal of a known wall nearest to this one, if directions have proven themselves.
 * @return false if none is near */
bool slam_walls_know(const slam_walls_t *walls, const slam_filter_t *filter, vec2_t *normal);

#endif
