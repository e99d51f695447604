// SPDX-License-Identifier: GPL-3.0-or-later
/** @file stabilizer_types.h  Host version: the setpoint and measurements that the app uses. */
#ifndef STABILIZER_TYPES_H
#define STABILIZER_TYPES_H

#include <stdbool.h>
#include <stdint.h>

typedef enum { modeDisable = 0, modeAbs, modeVelocity } stab_mode_t;

typedef struct {
  float roll, pitch, yaw;
} attitude_t;

typedef struct {
  float x, y, z;
} point_t;

typedef point_t velocity_t;

typedef struct {
  uint32_t timestamp;      ///< [ms], written by the commander
  attitude_t attitude;     ///< [deg]
  attitude_t attitudeRate; ///< [deg/s]
  float thrust;            ///< 0..65535
  point_t position;        ///< [m]
  velocity_t velocity;     ///< [m/s]
  bool velocity_body;      ///< velocity is in the level body frame, else in the world frame
  struct {
    stab_mode_t x, y, z, roll, pitch, yaw;
  } mode;
} setpoint_t;

typedef enum {
  MeasurementSourceLocationService = 0,
  MeasurementSourceLighthouse = 1,
} measurementSource_t;

typedef struct {
  float x, y, z;
  float stdDev;
  measurementSource_t source;
} positionMeasurement_t;

typedef struct {
  uint32_t timestamp; ///< [ms]
  float yawError;     ///< [rad], estimated minus measured
  float stdDev;       ///< [rad]
} yawErrorMeasurement_t;

#endif
