// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "bits.h"

#include <string.h>

#include "port.h"

static const uint32_t PRIME = 0x01000193u;
static const uint32_t ANY_NAN = 0x7FC00000u;

uint8_t bits_get_u8(void) {
  uint8_t value = 0;
  port_read(&value, sizeof value);
  return value;
}

uint32_t bits_get_u32(void) {
  uint32_t value = 0;
  port_read(&value, sizeof value);
  return value;
}

float bits_get_float(void) {
  float value = 0.0f;
  port_read(&value, sizeof value);
  return value;
}

vec2_t bits_get_vec2(void) {
  float x = bits_get_float();
  return (vec2_t){x, bits_get_float()};
}

static uint32_t bits_of(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return value == value ? bits : ANY_NAN;
}

void bits_put_u8(uint8_t value) {
  port_write(&value, sizeof value);
}

void bits_put_u32(uint32_t value) {
  port_write(&value, sizeof value);
}

void bits_put_float(float value) {
  bits_put_u32(bits_of(value));
}

void bits_put_vec2(vec2_t value) {
  bits_put_float(value.x);
  bits_put_float(value.y);
}

void bits_put_pose(pose2_t value) {
  bits_put_float(value.x_m);
  bits_put_float(value.y_m);
  bits_put_float(value.yaw_rad);
}

uint32_t bits_hash_u32(uint32_t hash, uint32_t value) {
  for (int i = 0; i < 32; i += 8) {
    hash = (hash ^ (value >> i & 0xFFu)) * PRIME;
  }
  return hash;
}

uint32_t bits_hash_float(uint32_t hash, float value) {
  return bits_hash_u32(hash, bits_of(value));
}

uint32_t bits_hash_vec2(uint32_t hash, vec2_t value) {
  return bits_hash_float(bits_hash_float(hash, value.x), value.y);
}

uint32_t bits_hash_grid(const grid_t *grid) {
  uint32_t hash = bits_hash_vec2(BITS_HASH_START, grid->origin_m);
  hash = bits_hash_u32(bits_hash_float(hash, grid->cell_m), grid->known);
  for (int i = 0; i < GRID_CELLS / 8; i++) {
    hash = bits_hash_u32(hash, grid->cells[i]);
  }
  for (int i = 0; i < GRID_POINTS; i++) {
    hash = bits_hash_u32(hash, grid->points[i]);
  }
  return hash;
}

uint32_t bits_hash_clearance(const clearance_t *clearance) {
  uint32_t hash = BITS_HASH_START;
  for (int i = 0; i < GRID_SIDE_CELLS * GRID_BIT_WORDS; i++) {
    hash = bits_hash_u32(hash, clearance->bits[i]);
  }
  return hash;
}

uint32_t bits_hash_route(const route_t *route) {
  uint32_t hash = bits_hash_u32(BITS_HASH_START, route->count);
  for (int i = 0; i < route->count; i++) {
    hash = bits_hash_vec2(hash, route->points_m[i]);
  }
  return hash;
}

uint32_t bits_hash_nav(const nav_t *nav) {
  uint32_t hash = bits_hash_grid(&nav->grid);
  hash = bits_hash_u32(hash, bits_hash_clearance(&nav->clearance));
  hash = bits_hash_u32(hash, bits_hash_route(&nav->route));
  hash = bits_hash_float(bits_hash_float(hash, nav->slam.filter.bias_rps), nav->slam.filter.scale);
  for (int i = 0; i < SLAM_PAIRS; i++) {
    hash = bits_hash_float(hash, nav->slam.filter.covariance[i]);
  }
  return hash;
}
