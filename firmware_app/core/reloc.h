// SPDX-License-Identifier: GPL-3.0-or-later
/** @file reloc.h  Global relocalisation: finds the pose in a known map from no prior at all.
 *
 *  Needed by a kidnapped robot: carried elsewhere, restarted with its map kept, or given a stored
 *  map. The drone turns and makes short moves. Sets of ranges, spread over that motion and placed
 *  by odometry, form a signature of its surroundings.
 *
 *  Search: every free place and heading is tried against the map's dilated obstacles (correlative
 *  matching, Olson 2009). The best that are apart from each other become hypotheses.
 *  Rounds: each hypothesis is moved onto the map's obstacles (ICP, Besl and McKay 1992; newer sets
 *  weigh more, as odometry drifts; its scale is matched too) and scored by all beams: by what their
 *  ends lie near and what they pass through. The drone moves on, new sets replace the
 *  oldest, and the next round matches and scores all hypotheses again. No hypothesis is lost by
 *  chance, as a particle may be.
 *  Result: a hypothesis is sure once it has stayed the best while the drone moved and then looked
 *  around, and fits better than the best place does in maps that do not contain the true one.
 *
 *  Sets that arrive during a round wait for the next one, so that the result does not depend on the
 *  slices. The grid must not change during relocalisation.
 */
#ifndef RELOC_H
#define RELOC_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "scan.h"

enum {
  RELOC_SETS = 48,    ///< sets in the signature
  RELOC_WAITING = 16, ///< sets that may arrive during a round
  RELOC_PLACES = 48,  ///< hypotheses
  RELOC_ENDS = 48,    ///< beam ends that the search uses
};

typedef enum {
  RELOC_GATHERING,  ///< waiting for sets
  RELOC_THICKENING, ///< dilating the map's obstacles for the search
  RELOC_SEARCHING,  ///< trying every free place and heading
  RELOC_MATCHING,   ///< matching and scoring the hypotheses
} reloc_stage_t;

/** Compact form of scan_frame_t. */
typedef struct {
  pose2_t pose; ///< odometry frame
  uint16_t range_mm[SCAN_BEAMS];
  uint8_t hit;   ///< bit mask of beams, as in scan_frame_t
  uint8_t clear; ///< likewise
} reloc_set_t;

/** A hypothesis. */
typedef struct {
  pose2_t pose;  ///< of the anchor, map frame
  float stretch; ///< metres in the map per metre of odometry
  float score;   ///< mean per beam; 1: every beam ends on an obstacle and passes none
} reloc_place_t;

/** Weighted sums over the beams, while a hypothesis is matched or scored. */
typedef struct {
  float weight;
  vec2_t arm_m;       ///< from the anchor to the beam's end
  vec2_t lever_m;     ///< from the anchor to the body at the set
  vec2_t away_m;      ///< from the beam's end to the nearest obstacle
  float arm2_m2;      ///< arm . arm
  float lever2_m2;    ///< lever . lever
  float arm_lever_m2; ///< arm x lever
  float cross_m2;     ///< arm x away
  float along_m2;     ///< lever . away
  float score;
} reloc_sums_t;

typedef struct {
  reloc_stage_t stage;
  bool sure;          ///< the best hypothesis may be trusted
  bool searched;      ///< the hypotheses of the last search were matched and scored
  uint8_t count;      ///< sets in the signature
  uint8_t oldest;     ///< index of the oldest of them
  uint8_t waiting;    ///< sets waiting, stored behind the signature
  uint8_t fresh;      ///< sets that joined the signature since the last round
  uint8_t places;     ///< hypotheses
  uint8_t ends;       ///< beam ends in end_cells
  uint8_t misses_max; ///< most ends off an obstacle, for the search to keep a place
  uint8_t heading;    ///< search: present heading
  uint8_t row;        ///< search and dilation: present row
  uint8_t column;     ///< search: present column
  uint8_t place;      ///< match: present hypothesis
  uint8_t pass;       ///< match: present pass; the last one scores
  uint8_t set;        ///< match: present set
  uint8_t held;       ///< rounds in a row in which the same hypothesis led
  float lead;         ///< its lead in score, summed over these rounds
  float fit;          ///< its score above NOWHERE, summed over the rounds since it is the best
  float moved_m;      ///< distance moved since it leads
  float turned_rad;   ///< angle turned after the first MOVED_SURE_M of these
  float unsearched_m; ///< distance moved since the last search
  pose2_t expected;   ///< pose of the best hypothesis before the present round
  pose2_t anchor;     ///< pose of the newest set in the signature, odometry frame
  reloc_sums_t sums;
  reloc_set_t sets[RELOC_SETS + RELOC_WAITING];     ///< ring of the signature, then those waiting
  reloc_place_t place_list[RELOC_PLACES];           ///< best first, once searched
  int8_t end_cells[RELOC_ENDS][2];                  ///< offset from the anchor, at `heading`
  uint32_t thick[GRID_SIDE_CELLS * GRID_BIT_WORDS]; ///< bit map of the dilated obstacles
} reloc_t;

/** Start with nothing known. */
void reloc_init(reloc_t *reloc);
/** Take a measured set. It is dropped if the body has hardly moved since the last, or without room.
 */
void reloc_add(reloc_t *reloc, const scan_frame_t *frame);
/** Work for about `budget` units. @return false if there is nothing to do until more sets arrive */
bool reloc_work(reloc_t *reloc, const grid_t *grid, int budget);
/** Convert a pose from the odometry frame to the map frame, by the best hypothesis; trust it only
 *  when sure. @return false if there is none */
bool reloc_to_map(const reloc_t *reloc, pose2_t pose_odom, pose2_t *map_pose);

#endif
