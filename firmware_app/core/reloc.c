// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "reloc.h"

#include <math.h>
#include <string.h>

#include "reloc_parts.h"

enum {
  SETS_FIRST = 20,   ///< with which the search begins
  SETS_MORE = 6,     ///< for another round
  PASSES_FIRST = 6,  ///< matches of a place that the search found
  PASSES_MORE = 5,   ///< and of one known from the last round
  PASSES_BEST = 12,  ///< which was the best in it
  MATCH_STRIDE = 2,  ///< of sets
  PLACES_KEPT = 24,  ///< after a round
  ROUNDS_HELD = 3,   ///< at least, to be sure
  UNITS_THICKEN = 6, ///< units are some 250 cycles
  UNITS_MATCH = 12,
  UNITS_JUDGE = 14,
};

static const float SPREAD_M = 0.05f;     ///< sets are so far apart
static const float SPREAD_RAD = 0.0873f; ///< or turned so much: 5 degrees
static const float SAME_M = 0.3f;        ///< places nearer than this
static const float SAME_RAD = 0.262f;    ///< and this (15 degrees) are one
static const float SCORE_POOR = 0.65f;   ///< of a best place that calls for a new search
static const float SEARCH_POOR_M = 0.5f; ///< moved until then
static const float SEARCH_M = 1.6f;      ///< moved until a new search anyway, if none leads
static const float LEAD_MIN = 0.05f;     ///< over the second best, in every round held
static const float LEAD_MAX = 0.15f;     ///< what one round counts
static const float LEAD_SURE = 0.5f;     ///< all rounds held together
static const float NOWHERE = 0.78f;  ///< what a place may score in a map that has not the right one
static const float FIT_MAX = 0.15f;  ///< what one round counts, beyond that or short of it
static const float FIT_SURE = 0.35f; ///< all rounds together
static const float MOVED_SURE_M = 0.4f;
static const float TURNED_SURE_RAD = 2.6f; ///< after the move: its odometry no longer matters
static const float RANGE_MAX_M = 60.0f;
static const float POSE_MAX = 2000.0f; ///< sum of its parts

void reloc_init(reloc_t *reloc) {
  memset(reloc, 0, sizeof *reloc);
}

/** The last set that was taken; NULL before the first. */
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

/** Hypotheses go along with the anchor. */
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

/** The sets that wait join the signature. */
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

/** Best first; of those that are the same only the best; at most PLACES_KEPT. */
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

/** The best place's evidence against being nowhere in the map, over the rounds since it is the
 * best; it never falls below none, so that what came before people stood in the way is not lost. */
static void weigh(reloc_t *reloc, bool stays, float score) {
  float fit = geometry_clamp(score - NOWHERE, -FIT_MAX, FIT_MAX);
  fit += stays ? reloc->fit : 0.0f;
  reloc->fit = fit > 0.0f ? fit : 0.0f;
}

/** All hypotheses are judged: has one of them been the best for long enough, and good enough? */
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

/** The sums over all sets are complete. */
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

/** How often the present hypothesis is matched in a round. */
static int passes(const reloc_t *reloc) {
  if (!reloc->searched) {
    return PASSES_FIRST;
  }
  return reloc->place == 0 ? PASSES_BEST : PASSES_MORE;
}

/** One set of one hypothesis. @return units of work */
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

/** @return false if there is not enough new to work on */
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
