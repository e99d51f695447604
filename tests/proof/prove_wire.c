// SPDX-License-Identifier: GPL-3.0-or-later
/* Packets and map pieces of any bytes, and messages of any values. */
#include <string.h>

#include "any.h"
#include "wire.h"

int main(void) {
  uint8_t packet[WIRE_PACKET_BYTES];
  uint8_t again[WIRE_PACKET_BYTES];
  uint8_t bytes[WIRE_MAP_BYTES];
  wire_message_t message;
  uint8_t epoch;
  wire_map_t map;
  wire_tile_t tile;
  for (int i = 0; i < WIRE_PACKET_BYTES; i++) {
    packet[i] = any_u8;
  }
  memset(&message, 0, sizeof message);
  //@ loop unroll 8;
  for (int count = 0; count < 8; count++) { // points of a path: 7 stands for too many
    packet[5] = count < 7 ? (uint8_t)count : (uint8_t)(7u + any_u8 % 249u);
    if (wire_decode(packet, any_int, &message) == WIRE_OK) {
      wire_encode(&message, again);
    }
  }
  message.type = WIRE_PATH;
  message.body.path.count = any_u8;
  for (int i = 0; i < WIRE_PATH_POINTS; i++) {
    message.body.path.points_m[i] = any_vec2();
  }
  wire_encode(&message, again);
  for (int i = 0; i < WIRE_MAP_BYTES; i++) {
    bytes[i] = any_u8;
  }
  wire_map_open(&map, bytes, &epoch);
  while (wire_map_read(&map, &tile)) {
  }
  memset(&tile, 0, sizeof tile);
  wire_map_begin(&map, any_u8, any_u8);
  tile.tile = map.tile;
  tile.first_point = any_u8;
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    tile.states[i] = any_u8 % 3u;
    tile.eighths[i] = any_u8;
  }
  for (int i = 0; i < 3 && wire_map_add(&map, &tile); i++) {
    tile.tile++;
  }
  wire_map_end(&map);
  return 0;
}
