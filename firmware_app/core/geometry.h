// SPDX-License-Identifier: GPL-3.0-or-later
/** @file geometry.h  Plane vectors, poses and angles. Everything else in the core stands on this.
 *  Frames: x forward, y left, yaw counter-clockwise. Metres and radians unless a name says
 * otherwise. Trigonometry is done by polynomials of our own, because sinf and atan2f differ between
 * the C libraries of a PC and of the chip: here both give the same bits. */
#ifndef GEOMETRY_H
#define GEOMETRY_H

#include <stdbool.h>

typedef struct {
  float x;
  float y;
} vec2_t;

/** A pose in the plane; composes like a 2-D rigid transform. */
typedef struct {
  float x_m;
  float y_m;
  float yaw_rad; ///< wrapped to [-pi, pi]
} pose2_t;

typedef struct {
  float sin;
  float cos;
} sincos_t;

/** Sine and cosine. |angle| <= 1000 rad; absolute error <= 2e-7 near zero, <= 1e-4 at the limit
 *  (argument reduction). Minimax polynomials on [-pi/4, pi/4] (Cephes sinf/cosf coefficients). */
sincos_t geometry_sincos(float angle_rad);

/** Angle of the vector (x, y) in [-pi, pi]; absolute error <= 4e-7. atan2(0, 0) is 0.
 *  Range reduction at tan(pi/8) and an odd polynomial (Cephes atanf). */
float geometry_atan2(float y, float x);

/** The same angle in [-pi, pi]. Not finite gives 0. */
float geometry_wrap_rad(float angle_rad);

/** value clamped to [low, high]; NaN gives low. */
float geometry_clamp(float value, float low, float high);

/** True for anything but NaN and infinities. */
bool geometry_is_finite(float value);

vec2_t vec2_add(vec2_t a, vec2_t b);
vec2_t vec2_sub(vec2_t a, vec2_t b);
vec2_t vec2_scale(vec2_t v, float factor);
vec2_t vec2_rotate(vec2_t v, float angle_rad);
float vec2_dot(vec2_t a, vec2_t b);
float vec2_norm(vec2_t v);
float vec2_distance(vec2_t a, vec2_t b);
/** v shortened to at most max_norm, direction kept. */
vec2_t vec2_limit(vec2_t v, float max_norm);
/** The points in opposite order. */
void vec2_reverse(vec2_t *points, int count);

vec2_t pose2_position(pose2_t pose);
/** The pose b, given in the frame a, in the frame that a is given in. */
pose2_t pose2_compose(pose2_t a, pose2_t b);
/** compose(pose, inverse(pose)) is the identity. */
pose2_t pose2_inverse(pose2_t pose);
/** The point p, given in the frame of the pose, in the frame that the pose is given in. */
vec2_t pose2_apply(pose2_t pose, vec2_t p);
/** The pose a fraction of the way from a (0) to b (1), turning the short way round. */
pose2_t pose2_interpolate(pose2_t a, pose2_t b, float fraction);

#endif
