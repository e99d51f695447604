# SPDX-License-Identifier: GPL-3.0-or-later
"""An emulated STM32F405: Unicorn, with the exact memory map and the cycle model in its hooks.

Any access outside of the firmware's flash, SRAM, CCM and the system control block raises.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI
from elftools.elf.elffile import ELFFile
from numpy.typing import NDArray
from unicorn import (
    UC_ARCH_ARM,
    UC_HOOK_BLOCK,
    UC_HOOK_INTR,
    UC_HOOK_MEM_READ,
    UC_HOOK_MEM_WRITE,
    UC_MODE_MCLASS,
    UC_MODE_THUMB,
    UC_PROT_ALL,
    UC_PROT_EXEC,
    UC_PROT_READ,
    Uc,
    UcError,
)
from unicorn import arm_const as arm
from unicorn.unicorn_py3.unicorn import uclib

from tests.firmware.build import build_model

CLOCK_HZ = 168_000_000
FLASH, FLASH_BYTES, BOOT_LOADER_BYTES = 0x0800_0000, 1 << 20, 16 << 10
SRAM, SRAM_BYTES = 0x2000_0000, 128 << 10
CCM, CCM_BYTES = 0x1000_0000, 64 << 10
SYSTEM, SYSTEM_BYTES = 0xE000_E000, 4096
PAGE = 4096
BREAK_POINT, CALL_READ, CALL_WRITE, CALL_EXIT = 7, 1, 2, 3

_DECLARATIONS = """
typedef struct { void *read; void *write; int cpsr; int sp; int lr; } m4_registers_t;
typedef struct m4_hooks m4_hooks_t;
m4_hooks_t *m4_hooks_new(const uint8_t *, m4_registers_t, uint32_t, uint32_t);
void m4_hooks_free(m4_hooks_t *);
int m4_hooks_watch(m4_hooks_t *, uint32_t, bool);
void m4_hooks_on_block(void *, uint64_t, uint32_t, void *);
void m4_hooks_on_access(void *, int, uint64_t, int, int64_t, void *);
uint64_t m4_hooks_cycles(const m4_hooks_t *);
uint64_t m4_hooks_instructions(const m4_hooks_t *);
uint32_t m4_hooks_depth(const m4_hooks_t *, int);
size_t m4_hooks_rows(const m4_hooks_t *, const uint32_t **);
"""
_WATCHED = 24  # M4_WATCHED


class ChipError(Exception):
    """The program did something that the chip cannot do."""


@dataclass(frozen=True)
class Run:
    """What a program did: its output, and what the watched functions cost.

    cycles has a column for each of them, with all that it calls, and a row for each return of the
    first; elapsed is from row to row.
    """

    output: bytes
    cycles: dict[str, NDArray[np.uint32]]
    elapsed: NDArray[np.uint32]
    stack_bytes: dict[str, int]
    all_cycles: int
    instructions: int


@cache
def _model() -> tuple[FFI, Any]:
    ffi = FFI()
    ffi.cdef(_DECLARATIONS)
    return ffi, ffi.dlopen(str(build_model()))


def _registers(ffi: FFI) -> dict[str, Any]:
    functions = {"read": uclib.uc_reg_read, "write": uclib.uc_reg_write}
    numbers = {"cpsr": arm.UC_ARM_REG_CPSR, "sp": arm.UC_ARM_REG_SP, "lr": arm.UC_ARM_REG_LR}
    addresses = {
        name: ffi.cast("void *", ctypes.cast(function, ctypes.c_void_p).value)
        for name, function in functions.items()
    }
    return addresses | numbers


class Chip:
    """A chip with one program in its flash."""

    def __init__(self, program: Path) -> None:
        self._uc: Any = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self._uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        self._flash = ctypes.create_string_buffer(FLASH_BYTES + PAGE)
        self._base = (ctypes.addressof(self._flash) + PAGE - 1) & ~(PAGE - 1)
        self._map_memory()
        self.symbols = self._load(program)
        self._input = memoryview(b"")
        self._output = bytearray()

    def run(self, data: bytes, watch: Sequence[str] = ()) -> Run:
        """Run from reset to the program's end, with this input."""
        ffi, lib = _model()
        self._input, self._output = memoryview(data), bytearray()
        low, top = self.symbols["chip_stack_low"], self.symbols["chip_stack_top"]
        hooks = lib.m4_hooks_new(ffi.cast("uint8_t *", self._base), _registers(ffi), low, top)
        handles = self._add_hooks(ffi, lib, hooks)
        try:
            for i, name in enumerate(watch):
                assert lib.m4_hooks_watch(hooks, self.symbols[name] & ~1, i == 0) == i
            self._emulate()
            return self._results(ffi, lib, hooks, watch)
        finally:
            for handle in handles:
                uclib.uc_hook_del(self._uc._uch, handle)
            lib.m4_hooks_free(hooks)

    def _map_memory(self) -> None:
        """Map flash to our memory, which the cycle model reads too; the boot loader is absent."""
        uc, skip = self._uc, BOOT_LOADER_BYTES
        permission = UC_PROT_READ | UC_PROT_EXEC
        uc.mem_map_ptr(FLASH + skip, FLASH_BYTES - skip, permission, self._base + skip)
        uc.mem_map(SRAM, SRAM_BYTES, UC_PROT_ALL)
        uc.mem_map(CCM, CCM_BYTES, UC_PROT_ALL)
        uc.mem_map(SYSTEM, SYSTEM_BYTES, UC_PROT_ALL)
        uc.hook_add(UC_HOOK_INTR, self._on_interrupt)

    def _load(self, program: Path) -> dict[str, int]:
        with program.open("rb") as file:
            elf = ELFFile(file)
            for segment in elf.iter_segments("PT_LOAD"):
                if segment["p_filesz"]:
                    at = self._base + segment["p_paddr"] - FLASH
                    ctypes.memmove(at, segment.data(), segment["p_filesz"])
            table: Any = elf.get_section_by_name(".symtab")
            return {symbol.name: symbol["st_value"] for symbol in table.iter_symbols()}

    def _add_hooks(self, ffi: FFI, lib: Any, hooks: Any) -> list[Any]:  # noqa: ANN401
        """Add C functions as hooks, which Unicorn's Python interface does not support."""
        added = []
        for kind, function in (
            (UC_HOOK_BLOCK, lib.m4_hooks_on_block),
            (UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE, lib.m4_hooks_on_access),
        ):
            handle = ctypes.c_size_t()
            error = uclib.uc_hook_add(
                self._uc._uch,
                ctypes.byref(handle),
                kind,
                ctypes.c_void_p(int(ffi.cast("uintptr_t", function))),
                ctypes.c_void_p(int(ffi.cast("uintptr_t", hooks))),
                ctypes.c_uint64(1),
                ctypes.c_uint64(0),
            )
            assert error == 0, error
            added.append(handle)
        return added

    def _emulate(self) -> None:
        start = FLASH + BOOT_LOADER_BYTES
        stack, reset = (
            int.from_bytes(self._uc.mem_read(start + 4 * word, 4), "little") for word in (0, 1)
        )
        self._uc.reg_write(arm.UC_ARM_REG_SP, stack)
        try:
            self._uc.emu_start(reset | 1, 0)
        except UcError as error:
            pc, sp = (self._uc.reg_read(r) for r in (arm.UC_ARM_REG_PC, arm.UC_ARM_REG_SP))
            raise ChipError(f"{error} in {self.function_at(pc)}, sp {sp:#x}") from error

    def function_at(self, address: int) -> str:
        """Name of the symbol that contains an address, for messages."""
        before = [(value, name) for name, value in self.symbols.items() if value <= address | 1]
        return f"{max(before)[1]} ({address:#x})"

    def _on_interrupt(self, uc: Any, number: int, _: object) -> None:  # noqa: ANN401
        if number != BREAK_POINT:
            raise ChipError(f"exception {number}")
        what, address, size = (
            uc.reg_read(r) for r in (arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2)
        )
        if what == CALL_READ:
            taken, self._input = self._input[:size], self._input[size:]
            uc.mem_write(address, bytes(taken))
            uc.reg_write(arm.UC_ARM_REG_R0, len(taken))
        elif what == CALL_WRITE:
            self._output += uc.mem_read(address, size)
        elif what == CALL_EXIT:
            uc.emu_stop()
        uc.reg_write(arm.UC_ARM_REG_PC, (uc.reg_read(arm.UC_ARM_REG_PC) + 2) | 1)

    def _results(self, ffi: FFI, lib: Any, hooks: Any, watch: Sequence[str]) -> Run:  # noqa: ANN401
        rows = ffi.new("const uint32_t **")
        count = lib.m4_hooks_rows(hooks, rows)
        table = np.zeros((0, _WATCHED + 1), np.uint32)
        if count:
            flat = np.frombuffer(ffi.buffer(rows[0], 4 * count * (_WATCHED + 1)), np.uint32)
            table = flat.reshape(count, _WATCHED + 1).copy()
        return Run(
            output=bytes(self._output),
            cycles={name: table[:, i] for i, name in enumerate(watch)},
            elapsed=table[:, _WATCHED],
            stack_bytes={name: lib.m4_hooks_depth(hooks, i) for i, name in enumerate(watch)},
            all_cycles=lib.m4_hooks_cycles(hooks),
            instructions=lib.m4_hooks_instructions(hooks),
        )
