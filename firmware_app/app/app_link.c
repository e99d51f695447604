// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_link.h"

#include <string.h>

#include "FreeRTOS.h"
#include "app_channel.h"
#include "app_command.h"
#include "app_selftest.h"
#include "app_status.h"
#include "app_text.h"
#include "crtp.h"
#include "history.h"
#include "task.h"

#define DEBUG_MODULE "WAYFLIE"
#include "debug.h"

enum {
  RECEIVE_MAX = 10,      ///< packets per tick: what the firmware's queue holds
  ACKS = 8,              ///< acknowledgements kept, to recognise repeated commands
  BEAT_SILENT_MS = 1500, ///< silence after heartbeats, which come twice a second
};

static wire_ack_t acks[ACKS]; ///< ring of the last ones; cmd 0: none
static uint8_t next_ack;

static history_t history;
static uint16_t next_record;                ///< sequence number of the next record to send
static uint16_t again_event, again_record;  ///< first one that the ground station asked for again
static uint8_t events_again, records_again; ///< number still to be sent again

static uint32_t beat_ms; ///< time of the last heartbeat
static bool beats;       ///< heartbeats were received in this flight

static bool hello_due;
static uint8_t hello_epoch; ///< map epoch of the last HELLO
static uint8_t path_revision;
static uint8_t path_total;
static uint8_t path_next; ///< next point to send, at most path_total
static bool path_due;
static wire_event_t event; ///< being sent
static bool event_due;

static bool send(const wire_message_t *message) {
  uint8_t packet[WIRE_PACKET_BYTES];
  const int length = wire_encode(message, packet);
  const bool sent = appchannelSendDataPacket(packet, (size_t)length) == pdTRUE;
  if (!sent) {
    app_status_count_drop();
  }
  return sent;
}

static const wire_ack_t *past_ack(const wire_command_t *command) {
  for (int i = 0; i < ACKS; i++) {
    if (acks[i].sequence == command->sequence && acks[i].cmd == command->cmd) {
      return &acks[i];
    }
  }
  return NULL;
}

/** A repeated command acts only once, even if others came in between; it is acknowledged again. */
static void on_command(nav_t *nav, const wire_command_t *command) {
  const wire_ack_t *ack = command->cmd != MISSION_CMD_NONE ? past_ack(command) : NULL;
  if (ack == NULL) {
    const nav_command_t order = {(mission_cmd_t)command->cmd, command->goal_m};
    const mission_reason_t reason = app_command(nav, &order);
    acks[next_ack] = (wire_ack_t){command->sequence, command->cmd, (uint8_t)reason};
    ack = &acks[next_ack];
    next_ack = (uint8_t)((next_ack + 1) % ACKS);
  }
  send(&(wire_message_t){.type = WIRE_ACK, .body.ack = *ack});
}

static void acknowledge(uint16_t sequence, mission_reason_t reason) {
  const wire_ack_t ack = {sequence, MISSION_CMD_NONE, (uint8_t)reason};
  send(&(wire_message_t){.type = WIRE_ACK, .body.ack = ack});
}

static void on_waypoints(nav_t *nav, const wire_waypoints_t *waypoints) {
  const mission_reason_t reason =
      app_selftest_running() ? MISSION_SELF_TEST : nav_take_waypoints(nav, waypoints);
  acknowledge(waypoints->sequence, reason);
}

/** Stick packets arrive many times a second, so only refusals are acknowledged. */
static void on_steer(nav_t *nav, const wire_steer_t *stick) {
  const mission_reason_t reason =
      app_selftest_running() ? MISSION_SELF_TEST : nav_steer(nav, stick);
  if (reason != MISSION_OK) {
    acknowledge(stick->sequence, reason);
  }
}

static void on_heartbeat(const nav_t *nav, const wire_heartbeat_t *heartbeat) {
  wire_message_t answer = {.type = WIRE_HEARTBEAT, .body.heartbeat = *heartbeat};
  beat_ms = T2M(xTaskGetTickCount());
  beats = true;
  answer.body.heartbeat.time_ms = beat_ms;
  answer.body.heartbeat.next_event = (uint16_t)(nav->event_sequence - nav->event_count);
  answer.body.heartbeat.next_record = next_record;
  answer.body.heartbeat.path_revision = path_revision;
  answer.body.heartbeat.path_total = path_total;
  answer.body.heartbeat.state = app_selftest_running() ? MISSION_IDLE : nav->status.state;
  send(&answer);
}

static void send_route_again(void) {
  path_due = true;
  path_next = 0;
}

static bool on_ask(const wire_ask_t *ask) {
  if (ask->what == WIRE_PATH) {
    send_route_again();
  } else if (ask->what == WIRE_EVENT) {
    again_event = ask->first;
    events_again = ask->count < NAV_EVENTS ? ask->count : (uint8_t)NAV_EVENTS;
  } else if (ask->what == WIRE_HISTORY) {
    again_record = ask->first;
    records_again = ask->count < HISTORY_RECORDS ? ask->count : (uint8_t)HISTORY_RECORDS;
  } else {
    return false;
  }
  return true;
}

/** @return false if the message was refused or is not for the drone */
static bool on_message(nav_t *nav, const wire_message_t *message) {
  switch ((wire_type_t)message->type) {
  case WIRE_HELLO:
    hello_due = hello_due || message->body.hello.request == 1;
    return message->body.hello.request == 1;
  case WIRE_COMMAND:
    on_command(nav, &message->body.command);
    return true;
  case WIRE_HEARTBEAT:
    on_heartbeat(nav, &message->body.heartbeat);
    return true;
  case WIRE_WAYPOINTS:
    on_waypoints(nav, &message->body.waypoints);
    return true;
  case WIRE_SNAPSHOT:
    hello_due = true;
    send_route_again();
    nav_resend_map(nav);
    return true;
  case WIRE_MAP:
    return !app_selftest_running() && nav_take_map_piece(nav, message->body.map);
  case WIRE_ASK:
    return on_ask(&message->body.ask);
  case WIRE_TILES:
    nav_resend_tiles(nav, &message->body.tiles);
    return true;
  case WIRE_STEER:
    on_steer(nav, &message->body.steer);
    return true;
  case WIRE_ACK:
  case WIRE_PATH:
  case WIRE_EVENT:
  case WIRE_HISTORY:
    break;
  }
  return false;
}

void app_link_receive(nav_t *nav) {
  uint8_t packet[APPCHANNEL_MTU];
  wire_message_t message;
  if (appchannelHasOverflowOccurred()) {
    app_status_count_drop();
  }
  for (int i = 0; i < RECEIVE_MAX; i++) {
    const size_t length = appchannelReceiveDataPacket(packet, sizeof packet, 0);
    if (length == 0) {
      return;
    }
    if (wire_decode(packet, (int)length, &message) != WIRE_OK || !on_message(nav, &message)) {
      app_status_count_bad();
    }
  }
}

/** Send HELLO when asked, and whenever a new map was made: without it the ground station cannot
 *  decode the map. */
static void send_hello(const nav_t *nav) {
  const wire_message_t hello = {.type = WIRE_HELLO, .body.hello = nav_hello(nav)};
  if (hello.body.hello.epoch != hello_epoch) {
    hello_due = true;
  }
  if (hello_due && send(&hello)) {
    hello_due = false;
    hello_epoch = hello.body.hello.epoch;
  }
}

/** Send one packet of the route; a new route is sent from its start, an empty one as such. */
static void send_route(const route_t *route) {
  if (route->revision != path_revision || route->count != path_total) {
    path_revision = route->revision;
    path_total = route->count;
    send_route_again();
  }
  if (!path_due) {
    return;
  }
  const int left = route->count - path_next;
  const int count = left < WIRE_PATH_POINTS ? left : WIRE_PATH_POINTS;
  wire_message_t message = {.type = WIRE_PATH};
  message.body.path.revision = route->revision;
  message.body.path.first = path_next;
  message.body.path.total = route->count;
  message.body.path.count = (uint8_t)count;
  memcpy(message.body.path.points_m, &route->points_m[path_next], (size_t)count * sizeof(vec2_t));
  if (send(&message)) {
    path_next += (uint8_t)count;
    path_due = path_next < route->count;
  }
}

static void tell(const wire_event_t *told) {
  const char *reason = app_reason_text((mission_reason_t)told->argument);
  if (told->code == WIRE_EVENT_REFUSED) {
    app_status_answer((mission_reason_t)told->argument);
    DEBUG_PRINT("goal refused: %s\n", reason);
  } else if (told->code == WIRE_EVENT_FAULT) {
    DEBUG_PRINT("fault: %s\n", reason);
  }
}

/** Send the next event, kept until there is room for it. Without a client it is discarded. */
static void send_event(nav_t *nav, bool connected) {
  if (!event_due && nav_take_event(nav, &event)) {
    tell(&event);
    event_due = true;
  }
  if (event_due &&
      (!connected || send(&(wire_message_t){.type = WIRE_EVENT, .body.event = event}))) {
    event_due = false;
  }
}

static void send_event_again(const nav_t *nav) {
  wire_message_t message = {.type = WIRE_EVENT};
  if (events_again > 0 &&
      (!nav_past_event(nav, again_event, &message.body.event) || send(&message))) {
    again_event++;
    events_again--;
  }
}

/** Send history records. Those asked for again go first, as the ground station holds the later ones
 *  back until it has them. */
static void send_history(void) {
  wire_message_t message = {.type = WIRE_HISTORY};
  const bool again = records_again > 0;
  const uint16_t from = again ? again_record : next_record;
  if (!history_get(&history, from, &message.body.history)) {
    records_again = 0;
  } else if (send(&message)) {
    const uint16_t next = (uint16_t)(message.body.history.first + message.body.history.count);
    const uint16_t told = (uint16_t)(next - from);
    if (again) {
      again_record = next;
      records_again = (uint8_t)(told < records_again ? records_again - told : 0);
    } else {
      next_record = next;
    }
  }
}

bool app_link_ground_alive(void) {
  return crtpIsConnected() && (!beats || T2M(xTaskGetTickCount()) - beat_ms < BEAT_SILENT_MS);
}

void app_link_send(nav_t *nav) {
  const bool connected = crtpIsConnected();
  beats = beats && mission_airborne(nav->mission.state);
  history_step(&history, nav);
  send_event(nav, connected);
  if (connected) {
    send_hello(nav);
    send_route(&nav->route);
    send_event_again(nav);
    send_history();
  }
}
