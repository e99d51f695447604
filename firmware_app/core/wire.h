// SPDX-License-Identifier: GPL-3.0-or-later
/** @file wire.h  The packets of the app channel and the pieces of the map stream, as bytes.
 *  App channel: at most 30 bytes, little-endian, byte 0 WIRE_VERSION, byte 1 the type. A packet of
 * another version, type or length is refused as a whole. Map piece: exactly 26 bytes, stands alone.
 * The ground decodes with this same code. */
#ifndef WIRE_H
#define WIRE_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"

enum {
  WIRE_VERSION = 2,
  WIRE_PACKET_BYTES = 30,
  WIRE_PATH_POINTS = 6, ///< in one PATH packet
  WIRE_WAYPOINTS_A_PACKET = 5,
  WIRE_MAP_BYTES = 26, ///< 6 x uint32 + 1 x uint16: one log block
  WIRE_MAP_CELLS = 64, ///< 8 x 8, the grid's tile
  WIRE_MAP_EPOCHS = 4,
  WIRE_NO_POINT = 255,
  WIRE_RECORDS_A_PACKET = 2,
  WIRE_TILES_A_PACKET = 27,
};

typedef enum {
  WIRE_HELLO = 1,     ///< ground asks (nothing), drone answers: wire_hello_t
  WIRE_COMMAND = 2,   ///< ground: wire_command_t
  WIRE_ACK = 3,       ///< drone: wire_ack_t
  WIRE_PATH = 4,      ///< drone: wire_path_t
  WIRE_EVENT = 5,     ///< drone: wire_event_t
  WIRE_HEARTBEAT = 6, ///< ground sends, drone answers with the same sequence: wire_heartbeat_t
  WIRE_SNAPSHOT = 7,  ///< ground: send hello, path and the whole map again
  WIRE_MAP = 8,       ///< ground: a piece of a map that it has kept, as the drone sent it
  WIRE_WAYPOINTS = 9, ///< ground: wire_waypoints_t, acknowledged
  WIRE_HISTORY = 10,  ///< drone: wire_history_t
  WIRE_ASK = 11,      ///< ground: wire_ask_t, for what was lost
  WIRE_TILES = 12,    ///< ground: wire_tiles_t, tiles that it has not heard for long
  WIRE_STEER = 13,    ///< ground: wire_steer_t, again and again; acknowledged only if refused
} wire_type_t;

typedef enum { WIRE_OK, WIRE_SHORT, WIRE_LONG, WIRE_BAD_VERSION, WIRE_BAD_TYPE } wire_status_t;

/** What the drone can do, whatever it is set to do. */
typedef enum {
  WIRE_CAP_RRTSTAR = 1,
  WIRE_CAP_GRID_SEARCH = 2,
  WIRE_CAP_SLAM = 4,
  WIRE_CAP_EXPLORE = 8,
} wire_capability_t;

typedef struct {
  uint8_t request; ///< 1: the ground asks, the rest is ignored
  uint8_t capabilities;
  uint8_t epoch; ///< of the map: grows when it is forgotten, modulo WIRE_MAP_EPOCHS
  uint16_t cell_mm;
  uint16_t side_cells;
  vec2_t origin_m; ///< corner of cell (0, 0), map frame
} wire_hello_t;

typedef struct {
  uint16_t sequence; ///< a repeated sequence acts once, and is acknowledged again
  uint8_t cmd;       ///< mission_cmd_t
  vec2_t goal_m;     ///< map frame; only for MISSION_CMD_GOTO
} wire_command_t;

/** Some of the way points of a list. The same packet again changes nothing; one of another list, or
 * of another total, begins anew. */
typedef struct {
  uint16_t sequence;                             ///< that the answer carries
  uint8_t list;                                  ///< any number, another one for other way points
  uint8_t first;                                 ///< index of the first point here
  uint8_t total;                                 ///< points of the whole list
  uint8_t count;                                 ///< points here
  int16_t points_mm[WIRE_WAYPOINTS_A_PACKET][2]; ///< x and y, map frame
} wire_waypoints_t;

typedef struct {
  uint16_t sequence;
  uint8_t cmd;    ///< mission_cmd_t; MISSION_CMD_NONE answers WAYPOINTS
  uint8_t reason; ///< mission_reason_t; MISSION_OK: taken
} wire_ack_t;

typedef struct {
  uint8_t revision;                  ///< of the route; pieces of one revision belong together
  uint8_t first;                     ///< index of the first point here
  uint8_t total;                     ///< points of the whole route, 0: there is none
  uint8_t count;                     ///< points here
  vec2_t points_m[WIRE_PATH_POINTS]; ///< sent in millimetres, +-32 m
} wire_path_t;

typedef enum {
  WIRE_EVENT_STATE = 1, ///< argument: mission_state_t entered
  WIRE_EVENT_REFUSED =
      2, ///< argument: mission_reason_t; place: the reachable point nearest to the goal
  WIRE_EVENT_FAULT = 3,    ///< argument: mission_reason_t
  WIRE_EVENT_ARRIVED = 4,  ///< place: where
  WIRE_EVENT_EXPLORED = 5, ///< argument 0: all that can be reached; 1: some of it was given up
  WIRE_EVENT_FOUND = 6,    ///< it knows again where it is; place: where
  WIRE_EVENT_WAYPOINT = 7, ///< argument: number of the way point, from 0; place: where it arrived
  WIRE_EVENT_SKIPPED = 8,  ///< argument: mission_reason_t; place: the way point
} wire_event_code_t;

typedef struct {
  uint16_t sequence;
  uint32_t time_ms;
  uint8_t code; ///< wire_event_code_t
  uint8_t argument;
  vec2_t place_m;
} wire_event_t;

/** What the drone has to tell, so that the ground knows what it has missed. Of what the ground
 * sends only the sequence counts; a simulator that is faster than reality waits for its time. */
typedef struct {
  uint16_t sequence;
  uint32_t time_ms;      ///< the drone's clock; from the ground, as far as it has heard
  uint8_t state;         ///< mission_state_t
  uint8_t path_revision; ///< of the present route
  uint8_t path_total;    ///< its points
  uint16_t next_event;   ///< sequence of the event that comes next
  uint16_t next_record;  ///< likewise of the history
} wire_heartbeat_t;

typedef enum {
  WIRE_RECORD_POSE,    ///< here the drone was
  WIRE_RECORD_MATCHED, ///< what it drifted since the correction before is taken back
  WIRE_RECORD_LOST,    ///< from here on it did not know where it was
  WIRE_RECORD_FOUND,   ///< and now it does
} wire_record_kind_t;

/** A pose in the map; or, of a correction, the turn about the map's origin and the shift behind it
 * that take the pose as it was believed to what is believed now. */
typedef struct {
  uint32_t time_ms;
  int16_t x_mm;
  int16_t y_mm;
  int16_t yaw_1e4_rad; ///< a ten-thousandth of a radian
  uint8_t kind;        ///< wire_record_kind_t
} wire_record_t;

typedef struct {
  uint16_t first; ///< sequence of the first record here
  uint8_t count;
  wire_record_t records[WIRE_RECORDS_A_PACKET];
} wire_history_t;

typedef struct {
  uint8_t what;   ///< WIRE_PATH, WIRE_EVENT or WIRE_HISTORY
  uint16_t first; ///< sequence of the first that is missing
  uint8_t count;
} wire_ask_t;

typedef struct {
  uint8_t count;
  uint8_t tiles[WIRE_TILES_A_PACKET];
} wire_tiles_t;

/** Flying by hand: what the stick wants just now. */
typedef struct {
  uint16_t sequence;   ///< that a refusal carries
  vec2_t velocity_mps; ///< level, x forward, y left of the heading that is kept
  float yaw_rate_rps;
  float climb_mps;
} wire_steer_t;

typedef struct {
  uint8_t type; ///< wire_type_t: says which member is meant
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
  uint8_t tile;                    ///< row-major from the grid's origin, GRID_TILES_PER_ROW a row
  uint8_t first_point;             ///< where not all points fit: told from this cell on
  bool whole;                      ///< read: these are all its points
  uint8_t states[WIRE_MAP_CELLS];  ///< grid_state_t, row-major from the tile's origin
  uint8_t eighths[WIRE_MAP_CELLS]; ///< a cell's obstacle point: x in bits 0-2, y in bits 3-5, or
                                   ///< WIRE_NO_POINT
} wire_tile_t;

/** A piece: the number of its first tile, a 16-bit word of epoch (2 bits) and a check over all the
 * rest, then tiles in a row, bit after bit, as many as fit; see wire_map.c. The check notices
 * variables of two log packets put together by mistake. */
typedef struct {
  uint8_t bytes[WIRE_MAP_BYTES];
  uint8_t bit;      ///< of the payload, the next one
  uint8_t run_bit;  ///< where the length of the present run of equal tiles stands
  uint8_t run;      ///< tiles in it, 0: there is none
  uint8_t run_kind; ///< grid_state_t
  uint8_t tile;     ///< the next one
  bool full;
} wire_map_t;

/** @param packet WIRE_PACKET_BYTES long. @return bytes used; 0 if the type is unknown */
int wire_encode(const wire_message_t *message, uint8_t *packet);
/** Numbers are not judged here: a goal may be NaN. */
wire_status_t wire_decode(const uint8_t *packet, int length, wire_message_t *message);

/** Begin a piece; its tiles follow one another from this one on. */
void wire_map_begin(wire_map_t *map, uint8_t tile, uint8_t epoch);
/** Add the next tile: all of it, or, if it is the first, the cells and as many points as fit. Only
 * occupied cells have points. @return false if it does not fit */
bool wire_map_add(wire_map_t *map, const wire_tile_t *tile);
/** Add the next tile, all of it in this state: unknown or free. */
bool wire_map_add_plain(wire_map_t *map, uint8_t state);
/** The piece is complete in map->bytes. */
void wire_map_end(wire_map_t *map);

/** @param bytes WIRE_MAP_BYTES long. @return false if the check does not match */
bool wire_map_open(wire_map_t *map, const uint8_t *bytes, uint8_t *epoch);
/** The next tile of it. @return false if there is none, or nothing that can be read */
bool wire_map_read(wire_map_t *map, wire_tile_t *tile);

#endif
