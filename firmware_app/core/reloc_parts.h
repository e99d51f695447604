// SPDX-License-Identifier: GPL-3.0-or-later
/** @file reloc_parts.h  What the files of reloc share among themselves; nobody else includes it. */
#ifndef RELOC_PARTS_H
#define RELOC_PARTS_H

#include "reloc.h"

enum { RELOC_THICK_CELLS = 3 /* around an obstacle */ };

/** Where a hypothesis has a pose of the odometry frame. */
pose2_t reloc_pose_at(const reloc_t *reloc, const reloc_place_t *place, pose2_t pose_odom);
/** Thicken one row of the map's obstacles. */
void reloc_thicken_row(reloc_t *reloc, const grid_t *grid, int iy);
/** A cell is near an obstacle. */
bool reloc_is_thick(const reloc_t *reloc, int ix, int iy);
/** Begin to try places; all rows are thickened. */
void reloc_search(reloc_t *reloc);
/** Try the next few places. @return units of work, 0 when all were tried */
int reloc_try(reloc_t *reloc, const grid_t *grid);

/** Add one set, seen from the present hypothesis, to the sums of its match. */
void reloc_match_set(reloc_t *reloc, const grid_t *grid, int set);
/** Move the hypothesis by what the sums say. */
void reloc_match_end(reloc_t *reloc);
/** Add one set to the sums of its score. */
void reloc_judge_set(reloc_t *reloc, const grid_t *grid, int set);

#endif
