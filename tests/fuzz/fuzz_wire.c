// SPDX-License-Identifier: GPL-3.0-or-later
/* Packets and map pieces: whatever comes in is refused or understood, and what was understood goes
 * out as it came. */
#include "bytes.h"
#include "wire.h"

enum { COORDINATE_MIN = 0x8000 }; ///< -32.768 m comes back as -32.767 m

/** Not byte for byte: one coordinate of a path is not sent by anyone. */
static bool has_extreme(const uint8_t *packet, int length) {
  for (int i = 6; i + 1 < length; i += 2) {
    if ((packet[i] | packet[i + 1] << 8) == COORDINATE_MIN) {
      return packet[1] == WIRE_PATH;
    }
  }
  return false;
}

static void decode_then_encode(const uint8_t *data, int length) {
  wire_message_t message;
  uint8_t packet[WIRE_PACKET_BYTES];
  if (wire_decode(data, length, &message) != WIRE_OK) {
    return;
  }
  REQUIRE(length <= WIRE_PACKET_BYTES);
  REQUIRE(wire_encode(&message, packet) == length);
  REQUIRE(memcmp(packet, data, (size_t)length) == 0 || has_extreme(data, length));
}

static void encode_then_decode(bytes_t bytes) {
  wire_message_t message;
  wire_message_t again;
  uint8_t packet[WIRE_PACKET_BYTES];
  uint8_t twice[WIRE_PACKET_BYTES];
  take(&bytes, &message, sizeof message);
  message.type = (uint8_t)(message.type % 16u);
  int length = wire_encode(&message, packet);
  REQUIRE(length >= 0 && length <= WIRE_PACKET_BYTES);
  REQUIRE((length > 0) == (message.type >= WIRE_HELLO && message.type <= WIRE_STEER));
  if (length > 0) {
    REQUIRE(wire_decode(packet, length, &again) == WIRE_OK);
    REQUIRE(wire_encode(&again, twice) == length);
    REQUIRE(memcmp(packet, twice, (size_t)length) == 0);
  }
}

static void check_tile(const wire_tile_t *tile) {
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    REQUIRE(tile->states[i] < 3);
    REQUIRE(tile->eighths[i] < 64 || tile->eighths[i] == WIRE_NO_POINT);
    REQUIRE(tile->eighths[i] == WIRE_NO_POINT || tile->states[i] == 2);
  }
}

/** Whatever its check says. */
static void read_piece(bytes_t bytes) {
  uint8_t data[WIRE_MAP_BYTES];
  uint8_t epoch;
  wire_map_t map;
  wire_tile_t tile;
  int count = 0;
  take(&bytes, data, sizeof data);
  wire_map_open(&map, data, &epoch);
  for (; wire_map_read(&map, &tile); count++) {
    REQUIRE(tile.tile == data[0] + count);
    check_tile(&tile);
  }
  REQUIRE(count <= 256 - data[0]);
}

static void write_piece(bytes_t bytes) {
  uint8_t data[WIRE_MAP_BYTES];
  wire_map_t map;
  wire_tile_t tile;
  wire_tile_t again;
  uint8_t epoch;
  wire_tile_t kept[4];
  int count = 0;
  memset(&tile, 0, sizeof tile);
  tile.tile = take_u8(&bytes);
  tile.first_point = take_u8(&bytes);
  wire_map_begin(&map, tile.tile, 1);
  for (; count < 4; count++, tile.tile++) {
    take(&bytes, tile.states, sizeof tile.states);
    for (int i = 0; i < WIRE_MAP_CELLS; i++) {
      tile.states[i] %= 3;
      tile.eighths[i] = tile.states[i] == 2 ? take_u8(&bytes) % 64u : WIRE_NO_POINT;
    }
    if (!wire_map_add(&map, &tile)) {
      break;
    }
    kept[count] = tile;
  }
  wire_map_end(&map);
  memcpy(data, map.bytes, sizeof data);
  REQUIRE(count > 0 && wire_map_open(&map, data, &epoch) && epoch == 1);
  for (int i = 0; i < count; i++) {
    REQUIRE(wire_map_read(&map, &again) && again.tile == kept[i].tile);
    REQUIRE(memcmp(again.states, kept[i].states, sizeof again.states) == 0);
    REQUIRE(!again.whole || memcmp(again.eighths, kept[i].eighths, sizeof again.eighths) == 0);
  }
  REQUIRE(!wire_map_read(&map, &again));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  decode_then_encode(data, (int)size);
  encode_then_decode((bytes_t){data, size});
  read_piece((bytes_t){data, size});
  write_piece((bytes_t){data, size});
  return 0;
}
