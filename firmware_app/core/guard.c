// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "guard.h"

#include <math.h>

enum {
  COMING_SETS = 3, ///< in a row: no noise comes nearer so often
  DOUBTED = 8,     ///< so restless, a beam tells of no comer
  JUMP_SETS = 2,   ///< a jump counts as much as so many sets without
};

static const float NOTHING_M = 100.0f;
static const float NEVER_S = 1000.0f;
static const float WATCHED_M = 2.0f;   ///< farther away nothing is a comer
static const float UNTOLD_M = 0.75f;   ///< nor what the map merely does not explain
static const float STEADY_RAD = 0.04f; ///< a set turned more against the one before tells no rate
static const float SET_S = 0.3f;       ///< nor does one that comes later
static const float DOUBT_S = 0.3f;     ///< so long a set that none has confirmed is doubted
static const float COMING_MPS = 0.2f;  ///< slower than this is noise
static const float STAYING_MPS = 0.1f; ///< slower than this for so long, it is as good as a wall,
static const float STAYS_S = 3.0f;     ///< but that nobody goes nearer to it
static const float MOVED_M = 0.3f;     ///< farther from where it was met, it does not stay
static const float RUNNING_MPS = 2.5f; ///< faster is another thing in the beam
static const float SAME_M = 0.5f;      ///< so near to where it was met, it is the same comer
static const float RESTLESS_M = 1.2f;
static const float JUMP_M = 0.2f;      ///< from a set to the next
static const float FALL_M = 0.25f;     ///< likewise, nearer than anybody runs
static const float SLIP_GAIN = 0.3f;   ///< a set's share
static const float AHEAD_S = 0.5f;     ///< so long it is thought to go on coming
static const float STANDING = 0.6f;    ///< of the distance, kept from one that stands still
static const float ONCE_MORE_M = 0.1f; ///< farther than this beyond the distance the retreat ends
static const float YIELD_GAIN_PER_S = 1.5f;
static const float ROOM_M = 0.8f;     ///< more room is not better
static const float AWAY_M = 0.8f;     ///< of room are worth it to go straight away, not aside
static const float SAME_WAY_M = 0.2f; ///< and to go on as before
static const float TOWARDS = -0.3f;   ///< a way whose cosine is less goes towards the comer

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

/** Unit vector away from the centre of what is near, each beam weighing by how far it lies within
 * `within_m`. */
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

/** Take out of a velocity what goes too fast in one direction, in which there is that much room:
 * the body still stops in time if v reaction + v^2 / (2 brake) <= room. @return true if it was
 * slowed */
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

/** Likewise towards each beam's obstacle, to stop stop_m before it. */
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

static bool steady(const guard_t *guard, const scan_frame_t *frame) {
  float turned_rad = geometry_wrap_rad(frame->pose.yaw_rad - guard->seen_from.yaw_rad);
  float elapsed_s = seconds(frame->time_ms, guard->seen_ms);
  return fabsf(turned_rad) < STEADY_RAD && elapsed_s > 0.0f && elapsed_s < SET_S;
}

/** Does a beam's echo come nearer, faster than the body's own motion explains, walls at 45 degrees
 * beside it included? */
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

/** How much faster odometry is than the body, along each of its axes: what echoes on both sides
 * agree on. */
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

/** A beam that tells at once of something so near that it would have had to run there: of nothing,
 * perhaps. The next set knows. */
static void note_fall(guard_t *guard, int beam, float range_m) {
  float before_m = guard->seen_m[beam];
  bool ran = before_m == 0.0f || before_m - range_m > FALL_M;
  uint8_t bit = (uint8_t)(1u << beam);
  guard->doubtful = (uint8_t)(ran ? guard->doubtful | bit : guard->doubtful & ~bit);
}

/** Does a beam tell something else near by in every set? */
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

/** A comer's echo: the same comer goes on, or another one is nearer. How fast it comes is told by a
 * beam that is held on it. */
static void meet(guard_t *guard, const scan_frame_t *frame, vec2_t echo_m, bool untold) {
  vec2_t here = pose2_position(frame->pose);
  float elapsed_s = guard->met ? seconds(frame->time_ms, guard->comer_ms) : NEVER_S;
  float nearer_m = vec2_distance(guard->comer_m, here) - vec2_distance(echo_m, here);
  bool known = elapsed_s < GUARD_REMEMBERED_S;
  bool same = known && vec2_distance(guard->comer_m, echo_m) < SAME_M;
  bool less = untold && !guard->untold;
  if (known && !same && (nearer_m < 0.0f || less)) {
    return;
  }
  guard->untold = untold && (!same || guard->untold);
  if (!same) {
    guard->comer_mps = 0.0f;
    guard->way = -1;
    guard->met = true;
  } else if (elapsed_s > 0.0f && elapsed_s < AHEAD_S && steady(guard, frame)) {
    float mps = geometry_clamp(nearer_m / elapsed_s, -RUNNING_MPS, RUNNING_MPS);
    guard->comer_mps += 0.5f * (mps - guard->comer_mps);
  }
  if (!same || vec2_distance(guard->met_m, echo_m) > MOVED_M) {
    guard->met_ms = frame->time_ms;
    guard->met_m = echo_m;
  }
  guard->comer_m = echo_m;
  guard->comer_ms = frame->time_ms;
}

/** No single echo is a comer, for some are of nothing: what was there a set before is, and what
 * goes on where a comer was. */
static bool told_twice(guard_t *guard, uint32_t now_ms, vec2_t echo_m) {
  bool again = seconds(now_ms, guard->hint_ms) < SET_S;
  bool there = again && vec2_distance(guard->hint_m, echo_m) < SAME_M;
  bool known = guard->met && seconds(now_ms, guard->comer_ms) < GUARD_REMEMBERED_S;
  guard->hint_m = echo_m;
  guard->hint_ms = now_ms;
  return there || (known && vec2_distance(guard->comer_m, echo_m) < SAME_M);
}

/** How a beam's echo looks: 2 a comer, 1 near and not explained by the map, 0 nothing of note. */
static int note_of(int judged, int sets, float range_m) {
  bool comer = judged == GRID_ECHO_STRANGE || (judged == GRID_ECHO_UNTOLD && sets >= COMING_SETS);
  return comer ? 2 : judged == GRID_ECHO_UNTOLD && range_m < UNTOLD_M;
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
    if (told_twice(guard, frame->time_ms, echo_m)) {
      meet(guard, frame, echo_m, most == 1);
    }
  }
  guard->seen_from = frame->pose;
  guard->seen_ms = frame->time_ms;
}

vec2_t guard_slip(const guard_t *guard, float yaw_rad) {
  return vec2_limit(vec2_rotate(guard->slip_mps, -yaw_rad), GUARD_SLIP_MPS);
}

bool guard_comer(const guard_t *guard, const scan_odometry_t *body, vec2_t *offset_m) {
  *offset_m = pose2_apply(pose2_inverse(body->pose), guard->comer_m);
  return guard->met && seconds(body->time_ms, guard->comer_ms) < GUARD_REMEMBERED_S;
}

/** How much nearer than it should the comer is, or will be when the body answers [m]. */
static float too_near_m(const guard_t *guard, const guard_config_t *cfg,
                        const scan_odometry_t *body, float distance_m) {
  float age_s = seconds(body->time_ms, guard->comer_ms);
  float ahead_s = (age_s < AHEAD_S ? age_s : AHEAD_S) + cfg->reaction_s;
  float kept_m = STANDING * cfg->yield_m;
  if (guard->comer_mps > COMING_MPS) {
    distance_m -= guard->comer_mps * ahead_s;
    kept_m = cfg->yield_m + (guard->status == GUARD_RETREAT ? ONCE_MORE_M : 0.0f);
  }
  return kept_m - distance_m;
}

/** The beam to back along: it moves only where a beam looks. Away from the comer, or aside where
 * there is more room; not to and fro. @return -1 if there is no room at all */
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

/** Out of the way of the comer as fast as it comes, and faster the nearer it is. */
static vec2_t give_way(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                       float near_m) {
  guard->way = (int8_t)way_out(guard, cfg, range_m);
  if (guard->way < 0) {
    return (vec2_t){0.0f, 0.0f};
  }
  float comes_mps = guard->comer_mps > 0.0f ? guard->comer_mps : 0.0f;
  float speed_mps = geometry_clamp(comes_mps + YIELD_GAIN_PER_S * near_m, 0.0f, cfg->yield_mps);
  vec2_t velocity_mps = vec2_scale(beam_direction(guard->way), speed_mps);
  slow_down(cfg, range_m, cfg->stop_m, &velocity_mps);
  return velocity_mps;
}

/** Nearest range of the beams that are not in this mask. */
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
  if (guard_comer(guard, body, &offset_m)) {
    float distance_m = vec2_norm(offset_m) + 1.0e-3f;
    float near_m = too_near_m(guard, cfg, body, distance_m);
    float met_s = seconds(body->time_ms, guard->met_ms);
    bool stays = guard->untold || (guard->comer_mps < STAYING_MPS && met_s > STAYS_S);
    towards = vec2_scale(offset_m, 1.0f / distance_m);
    guard->away = vec2_scale(towards, -1.0f);
    room_m = -near_m;
    if (near_m > 0.0f && !stays) {
      guard->status = GUARD_RETREAT;
      return give_way(guard, cfg, range_m, near_m);
    }
    if (guard->comer_mps > COMING_MPS || stays) {
      slowed = limit(cfg, towards, room_m, &velocity_mps) || slowed;
    }
  }
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
