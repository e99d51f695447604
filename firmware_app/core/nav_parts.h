// SPDX-License-Identifier: GPL-3.0-or-later
/** @file nav_parts.h  Shared by the source files of nav only. */
#ifndef NAV_PARTS_H
#define NAV_PARTS_H

#include "nav.h"

enum { NAV_LOOKS = 4 /* stop-and-looks of a plan before "no way" is final */ };

/** Time of this tick. */
uint32_t nav_now_ms(const nav_t *nav);
/** Queue an event for the ground station. */
void nav_emit(nav_t *nav, wire_event_code_t code, uint8_t argument, vec2_t place_m);
/** Apply an event to the mission, and set up the state that it enters. */
void nav_apply(nav_t *nav, mission_event_t event);
/** Remember a fault and report it. */
void nav_fault(nav_t *nav, mission_reason_t reason);
/** Start a task. */
void nav_set_task(nav_t *nav, mission_task_t task);
/** Make an empty map by the present configuration. A new epoch tells the ground station. */
void nav_make_map(nav_t *nav);

/** Start SLAM with the map's origin at the drone. */
void nav_start_slam(nav_t *nav);
/** Update odometry and the map pose from the firmware's estimate in nav->input. On the ground it
 *  sees through estimator resets; before the first take-off the map's origin stays at the drone. */
void nav_tie_frames(nav_t *nav, pose2_t odometry_before);
/** The firmware's estimate of this tick. */
pose2_t nav_estimate(const nav_t *nav);
/** Confidence of the map pose [%]. */
uint8_t nav_confidence(const nav_t *nav);

/** Does a goal lie within the grid and the geofence? Obstacles are not considered. */
mission_reason_t nav_check_place(const nav_t *nav, vec2_t goal_m);
/** Start along the waypoint list. @return MISSION_OK, or why it cannot be flown */
mission_reason_t nav_start_waypoints(nav_t *nav, mission_task_t task);
/** At the end of a route: report a waypoint. @return true if the drone flies on to the next one */
bool nav_pass_waypoint(nav_t *nav);
/** Leave out a waypoint that cannot be reached. @return true if nav->goal_m is another one now */
bool nav_skip_waypoint(nav_t *nav, mission_reason_t reason);
/** Reset what planning tried and gave up in the previous task. */
void nav_plan_afresh(nav_t *nav);
/** Distance that plans keep from obstacles at present. */
float nav_clearance_m(const nav_t *nav);
/** Run one slice of planning if the state needs it. plan.stage = NAV_PLAN_BEGIN asks for a plan. */
void nav_plan_step(nav_t *nav);

/** The pose in the map is unknown from now on: nothing is drawn or matched until it is found. */
void nav_lose(nav_t *nav);
/** Set up MISSION_RELOCALISE. */
void nav_reloc_start(nav_t *nav);
/** Leave MISSION_RELOCALISE: the memory belongs to the planner again. */
void nav_reloc_stop(nav_t *nav);
/** Run one slice of relocalisation. */
void nav_reloc_step(nav_t *nav);
/** Motion that shows the surroundings while relocalising. */
follower_command_t nav_reloc_move(nav_t *nav);
/** On the ground: a drone that is lifted with its motors off is lost. */
void nav_watch_lifting(nav_t *nav);

/** Does a range sensor fail: stuck, dead, broken, or all without return? */
bool nav_half_blind(const nav_t *nav);
/** Count for each beam of a set whether it fails to return. */
void nav_check_beams(nav_t *nav, const scan_frame_t *frame, pose2_t map_pose);
/** Apply the policies on supervisor, battery, link and sensors. */
void nav_watch(nav_t *nav);
/** Update nav->limits by the present map. @return true if the rest of the route is clear */
bool nav_look_along(nav_t *nav);
/** Is the drone flown by hand at present? */
bool nav_is_steered(const nav_t *nav);
/** Does the drone hover without being flown by hand? */
bool nav_rests(const nav_t *nav);
/** Motion that the stick wants; updates post and height setpoint. */
follower_command_t nav_follow_stick(nav_t *nav);
/** Setpoint of the present state, limited by the guard.
 *  @param fresh  a new set was measured in this tick */
nav_setpoint_t nav_move(nav_t *nav, bool fresh);

#endif
