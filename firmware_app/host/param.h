// SPDX-License-Identifier: GPL-3.0-or-later
/** @file param.h  Host version: parameters, declared with the firmware's macros.
 *
 *  Groups are stored like those of log.h: arrays of entries, found by pointers in a section.
 */
#ifndef PARAM_H
#define PARAM_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  uint16_t id;
  uint16_t index;
} paramVarId_t;

#define PARAM_VARID_IS_VALID(varId) ((varId).id != 0xffffu)

paramVarId_t paramGetVarId(const char *group, const char *name);
/** In all of these an invalid id stops the firmware. */
unsigned int paramGetUint(paramVarId_t id);
/** Store a value, notify the client, and run the callback in the caller's task. */
void paramSetInt(paramVarId_t id, int value);
void paramSetFloat(paramVarId_t id, float value);

struct param_s {
  uint8_t type;
  uint8_t extended_type;
  const char *name;
  void *address;
  void (*callback)(void);
};

#define PARAM_INT8   0x00
#define PARAM_INT16  0x01
#define PARAM_INT32  0x02
#define PARAM_FLOAT  0x06
#define PARAM_UINT8  0x08
#define PARAM_UINT16 0x09
#define PARAM_UINT32 0x0A

#define PARAM_STOP       0x00
#define PARAM_START      0x01
#define PARAM_BYTES_MASK 0x03
#define PARAM_TYPE_MASK  0x0F
#define PARAM_EXTENDED   0x10
#define PARAM_CORE       0x20
#define PARAM_RONLY      0x40
#define PARAM_GROUP      0x80
#define PARAM_PERSISTENT 0x100

#define PARAM_ADD_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK)                                     \
  {.type = (uint8_t)(((TYPE) > 0xff ? (TYPE) | PARAM_EXTENDED : (TYPE)) & 0xff),                   \
   .extended_type = (TYPE) >> 8,                                                                   \
   .name = #NAME,                                                                                  \
   .address = (void *)(ADDRESS),                                                                   \
   .callback = (CALLBACK)},
#define PARAM_ADD(TYPE, NAME, ADDRESS)      PARAM_ADD_WITH_CALLBACK(TYPE, NAME, ADDRESS, 0)
#define PARAM_ADD_CORE(TYPE, NAME, ADDRESS) PARAM_ADD((TYPE) | PARAM_CORE, NAME, ADDRESS)

#define PARAM_GROUP_START(NAME)                                                                    \
  static const struct param_s param_group_##NAME[] = {PARAM_ADD(PARAM_GROUP | PARAM_START, NAME, 0)
#define PARAM_GROUP_STOP(NAME)                                                                     \
  PARAM_ADD(PARAM_GROUP | PARAM_STOP, stop_##NAME, 0)                                              \
  }                                                                                                \
  ;                                                                                                \
  static const struct param_s *const param_link_##NAME                                             \
      __attribute__((section("wayflie_param"), used)) = param_group_##NAME;

#endif
