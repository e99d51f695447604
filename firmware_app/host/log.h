// SPDX-License-Identifier: GPL-3.0-or-later
/** @file log.h  Host version: log variables, declared with the firmware's macros.
 *
 *  A group is an array of entries between a start and a stop entry. A pointer to it is placed in a
 *  linker section, in which log.c finds all groups.
 */
#ifndef LOG_H
#define LOG_H

#include <stdbool.h>
#include <stdint.h>

typedef uint16_t logVarId_t;

logVarId_t logGetVarId(const char *group, const char *name);
/** Read a variable; not one by function, which the firmware does not support here. An invalid id
 *  stops the firmware: check with logVarIdIsValid() first. */
float logGetFloat(logVarId_t id);
unsigned int logGetUint(logVarId_t id);

static inline bool logVarIdIsValid(logVarId_t id) {
  return id != 0xffffu;
}

struct log_s {
  uint8_t type;
  const char *name;
  void *address;
};

typedef struct {
  union {
    uint8_t (*acquireUInt8)(uint32_t timestamp, void *data);
    uint16_t (*acquireUInt16)(uint32_t timestamp, void *data);
    uint32_t (*acquireUInt32)(uint32_t timestamp, void *data);
    int8_t (*acquireInt8)(uint32_t timestamp, void *data);
    int16_t (*acquireInt16)(uint32_t timestamp, void *data);
    int32_t (*acquireInt32)(uint32_t timestamp, void *data);
    float (*aquireFloat)(uint32_t timestamp, void *data);
  };
  void *data;
} logByFunction_t;

#define LOG_UINT8  1
#define LOG_UINT16 2
#define LOG_UINT32 3
#define LOG_INT8   4
#define LOG_INT16  5
#define LOG_INT32  6
#define LOG_FLOAT  7
#define LOG_FP16   8

#define LOG_STOP        0x00
#define LOG_START       0x01
#define LOG_CORE        0x20
#define LOG_BY_FUNCTION 0x40
#define LOG_GROUP       0x80

#define LOG_ADD(TYPE, NAME, ADDRESS) {.type = (TYPE), .name = #NAME, .address = (void *)(ADDRESS)},

#define LOG_ADD_CORE(TYPE, NAME, ADDRESS)        LOG_ADD((TYPE) | LOG_CORE, NAME, ADDRESS)
#define LOG_ADD_BY_FUNCTION(TYPE, NAME, ADDRESS) LOG_ADD((TYPE) | LOG_BY_FUNCTION, NAME, ADDRESS)

#define LOG_GROUP_START(NAME)                                                                      \
  static const struct log_s log_group_##NAME[] = {LOG_ADD(LOG_GROUP | LOG_START, NAME, 0)
#define LOG_GROUP_STOP(NAME)                                                                       \
  LOG_ADD(LOG_GROUP | LOG_STOP, stop_##NAME, 0)                                                    \
  }                                                                                                \
  ;                                                                                                \
  static const struct log_s *const log_link_##NAME __attribute__((section("wayflie_log"), used)) = \
      log_group_##NAME;

#endif
