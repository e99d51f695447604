// SPDX-License-Identifier: GPL-3.0-or-later
#include "log.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "port.h"
#include "toc.h"

enum { TYPE_MASK = 0x0F, GROUPS_MAX = 64 };

typedef const struct log_s *group_t;

extern const group_t __start_wayflie_log[];
extern const group_t __stop_wayflie_log[];

static toc_t toc;

static int by_name(const void *a, const void *b) {
  return strcmp((*(const struct log_s *const *)a)->name, (*(const struct log_s *const *)b)->name);
}

__attribute__((constructor)) static void build(void) {
  group_t groups[GROUPS_MAX];
  const size_t count = (size_t)(__stop_wayflie_log - __start_wayflie_log);
  if (count > GROUPS_MAX) {
    abort();
  }
  memcpy(groups, __start_wayflie_log, count * sizeof(group_t));
  qsort(groups, count, sizeof(group_t), by_name);
  for (size_t i = 0; i < count; i++) {
    const struct log_s *entry = groups[i];
    do {
      toc_add(&toc, entry->type, entry->name, entry);
    } while ((entry++)->type != (LOG_GROUP | LOG_STOP));
  }
}

static const struct log_s *entry_of(int id) {
  if (!toc_valid(&toc, id)) {
    port_fail("invalid log id");
    return 0;
  }
  return toc.entries[id].entry;
}

/** Value of a variable, from memory or from its function. A double holds all types exactly. */
static double acquire(const struct log_s *entry, uint32_t time_ms) {
  if (!entry || !entry->address) {
    return 0.0;
  }
  const logByFunction_t *get = (entry->type & LOG_BY_FUNCTION) ? entry->address : 0;
  const void *at = entry->address;
  switch (entry->type & TYPE_MASK) {
  case LOG_UINT8:
    return get ? get->acquireUInt8(time_ms, get->data) : *(const uint8_t *)at;
  case LOG_UINT16:
    return get ? get->acquireUInt16(time_ms, get->data) : *(const uint16_t *)at;
  case LOG_UINT32:
    return get ? get->acquireUInt32(time_ms, get->data) : *(const uint32_t *)at;
  case LOG_INT8:
    return get ? get->acquireInt8(time_ms, get->data) : *(const int8_t *)at;
  case LOG_INT16:
    return get ? get->acquireInt16(time_ms, get->data) : *(const int16_t *)at;
  case LOG_INT32:
    return get ? get->acquireInt32(time_ms, get->data) : *(const int32_t *)at;
  default:
    return (double)(get ? get->aquireFloat(time_ms, get->data) : *(const float *)at);
  }
}

/** Half precision as the firmware converts it: truncated; too small becomes zero, too large
 *  infinite. */
static uint16_t to_half(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  const uint16_t sign = (uint16_t)((bits >> 16) & 0x8000u);
  const int exponent = (int)((bits >> 23) & 0xffu) - 127;
  const uint32_t fraction = bits & 0x7fffffu;
  if (exponent == 128 && fraction != 0) {
    return sign | 0x7e00u;
  }
  if (exponent > 15) {
    return sign | 0x7c00u;
  }
  if (exponent < -14) {
    return sign;
  }
  return (uint16_t)(sign | (uint32_t)(exponent + 15) << 10 | fraction >> 13);
}

/** Integer as the chip converts it: truncated and saturated at 32 bits; NaN gives 0. */
static uint32_t to_integer(double value) {
  if (isnan(value)) {
    return 0;
  }
  if (value < 0.0) {
    return (uint32_t)(value <= INT32_MIN ? INT32_MIN : (int32_t)value);
  }
  return value >= UINT32_MAX ? UINT32_MAX : (uint32_t)value;
}

int sim_port_log_read(int id, int fetch_type, uint32_t time_ms, uint8_t *bytes) {
  static const uint8_t sizes[] = {0, 1, 2, 4, 1, 2, 4, 4, 2};
  if (!toc_valid(&toc, id) || fetch_type < LOG_UINT8 || fetch_type > LOG_FP16) {
    return 0;
  }
  const double value = acquire(toc.entries[id].entry, time_ms);
  const float single = (float)value;
  uint32_t raw;
  if (fetch_type == LOG_FLOAT) {
    memcpy(&raw, &single, sizeof raw);
  } else if (fetch_type == LOG_FP16) {
    raw = to_half(single);
  } else {
    raw = to_integer(value);
  }
  for (int i = 0; i < sizes[fetch_type]; i++) {
    bytes[i] = (uint8_t)(raw >> (8 * i));
  }
  return sizes[fetch_type];
}

int sim_port_log_read_block(const uint16_t *ids, const uint8_t *types, int n, uint32_t time_ms,
                            uint8_t *bytes) {
  int size = 0;
  for (int i = 0; i < n; i++) {
    const int added = sim_port_log_read(ids[i], types[i], time_ms, &bytes[size]);
    if (added == 0) {
      return 0;
    }
    size += added;
  }
  return size;
}

int sim_port_log_count(void) {
  return toc.count;
}

bool sim_port_log_entry(int id, sim_port_entry_t *entry) {
  if (!toc_valid(&toc, id)) {
    return false;
  }
  *entry = (sim_port_entry_t){0};
  toc_describe(&toc.entries[id], entry);
  return true;
}

uint32_t sim_port_log_crc(void) {
  return toc.crc;
}

logVarId_t logGetVarId(const char *group, const char *name) {
  return (logVarId_t)toc_find(&toc, group, name);
}

float logGetFloat(logVarId_t id) {
  const struct log_s *entry = entry_of(id);
  return entry ? (float)acquire(entry, port_now_ms()) : 0.0f;
}

unsigned int logGetUint(logVarId_t id) {
  const struct log_s *entry = entry_of(id);
  return entry ? to_integer(acquire(entry, port_now_ms())) : 0;
}
