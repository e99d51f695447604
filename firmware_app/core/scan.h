// SPDX-License-Identifier: GPL-3.0-or-later
/** @file scan.h  Stage 1: five ranges and odometry in, beams and the pose of their measurement out.
 *
 *  The Multi-ranger publishes all ranges together every 100 ms, without a time stamp, 60-100 ms
 *  after the measurement. This stage notices a new set by its change, dates it back by the latency
 *  and takes the pose of that moment from a short history. Each set is used once. While no sensor
 *  has a return nothing changes, so a set is assumed every period. Tilt is removed; a beam that may
 *  have hit the floor is dropped.
 */
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
  SCAN_BEAMS = SCAN_UP, ///< number of horizontal ranges
  SCAN_HISTORY = 12,    ///< poses kept, one per tick: 240 ms at 50 Hz
};

typedef struct {
  uint32_t latency_ms;         ///< from the measurement to the first tick that sees it
  uint32_t period_ms;          ///< between two sets
  float min_range_m;           ///< nearer echoes are dropped
  float max_range_m;           ///< farther echoes count as no return
  float no_return_clear_m;     ///< distance that is free along a beam without return
  float floor_margin_m;        ///< a beam that ends lower than this above the floor is dropped
  float offset_m[SCAN_RANGES]; ///< distance of the sensor from the body's centre, along its beam
} scan_config_t;

/** State of the body by odometry. */
typedef struct {
  uint32_t time_ms;
  pose2_t pose; ///< odometry frame
  float height_m;
  float roll_rad;  ///< positive right side down
  float pitch_rad; ///< positive nose up, as the firmware's stateEstimate.pitch
} scan_odometry_t;

/** One measured set. Bit b of the masks stands for beam b; a dropped beam is in neither. */
typedef struct {
  uint32_t time_ms;          ///< of the measurement
  pose2_t pose;              ///< of the body then, odometry frame
  float range_m[SCAN_BEAMS]; ///< level distance from the body's centre
  uint8_t hit;               ///< the beam ended on something at range_m
  uint8_t clear;             ///< no return: the beam is free up to range_m
} scan_frame_t;

typedef struct {
  scan_config_t cfg;
  scan_odometry_t history[SCAN_HISTORY];
  uint8_t newest;
  uint8_t count;
  uint32_t changed_ms;          ///< time of the last set
  uint32_t answered_ms;         ///< time of the last return of any sensor, up included
  float last_m[SCAN_RANGES];    ///< as published; negative: no return
  uint8_t repeats[SCAN_RANGES]; ///< ticks in a row without a change of this range
} scan_t;

scan_config_t scan_config_default(void);
void scan_init(scan_t *scan, const scan_config_t *cfg);

/** Direction of a beam in the body frame [rad]. */
float scan_bearing_rad(int beam);

/** Take this tick's odometry and published ranges.
 *  @param range_m SCAN_RANGES distances; negative or not finite: no return
 *  @return true if they are a new set; then *frame is filled */
bool scan_step(scan_t *scan, const scan_odometry_t *odometry, const float *range_m,
               scan_frame_t *frame);

/** Has a range been the same for 15 sets? Then the sensor has no return, or is stuck: its noise is
 *  more than the millimetre in which ranges are published. */
bool scan_unchanged(const scan_t *scan, int beam);

/** Time since any sensor had a return. */
uint32_t scan_silent_ms(const scan_t *scan, uint32_t time_ms);
/** Time since the last set. */
uint32_t scan_age_ms(const scan_t *scan, uint32_t time_ms);

#endif
