// SPDX-License-Identifier: GPL-3.0-or-later
/** @file bits.h  Values as bytes, little-endian and without gaps: structs differ between machines
 * in padding and in the size of enums, these do not. Hashes are FNV-1a over the same bytes. */
#ifndef BITS_H
#define BITS_H

#include <stdint.h>

#include "geometry.h"
#include "nav.h"

uint8_t bits_get_u8(void);
uint32_t bits_get_u32(void);
float bits_get_float(void);
vec2_t bits_get_vec2(void);

void bits_put_u8(uint8_t value);
void bits_put_u32(uint32_t value);
/** Any NaN as the same one: which of them comes out is not defined. */
void bits_put_float(float value);
void bits_put_vec2(vec2_t value);
void bits_put_pose(pose2_t value);

enum { BITS_HASH_START = 0x811C9DC5 };
uint32_t bits_hash_u32(uint32_t hash, uint32_t value);
uint32_t bits_hash_float(uint32_t hash, float value);
uint32_t bits_hash_vec2(uint32_t hash, vec2_t value);

/** Everything of a map that anybody can ask for. */
uint32_t bits_hash_grid(const grid_t *grid);
uint32_t bits_hash_clearance(const clearance_t *clearance);
uint32_t bits_hash_route(const route_t *route);
/** Map, clearance, route and what SLAM believes. */
uint32_t bits_hash_nav(const nav_t *nav);

#endif
