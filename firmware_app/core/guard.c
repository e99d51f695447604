// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "guard.h"

#include <math.h>

enum {
  COMING_SETS = 3, ///< sets in a row with an approaching echo: more than noise
  DOUBTED = 8,     ///< restless score at which a beam no longer reports approaching obstacles
  JUMP_SETS = 2,   ///< added to the score by a jump; each set without one takes 1 off
};

static const float NOTHING_M = 100.0f;    ///< range that stands for no return
static const float NEVER_S = 1000.0f;     ///< age that stands for never
static const float WATCHED_M = 2.0f;      ///< range within which obstacles may count as approaching
static const float UNEXPLAINED_M = 0.75f; ///< a nearer echo may be of an unmapped wall
static const float STEADY_RAD = 0.04f;    ///< largest turn between two sets that are compared
static const float SET_S = 0.3f;          ///< largest time between two sets that are compared
static const float DOUBT_S = 0.3f;        ///< time that an unconfirmed fall in range is doubted
static const float COMING_MPS = 0.2f;     ///< slowest approach; below is noise
static const float STAYING_MPS = 0.1f; ///< an obstacle that approaches more slowly may have stopped
static const float STAYS_S = 3.0f;     ///< slower than STAYING_MPS for this long: it has stopped
static const float MOVED_M = 0.3f;     ///< an obstacle that moved farther than this has moved on
static const float RUNNING_MPS = 2.5f; ///< fastest approach; above, the beam hit something else
static const float SAME_M = 0.5f;      ///< echoes within this distance are of the same obstacle
static const float RESTLESS_M = 1.2f;  ///< range within which jumps of a beam are counted
static const float JUMP_M = 0.2f;      ///< change between two sets that is a jump
static const float FALL_M = 0.25f;     ///< largest plausible fall in a set: RUNNING_MPS for 0.1 s
static const float SLIP_GAIN = 0.3f;   ///< weight of one set in slip_mps
static const float AHEAD_S = 0.5f;     ///< an approach is extrapolated for this long at most
static const float STANDING = 0.6f;    ///< share of yield_m kept from one that does not approach
static const float ONCE_MORE_M = 0.1f; ///< hysteresis: a retreat ends this much beyond yield_m
static const float YIELD_GAIN_PER_S = 1.5f; ///< retreat speed per metre that it is too near
static const float ROOM_M = 0.8f;           ///< more room than this has no further worth
static const float AWAY_M = 0.8f;     ///< worth of retreating straight away, as metres of room
static const float SAME_WAY_M = 0.2f; ///< worth of keeping the direction, as metres of room
static const float TOWARDS = -0.3f;   ///< directions with a smaller cosine approach the obstacle

guard_config_t guard_config_default(void) {
  return (guard_config_t){
      .slow_m = 0.6f,
      .stop_m = 0.20f, // propeller tips are 0.07 m out; the rest is for range noise and overshoot
      .retreat_m = 0.14f,
      .release_m = 0.21f,
      .retreat_mps = 0.25f,
      .yield_m = 0.6f,
      .yield_mps = 0.7f,
      .reaction_s = 0.25f, // ranges are up to 0.2 s old
      .brake_mps2 = 0.8f,
  };
}

void guard_init(guard_t *guard) {
  *guard = (guard_t){.status = GUARD_CLEAR, .nearest_m = NOTHING_M};
}

static vec2_t beam_direction(int beam) {
  switch (beam) {
  case SCAN_FRONT:
    return (vec2_t){1.0f, 0.0f};
  case SCAN_BACK:
    return (vec2_t){-1.0f, 0.0f};
  case SCAN_LEFT:
    return (vec2_t){0.0f, 1.0f};
  default:
    return (vec2_t){0.0f, -1.0f};
  }
}

static vec2_t left_of(vec2_t direction) {
  return (vec2_t){-direction.y, direction.x};
}

static float level_range(const float *range_m, int beam) {
  return range_m[beam] >= 0.0f && range_m[beam] < NOTHING_M ? range_m[beam] : NOTHING_M;
}

/** Unit vector away from what is nearer than within_m, each beam weighted by how much nearer. */
static vec2_t away_from_near(const float *range_m, float within_m) {
  vec2_t away = {0.0f, 0.0f};
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float depth_m = within_m - level_range(range_m, beam);
    if (depth_m > 0.0f) {
      away = vec2_sub(away, vec2_scale(beam_direction(beam), depth_m));
    }
  }
  float norm = vec2_norm(away);
  return norm > 1.0e-4f ? vec2_scale(away, 1.0f / norm) : (vec2_t){0.0f, 0.0f};
}

/** Limit the velocity's component in one direction so that the body stops within room_m:
 *  v reaction_s + v^2 / (2 brake_mps2) <= room_m. @return true if it was slowed */
static bool limit(const guard_config_t *cfg, vec2_t direction, float room_m, vec2_t *velocity_mps) {
  float t = cfg->reaction_s;
  float most_mps =
      room_m > 0.0f ? cfg->brake_mps2 * (sqrtf(t * t + 2.0f * room_m / cfg->brake_mps2) - t) : 0.0f;
  float over_mps = vec2_dot(*velocity_mps, direction) - most_mps;
  if (over_mps <= 0.0f) {
    return false;
  }
  *velocity_mps = vec2_sub(*velocity_mps, vec2_scale(direction, over_mps));
  return true;
}

/** Likewise along each beam, to stop stop_m before its obstacle. */
static bool slow_down(const guard_config_t *cfg, const float *range_m, float stop_m,
                      vec2_t *velocity_mps) {
  bool slowed = false;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float room_m = level_range(range_m, beam) - stop_m;
    slowed = limit(cfg, beam_direction(beam), room_m, velocity_mps) || slowed;
  }
  return slowed;
}

static float seconds(uint32_t now_ms, uint32_t then_ms) {
  return (float)(now_ms - then_ms) * 0.001f;
}

/** May this set be compared with the previous one beam by beam? */
static bool steady(const guard_t *guard, const scan_frame_t *frame) {
  float turned_rad = geometry_wrap_rad(frame->pose.yaw_rad - guard->seen_from.yaw_rad);
  float elapsed_s = seconds(frame->time_ms, guard->seen_ms);
  return fabsf(turned_rad) < STEADY_RAD && elapsed_s > 0.0f && elapsed_s < SET_S;
}

/** Does a beam's echo come nearer faster than the body's own motion explains? Motion across the
 *  beam counts in full, as it shortens the range to a wall at 45 degrees by as much. */
static bool comes(const guard_t *guard, const scan_frame_t *frame, int beam) {
  vec2_t step_m = vec2_sub(pose2_position(frame->pose), pose2_position(guard->seen_from));
  vec2_t direction = vec2_rotate(beam_direction(beam), frame->pose.yaw_rad);
  float explained_m = vec2_dot(step_m, direction) + fabsf(vec2_dot(step_m, left_of(direction)));
  float elapsed_s = seconds(frame->time_ms, guard->seen_ms);
  float came_m = guard->seen_m[beam] - explained_m - frame->range_m[beam];
  return came_m > COMING_MPS * elapsed_s && came_m < RUNNING_MPS * elapsed_s;
}

static float median(float a, float b, float c) {
  return geometry_clamp(c, a < b ? a : b, a < b ? b : a);
}

/** Update slip_mps along each body axis. The two opposite beams each tell how far the body really
 *  moved; the median of both and of the present value is low-pass filtered. A single beam counts
 *  alone. */
static void note_slip(guard_t *guard, const scan_frame_t *frame) {
  pose2_t step = pose2_compose(pose2_inverse(guard->seen_from), frame->pose);
  const float moved_m[2] = {step.x_m, step.y_m};
  vec2_t known_mps = vec2_rotate(guard->slip_mps, -frame->pose.yaw_rad);
  float slip_mps[2] = {known_mps.x, known_mps.y};
  float elapsed_s = seconds(frame->time_ms, guard->seen_ms);
  for (int axis = 0; axis < 2; axis++) {
    float told_mps[2];
    int count = 0;
    for (int side = 0; side < 2; side++) {
      int beam = 2 * axis + side;
      float sign = side == 0 ? 1.0f : -1.0f;
      if ((frame->hit >> beam & 1) != 0 && guard->seen_m[beam] > 0.0f) {
        float nearer_m = guard->seen_m[beam] - frame->range_m[beam];
        told_mps[count++] = (moved_m[axis] - sign * nearer_m) / elapsed_s;
      }
    }
    if (count > 0) {
      float off_mps = median(told_mps[0], told_mps[count - 1], slip_mps[axis]) - slip_mps[axis];
      slip_mps[axis] += SLIP_GAIN * geometry_clamp(off_mps, -1.0f, 1.0f);
    }
  }
  guard->slip_mps = vec2_rotate((vec2_t){slip_mps[0], slip_mps[1]}, frame->pose.yaw_rad);
}

/** Mark a beam whose range fell farther between two sets than anything runs: it may be a false
 *  echo, which the next set will tell. */
static void note_fall(guard_t *guard, int beam, float range_m) {
  float before_m = guard->seen_m[beam];
  bool ran = before_m == 0.0f || before_m - range_m > FALL_M;
  uint8_t bit = (uint8_t)(1u << beam);
  guard->doubtful = (uint8_t)(ran ? guard->doubtful | bit : guard->doubtful & ~bit);
}

/** Score a beam that jumps between near echoes: its sensor may be broken. */
static void note_jump(guard_t *guard, int beam, float range_m) {
  float before_m = guard->seen_m[beam];
  bool both = before_m > 0.0f && range_m > 0.0f && before_m < RESTLESS_M && range_m < RESTLESS_M;
  uint8_t *count = &guard->restless[beam];
  if (both && fabsf(range_m - before_m) > JUMP_M) {
    *count = (uint8_t)(*count < GUARD_RESTLESS ? *count + JUMP_SETS : *count);
  } else if (*count > 0) {
    (*count)--;
  }
}

/** Take the echo of an approaching obstacle: of the one known, or of another that replaces it if it
 *  is nearer and no less certain. Only two sets that can be compared tell its speed. */
static void meet(guard_t *guard, const scan_frame_t *frame, vec2_t echo_m, bool unexplained) {
  vec2_t here = pose2_position(frame->pose);
  float elapsed_s = guard->met ? seconds(frame->time_ms, guard->intruder_ms) : NEVER_S;
  float nearer_m = vec2_distance(guard->intruder_m, here) - vec2_distance(echo_m, here);
  bool known = elapsed_s < GUARD_REMEMBERED_S;
  bool same = known && vec2_distance(guard->intruder_m, echo_m) < SAME_M;
  bool less = unexplained && !guard->unexplained;
  if (known && !same && (nearer_m < 0.0f || less)) {
    return;
  }
  guard->unexplained = unexplained && (!same || guard->unexplained);
  if (!same) {
    guard->intruder_mps = 0.0f;
    guard->way = -1;
    guard->met = true;
  } else if (elapsed_s > 0.0f && elapsed_s < AHEAD_S && steady(guard, frame)) {
    float mps = geometry_clamp(nearer_m / elapsed_s, -RUNNING_MPS, RUNNING_MPS);
    guard->intruder_mps += 0.5f * (mps - guard->intruder_mps);
  }
  if (!same || vec2_distance(guard->met_m, echo_m) > MOVED_M) {
    guard->met_ms = frame->time_ms;
    guard->met_m = echo_m;
  }
  guard->intruder_m = echo_m;
  guard->intruder_ms = frame->time_ms;
}

/** One range in three hundred is a false echo, so a single one is not believed: the previous set
 *  must have had one nearby, or a known approaching obstacle be there. */
static bool told_twice(guard_t *guard, uint32_t now_ms, vec2_t echo_m) {
  bool again = seconds(now_ms, guard->hint_ms) < SET_S;
  bool there = again && vec2_distance(guard->hint_m, echo_m) < SAME_M;
  bool known = guard->met && seconds(now_ms, guard->intruder_ms) < GUARD_REMEMBERED_S;
  guard->hint_m = echo_m;
  guard->hint_ms = now_ms;
  return there || (known && vec2_distance(guard->intruder_m, echo_m) < SAME_M);
}

/** Is the echo of this beam an implausible fall, and its first jump for a while? The next set will
 *  tell whether something is there. */
static bool lone_fall(const guard_t *guard, int beam) {
  return (guard->doubtful >> beam & 1) != 0 && guard->restless[beam] <= JUMP_SETS;
}

/** Class of an echo: 2 an approaching obstacle, 1 near and not explained by the map, 0 neither. */
static int note_of(int judged, int sets, float range_m) {
  bool intruder =
      judged == GRID_ECHO_STRANGE || (judged == GRID_ECHO_UNEXPLAINED && sets >= COMING_SETS);
  return intruder ? 2 : judged == GRID_ECHO_UNEXPLAINED && range_m < UNEXPLAINED_M;
}

void guard_watch(guard_t *guard, const guard_config_t *cfg, const scan_frame_t *frame,
                 const uint8_t *judged) {
  int nearest = -1;
  int most = 0;
  bool tells = steady(guard, frame);
  if (tells) {
    note_slip(guard, frame);
  }
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float range_m = frame->range_m[beam];
    bool near = (frame->hit >> beam & 1) != 0 && range_m < WATCHED_M;
    bool coming = near && tells && guard->seen_m[beam] > 0.0f && comes(guard, frame, beam);
    int sets = coming ? guard->coming[beam] + 1 : 0;
    guard->coming[beam] = (uint8_t)(sets < COMING_SETS ? sets : COMING_SETS);
    note_fall(guard, beam, range_m);
    note_jump(guard, beam, near ? range_m : 0.0f);
    guard->seen_m[beam] = near ? range_m : 0.0f;
    bool believed = near && guard->restless[beam] < DOUBTED;
    int note = believed ? note_of(judged[beam], sets, range_m) : 0;
    if (note > most || (note == most && note > 0 && range_m < frame->range_m[nearest])) {
      nearest = beam;
      most = note;
    }
  }
  if (nearest >= 0 && cfg->yield_m > 0.0f) {
    vec2_t offset_m = vec2_scale(beam_direction(nearest), frame->range_m[nearest]);
    vec2_t echo_m = pose2_apply(frame->pose, offset_m);
    if (told_twice(guard, frame->time_ms, echo_m) && !lone_fall(guard, nearest)) {
      meet(guard, frame, echo_m, most == 1);
    }
  }
  guard->seen_from = frame->pose;
  guard->seen_ms = frame->time_ms;
}

vec2_t guard_slip(const guard_t *guard, float yaw_rad) {
  return vec2_limit(vec2_rotate(guard->slip_mps, -yaw_rad), GUARD_SLIP_MPS);
}

bool guard_intruder(const guard_t *guard, const scan_odometry_t *body, vec2_t *offset_m) {
  *offset_m = pose2_apply(pose2_inverse(body->pose), guard->intruder_m);
  return guard->met && seconds(body->time_ms, guard->intruder_ms) < GUARD_REMEMBERED_S;
}

/** How much nearer than allowed the approaching obstacle is, or will be once the body responds. */
static float too_near_m(const guard_t *guard, const guard_config_t *cfg,
                        const scan_odometry_t *body, float distance_m) {
  float age_s = seconds(body->time_ms, guard->intruder_ms);
  float ahead_s = (age_s < AHEAD_S ? age_s : AHEAD_S) + cfg->reaction_s;
  float kept_m = STANDING * cfg->yield_m;
  if (guard->intruder_mps > COMING_MPS) {
    distance_m -= guard->intruder_mps * ahead_s;
    kept_m = cfg->yield_m + (guard->status == GUARD_RETREAT ? ONCE_MORE_M : 0.0f);
  }
  return kept_m - distance_m;
}

/** Choose the beam to retreat along, as only there the room is measured: straight away, or sideways
 *  where there is more room, with a preference for the present choice so that it does not
 *  alternate. @return -1 if there is no room at all */
static int way_out(const guard_t *guard, const guard_config_t *cfg, const float *range_m) {
  int best = -1;
  float best_m = 0.0f;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float along = vec2_dot(beam_direction(beam), guard->away);
    float room_m = geometry_clamp(level_range(range_m, beam) - cfg->stop_m, 0.0f, ROOM_M);
    float worth_m = room_m + AWAY_M * along + (beam == guard->way ? SAME_WAY_M : 0.0f);
    if (along > TOWARDS && room_m > 0.0f && worth_m > best_m) {
      best = beam;
      best_m = worth_m;
    }
  }
  return best;
}

/** Retreat velocity: the speed of the approach, and more the nearer the obstacle is. */
static vec2_t give_way(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                       float near_m) {
  guard->way = (int8_t)way_out(guard, cfg, range_m);
  if (guard->way < 0) {
    return (vec2_t){0.0f, 0.0f};
  }
  float comes_mps = guard->intruder_mps > 0.0f ? guard->intruder_mps : 0.0f;
  float speed_mps = geometry_clamp(comes_mps + YIELD_GAIN_PER_S * near_m, 0.0f, cfg->yield_mps);
  vec2_t velocity_mps = vec2_scale(beam_direction(guard->way), speed_mps);
  slow_down(cfg, range_m, cfg->stop_m, &velocity_mps);
  return velocity_mps;
}

/** Nearest level range, beams of the bit mask `without` left out. */
static float nearest_of(const float *range_m, unsigned without) {
  float nearest_m = NOTHING_M;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float range = (without >> beam & 1u) != 0 ? NOTHING_M : level_range(range_m, beam);
    nearest_m = range < nearest_m ? range : nearest_m;
  }
  return nearest_m;
}

vec2_t guard_step(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                  const scan_odometry_t *body, vec2_t wanted_mps) {
  guard->nearest_m = nearest_of(range_m, 0);
  vec2_t velocity_mps = wanted_mps;
  bool slowed = slow_down(cfg, range_m, cfg->stop_m, &velocity_mps);
  vec2_t offset_m;
  vec2_t towards = {0.0f, 0.0f};
  float room_m = 0.0f;
  if (guard_intruder(guard, body, &offset_m)) { // retreat from it, or at least fly no nearer to it
    float distance_m = vec2_norm(offset_m) + 1.0e-3f;
    float near_m = too_near_m(guard, cfg, body, distance_m);
    float met_s = seconds(body->time_ms, guard->met_ms);
    bool stays = guard->unexplained || (guard->intruder_mps < STAYING_MPS && met_s > STAYS_S);
    towards = vec2_scale(offset_m, 1.0f / distance_m);
    guard->away = vec2_scale(towards, -1.0f);
    room_m = -near_m;
    if (near_m > 0.0f && !stays) {
      guard->status = GUARD_RETREAT;
      return give_way(guard, cfg, range_m, near_m);
    }
    if (guard->intruder_mps > COMING_MPS || stays) {
      slowed = limit(cfg, towards, room_m, &velocity_mps) || slowed;
    }
  }
  // back away from anything too near; until confirmed, a doubtful beam only stops the flight
  float bound_m = guard->status == GUARD_RETREAT ? cfg->release_m : cfg->retreat_m;
  bool fresh = seconds(body->time_ms, guard->seen_ms) < DOUBT_S;
  if (nearest_of(range_m, fresh ? guard->doubtful : 0u) < bound_m) {
    guard->status = GUARD_RETREAT;
    guard->away = away_from_near(range_m, cfg->release_m);
    vec2_t retreat_mps = vec2_scale(guard->away, cfg->retreat_mps);
    limit(cfg, towards, room_m, &retreat_mps);
    slow_down(cfg, range_m, cfg->stop_m, &retreat_mps);
    return retreat_mps;
  }
  guard->away = (vec2_t){0.0f, 0.0f};
  bool stopped = slowed && vec2_norm(velocity_mps) < 0.1f * vec2_norm(wanted_mps);
  guard->status = stopped                                    ? GUARD_STOP
                  : slowed || guard->nearest_m < cfg->slow_m ? GUARD_SLOW
                                                             : GUARD_CLEAR;
  return velocity_mps;
}
