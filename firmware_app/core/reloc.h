// SPDX-License-Identifier: GPL-3.0-or-later
/** @file reloc.h  Where in a known map is the drone, when nothing is known of its pose: after a
 * kidnapping, a restart with the map kept, on an imported map. The drone turns and makes short
 * moves; spread sets of ranges with their odometry make a signature of its surroundings. Every free
 * place and heading is tried against the map's obstacles, thickened (correlative matching, Olson
 * 2009). The best that are apart from each other are kept as hypotheses, moved onto the map's
 * obstacles (ICP, Besl and McKay 1992; newer sets count more, as odometry drifts) and judged by all
 * beams: what their ends lie near, and what they pass through. The drone moves on, the newest sets
 * replace the oldest, and all hypotheses are matched and judged anew: none is lost by chance, as
 * particles are. Odometry may read too far: how much is matched with the pose. Sure is what has
 * stayed best while the drone moved and then looked around, and fits so much better than the best
 * place of a map that does not know the right one. Sets that come while others are worked on wait,
 * so that a round does not depend on its slices. The grid must not change meanwhile. */
#ifndef RELOC_H
#define RELOC_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "scan.h"

enum {
  RELOC_SETS = 48,    ///< of the signature
  RELOC_WAITING = 16, ///< that may come while these are worked on
  RELOC_PLACES = 48,  ///< hypotheses
  RELOC_ENDS = 48,    ///< of beams, that the search looks at
};

typedef enum {
  RELOC_GATHERING,  ///< waiting for sets
  RELOC_THICKENING, ///< the map's obstacles, for the search
  RELOC_SEARCHING,  ///< trying every place and heading
  RELOC_MATCHING,   ///< moving hypotheses and judging them
} reloc_stage_t;

/** A measured set, small. */
typedef struct {
  pose2_t pose; ///< odometry frame
  uint16_t range_mm[SCAN_BEAMS];
  uint8_t hit;
  uint8_t clear;
} reloc_set_t;

/** A hypothesis. */
typedef struct {
  pose2_t pose;  ///< map frame, of the anchor
  float stretch; ///< metres of the map for one of odometry
  float score;   ///< 1: every beam ends on an obstacle and passes none
} reloc_place_t;

/** Sums over the beams of a hypothesis, while it is matched or judged. */
typedef struct {
  float weight;
  vec2_t arm_m;   ///< from the anchor to the ends
  vec2_t lever_m; ///< from the anchor to the sets
  vec2_t away_m;  ///< from the ends to their obstacles
  float arm2_m2;
  float lever2_m2;
  float arm_lever_m2; ///< arm x lever
  float cross_m2;     ///< arm x away
  float along_m2;     ///< lever . away
  float score;
} reloc_sums_t;

typedef struct {
  reloc_stage_t stage;
  bool sure;
  bool searched;   ///< places are hypotheses, matched and judged
  uint8_t count;   ///< sets of the signature
  uint8_t oldest;  ///< of them
  uint8_t waiting; ///< sets, behind those of the signature
  uint8_t fresh;   ///< sets that joined the signature since the last round
  uint8_t places;
  uint8_t ends;
  uint8_t misses_max; ///< of ends, for a place to be kept by the search
  uint8_t heading;    ///< that is tried
  uint8_t row;        ///< that is tried, or thickened
  uint8_t column;     ///< that is tried
  uint8_t place;      ///< that is matched
  uint8_t pass;
  uint8_t set;
  uint8_t held;       ///< rounds in a row in which the same place was best
  float lead;         ///< of its score, summed over these rounds
  float fit;          ///< of its score beyond NOWHERE, summed since the same place is best
  float moved_m;      ///< since it is the best
  float turned_rad;   ///< likewise, after enough of a move
  float unsearched_m; ///< moved since the last search
  pose2_t expected;   ///< of the best place, before it is matched
  pose2_t anchor;     ///< newest set of the signature: odometry frame
  reloc_sums_t sums;
  reloc_set_t sets[RELOC_SETS + RELOC_WAITING];
  reloc_place_t place_list[RELOC_PLACES];           ///< best first, once searched
  int8_t end_cells[RELOC_ENDS][2];                  ///< from the anchor, at the heading
  uint32_t thick[GRID_SIDE_CELLS * GRID_BIT_WORDS]; ///< cells near an obstacle
} reloc_t;

/** Nothing is known. */
void reloc_init(reloc_t *reloc);
/** Take a measured set. One that is not spread from the last, or finds no room, is dropped. */
void reloc_add(reloc_t *reloc, const scan_frame_t *frame);
/** Work for about `budget` units. @return false if there is nothing to do until more sets come */
bool reloc_work(reloc_t *reloc, const grid_t *grid, int budget);
/** The map pose of a pose of the odometry frame, by the best hypothesis; to be trusted when sure.
 * @return false if there is none */
bool reloc_to_map(const reloc_t *reloc, pose2_t pose_odom, pose2_t *map_pose);

#endif
