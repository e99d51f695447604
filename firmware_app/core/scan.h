// SPDX-License-Identifier: GPL-3.0-or-later
/** @file scan.h  Five ranges and odometry in, beams with the pose at which they were measured out.
 * Stage 1. The Multi-ranger publishes all ranges together every 100 ms, without a time stamp,
 * 60-100 ms after the measurement. The stage notices a new set by its change, dates it back by the
 * latency and takes the pose from a short history. Each set is used once; when no sensor answers
 * nothing changes, and a set is taken every period. Tilt is taken out; a beam that may have met the
 * floor is dropped. */
#ifndef SCAN_H
#define SCAN_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"

enum {
  SCAN_FRONT,
  SCAN_BACK,
  SCAN_LEFT,
  SCAN_RIGHT,
  SCAN_UP,
  SCAN_RANGES,
  SCAN_BEAMS = SCAN_UP, ///< the horizontal ones
  SCAN_HISTORY = 12,    ///< poses kept, one a tick: 240 ms at 50 Hz
};

typedef struct {
  uint32_t latency_ms;     ///< from the measurement to the first tick that sees it
  uint32_t period_ms;      ///< between two sets
  float min_range_m;       ///< nearer echoes are not trusted
  float max_range_m;       ///< farther echoes are treated as none
  float no_return_clear_m; ///< a beam without echo clears this far: dark or oblique walls answer no
                           ///< farther
  float floor_margin_m;    ///< a beam ending lower than this above the floor is dropped
  float offset_m[SCAN_RANGES]; ///< sensor's distance from the body's centre, along its beam
} scan_config_t;

/** What the body does now, in the odometry frame. */
typedef struct {
  uint32_t time_ms;
  pose2_t pose;
  float height_m;
  float roll_rad;  ///< right side down positive
  float pitch_rad; ///< nose up positive, as the firmware's stateEstimate.pitch
} scan_odometry_t;

/** One measured set, as seen from pose. Bit b of the masks stands for beam b. */
typedef struct {
  uint32_t time_ms;          ///< when it was measured
  pose2_t pose;              ///< odometry frame, when it was measured
  float range_m[SCAN_BEAMS]; ///< level distance from the body's centre
  uint8_t hit;               ///< the beam ended on something
  uint8_t clear;             ///< nothing answered up to range_m
} scan_frame_t;

typedef struct {
  scan_config_t cfg;
  scan_odometry_t history[SCAN_HISTORY];
  uint8_t newest;
  uint8_t count;
  uint32_t changed_ms;          ///< when the ranges last changed, or when no sensor answered
  uint32_t answered_ms;         ///< when a sensor last answered, up included
  float last_m[SCAN_RANGES];    ///< as published; < 0 where invalid
  uint8_t repeats[SCAN_RANGES]; ///< ticks in a row in which this one did not change
} scan_t;

scan_config_t scan_config_default(void);
void scan_init(scan_t *scan, const scan_config_t *cfg);

/** Direction of a beam in the body frame [rad]. */
float scan_bearing_rad(int beam);

/** Take this tick's odometry and published ranges.
 *  @param range_m SCAN_RANGES distances [m], negative or not finite where the sensor reports none
 *  @return true if the ranges are new; then *frame is filled */
bool scan_step(scan_t *scan, const scan_odometry_t *odometry, const float *range_m,
               scan_frame_t *frame);

/** It said the same in set after set: no echo, or what no living sensor repeats, as its noise is
 * more than a millimetre. */
bool scan_unchanged(const scan_t *scan, int beam);

/** Milliseconds since any sensor answered. */
uint32_t scan_silent_ms(const scan_t *scan, uint32_t time_ms);
/** Milliseconds since the ranges last changed. */
uint32_t scan_age_ms(const scan_t *scan, uint32_t time_ms);

#endif
