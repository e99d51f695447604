// SPDX-License-Identifier: GPL-3.0-or-later
/** @file geometry.h  Plane vectors, poses and angles, on which the rest of the core is built.
 *
 * Frames: x forward, y left, yaw counter-clockwise. Metres and radians unless a name says
 * otherwise. Trigonometry uses polynomials of our own because sinf and atan2f differ between the C
 * libraries of a PC and of the chip; these give the same bits on both. */
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

/** Sine and cosine by minimax polynomials on [-pi/4, pi/4] (coefficients of Cephes sinf and cosf).
 * |angle| <= 1000 rad; a larger one, or one that is not finite, is treated as 0. Absolute error
 * <= 2e-7 near zero and <= 1e-4 at the limit, where it comes from the argument reduction. */
sincos_t geometry_sincos(float angle_rad);

/** Angle of the vector (x, y) in [-pi, pi]; absolute error <= 4e-7. atan2(0, 0) is 0.
 * Range reduction at tan(pi/8) and an odd polynomial (Cephes atanf). */
float geometry_atan2(float y, float x);

/** The same angle in [-pi, pi]. An angle beyond 1000 rad or not finite gives 0. */
float geometry_wrap_rad(float angle_rad);

/** value clamped to [low, high]; NaN gives low. */
float geometry_clamp(float value, float low, float high);

/** True for anything but NaN and infinities. */
bool geometry_is_finite(float value);

vec2_t vec2_add(vec2_t a, vec2_t b);
vec2_t vec2_sub(vec2_t a, vec2_t b);
vec2_t vec2_scale(vec2_t v, float factor);
vec2_t vec2_rotate(vec2_t v, float angle_rad);
/** The unit vector in a direction. */
vec2_t vec2_towards(float angle_rad);
float vec2_dot(vec2_t a, vec2_t b);
float vec2_norm(vec2_t v);
float vec2_distance(vec2_t a, vec2_t b);
/** v shortened to a length of at most max_norm, direction kept. */
vec2_t vec2_limit(vec2_t v, float max_norm);

vec2_t pose2_position(pose2_t pose);
/** Pose b, given in the frame of a, expressed in the parent frame of a (the product a b of the two
 * rigid transforms). */
pose2_t pose2_compose(pose2_t a, pose2_t b);
/** compose(pose, inverse(pose)) is the identity. */
pose2_t pose2_inverse(pose2_t pose);
/** Point p, given in the frame of the pose, expressed in the parent frame of the pose. */
vec2_t pose2_apply(pose2_t pose, vec2_t p);
/** The pose at a fraction of the way from a (0) to b (1); yaw turns the short way round. */
pose2_t pose2_interpolate(pose2_t a, pose2_t b, float fraction);

#endif
