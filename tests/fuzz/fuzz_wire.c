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
  REQUIRE((length > 0) == (message.type >= WIRE_HELLO && message.type <= WIRE_WAYPOINTS));
  if (length > 0) {
    REQUIRE(wire_decode(packet, length, &again) == WIRE_OK);
    REQUIRE(wire_encode(&again, twice) == length);
    REQUIRE(memcmp(packet, twice, (size_t)length) == 0);
  }
}

static bool same_piece(const wire_map_piece_t *a, const wire_map_piece_t *b) {
  size_t count = a->point_count;
  return a->tile == b->tile && a->epoch == b->epoch && a->point_count == b->point_count &&
         memcmp(a->states, b->states, sizeof a->states) == 0 &&
         memcmp(a->point_cell, b->point_cell, count) == 0 &&
         memcmp(a->point_eighths, b->point_eighths, count) == 0;
}

static void decode_piece(bytes_t bytes) {
  uint8_t data[WIRE_MAP_BYTES];
  wire_map_piece_t piece;
  wire_map_piece_t again;
  take(&bytes, data, sizeof data);
  if (!wire_map_decode(data, &piece)) {
    return;
  }
  REQUIRE(piece.point_count <= WIRE_MAP_POINTS && piece.epoch < WIRE_MAP_EPOCHS);
  wire_map_encode(&piece, data);
  REQUIRE(wire_map_decode(data, &again) && same_piece(&piece, &again));
}

static void encode_piece(bytes_t bytes) {
  uint8_t data[WIRE_MAP_BYTES];
  wire_map_piece_t piece;
  wire_map_piece_t again;
  take(&bytes, &piece, sizeof piece);
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    piece.states[i] %= 3;
  }
  wire_map_encode(&piece, data);
  REQUIRE(wire_map_decode(data, &again));
  piece.epoch %= WIRE_MAP_EPOCHS;
  piece.point_count = piece.point_count < WIRE_MAP_POINTS ? piece.point_count : WIRE_MAP_POINTS;
  for (int i = 0; i < WIRE_MAP_POINTS; i++) {
    piece.point_cell[i] &= 63u;
    piece.point_eighths[i] &= 63u;
  }
  REQUIRE(same_piece(&piece, &again));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  decode_then_encode(data, (int)size);
  encode_then_decode((bytes_t){data, size});
  decode_piece((bytes_t){data, size});
  encode_piece((bytes_t){data, size});
  return 0;
}
