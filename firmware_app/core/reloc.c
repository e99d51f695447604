// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "reloc.h"

#include <math.h>
#include <string.h>

#include "reloc_parts.h"

enum {
  SETS_FIRST = 20,   ///< sets needed for a search
  SETS_MORE = 6,     ///< new sets needed for another round
  PASSES_FIRST = 6,  ///< ICP passes of a hypothesis from the search
  PASSES_MORE = 5,   ///< ICP passes of a hypothesis from the last round
  PASSES_BEST = 12,  ///< ICP passes of the best hypothesis from the last round
  MATCH_STRIDE = 2,  ///< a match uses every second set; the score uses all
  PLACES_KEPT = 24,  ///< hypotheses kept after a round
  ROUNDS_HELD = 3,   ///< rounds in the lead that are needed to be sure
  UNITS_THICKEN = 6, ///< cost of dilating a row; a unit is about 250 cycles
  UNITS_MATCH = 12,  ///< cost of matching a set
  UNITS_JUDGE = 14,  ///< cost of scoring a set
};

static const float SPREAD_M = 0.05f;     ///< a set is taken after a motion of more than this
static const float SPREAD_RAD = 0.0873f; ///< a set is taken after a turn of more than this: 5 deg
static const float SAME_M = 0.3f;        ///< distance below which hypotheses may be the same
static const float SAME_RAD = 0.262f;    ///< turn below which they are the same: 15 degrees
static const float SCORE_POOR = 0.65f;   ///< best score below which the search is soon repeated
static const float SEARCH_POOR_M = 0.5f; ///< motion before a new search, if the best score is poor
static const float SEARCH_M = 1.6f;      ///< motion before a new search, if no hypothesis leads
static const float LEAD_MIN = 0.05f;     ///< lead over the second best that counts as leading
static const float LEAD_MAX = 0.15f;     ///< lead that one round adds, at most
static const float LEAD_SURE = 0.5f;     ///< summed lead needed to be sure
static const float NOWHERE = 0.78f;      ///< best score in a map without the true place, measured
static const float FIT_MAX = 0.15f;      ///< fit that one round adds or takes off, at most
static const float FIT_SURE = 0.35f;     ///< summed fit needed to be sure
static const float MOVED_SURE_M = 0.4f;  ///< motion in the lead needed to be sure
static const float TURNED_SURE_RAD = 2.6f; ///< turn needed after the move: its sets then weigh less
static const float RANGE_MAX_M = 60.0f;    ///< bound for 16 bits of millimetres
static const float POSE_MAX = 2000.0f;     ///< bound of |x| + |y| + |yaw|, metres and radians

void reloc_init(reloc_t *reloc) {
  memset(reloc, 0, sizeof *reloc);
}

/** Latest set taken; NULL before the first. */
static const reloc_set_t *newest(const reloc_t *reloc) {
  if (reloc->waiting > 0) {
    return &reloc->sets[RELOC_SETS + reloc->waiting - 1];
  }
  return reloc->count > 0 ? &reloc->sets[(reloc->oldest + reloc->count - 1) % RELOC_SETS] : NULL;
}

static bool spread(const reloc_set_t *before, pose2_t pose) {
  pose2_t step = pose2_compose(pose2_inverse(before->pose), pose);
  return vec2_norm(pose2_position(step)) > SPREAD_M || fabsf(step.yaw_rad) > SPREAD_RAD;
}

void reloc_add(reloc_t *reloc, const scan_frame_t *frame) {
  const reloc_set_t *before = newest(reloc);
  pose2_t pose = frame->pose;
  bool usable = fabsf(pose.x_m) + fabsf(pose.y_m) + fabsf(pose.yaw_rad) < POSE_MAX;
  if (!usable || reloc->waiting == RELOC_WAITING || (before != NULL && !spread(before, pose))) {
    return;
  }
  reloc_set_t *set = &reloc->sets[RELOC_SETS + reloc->waiting++];
  *set = (reloc_set_t){.pose = pose};
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float range_m = frame->range_m[beam];
    uint8_t bit = (uint8_t)(1u << beam);
    if (range_m >= 0.0f && range_m < RANGE_MAX_M) {
      set->range_mm[beam] = (uint16_t)(range_m * 1000.0f + 0.5f);
      set->hit |= frame->hit & bit;
      set->clear |= frame->clear & bit & (uint8_t)~frame->hit;
    }
  }
}

pose2_t reloc_pose_at(const reloc_t *reloc, const reloc_place_t *place, pose2_t pose_odom) {
  pose2_t since = pose2_compose(pose2_inverse(reloc->anchor), pose_odom);
  since.x_m *= place->stretch;
  since.y_m *= place->stretch;
  return pose2_compose(place->pose, since);
}

/** Move the anchor; the hypotheses follow by odometry. */
static void move_anchor(reloc_t *reloc, pose2_t anchor) {
  pose2_t step = pose2_compose(pose2_inverse(reloc->anchor), anchor);
  for (int i = 0; i < reloc->places; i++) {
    reloc->place_list[i].pose = reloc_pose_at(reloc, &reloc->place_list[i], anchor);
  }
  reloc->anchor = anchor;
  if (reloc->searched) {
    float step_m = vec2_norm(pose2_position(step));
    reloc->moved_m += step_m;
    reloc->unsearched_m += step_m;
    reloc->turned_rad += reloc->moved_m > MOVED_SURE_M ? fabsf(step.yaw_rad) : 0.0f;
  }
}

/** Append the waiting sets to the signature. */
static void take_waiting(reloc_t *reloc) {
  if (reloc->waiting == 0) {
    return;
  }
  for (int i = 0; i < reloc->waiting; i++) {
    reloc->sets[(reloc->oldest + reloc->count) % RELOC_SETS] = reloc->sets[RELOC_SETS + i];
    if (reloc->count < RELOC_SETS) {
      reloc->count++;
    } else {
      reloc->oldest = (uint8_t)((reloc->oldest + 1) % RELOC_SETS);
    }
  }
  reloc->fresh = (uint8_t)(reloc->fresh + reloc->waiting);
  pose2_t anchor = newest(reloc)->pose;
  reloc->waiting = 0;
  move_anchor(reloc, anchor);
}

static bool same(pose2_t a, pose2_t b) {
  return vec2_distance(pose2_position(a), pose2_position(b)) < SAME_M &&
         fabsf(geometry_wrap_rad(a.yaw_rad - b.yaw_rad)) < SAME_RAD;
}

/** Sort the hypotheses, best first. Keep only the best of those that are the same, and PLACES_KEPT
 *  at most. */
static void sort(reloc_t *reloc) {
  reloc_place_t *list = reloc->place_list;
  int kept = 0;
  int count = reloc->places;
  while (kept < count && kept < PLACES_KEPT) {
    int best = kept;
    for (int i = kept + 1; i < count; i++) {
      best = list[i].score > list[best].score ? i : best;
    }
    reloc_place_t found = list[best];
    list[best] = list[kept];
    list[kept++] = found;
    int left = kept;
    for (int i = kept; i < count; i++) {
      if (!same(list[i].pose, found.pose)) {
        list[left++] = list[i];
      }
    }
    count = left;
  }
  reloc->places = (uint8_t)kept;
}

/** Sum the evidence that the best hypothesis is right, against the drone being nowhere in the map,
 *  over the rounds since it is the best. Never below 0: bad rounds, when people stood in the way,
 *  leave nothing to make up for. */
static void weigh(reloc_t *reloc, bool stays, float score) {
  float fit = geometry_clamp(score - NOWHERE, -FIT_MAX, FIT_MAX);
  fit += stays ? reloc->fit : 0.0f;
  reloc->fit = fit > 0.0f ? fit : 0.0f;
}

/** End of a round: has one hypothesis been good enough for long enough? */
static void conclude(reloc_t *reloc) {
  sort(reloc);
  const reloc_place_t *list = reloc->place_list;
  bool stays = reloc->places > 0 && same(reloc->expected, list[0].pose);
  float best = reloc->places > 0 ? list[0].score : 0.0f;
  float lead = best - (reloc->places > 1 ? list[1].score : 0.0f);
  bool leads = lead > LEAD_MIN;
  weigh(reloc, stays, best);
  if (!leads || reloc->held == 0 || !stays) {
    reloc->held = 0;
    reloc->lead = reloc->moved_m = reloc->turned_rad = 0.0f;
  }
  if (leads) {
    reloc->lead += lead < LEAD_MAX ? lead : LEAD_MAX;
    reloc->held = (uint8_t)(reloc->held < UINT8_MAX ? reloc->held + 1 : UINT8_MAX);
  }
  reloc->sure = reloc->held >= ROUNDS_HELD && reloc->lead > LEAD_SURE && reloc->fit > FIT_SURE &&
                reloc->moved_m > MOVED_SURE_M && reloc->turned_rad > TURNED_SURE_RAD;
  reloc->searched = true;
  reloc->stage = RELOC_GATHERING;
}

static void begin_match(reloc_t *reloc) {
  reloc->stage = RELOC_MATCHING;
  reloc->expected = reloc->place_list[0].pose;
  reloc->place = reloc->pass = reloc->set = 0;
  memset(&reloc->sums, 0, sizeof reloc->sums);
}

/** The sums over all sets are complete: score the hypothesis, or move it. */
static void end_pass(reloc_t *reloc, bool judging) {
  if (judging) {
    float beams = reloc->sums.weight > 1.0f ? reloc->sums.weight : 1.0f;
    reloc->place_list[reloc->place++].score = reloc->sums.score / beams;
    reloc->pass = 0;
  } else {
    reloc_match_end(reloc);
    reloc->pass++;
  }
  reloc->set = 0;
  memset(&reloc->sums, 0, sizeof reloc->sums);
}

/** ICP passes of the present hypothesis in this round. */
static int passes(const reloc_t *reloc) {
  if (!reloc->searched) {
    return PASSES_FIRST;
  }
  return reloc->place == 0 ? PASSES_BEST : PASSES_MORE;
}

/** Match or score one hypothesis with one set. @return units of work */
static int match_step(reloc_t *reloc, const grid_t *grid) {
  if (reloc->place == reloc->places) {
    conclude(reloc);
    return UNITS_JUDGE;
  }
  bool judging = reloc->pass == passes(reloc);
  if (judging) {
    reloc_judge_set(reloc, grid, reloc->set);
  } else {
    reloc_match_set(reloc, grid, reloc->set);
  }
  reloc->set = (uint8_t)(reloc->set + (judging ? 1 : MATCH_STRIDE));
  if (reloc->set >= reloc->count) {
    end_pass(reloc, judging);
  }
  return judging ? UNITS_JUDGE : UNITS_MATCH;
}

/** Start a round, with a search if one is due. @return false if too few sets are new */
static bool begin_round(reloc_t *reloc) {
  take_waiting(reloc);
  if (reloc->fresh < (reloc->searched ? SETS_MORE : SETS_FIRST)) {
    return false;
  }
  reloc->fresh = 0;
  bool poor = reloc->places == 0 || reloc->place_list[0].score < SCORE_POOR;
  bool again = reloc->held == 0 && reloc->unsearched_m > (poor ? SEARCH_POOR_M : SEARCH_M);
  if (reloc->searched && !again) {
    begin_match(reloc);
    return true;
  }
  reloc->searched = false;
  reloc->unsearched_m = 0.0f;
  reloc->row = 0;
  reloc->stage = RELOC_THICKENING;
  return true;
}

static int thicken_step(reloc_t *reloc, const grid_t *grid) {
  reloc_thicken_row(reloc, grid, reloc->row++);
  if (reloc->row == GRID_SIDE_CELLS) {
    reloc_search(reloc);
    reloc->stage = RELOC_SEARCHING;
  }
  return UNITS_THICKEN;
}

static int search_step(reloc_t *reloc, const grid_t *grid) {
  int units = reloc_try(reloc, grid);
  if (units == 0) {
    begin_match(reloc);
  }
  return units;
}

bool reloc_work(reloc_t *reloc, const grid_t *grid, int budget) {
  while (budget > 0) {
    switch (reloc->stage) {
    case RELOC_GATHERING:
      if (!begin_round(reloc)) {
        return false;
      }
      budget--;
      break;
    case RELOC_THICKENING:
      budget -= thicken_step(reloc, grid);
      break;
    case RELOC_SEARCHING:
      budget -= search_step(reloc, grid);
      break;
    case RELOC_MATCHING:
      budget -= match_step(reloc, grid);
      break;
    }
  }
  return true;
}

bool reloc_to_map(const reloc_t *reloc, pose2_t pose_odom, pose2_t *map_pose) {
  if (!reloc->searched || reloc->places == 0) {
    return false;
  }
  *map_pose = reloc_pose_at(reloc, &reloc->place_list[0], pose_odom);
  return true;
}
