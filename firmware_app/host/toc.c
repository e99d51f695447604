// SPDX-License-Identifier: GPL-3.0-or-later
#include "toc.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TYPE_GROUP = 0x80, TYPE_START = 0x01 };

/** CRC-32 as in zlib (reflected polynomial 0xEDB88320). */
static uint32_t crc32_of(const uint8_t *bytes, size_t size) {
  uint32_t rest = ~0u;
  for (size_t i = 0; i < size; i++) {
    rest ^= bytes[i];
    for (int bit = 0; bit < 8; bit++) {
      rest = (rest >> 1) ^ ((rest & 1u) ? 0xEDB88320u : 0u);
    }
  }
  return ~rest;
}

/** Content hash as in the firmware: each entry is hashed together with the previous hash. */
static uint32_t chain(uint32_t crc, uint8_t type, const char *name) {
  uint8_t buffer[5 + SIM_PORT_NAME_BYTES];
  const size_t length = strlen(name);
  for (int i = 0; i < 4; i++) {
    buffer[i] = (uint8_t)(crc >> (8 * i));
  }
  buffer[4] = type;
  for (size_t i = 0; i < length; i++) {
    buffer[5 + i] = (uint8_t)name[i];
  }
  return crc32_of(buffer, 5 + length);
}

static void require(bool holds, const char *rule, const char *name) {
  if (!holds) {
    (void)fprintf(stderr, "wayflie host: %s: %s\n", rule, name);
    abort();
  }
}

void toc_add(toc_t *toc, uint8_t type, const char *name, const void *entry) {
  require(strlen(name) < SIM_PORT_NAME_BYTES, "name too long", name);
  toc->crc = chain(toc->crc, type, name);
  if (type & TYPE_GROUP) {
    toc->group = (type & TYPE_START) ? name : 0;
    return;
  }
  require(toc->group != 0, "variable outside of a group", name);
  require(strlen(toc->group) + strlen(name) <= TOC_NAMES_MAX, "group and name too long", name);
  require(toc->count < TOC_ENTRIES, "table full", name);
  require(toc_find(toc, toc->group, name) < 0, "declared twice", name);
  toc->entries[toc->count++] = (toc_entry_t){type, toc->group, name, entry};
}

int toc_find(const toc_t *toc, const char *group, const char *name) {
  for (int i = 0; i < toc->count; i++) {
    if (strcmp(toc->entries[i].name, name) == 0 && strcmp(toc->entries[i].group, group) == 0) {
      return i;
    }
  }
  return -1;
}

bool toc_valid(const toc_t *toc, int id) {
  return id >= 0 && id < toc->count;
}

void toc_describe(const toc_entry_t *entry, sim_port_entry_t *out) {
  out->type = entry->type;
  memcpy(out->group, entry->group, strlen(entry->group) + 1); // toc_add() checked that both fit
  memcpy(out->name, entry->name, strlen(entry->name) + 1);
}
