// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "geometry.h"

#include <math.h>
#include <stdint.h>

static const float PI = 3.14159265f;
static const float TWO_PI = 6.28318531f;
static const float MAX_ANGLE_RAD = 1000.0f;

// pi/2 as the sum of three parts (Cody and Waite 1980). The first two have so few bits that their
// product with the number of quarter turns, at most 637, is exact.
static const float HALF_PI_1 = 1.5703125f;
static const float HALF_PI_2 = 4.837512969970703125e-4f;
static const float HALF_PI_3 = 7.549789948768648e-8f;

/** sin(r) for |r| <= pi/4. */
static float sin_kernel(float r) {
  float z = r * r;
  float p = -1.9515295891e-4f * z + 8.3321608736e-3f;
  p = p * z - 1.6666654611e-1f;
  return p * z * r + r;
}

/** cos(r) for |r| <= pi/4. */
static float cos_kernel(float r) {
  float z = r * r;
  float p = 2.443315711809948e-5f * z - 1.388731625493765e-3f;
  p = p * z + 4.166664568298827e-2f;
  return p * z * z - 0.5f * z + 1.0f;
}

sincos_t geometry_sincos(float angle_rad) {
  if (!(fabsf(angle_rad) <= MAX_ANGLE_RAD)) {
    return (sincos_t){.sin = 0.0f, .cos = 1.0f};
  }
  float quarter = floorf(angle_rad * (2.0f / PI) + 0.5f);
  float r = angle_rad - quarter * HALF_PI_1;
  r = r - quarter * HALF_PI_2;
  r = r - quarter * HALF_PI_3;
  float s = sin_kernel(r);
  float c = cos_kernel(r);
  // 4096 is a multiple of 4 that keeps the number of quarter turns positive.
  switch ((uint32_t)((int32_t)quarter + 4096) & 3u) {
  case 0u:
    return (sincos_t){.sin = s, .cos = c};
  case 1u:
    return (sincos_t){.sin = c, .cos = -s};
  case 2u:
    return (sincos_t){.sin = -s, .cos = -c};
  default:
    return (sincos_t){.sin = -c, .cos = s};
  }
}

/** atan(t) for t >= 0. */
static float atan_positive(float t) {
  float base = 0.0f;
  if (t > 2.41421356f) { // tan(3 pi / 8)
    base = 0.5f * PI;
    t = -1.0f / t;
  } else if (t > 0.41421356f) { // tan(pi / 8)
    base = 0.25f * PI;
    t = (t - 1.0f) / (t + 1.0f);
  }
  float z = t * t;
  float p = 8.05374449538e-2f * z - 1.38776856032e-1f;
  p = p * z + 1.99777106478e-1f;
  p = p * z - 3.33329491539e-1f;
  return base + (p * z * t + t);
}

float geometry_atan2(float y, float x) {
  float ax = fabsf(x);
  float ay = fabsf(y);
  if (!(ax + ay > 0.0f)) {
    return 0.0f;
  }
  float angle = ax > 0.0f ? atan_positive(ay / ax) : 0.5f * PI;
  if (x < 0.0f) {
    angle = PI - angle;
  }
  return y < 0.0f ? -angle : angle;
}

float geometry_wrap_rad(float angle_rad) {
  if (!(fabsf(angle_rad) <= MAX_ANGLE_RAD)) {
    return 0.0f;
  }
  float turns = floorf(angle_rad * (1.0f / TWO_PI) + 0.5f);
  return geometry_clamp(angle_rad - turns * TWO_PI, -PI, PI);
}

float geometry_clamp(float value, float low, float high) {
  if (!(value > low)) {
    return low;
  }
  return value > high ? high : value;
}

bool geometry_is_finite(float value) {
  return fabsf(value) <= 3.4028234e38f;
}

vec2_t vec2_add(vec2_t a, vec2_t b) {
  return (vec2_t){a.x + b.x, a.y + b.y};
}

vec2_t vec2_sub(vec2_t a, vec2_t b) {
  return (vec2_t){a.x - b.x, a.y - b.y};
}

vec2_t vec2_scale(vec2_t v, float factor) {
  return (vec2_t){v.x * factor, v.y * factor};
}

vec2_t vec2_rotate(vec2_t v, float angle_rad) {
  sincos_t turn = geometry_sincos(angle_rad);
  return (vec2_t){turn.cos * v.x - turn.sin * v.y, turn.sin * v.x + turn.cos * v.y};
}

vec2_t vec2_towards(float angle_rad) {
  sincos_t turn = geometry_sincos(angle_rad);
  return (vec2_t){turn.cos, turn.sin};
}

float vec2_dot(vec2_t a, vec2_t b) {
  return a.x * b.x + a.y * b.y;
}

float vec2_norm(vec2_t v) {
  return sqrtf(vec2_dot(v, v));
}

float vec2_distance(vec2_t a, vec2_t b) {
  return vec2_norm(vec2_sub(a, b));
}

vec2_t vec2_limit(vec2_t v, float max_norm) {
  float norm = vec2_norm(v);
  return norm > max_norm ? vec2_scale(v, max_norm / norm) : v;
}

vec2_t pose2_position(pose2_t pose) {
  return (vec2_t){pose.x_m, pose.y_m};
}

pose2_t pose2_compose(pose2_t a, pose2_t b) {
  vec2_t p = pose2_apply(a, pose2_position(b));
  return (pose2_t){p.x, p.y, geometry_wrap_rad(a.yaw_rad + b.yaw_rad)};
}

pose2_t pose2_inverse(pose2_t pose) {
  vec2_t p = vec2_rotate((vec2_t){-pose.x_m, -pose.y_m}, -pose.yaw_rad);
  return (pose2_t){p.x, p.y, geometry_wrap_rad(-pose.yaw_rad)};
}

vec2_t pose2_apply(pose2_t pose, vec2_t p) {
  return vec2_add(pose2_position(pose), vec2_rotate(p, pose.yaw_rad));
}

pose2_t pose2_interpolate(pose2_t a, pose2_t b, float fraction) {
  float turn = geometry_wrap_rad(b.yaw_rad - a.yaw_rad);
  return (pose2_t){
      a.x_m + fraction * (b.x_m - a.x_m),
      a.y_m + fraction * (b.y_m - a.y_m),
      geometry_wrap_rad(a.yaw_rad + fraction * turn),
  };
}
