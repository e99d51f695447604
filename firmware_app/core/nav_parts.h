// SPDX-License-Identifier: GPL-3.0-or-later
/** @file nav_parts.h  What the files of nav share among themselves; nobody else includes it. */
#ifndef NAV_PARTS_H
#define NAV_PARTS_H

#include "nav.h"

enum { NAV_LOOKS = 4 /* turns to look around before "no way" is final */ };

uint32_t nav_now_ms(const nav_t *nav);
/** Queue an event for the ground. */
void nav_emit(nav_t *nav, wire_event_code_t code, uint8_t argument, vec2_t place_m);
/** Apply an event to the mission and do what entering the new state takes. */
void nav_apply(nav_t *nav, mission_event_t event);
/** Remember a fault and tell the ground. */
void nav_fault(nav_t *nav, mission_reason_t reason);
/** Give the drone a task now. */
void nav_set_task(nav_t *nav, mission_task_t task);
/** Empty grid and clearance for the present configuration; the ground is told by the epoch. */
void nav_make_map(nav_t *nav);

/** The map begins where the drone is. */
void nav_start_slam(nav_t *nav);
/** From the firmware's estimate in nav->input to odometry, and on to the pose in the map: on the
 * ground through estimator resets; before the first take-off the map begins wherever the drone
 * stands. */
void nav_tie_frames(nav_t *nav, pose2_t odometry_before);
/** The firmware's estimate as it was given. */
pose2_t nav_estimate(const nav_t *nav);
/** Of the pose, for the ground [%]. */
uint8_t nav_confidence(const nav_t *nav);

/** May the drone be sent there, whatever the map says? */
mission_reason_t nav_check_place(const nav_t *nav, vec2_t goal_m);
/** Set off along the way points. */
mission_reason_t nav_start_waypoints(nav_t *nav, mission_task_t task);
/** At the end of a route: a way point? @return true if it flies on to the next */
bool nav_pass_waypoint(nav_t *nav);
/** The present way point cannot be reached. @return true if it goes on to another; PLAN then has a
 * new goal */
bool nav_skip_waypoint(nav_t *nav, mission_reason_t reason);
/** For another task: nothing was tried or looked at in vain yet. */
void nav_plan_afresh(nav_t *nav);
/** What plans keep from obstacles now. */
float nav_clearance_m(const nav_t *nav);
/** One slice of planning, where the state asks for it. A new plan is asked for by plan.stage =
 * NAV_PLAN_BEGIN. */
void nav_plan_step(nav_t *nav);

/** From now on it does not know where it is in its map; nothing is drawn until it does. */
void nav_lose(nav_t *nav);
/** RELOCALISE is entered. */
void nav_start_looking(nav_t *nav);
/** RELOCALISE is left: the planner has its memory back. */
void nav_stop_looking(nav_t *nav);
/** One slice of looking for itself. */
void nav_look_step(nav_t *nav);
/** The motion that shows it its surroundings. */
follower_command_t nav_look_about(nav_t *nav);
/** On the ground: was it lifted, and set down elsewhere? */
void nav_watch_lifting(nav_t *nav);

/** A side is not seen: no beam answers there, or it is stuck. */
bool nav_half_blind(const nav_t *nav);
/** A set was measured in flight: does each beam answer where it should? */
void nav_check_beams(nav_t *nav, const scan_frame_t *frame, pose2_t map_pose);
/** Policies: battery, link, supervisor, estimator, ranges. */
void nav_watch(nav_t *nav);
/** How far the route may be flown by what the map says now. @return true if all the rest is clear
 */
bool nav_look_along(nav_t *nav);
/** A stick was taken of late. */
bool nav_is_steered(const nav_t *nav);
/** Holds its place, and nobody steers it. */
bool nav_rests(const nav_t *nav);
/** Then, the motion that it wants, height included; the post comes along. */
follower_command_t nav_follow_stick(nav_t *nav);
/** What the state wants the vehicle to do, past the guard. @param fresh the map was measured anew
 * in this tick */
nav_setpoint_t nav_move(nav_t *nav, bool fresh);

#endif
