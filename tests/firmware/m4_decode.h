// SPDX-License-Identifier: GPL-3.0-or-later
/** @file m4_decode.h  What one Thumb-2 instruction costs on a Cortex-M4F, and on what it waits.
 *
 *  Sources: ARM DDI 0439 (Cortex-M4 TRM), tables 3-1 and 7-1, and its "Load/store timings".
 *
 *  | class                                        | cycles                             |
 *  |----------------------------------------------|------------------------------------|
 *  | arithmetic, multiply, multiply-add           | 1                                  |
 *  | LDR                                          | 2                                  |
 *  | STR with immediate / register offset         | 1 / 2                              |
 *  | LDRD, STRD                                   | 3                                  |
 *  | LDM, STM, PUSH, POP of N                     | 1 + N                              |
 *  | SDIV, UDIV                                   | 7 (the TRM: 2 to 12)               |
 *  | branch                                       | 1, and the refill when it is taken |
 *  | TBB, TBH                                     | 3, and the refill                  |
 *  | IT, and an instruction skipped by IT         | 1                                  |
 *  | VADD, VSUB, VMUL, VCMP, VCVT, VMOV           | 1                                  |
 *  | VMLA, VMLS, VFMA, VFMS                       | 3                                  |
 *  | VDIV, VSQRT                                  | 14                                 |
 *  | VLDR, VSTR                                   | 2                                  |
 *  | VLDM, VSTM, VPUSH, VPOP of N                 | 1 + N                              |
 */
#ifndef M4_DECODE_H
#define M4_DECODE_H

#include <stdbool.h>
#include <stdint.h>

/** Registers are sets of bits: bit n is r<n> or s<n>. */
typedef struct {
  uint8_t cycles;         ///< alone
  bool single_load;       ///< the memory access after it may overlap with it
  bool may_overlap;       ///< with a single load before it
  uint16_t address;       ///< core registers that make its address
  uint16_t result;        ///< core registers that arithmetic writes
  uint16_t loaded;        ///< core registers that a single load writes
  uint32_t float_read;    ///< S registers
  uint32_t float_written; ///< S registers that arithmetic writes
  bool compares;          ///< writes the floating-point flags
  bool fetches_flags;     ///< reads them
} m4_instruction_t;

/** Bytes of the instruction that begins with this half word. */
int m4_length(uint16_t first);
/** IT: the one to four instructions after it are conditional. */
bool m4_is_it(uint16_t first);
/** @param second of a 4-byte instruction, else not looked at */
m4_instruction_t m4_decode(uint16_t first, uint16_t second);
/** Cycles of `after` when it directly follows `before`: what the pipeline saves or loses. */
int m4_pair_cycles(const m4_instruction_t *before, const m4_instruction_t *after);

#endif
