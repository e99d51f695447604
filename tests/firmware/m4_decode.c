// SPDX-License-Identifier: GPL-3.0-or-later
#include "m4_decode.h"

enum {
  SP = 13,
  PC = 15,
  DIVIDE_CYCLES = 7,
  TABLE_BRANCH_CYCLES = 3,
  FLOAT_MULTIPLY_ADD_CYCLES = 3,
  FLOAT_DIVIDE_CYCLES = 14,
};

static const m4_instruction_t ONE_CYCLE = {.cycles = 1};

static uint16_t core(unsigned number) {
  return (uint16_t)(1u << (number & 15u));
}

static uint8_t one_more_than(unsigned registers) {
  return (uint8_t)(1 + __builtin_popcount(registers));
}

static m4_instruction_t arithmetic(unsigned result) {
  return (m4_instruction_t){.cycles = 1, .result = core(result)};
}

static m4_instruction_t load(uint16_t address, unsigned loaded) {
  return (m4_instruction_t){.cycles = 2,
                            .single_load = true,
                            .may_overlap = true,
                            .address = address,
                            .loaded = core(loaded)};
}

/** With a register offset the store takes longer, but may overlap with a load before it. */
static m4_instruction_t store(uint16_t address, bool by_register) {
  return (m4_instruction_t){
      .cycles = by_register ? 2 : 1, .may_overlap = by_register, .address = address};
}

static m4_instruction_t many(unsigned registers, unsigned base) {
  return (m4_instruction_t){.cycles = one_more_than(registers), .address = core(base)};
}

/** 010000 to 01001: arithmetic on low registers, on high ones, branches, literals. */
static m4_instruction_t decode_group4(unsigned h) {
  if (h >= 0x4800u) {
    return load(0, h >> 8 & 7u);
  }
  if (h >= 0x4700u) { // BX, BLX
    return ONE_CYCLE;
  }
  if (h >= 0x4400u) {
    bool compare = (h & 0xFF00u) == 0x4500u;
    return compare ? ONE_CYCLE : arithmetic((h & 7u) | (h >> 4 & 8u));
  }
  unsigned operation = h >> 6 & 15u;
  bool compare = operation == 8u || operation == 10u || operation == 11u;
  return compare ? ONE_CYCLE : arithmetic(h & 7u);
}

/** 1011: stack pointer, extensions, PUSH, POP, CBZ, hints. */
static m4_instruction_t decode_group11(unsigned h) {
  if ((h & 0xF600u) == 0xB400u) {
    return many(h & 0x1FFu, SP);
  }
  if ((h & 0xFF00u) == 0xB000u) {
    return arithmetic(SP);
  }
  if ((h & 0xFF00u) == 0xB200u || (h & 0xFF00u) == 0xBA00u) {
    return arithmetic(h & 7u);
  }
  bool change_state = (h & 0xFF00u) == 0xB600u;
  return change_state ? (m4_instruction_t){.cycles = 2} : ONE_CYCLE;
}

static m4_instruction_t decode16(unsigned h) {
  unsigned low = h & 7u;
  unsigned middle = h >> 3 & 7u;
  unsigned high = h >> 8 & 7u;
  uint16_t pair = core(middle) | core(h >> 6 & 7u);
  switch (h >> 12) {
  case 0:
  case 1:
    return arithmetic(low);
  case 2:
  case 3:
    return h >> 11 == 5u ? ONE_CYCLE : arithmetic(high); // 5: CMP
  case 4:
    return decode_group4(h);
  case 5:
    return (h >> 9 & 7u) < 3u ? store(pair, true) : load(pair, low);
  case 6:
  case 7:
  case 8:
    return (h & 0x800u) != 0u ? load(core(middle), low) : store(core(middle), false);
  case 9:
    return (h & 0x800u) != 0u ? load(core(SP), high) : store(core(SP), false);
  case 10:
    return arithmetic(high);
  case 11:
    return decode_group11(h);
  case 12:
    return many(h & 0xFFu, high);
  default:
    return ONE_CYCLE;
  }
}

/** Loads and stores of the floating-point unit, and its moves of two core registers. */
static m4_instruction_t decode_float_memory(unsigned a, unsigned b, unsigned d, unsigned m) {
  if ((a & 0xFFE0u) == 0xEC40u) {
    return (m4_instruction_t){.cycles = 2, .float_read = 3u << m};
  }
  bool is_double = (b >> 8 & 15u) == 11u;
  bool single = (a & 0xFF20u) == 0xED00u;
  unsigned words = single ? 1u + is_double : b & 0xFFu;
  unsigned first = is_double ? (b >> 12 & 15u) << 1 : d;
  m4_instruction_t found = {.cycles = (uint8_t)(1u + words), .address = core(a & 15u)};
  if ((a & 0x10u) == 0u) {
    found.float_read = (words >= 32u ? ~0u : (1u << words) - 1u) << first;
  }
  return found;
}

static m4_instruction_t decode_float_move(unsigned a, unsigned n) {
  m4_instruction_t found = ONE_CYCLE;
  if ((a & 0xFFF0u) == 0xEEF0u) { // VMRS
    found.fetches_flags = true;
  } else if ((a & 0xFFF0u) != 0xEEE0u && (a & 0x10u) != 0u) { // from S to core
    found.float_read = 1u << n;
  }
  return found;
}

/** VMOV, VABS, VNEG, VSQRT, VCMP, VCVT. */
static m4_instruction_t decode_float_unary(unsigned a, unsigned b, unsigned d, unsigned m) {
  m4_instruction_t found = {.cycles = 1, .float_read = 1u << m, .float_written = 1u << d};
  if ((b & 0x40u) == 0u) { // VMOV of a constant
    return ONE_CYCLE;
  }
  if ((a & 15u) == 1u && (b & 0xC0u) == 0xC0u) { // VSQRT
    found.cycles = FLOAT_DIVIDE_CYCLES;
  }
  if ((a & 14u) == 4u) { // VCMP; of register or zero
    found.float_written = 0u;
    found.compares = true;
    found.float_read = 1u << d | ((a & 1u) != 0u ? 0u : 1u << m);
  }
  return found;
}

static m4_instruction_t decode_float(unsigned a, unsigned b) {
  unsigned d = (b >> 12 & 15u) << 1 | (a >> 6 & 1u);
  unsigned n = (a & 15u) << 1 | (b >> 7 & 1u);
  unsigned m = (b & 15u) << 1 | (b >> 5 & 1u);
  if ((a & 0xFE00u) == 0xEC00u) {
    return decode_float_memory(a, b, d, m);
  }
  if ((b & 0x10u) != 0u) {
    return decode_float_move(a, n);
  }
  m4_instruction_t found = {.cycles = 1, .float_read = 1u << n | 1u << m, .float_written = 1u << d};
  switch (a >> 4 & 11u) {
  case 0:
  case 1:
  case 9:
  case 10:
    found.cycles = FLOAT_MULTIPLY_ADD_CYCLES;
    found.float_read |= 1u << d;
    return found;
  case 8:
    found.cycles = FLOAT_DIVIDE_CYCLES;
    return found;
  case 11:
    return decode_float_unary(a, b, d, m);
  default:
    return found;
  }
}

/** 1110100: LDM, STM, LDRD, STRD, LDREX, STREX, TBB, TBH. */
static m4_instruction_t decode_many(unsigned a, unsigned b) {
  if ((a & 0x40u) == 0u) {
    return many(b, a & 15u);
  }
  if ((a & 0xFFF0u) == 0xE8D0u && (b & 0xFFE0u) == 0xF000u) {
    return (m4_instruction_t){.cycles = TABLE_BRANCH_CYCLES,
                              .address = core(a & 15u) | core(b & 15u)};
  }
  bool exclusive = (a & 0x120u) == 0u;
  return (m4_instruction_t){.cycles = exclusive ? 2 : 3, .address = core(a & 15u)};
}

static m4_instruction_t decode_single(unsigned a, unsigned b) {
  unsigned base = a & 15u;
  bool by_register = (a & 0x80u) == 0u && (b & 0x800u) == 0u && base != PC;
  uint16_t address = core(base) | (by_register ? core(b) : 0);
  return (a & 0x10u) != 0u ? load(address, b >> 12) : store(address, by_register);
}

static m4_instruction_t decode32(unsigned a, unsigned b) {
  unsigned result = b >> 8 & 15u;
  if ((a & 0xEC00u) == 0xEC00u) {
    return (b & 0xE00u) == 0xA00u ? decode_float(a, b) : ONE_CYCLE;
  }
  if ((a & 0xFE00u) == 0xE800u) {
    return decode_many(a, b);
  }
  if ((a & 0xF800u) == 0xF000u) { // branches and the like have bit 15
    return (b & 0x8000u) != 0u ? ONE_CYCLE : arithmetic(result);
  }
  if ((a & 0xFE00u) == 0xF800u) {
    return decode_single(a, b);
  }
  m4_instruction_t found = arithmetic(result);
  if ((a & 0xFFD0u) == 0xFB90u) {
    found.cycles = DIVIDE_CYCLES;
  } else if ((a & 0xFF80u) == 0xFB80u) { // long multiplication: two results
    found.result |= core(b >> 12);
  }
  return found;
}

int m4_length(uint16_t first) {
  return first >= 0xE800u ? 4 : 2;
}

bool m4_is_it(uint16_t first) {
  return (first & 0xFF00u) == 0xBF00u && (first & 0xFu) != 0u;
}

m4_instruction_t m4_decode(uint16_t first, uint16_t second) {
  return m4_length(first) == 4 ? decode32(first, second) : decode16(first);
}

int m4_pair_cycles(const m4_instruction_t *before, const m4_instruction_t *after) {
  int cycles = after->cycles;
  if (before->single_load && after->may_overlap && (before->loaded & after->address) == 0) {
    cycles--;
  }
  if ((after->address & before->result & (uint16_t)~core(PC)) != 0) {
    cycles++;
  }
  if ((after->float_read & before->float_written) != 0u ||
      (after->fetches_flags && before->compares)) {
    cycles++;
  }
  return cycles;
}
