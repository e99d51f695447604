// SPDX-License-Identifier: GPL-3.0-or-later
/* Traffic with the client: app channel, console, and notices of changed parameters. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "FreeRTOS.h"
#include "app_channel.h"
#include "crtp.h"
#include "debug.h"
#include "port.h"
#include "sim_port.h"

enum {
  RX_PACKETS = 10,      ///< the app channel's receive queue in the firmware
  TX_PACKETS = 200,     ///< the firmware's transmit queue
  CONSOLE_BYTES = 8192, ///< text that waits for the simulator
  UPDATES = 64,         ///< notices of changed parameters that wait for it
};

typedef struct {
  uint8_t size;
  uint8_t bytes[SIM_PORT_APPCHANNEL_BYTES];
} packet_t;

static packet_t rx[RX_PACKETS];
static int rx_first, rx_count;
static bool rx_overflow;
static packet_t tx[TX_PACKETS];
static int tx_first, tx_count;
static int tx_free = TX_PACKETS;
static char console[CONSOLE_BYTES];
static int console_first, console_count;
static int updates[UPDATES];
static int updates_first, updates_count;
static bool connected;

void sim_port_set_connected(bool is_connected) {
  connected = is_connected;
}

void sim_port_set_tx_free(int packets) {
  tx_free = packets < 0 ? 0 : packets > TX_PACKETS ? TX_PACKETS : packets;
}

bool crtpIsConnected(void) {
  return connected;
}

int crtpGetFreeTxQueuePackets(void) {
  return tx_count < tx_free ? tx_free - tx_count : 0;
}

int appchannelSendDataPacket(void *data, size_t length) {
  if (crtpGetFreeTxQueuePackets() == 0) {
    return errQUEUE_FULL;
  }
  packet_t *packet = &tx[(tx_first + tx_count++) % TX_PACKETS];
  packet->size = (uint8_t)(length < APPCHANNEL_MTU ? length : APPCHANNEL_MTU);
  memcpy(packet->bytes, data, packet->size);
  return pdTRUE;
}

int sim_port_appchannel_take(uint8_t *bytes) {
  if (tx_count == 0) {
    return 0;
  }
  const packet_t *packet = &tx[tx_first];
  memcpy(bytes, packet->bytes, packet->size);
  tx_first = (tx_first + 1) % TX_PACKETS;
  tx_count--;
  return packet->size;
}

bool sim_port_appchannel_push(const uint8_t *bytes, int size) {
  if (rx_count == RX_PACKETS) {
    rx_overflow = true;
    return false;
  }
  packet_t *packet = &rx[(rx_first + rx_count++) % RX_PACKETS];
  packet->size = (uint8_t)(size < 0 ? 0 : size > APPCHANNEL_MTU ? APPCHANNEL_MTU : size);
  memcpy(packet->bytes, bytes, packet->size);
  return true;
}

size_t appchannelReceiveDataPacket(void *buffer, size_t max_length, int timeout_ms) {
  if (timeout_ms != 0) {
    port_fail("the app waits for a packet");
  }
  if (rx_count == 0) {
    return 0;
  }
  const packet_t *packet = &rx[rx_first];
  const size_t length = packet->size < max_length ? packet->size : max_length;
  memcpy(buffer, packet->bytes, length);
  rx_first = (rx_first + 1) % RX_PACKETS;
  rx_count--;
  return length;
}

bool appchannelHasOverflowOccurred(void) {
  const bool overflow = rx_overflow;
  rx_overflow = false;
  return overflow;
}

/** Text that finds no room is lost, as it is in the firmware. */
void consolePrintf(const char *format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  (void)vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  for (const char *c = text; *c && console_count < CONSOLE_BYTES; c++) {
    console[(console_first + console_count++) % CONSOLE_BYTES] = *c;
  }
}

/** A packet ends at the end of a line, or when it is full. */
int sim_port_console_take(char *text) {
  int length = 0;
  while (console_count > 0 && length < SIM_PORT_CONSOLE_BYTES) {
    const char c = console[console_first];
    console_first = (console_first + 1) % CONSOLE_BYTES;
    console_count--;
    text[length++] = c;
    if (c == '\n') {
      break;
    }
  }
  return length;
}

void port_param_changed(int id) {
  if (connected && updates_count < UPDATES) {
    updates[(updates_first + updates_count++) % UPDATES] = id;
  }
}

int sim_port_take_param_update(void) {
  if (updates_count == 0) {
    return -1;
  }
  const int id = updates[updates_first];
  updates_first = (updates_first + 1) % UPDATES;
  updates_count--;
  return id;
}
