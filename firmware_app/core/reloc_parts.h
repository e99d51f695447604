// SPDX-License-Identifier: GPL-3.0-or-later
/** @file reloc_parts.h  Shared by the source files of reloc only. */
#ifndef RELOC_PARTS_H
#define RELOC_PARTS_H

#include "reloc.h"

enum { RELOC_THICK_CELLS = 3 /* by which obstacles are dilated */ };

/** Convert a pose from the odometry frame to the map frame, by a hypothesis. */
pose2_t reloc_pose_at(const reloc_t *reloc, const reloc_place_t *place, pose2_t pose_odom);
/** Dilate the map's obstacles in one row of reloc->thick. */
void reloc_thicken_row(reloc_t *reloc, const grid_t *grid, int iy);
/** Is this cell within RELOC_THICK_CELLS of an obstacle? */
bool reloc_is_thick(const reloc_t *reloc, int ix, int iy);
/** Start the search, once all rows are dilated. */
void reloc_search(reloc_t *reloc);
/** Try the next few places. @return units of work; 0 when all were tried */
int reloc_try(reloc_t *reloc, const grid_t *grid);

/** Add one set to the sums of the present hypothesis's match. */
void reloc_match_set(reloc_t *reloc, const grid_t *grid, int set);
/** Move the present hypothesis to where its sums are least. */
void reloc_match_end(reloc_t *reloc);
/** Add one set to the sum of the present hypothesis's score. */
void reloc_judge_set(reloc_t *reloc, const grid_t *grid, int set);

#endif
