// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Three frames. The estimate is the firmware's stateEstimate; positioning systems pull it about,
 * and so does this app with way.slam 2. Odometry is the estimate with these pulls taken out: motion
 * and nothing else. The map frame is tied to odometry by SLAM. */
#include <math.h>

#include "nav.h"
#include "nav_parts.h"

enum {
  TAKEN_TICKS = 2,         ///< ticks within which the estimator applies a fix
  SETTLE_MS = 1000,        ///< a positioning system that measures for this long is trusted
  YAW_YAW = 5,             ///< index of the yaw's variance in the filter's covariance
  CONFIDENT_PERCENT = 100, ///< while a positioning system measures
};

static const float JUMP_M = 0.5f;       ///< in one tick: an estimator reset, as no drone does that
static const float PULL_M = 0.01f;      ///< estimate minus velocity in a tick: more is a pull
static const float STILL_RPS = 0.035f;  ///< gyro of a drone that stands still, at most
static const float SAME_PLACE_M = 0.5f; ///< shift up to which a returning system's frame is the old
static const float SAME_YAW_RAD = 0.26f; ///< turn up to which it is
/** Factor on the variance of a fix. Successive matches share errors of beams and map, and the
 *  estimator averages over about three of them: so it is never surer than SLAM. */
static const float SHARED = 3.0f;

static const pose2_t NOWHERE = {0.0f, 0.0f, 0.0f};

static bool grounded(const nav_t *nav) {
  return !mission_airborne(nav->mission.state) && (nav->input.flags & NAV_IS_FLYING) == 0;
}

/** Motion of this tick by velocity and gyro, in the body frame at its start. */
static pose2_t felt(const nav_t *nav, float yaw_rad) {
  float turned_rad = nav->input.yaw_rate_rps * nav->tick_s;
  vec2_t moved_m =
      vec2_rotate(vec2_scale(nav->input.velocity_mps, nav->tick_s), turned_rad - yaw_rad);
  return (pose2_t){moved_m.x, moved_m.y, turned_rad};
}

/** Motion of this tick on the ground: none but the gyro's, for a hand may turn the drone. The
 *  estimate moves there, as flow drifts and the firmware lets its yaw creep back to where it began.
 *  Lifting is noticed by nav_watch_lifting(). */
static pose2_t stands(const nav_t *nav) {
  float rate_rps = nav->input.yaw_rate_rps;
  return (pose2_t){0.0f, 0.0f, fabsf(rate_rps) > STILL_RPS ? rate_rps * nav->tick_s : 0.0f};
}

/** Was the estimate pulled in this tick, by a fix or a positioning system? One that returns pulls
 *  before its status says that it measures. */
static bool pulled(nav_t *nav, pose2_t step, pose2_t by_feel) {
  if (nav->told_ticks > 0) {
    nav->told_ticks--;
    return true;
  }
  bool may_come = nav->has_absolute || nav->input.positioning != NAV_POSITIONING_NONE;
  vec2_t off_m = vec2_sub(pose2_position(step), pose2_position(by_feel));
  return may_come && !nav->aside && vec2_norm(off_m) > PULL_M;
}

/** Map pose of the estimate if a positioning system measures in the same frame as it did before.
 *  @return false if none ever measured, or the pose is far from the believed one */
static bool measured_place(const nav_t *nav, pose2_t estimate, pose2_t *place) {
  *place = pose2_compose(nav->absolute, estimate);
  float off_m = vec2_distance(pose2_position(*place), pose2_position(nav->pose));
  float off_rad = geometry_wrap_rad(place->yaw_rad - nav->pose.yaw_rad);
  return nav->has_absolute && off_m < SAME_PLACE_M && fabsf(off_rad) < SAME_YAW_RAD;
}

/** Convert nav->input from the estimate to odometry. @return false if the estimate has jumped */
static bool take_out_pulls(nav_t *nav, pose2_t before) {
  pose2_t estimate = nav->input.odometry.pose;
  if (!nav->mapped) {
    nav->from_estimate = NOWHERE;
  }
  pose2_t odometry = pose2_compose(nav->from_estimate, estimate);
  nav->input.velocity_mps = vec2_rotate(nav->input.velocity_mps, nav->from_estimate.yaw_rad);
  pose2_t step = pose2_compose(pose2_inverse(before), odometry);
  pose2_t place;
  bool jumped = vec2_norm(pose2_position(step)) > JUMP_M && !measured_place(nav, estimate, &place);
  bool on_ground = nav->mapped && grounded(nav) && !nav->aside;
  pose2_t by_feel = on_ground ? stands(nav) : felt(nav, odometry.yaw_rad);
  bool moved_otherwise = on_ground || pulled(nav, step, by_feel);
  if (moved_otherwise && !jumped) {
    odometry = pose2_compose(before, by_feel);
    nav->from_estimate = pose2_compose(odometry, pose2_inverse(estimate));
  }
  nav->input.odometry.pose = odometry;
  return !jumped;
}

pose2_t nav_estimate(const nav_t *nav) {
  return pose2_compose(pose2_inverse(nav->from_estimate), nav->input.odometry.pose);
}

/** Switch SLAM off while a positioning system measures, and on again afterwards. Neither moves the
 *  drone in the map, except when the map is tied to that system's frame as it was before. */
static void choose_slam(nav_t *nav, bool smooth) {
  if (nav->input.positioning == NAV_POSITIONING_NONE) {
    nav->unmeasured_ms = nav_now_ms(nav);
  }
  bool aside = nav_now_ms(nav) - nav->unmeasured_ms >= SETTLE_MS;
  bool enabled = nav->cfg.slam != NAV_SLAM_OFF && !aside;
  if (aside == nav->aside && enabled == nav->slam.enabled) {
    return;
  }
  pose2_t odometry = nav->input.odometry.pose;
  pose2_t estimate = nav_estimate(nav);
  pose2_t here = smooth ? slam_to_map(&nav->slam, odometry) : nav->pose;
  pose2_t place;
  if (aside && !nav->aside && measured_place(nav, estimate, &place)) {
    here = place;
  } else if (!aside && nav->aside) {
    nav->absolute = pose2_compose(here, pose2_inverse(estimate));
    nav->has_absolute = true;
  }
  slam_init(&nav->slam, &nav->cfg.slam_filter, enabled, odometry, here);
  nav->aside = aside;
}

void nav_start_slam(nav_t *nav) {
  nav->has_absolute = false;
  slam_init(&nav->slam, &nav->cfg.slam_filter, nav->cfg.slam != NAV_SLAM_OFF && !nav->aside,
            nav->input.odometry.pose, NOWHERE);
}

void nav_tie_frames(nav_t *nav, pose2_t odometry_before) {
  bool smooth = take_out_pulls(nav, odometry_before);
  choose_slam(nav, smooth);
  pose2_t odometry = nav->input.odometry.pose;
  if (!nav->mapped) {
    nav_start_slam(nav);
  } else if (!smooth && mission_airborne(nav->mission.state)) {
    nav_fault(nav, MISSION_ESTIMATOR);
    nav_lose(nav);
    nav_apply(nav, MISSION_EV_LAND);
  } else if (!smooth) {
    slam_tie(&nav->slam, odometry, nav->pose);
  }
  slam_predict(&nav->slam, odometry,
               grounded(nav) ? 0.0f : nav->tick_s); // bias and drift must not move a resting drone
  nav->pose = slam_pose(&nav->slam);
}

nav_source_t nav_source(const nav_t *nav) {
  if (nav->aside) {
    return (nav_source_t)(NAV_SOURCE_LIGHTHOUSE + nav->input.positioning -
                          NAV_POSITIONING_LIGHTHOUSE);
  }
  return (nav_source_t)nav->cfg.slam;
}

uint8_t nav_confidence(const nav_t *nav) {
  if (nav->mission.lost) {
    return 0;
  }
  return nav->aside ? CONFIDENT_PERCENT : nav->slam.confidence;
}

bool nav_take_fix(nav_t *nav, nav_fix_t *fix) {
  bool due = nav->matched && nav->cfg.slam == NAV_SLAM_ESTIMATOR && nav->slam.enabled &&
             mission_airborne(nav->mission.state) && !nav->mission.lost;
  nav->matched = false;
  float yaw_variance = nav->slam.filter.covariance[YAW_YAW];
  float sd_m = slam_filter_sd_m(&nav->slam.filter); // both axes together
  if (!due || !(yaw_variance > 0.0f) || !(sd_m > 0.0f)) {
    return false;
  }
  pose2_t estimate = nav_estimate(nav);
  fix->estimate = estimate;
  fix->off_m = vec2_sub(pose2_position(nav->pose), pose2_position(estimate));
  fix->off_rad = geometry_wrap_rad(nav->pose.yaw_rad - estimate.yaw_rad);
  fix->sd_m = sqrtf(0.5f * SHARED) * sd_m;
  fix->sd_rad = sqrtf(yaw_variance);
  nav->told_ticks = TAKEN_TICKS;
  return true;
}
