// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "wire.h"

#include <math.h>
#include <string.h>

static const float MILLIMETRES = 1000.0f;
static const float MILLIMETRES_MAX = 32767.0f;

enum { HEADER_BYTES = 2, RECORD_BYTES = 11 };

/* put_...: write a value, little-endian, and return the place behind it. get_...: read one. */

static uint8_t *put_u8(uint8_t *p, uint8_t value) {
  *p = value;
  return p + 1;
}

static uint8_t *put_u16(uint8_t *p, uint16_t value) {
  p[0] = (uint8_t)(value & 0xFF);
  p[1] = (uint8_t)(value >> 8);
  return p + 2;
}

static uint8_t *put_u32(uint8_t *p, uint32_t value) {
  p = put_u16(p, (uint16_t)(value & 0xFFFFu));
  return put_u16(p, (uint16_t)(value >> 16));
}

static uint8_t *put_float(uint8_t *p, float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return put_u32(p, bits);
}

static uint8_t *put_vec2(uint8_t *p, vec2_t v) {
  return put_float(put_float(p, v.x), v.y);
}

static uint8_t *put_mm(uint8_t *p, float metres) {
  float mm = floorf(geometry_clamp(metres * MILLIMETRES, -MILLIMETRES_MAX, MILLIMETRES_MAX) + 0.5f);
  return put_u16(p, (uint16_t)(int16_t)mm);
}

static uint16_t get_u16(const uint8_t *p) {
  return (uint16_t)(p[0] | p[1] << 8);
}

static uint32_t get_u32(const uint8_t *p) {
  return get_u16(p) | (uint32_t)get_u16(p + 2) << 16;
}

static float get_float(const uint8_t *p) {
  uint32_t bits = get_u32(p);
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static vec2_t get_vec2(const uint8_t *p) {
  return (vec2_t){get_float(p), get_float(p + 4)};
}

static int16_t get_i16(const uint8_t *p) {
  int32_t raw = get_u16(p);
  return (int16_t)(raw >= 0x8000 ? raw - 0x10000 : raw);
}

static float get_mm(const uint8_t *p) {
  return (float)get_i16(p) / MILLIMETRES;
}

static uint8_t *put_path(uint8_t *p, const wire_path_t *path) {
  uint8_t count = path->count < WIRE_PATH_POINTS ? path->count : (uint8_t)WIRE_PATH_POINTS;
  p = put_u8(p, path->revision);
  p = put_u8(p, path->first);
  p = put_u8(p, path->total);
  p = put_u8(p, count);
  for (int i = 0; i < count; i++) {
    p = put_mm(p, path->points_m[i].x);
    p = put_mm(p, path->points_m[i].y);
  }
  return p;
}

static uint8_t *put_waypoints(uint8_t *p, const wire_waypoints_t *waypoints) {
  uint8_t count = waypoints->count < WIRE_WAYPOINTS_A_PACKET ? waypoints->count
                                                             : (uint8_t)WIRE_WAYPOINTS_A_PACKET;
  p = put_u16(p, waypoints->sequence);
  p = put_u8(p, waypoints->list);
  p = put_u8(p, waypoints->first);
  p = put_u8(p, waypoints->total);
  p = put_u8(p, count);
  for (int i = 0; i < count; i++) {
    p = put_u16(p, (uint16_t)waypoints->points_mm[i][0]);
    p = put_u16(p, (uint16_t)waypoints->points_mm[i][1]);
  }
  return p;
}

static uint8_t *put_heartbeat(uint8_t *p, const wire_heartbeat_t *beat) {
  p = put_u16(p, beat->sequence);
  p = put_u32(p, beat->time_ms);
  p = put_u8(p, beat->state);
  p = put_u8(p, beat->path_revision);
  p = put_u8(p, beat->path_total);
  p = put_u16(p, beat->next_event);
  return put_u16(p, beat->next_record);
}

static uint8_t *put_history(uint8_t *p, const wire_history_t *history) {
  uint8_t count =
      history->count < WIRE_RECORDS_A_PACKET ? history->count : (uint8_t)WIRE_RECORDS_A_PACKET;
  p = put_u16(p, history->first);
  p = put_u8(p, count);
  for (int i = 0; i < count; i++) {
    const wire_record_t *record = &history->records[i];
    p = put_u32(p, record->time_ms);
    p = put_u16(p, (uint16_t)record->x_mm);
    p = put_u16(p, (uint16_t)record->y_mm);
    p = put_u16(p, (uint16_t)record->yaw_1e4_rad);
    p = put_u8(p, record->kind);
  }
  return p;
}

static uint8_t *put_tiles(uint8_t *p, const wire_tiles_t *tiles) {
  uint8_t count = tiles->count < WIRE_TILES_A_PACKET ? tiles->count : (uint8_t)WIRE_TILES_A_PACKET;
  p = put_u8(p, count);
  memcpy(p, tiles->tiles, count);
  return p + count;
}

int wire_encode(const wire_message_t *message, uint8_t *packet) {
  uint8_t *p = put_u8(packet, WIRE_VERSION);
  p = put_u8(p, message->type);
  switch (message->type) {
  case WIRE_HELLO:
    p = put_u8(p, message->body.hello.request);
    p = put_u8(p, message->body.hello.capabilities);
    p = put_u8(p, message->body.hello.epoch);
    p = put_u16(p, message->body.hello.cell_mm);
    p = put_u16(p, message->body.hello.side_cells);
    p = put_vec2(p, message->body.hello.origin_m);
    break;
  case WIRE_COMMAND:
    p = put_u16(p, message->body.command.sequence);
    p = put_u8(p, message->body.command.cmd);
    p = put_vec2(p, message->body.command.goal_m);
    break;
  case WIRE_ACK:
    p = put_u16(p, message->body.ack.sequence);
    p = put_u8(p, message->body.ack.cmd);
    p = put_u8(p, message->body.ack.reason);
    break;
  case WIRE_PATH:
    p = put_path(p, &message->body.path);
    break;
  case WIRE_WAYPOINTS:
    p = put_waypoints(p, &message->body.waypoints);
    break;
  case WIRE_EVENT:
    p = put_u16(p, message->body.event.sequence);
    p = put_u32(p, message->body.event.time_ms);
    p = put_u8(p, message->body.event.code);
    p = put_u8(p, message->body.event.argument);
    p = put_vec2(p, message->body.event.place_m);
    break;
  case WIRE_HEARTBEAT:
    p = put_heartbeat(p, &message->body.heartbeat);
    break;
  case WIRE_HISTORY:
    p = put_history(p, &message->body.history);
    break;
  case WIRE_ASK:
    p = put_u8(p, message->body.ask.what);
    p = put_u16(p, message->body.ask.first);
    p = put_u8(p, message->body.ask.count);
    break;
  case WIRE_TILES:
    p = put_tiles(p, &message->body.tiles);
    break;
  case WIRE_STEER:
    p = put_u16(p, message->body.steer.sequence);
    p = put_vec2(p, message->body.steer.velocity_mps);
    p = put_float(p, message->body.steer.yaw_rate_rps);
    p = put_float(p, message->body.steer.climb_mps);
    break;
  case WIRE_SNAPSHOT:
    break;
  case WIRE_MAP:
    memcpy(p, message->body.map, WIRE_MAP_BYTES);
    p += WIRE_MAP_BYTES;
    break;
  default:
    return 0;
  }
  return (int)(p - packet);
}

/** Length that the packet must have by its type and count of elements; -1 if the type is unknown.
 * A packet of at most WIRE_PACKET_BYTES with this length has no larger count than its array in
 * wire_message_t. */
static int length_of(const uint8_t *packet, int length) {
  switch (packet[1]) {
  case WIRE_HELLO:
    return HEADER_BYTES + 15;
  case WIRE_COMMAND:
    return HEADER_BYTES + 11;
  case WIRE_ACK:
    return HEADER_BYTES + 4;
  case WIRE_PATH:
    return HEADER_BYTES + 4 + (length > 5 ? 4 * packet[5] : 0);
  case WIRE_WAYPOINTS:
    return HEADER_BYTES + 6 + (length > 7 ? 4 * packet[7] : 0);
  case WIRE_EVENT:
    return HEADER_BYTES + 16;
  case WIRE_HEARTBEAT:
    return HEADER_BYTES + 13;
  case WIRE_HISTORY:
    return HEADER_BYTES + 3 + (length > 4 ? RECORD_BYTES * packet[4] : 0);
  case WIRE_ASK:
    return HEADER_BYTES + 4;
  case WIRE_TILES:
    return HEADER_BYTES + 1 + (length > 2 ? packet[2] : 0);
  case WIRE_STEER:
    return HEADER_BYTES + 18;
  case WIRE_SNAPSHOT:
    return HEADER_BYTES;
  case WIRE_MAP:
    return HEADER_BYTES + WIRE_MAP_BYTES;
  default:
    return -1;
  }
}

static void get_path(const uint8_t *p, wire_path_t *path) {
  path->revision = p[0];
  path->first = p[1];
  path->total = p[2];
  path->count = p[3];
  for (int i = 0; i < path->count; i++) {
    path->points_m[i] = (vec2_t){get_mm(p + 4 + 4 * i), get_mm(p + 6 + 4 * i)};
  }
}

static void get_waypoints(const uint8_t *p, wire_waypoints_t *waypoints) {
  waypoints->sequence = get_u16(p);
  waypoints->list = p[2];
  waypoints->first = p[3];
  waypoints->total = p[4];
  waypoints->count = p[5];
  for (int i = 0; i < waypoints->count; i++) {
    waypoints->points_mm[i][0] = get_i16(p + 6 + 4 * i);
    waypoints->points_mm[i][1] = get_i16(p + 8 + 4 * i);
  }
}

static void get_history(const uint8_t *p, wire_history_t *history) {
  history->first = get_u16(p);
  history->count = p[2];
  p += 3;
  for (int i = 0; i < history->count; i++, p += RECORD_BYTES) {
    history->records[i] =
        (wire_record_t){get_u32(p), get_i16(p + 4), get_i16(p + 6), get_i16(p + 8), p[10]};
  }
}

wire_status_t wire_decode(const uint8_t *packet, int length, wire_message_t *message) {
  if (length < HEADER_BYTES) {
    return WIRE_SHORT;
  }
  if (length > WIRE_PACKET_BYTES) {
    return WIRE_LONG;
  }
  if (packet[0] != WIRE_VERSION) {
    return WIRE_BAD_VERSION;
  }
  int expected = length_of(packet, length);
  if (expected < 0) {
    return WIRE_BAD_TYPE;
  }
  if (length != expected) {
    return length < expected ? WIRE_SHORT : WIRE_LONG;
  }
  const uint8_t *p = packet + HEADER_BYTES;
  memset(message, 0, sizeof *message);
  message->type = packet[1];
  switch (message->type) {
  case WIRE_HELLO:
    message->body.hello =
        (wire_hello_t){p[0], p[1], p[2], get_u16(p + 3), get_u16(p + 5), get_vec2(p + 7)};
    break;
  case WIRE_COMMAND:
    message->body.command = (wire_command_t){get_u16(p), p[2], get_vec2(p + 3)};
    break;
  case WIRE_ACK:
    message->body.ack = (wire_ack_t){get_u16(p), p[2], p[3]};
    break;
  case WIRE_PATH:
    get_path(p, &message->body.path);
    break;
  case WIRE_WAYPOINTS:
    get_waypoints(p, &message->body.waypoints);
    break;
  case WIRE_EVENT:
    message->body.event = (wire_event_t){get_u16(p), get_u32(p + 2), p[6], p[7], get_vec2(p + 8)};
    break;
  case WIRE_HEARTBEAT:
    message->body.heartbeat = (wire_heartbeat_t){get_u16(p), get_u32(p + 2), p[6],           p[7],
                                                 p[8],       get_u16(p + 9), get_u16(p + 11)};
    break;
  case WIRE_HISTORY:
    get_history(p, &message->body.history);
    break;
  case WIRE_ASK:
    message->body.ask = (wire_ask_t){p[0], get_u16(p + 1), p[3]};
    break;
  case WIRE_TILES:
    message->body.tiles.count = p[0];
    memcpy(message->body.tiles.tiles, p + 1, p[0]);
    break;
  case WIRE_STEER:
    message->body.steer =
        (wire_steer_t){get_u16(p), get_vec2(p + 2), get_float(p + 10), get_float(p + 14)};
    break;
  case WIRE_MAP:
    memcpy(message->body.map, p, WIRE_MAP_BYTES);
    break;
  default:
    break;
  }
  return WIRE_OK;
}
