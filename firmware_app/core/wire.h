// SPDX-License-Identifier: GPL-3.0-or-later
/** @file wire.h  Byte formats of the app channel's packets and of the map stream's pieces.
 *
 * App channel packet: at most 30 bytes, little-endian; byte 0 is WIRE_VERSION, byte 1 the type. A
 * packet of another version, type or length is refused as a whole.
 * Map piece: exactly 26 bytes, can be decoded without any other piece.
 * The ground station uses this same code. */
#ifndef WIRE_H
#define WIRE_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"

enum {
  WIRE_VERSION = 2,
  WIRE_PACKET_BYTES = 30,
  WIRE_PATH_POINTS = 6, ///< points in one PATH packet
  WIRE_WAYPOINTS_A_PACKET = 5,
  WIRE_MAP_BYTES = 26, ///< 6 x uint32 + 1 x uint16: one log block
  WIRE_MAP_CELLS = 64, ///< cells of one of the grid's tiles, 8 x 8
  WIRE_MAP_EPOCHS = 4,
  WIRE_NO_POINT = 255,
  WIRE_RECORDS_A_PACKET = 2,
  WIRE_TILES_A_PACKET = 27,
};

typedef enum {
  WIRE_HELLO = 1,     ///< ground asks, drone answers: wire_hello_t
  WIRE_COMMAND = 2,   ///< ground: wire_command_t
  WIRE_ACK = 3,       ///< drone: wire_ack_t
  WIRE_PATH = 4,      ///< drone: wire_path_t
  WIRE_EVENT = 5,     ///< drone: wire_event_t
  WIRE_HEARTBEAT = 6, ///< ground sends, drone answers with the same sequence: wire_heartbeat_t
  WIRE_SNAPSHOT = 7,  ///< ground: request for hello, path and the whole map; no body
  WIRE_MAP = 8,       ///< ground: a piece of a saved map, as the drone sent it
  WIRE_WAYPOINTS = 9, ///< ground: wire_waypoints_t; acknowledged
  WIRE_HISTORY = 10,  ///< drone: wire_history_t
  WIRE_ASK = 11,      ///< ground: wire_ask_t, request for packets that were lost
  WIRE_TILES = 12,    ///< ground: wire_tiles_t, request for tiles not received for long
  WIRE_STEER = 13,    ///< ground: wire_steer_t, repeated; acknowledged only if refused
} wire_type_t;

typedef enum { WIRE_OK, WIRE_SHORT, WIRE_LONG, WIRE_BAD_VERSION, WIRE_BAD_TYPE } wire_status_t;

/** What the app was built with, whatever its parameters are set to. Bits of wire_hello_t. */
typedef enum {
  WIRE_CAP_RRTSTAR = 1,
  WIRE_CAP_GRID_SEARCH = 2,
  WIRE_CAP_SLAM = 4,
  WIRE_CAP_EXPLORE = 8,
} wire_capability_t;

typedef struct {
  uint8_t request;      ///< 1: the ground asks, the rest is ignored
  uint8_t capabilities; ///< bits of wire_capability_t
  uint8_t epoch;        ///< of the map: counts how often it was forgotten, modulo WIRE_MAP_EPOCHS
  uint16_t cell_mm;
  uint16_t side_cells;
  vec2_t origin_m; ///< lower left corner of cell (0, 0), map frame
} wire_hello_t;

typedef struct {
  uint16_t sequence; ///< a command with a repeated number is acknowledged, but acts once
  uint8_t cmd;       ///< mission_cmd_t
  vec2_t goal_m;     ///< map frame; only for MISSION_CMD_GOTO
} wire_command_t;

/** Some of the waypoints of a list. Repeating a packet changes nothing; a packet with another
 * `list` or `total` starts a new list. */
typedef struct {
  uint16_t sequence;                             ///< number that the acknowledgement repeats
  uint8_t list;                                  ///< arbitrary number that identifies the list
  uint8_t first;                                 ///< index of this packet's first point
  uint8_t total;                                 ///< number of points in the list
  uint8_t count;                                 ///< number of points in this packet
  int16_t points_mm[WIRE_WAYPOINTS_A_PACKET][2]; ///< x and y, map frame
} wire_waypoints_t;

typedef struct {
  uint16_t sequence;
  uint8_t cmd;    ///< mission_cmd_t; MISSION_CMD_NONE for WIRE_WAYPOINTS and WIRE_STEER
  uint8_t reason; ///< mission_reason_t; MISSION_OK: accepted
} wire_ack_t;

typedef struct {
  uint8_t revision;                  ///< of the route; packets of one revision belong together
  uint8_t first;                     ///< index of this packet's first point
  uint8_t total;                     ///< number of points in the route; 0: there is none
  uint8_t count;                     ///< number of points in this packet
  vec2_t points_m[WIRE_PATH_POINTS]; ///< sent in millimetres, +-32 m
} wire_path_t;

typedef enum {
  WIRE_EVENT_STATE = 1,    ///< argument: mission_state_t entered
  WIRE_EVENT_REFUSED = 2,  ///< argument: mission_reason_t; place: reachable point nearest the goal
  WIRE_EVENT_FAULT = 3,    ///< argument: mission_reason_t
  WIRE_EVENT_ARRIVED = 4,  ///< place: where the drone arrived
  WIRE_EVENT_EXPLORED = 5, ///< argument 0: all that can be reached; 1: some of it was given up
  WIRE_EVENT_FOUND = 6,    ///< relocalised after having been lost; place: where
  WIRE_EVENT_WAYPOINT = 7, ///< argument: index of the waypoint reached; place: where it arrived
  WIRE_EVENT_SKIPPED = 8,  ///< argument: mission_reason_t; place: the waypoint left out
} wire_event_code_t;

typedef struct {
  uint16_t sequence;
  uint32_t time_ms;
  uint8_t code; ///< wire_event_code_t
  uint8_t argument;
  vec2_t place_m;
} wire_event_t;

/** The drone's answer lets the ground find out what it has missed. Of the ground's own heartbeat
 * only the sequence counts for the drone; a simulator that runs faster than real time also waits
 * for its time_ms. */
typedef struct {
  uint16_t sequence;
  uint32_t time_ms;      ///< the drone's clock; from the ground: the latest that it received
  uint8_t state;         ///< mission_state_t
  uint8_t path_revision; ///< of the present route
  uint8_t path_total;    ///< number of points of the present route
  uint16_t next_event;   ///< sequence number of the next event to be sent
  uint16_t next_record;  ///< sequence number of the next history record to be sent
} wire_heartbeat_t;

typedef enum {
  WIRE_RECORD_POSE,    ///< the drone was at this pose
  WIRE_RECORD_MATCHED, ///< correction: SLAM took back the drift since the correction before
  WIRE_RECORD_LOST,    ///< the drone was lost from this pose on
  WIRE_RECORD_FOUND,   ///< correction: the drone was relocalised
} wire_record_kind_t;

/** A pose in the map frame, or a correction: the turn about the map's origin and then the shift
 * that take the previously estimated pose to the corrected one. */
typedef struct {
  uint32_t time_ms;
  int16_t x_mm;
  int16_t y_mm;
  int16_t yaw_1e4_rad; ///< in 1e-4 rad
  uint8_t kind;        ///< wire_record_kind_t
} wire_record_t;

typedef struct {
  uint16_t first; ///< sequence number of this packet's first record
  uint8_t count;
  wire_record_t records[WIRE_RECORDS_A_PACKET];
} wire_history_t;

typedef struct {
  uint8_t what;   ///< WIRE_PATH, WIRE_EVENT or WIRE_HISTORY
  uint16_t first; ///< sequence number of the first missing event or record
  uint8_t count;  ///< missing ones; the route is sent as a whole
} wire_ask_t;

typedef struct {
  uint8_t count;
  uint8_t tiles[WIRE_TILES_A_PACKET];
} wire_tiles_t;

/** Manual flight: the present demand of the stick. */
typedef struct {
  uint16_t sequence;   ///< number that a refusal repeats
  vec2_t velocity_mps; ///< horizontal, x forward and y left of the heading that is kept
  float yaw_rate_rps;
  float climb_mps;
} wire_steer_t;

typedef struct {
  uint8_t type; ///< wire_type_t: says which member of body is in use
  union {
    wire_hello_t hello;
    wire_command_t command;
    wire_ack_t ack;
    wire_path_t path;
    wire_waypoints_t waypoints;
    wire_event_t event;
    wire_heartbeat_t heartbeat;
    wire_history_t history;
    wire_ask_t ask;
    wire_tiles_t tiles;
    wire_steer_t steer;
    uint8_t map[WIRE_MAP_BYTES];
  } body;
} wire_message_t;

/** One tile of the map. */
typedef struct {
  uint8_t tile;                   ///< row-major from the grid's origin, GRID_TILES_PER_ROW a row
  uint8_t first_point;            ///< writing: if not all points fit, begin with those of this cell
  bool whole;                     ///< reading: all points of the tile are here
  uint8_t states[WIRE_MAP_CELLS]; ///< grid_state_t, row-major from the tile's origin
  uint8_t eighths[WIRE_MAP_CELLS]; ///< a cell's obstacle point: x in bits 0-2, y in bits 3-5, or
                                   ///< WIRE_NO_POINT
} wire_tile_t;

/** A piece while it is written or read: index of its first tile (1 byte); epoch (2 bits) and
 * checksum (14 bits); then consecutive tiles, packed bit by bit, as many as fit (wire_map.c). The
 * checksum detects pieces that a client put together from the variables of two log packets. */
typedef struct {
  uint8_t bytes[WIRE_MAP_BYTES];
  uint8_t bit;      ///< next bit of the payload
  uint8_t run_bit;  ///< bit at which the length of the present run of equal tiles is
  uint8_t run;      ///< writing: tiles in that run; reading: tiles left in it; 0: there is none
  uint8_t run_kind; ///< grid_state_t of the run, or a code of wire_map.c
  uint8_t tile;     ///< index of the next tile
  bool full;        ///< no further tile follows
} wire_map_t;

/** @param packet  WIRE_PACKET_BYTES long. @return bytes used; 0 if the type is unknown */
int wire_encode(const wire_message_t *message, uint8_t *packet);
/** Values are not validated here: a goal may be NaN. */
wire_status_t wire_decode(const uint8_t *packet, int length, wire_message_t *message);

/** Begin a piece whose first tile is this one. */
void wire_map_begin(wire_map_t *map, uint8_t tile, uint8_t epoch);
/** Add the next tile as a whole; or, if it is the first, its cells and as many points as fit. Only
 * occupied cells have points. @return false if it does not fit */
bool wire_map_add(wire_map_t *map, const wire_tile_t *tile);
/** Add the next tile, all cells of which are in this state: unknown or free. @return false if it
 * does not fit */
bool wire_map_add_plain(wire_map_t *map, uint8_t state);
/** Finish the piece in map->bytes. */
void wire_map_end(wire_map_t *map);

/** Begin to read a piece, WIRE_MAP_BYTES long. @return false if the checksum is wrong */
bool wire_map_open(wire_map_t *map, const uint8_t *bytes, uint8_t *epoch);
/** Read the next tile. @return false if there is none left */
bool wire_map_read(wire_map_t *map, wire_tile_t *tile);

#endif
