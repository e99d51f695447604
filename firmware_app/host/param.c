// SPDX-License-Identifier: GPL-3.0-or-later
#include "param.h"

#include <stdlib.h>
#include <string.h>

#include "port.h"
#include "toc.h"

enum { GROUPS_MAX = 64, NO_ENTRY = 2, NO_ACCESS = 13, INVALID = 22 };

typedef const struct param_s *group_t;

extern const group_t __start_wayflie_param[];
extern const group_t __stop_wayflie_param[];

static toc_t toc;
static uint8_t defaults[TOC_ENTRIES][4];

static int size_of(const struct param_s *entry) {
  return 1 << (entry->type & PARAM_BYTES_MASK);
}

static int by_name(const void *a, const void *b) {
  return strcmp((*(const struct param_s *const *)a)->name,
                (*(const struct param_s *const *)b)->name);
}

/** Builds the table. Defaults are the values of the variables when the library is loaded. */
__attribute__((constructor)) static void build(void) {
  group_t groups[GROUPS_MAX];
  const size_t count = (size_t)(__stop_wayflie_param - __start_wayflie_param);
  if (count > GROUPS_MAX) {
    abort();
  }
  memcpy(groups, __start_wayflie_param, count * sizeof(group_t));
  qsort(groups, count, sizeof(group_t), by_name);
  for (size_t i = 0; i < count; i++) {
    const struct param_s *entry = groups[i];
    do {
      toc_add(&toc, entry->type, entry->name, entry);
    } while ((entry++)->type != (PARAM_GROUP | PARAM_STOP));
  }
  for (int id = 0; id < toc.count; id++) {
    sim_port_param_read(id, defaults[id]);
  }
}

static const struct param_s *entry_of(int id) {
  return toc_valid(&toc, id) ? toc.entries[id].entry : 0;
}

int sim_port_param_count(void) {
  return toc.count;
}

uint32_t sim_port_param_crc(void) {
  return toc.crc;
}

bool sim_port_param_entry(int id, sim_port_entry_t *entry) {
  const struct param_s *found = entry_of(id);
  if (!found) {
    return false;
  }
  *entry = (sim_port_entry_t){
      .extended = (found->type & PARAM_EXTENDED) != 0,
      .persistent = (found->extended_type & (PARAM_PERSISTENT >> 8)) != 0,
  };
  toc_describe(&toc.entries[id], entry);
  return true;
}

int sim_port_param_read(int id, uint8_t *bytes) {
  const struct param_s *entry = entry_of(id);
  if (!entry) {
    return 0;
  }
  memcpy(bytes, entry->address, (size_t)size_of(entry));
  return size_of(entry);
}

int sim_port_param_default(int id, uint8_t *bytes) {
  const struct param_s *entry = entry_of(id);
  if (!entry) {
    return 0;
  }
  memcpy(bytes, defaults[id], (size_t)size_of(entry));
  return size_of(entry);
}

int sim_port_param_force(int id, const uint8_t *bytes, int size) {
  const struct param_s *entry = entry_of(id);
  if (!entry) {
    return NO_ENTRY;
  }
  if (size != size_of(entry)) {
    return INVALID;
  }
  memcpy(entry->address, bytes, (size_t)size);
  return 0;
}

int sim_port_param_write(int id, const uint8_t *bytes, int size) {
  const struct param_s *entry = entry_of(id);
  if (entry && (entry->type & PARAM_RONLY)) {
    return NO_ACCESS;
  }
  const int error = sim_port_param_force(id, bytes, size);
  if (error == 0 && entry && entry->callback) {
    entry->callback();
  }
  return error;
}

paramVarId_t paramGetVarId(const char *group, const char *name) {
  const uint16_t id = (uint16_t)toc_find(&toc, group, name);
  return (paramVarId_t){id, id};
}

static const struct param_s *checked(paramVarId_t id, bool for_writing) {
  const struct param_s *entry = entry_of(id.id);
  if (!entry) {
    port_fail("invalid parameter id");
  } else if (for_writing && (entry->type & PARAM_RONLY)) {
    port_fail("writing a read-only parameter");
    entry = 0;
  }
  return entry;
}

unsigned int paramGetUint(paramVarId_t id) {
  const struct param_s *entry = checked(id, false);
  unsigned int value = 0;
  if (entry && (entry->type & PARAM_TYPE_MASK) == PARAM_FLOAT) {
    value = (unsigned int)(int)*(const float *)entry->address;
  } else if (entry) {
    memcpy(&value, entry->address, (size_t)size_of(entry));
  }
  return value;
}

static void set(paramVarId_t id, const void *value) {
  const struct param_s *entry = checked(id, true);
  if (!entry) {
    return;
  }
  memcpy(entry->address, value, (size_t)size_of(entry));
  port_param_changed(id.id);
  if (entry->callback) {
    entry->callback();
  }
}

void paramSetInt(paramVarId_t id, int value) {
  set(id, &value);
}

void paramSetFloat(paramVarId_t id, float value) {
  set(id, &value);
}
