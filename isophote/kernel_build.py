"""From the kernels' source to a program that runs: out of the cache, or by the driver's compiler."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable

from isophote.kernel_cache import CacheError, KernelCache, cache_key

PROGRAM_BINARY_SIZES, PROGRAM_BINARIES = 0x1165, 0x1166  # of clGetProgramInfo


def build_key(device, source: str, options: list[str]) -> str:
    """What a program depends on, as the name of its entry in the cache."""
    platform = device.platform
    return cache_key(platform.vendor, platform.name, platform.version, device.vendor, device.name, device.version,
                     device.driver_version, " ".join(options), source)


class KernelBuild:
    """One program of one device. `from_cache` says where it came from, `problems` what was wrong with the cache.

    `cl` is the module pyopencl. Raises cl.Error where the source does not compile.
    """

    def __init__(self, cl, context, device, source: str, options: list[str], cache: KernelCache | None):
        self.cl, self.cache, self.problems = cl, cache, []
        self.key = build_key(device, source, options)
        self.program = self.load(context, device, options) if cache else None
        self.from_cache = self.kept = self.program is not None
        if not self.from_cache:
            if cache and (why := cache.why_not_writable()):
                self.problems.append(f"the kernels will not be kept for the next time: {why}")
            self.program = cl.Program(context, source)
            self.program.build(options=options, cache_dir=False)  # pyopencl's own cache stays out of it

    def load(self, context, device, options: list[str]):
        """The program of the cache's entry, None where there is none that works."""
        try:
            binary = self.cache.load(self.key)
            if binary is None:
                return None
            return self.cl.Program(context, [device], [binary]).build(options=options)
        except CacheError as error:
            self.problems.append(f"an entry of the kernel cache could not be used ({error})")
        except self.cl.Error as error:
            self.cache.discard(self.key)
            self.problems.append(f"the driver refused an entry of the kernel cache ({error})")
        self.problems[-1] += "; the kernels were compiled anew, nothing is lost"
        return None

    def keep(self, failed: Callable[[str], None]) -> None:
        """Put what was compiled into the cache, in a thread that nobody has to wait for; `failed` takes a message.

        To be called when the kernels have run: PoCL compiles them then, puts what it made into the
        binary, and while it makes the binary no kernel of the process starts (for 2 s).
        """
        if self.kept or not self.cache:
            return

        def work() -> None:
            try:
                self.cache.store(self.key, program_binary(self.cl, self.program))
            except (CacheError, self.cl.Error) as error:
                failed(f"the kernels were not kept for the next time: {error}")

        self.kept = True
        threading.Thread(target=work, name="isophote-kernel-cache").start()


def program_binary(cl, program) -> bytes:
    """The program's binary for its one device.

    Read through ctypes where that finds the function: PoCL compiles a general version of every kernel
    for it, for seconds, in which pyopencl would hold the interpreter's lock.
    """
    try:
        get_info = ctypes.CDLL(cl._cl.__file__).clGetProgramInfo
    except (AttributeError, OSError):
        return program.get_info(cl.program_info.BINARIES)[0]
    get_info.argtypes = [ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]
    size = ctypes.c_size_t()
    status = get_info(program.int_ptr, PROGRAM_BINARY_SIZES, ctypes.sizeof(size), ctypes.byref(size), None)
    binary = ctypes.create_string_buffer(size.value)
    place = ctypes.c_void_p(ctypes.addressof(binary))
    status = status or get_info(program.int_ptr, PROGRAM_BINARIES, ctypes.sizeof(place), ctypes.byref(place), None)
    if status:
        raise CacheError(f"the driver gives no binary of its kernels (error {status})")
    return binary.raw
