"""Built kernels on disk, so that only the first scene of a kind waits for a compiler.

An entry is a file named by a hash of all that its binary depends on: sources, options (which hold the
scene's features), device and driver. A change of any of them is another name, so nothing goes stale.
The folder is bounded; entries that were not used for longest go first. ISOPHOTE_KERNEL_CACHE names
another folder, or is `off`.

pyopencl's cache (pyopencl.cache) is not used: it leaves PoCL and NVIDIA to their drivers, has no bound,
and a lock file that a killed process leaves behind stops everyone for a minute.
"""

from __future__ import annotations

import hashlib
import os
import time
from dataclasses import dataclass
from pathlib import Path

from isophote.files import replacing

VARIABLE = "ISOPHOTE_KERNEL_CACHE"
LIMIT = 128 << 20  # bytes of all entries; one is about half a megabyte on PoCL
MAGIC = b"isophote kernels 1\n"
SUFFIX = ".kernels"
ABANDONED = 3600.0  # seconds after which a temporary file's writer is taken for dead


class CacheError(RuntimeError):
    """An entry that is damaged, or a folder that cannot be written; the render goes on without it."""


def cache_key(*parts: str) -> str:
    """The name of an entry: SHA-256 of the parts, each with its length, so that none runs into the next."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode()
        digest.update(b"%d:" % len(data) + data)
    return digest.hexdigest()


def cache_folder() -> Path | None:
    """Where entries lie: the user's cache folder, or what ISOPHOTE_KERNEL_CACHE says; None where that is `off`."""
    named = os.environ.get(VARIABLE, "")
    if named.lower() in ("off", "0"):
        return None
    if named:
        return Path(named)
    try:
        import platformdirs  # comes with pyopencl, without which there is nothing to keep
    except ImportError:
        return None
    return platformdirs.user_cache_path("isophote", appauthor=False) / "kernels"


@dataclass(frozen=True)
class KernelCache:
    """Entries in a folder. Several processes may use it at once: entries appear whole or not at all."""

    folder: Path
    limit: int = LIMIT

    def path(self, key: str) -> Path:
        return self.folder / f"{key}{SUFFIX}"

    def why_not_writable(self) -> str:
        """What keeps entries from being stored, as far as that shows beforehand; "" for nothing."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            return f"{self.folder} cannot be made: {error.strerror}"
        return "" if os.access(self.folder, os.W_OK) else f"{self.folder} cannot be written"

    def load(self, key: str) -> bytes | None:
        """The binary of a key, None where there is none. Raises CacheError for a damaged entry, which is removed."""
        path = self.path(key)
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise CacheError(f"{path} cannot be read: {error.strerror}") from error
        digest, binary = data[len(MAGIC):len(MAGIC) + 32], data[len(MAGIC) + 32:]
        if not data.startswith(MAGIC) or hashlib.sha256(binary).digest() != digest:
            self.discard(key)
            raise CacheError(f"{path} was damaged")
        try:
            os.utime(path)  # used now: others go first
        except OSError:
            pass  # in a folder that only others may write, or already removed by them
        return binary

    def store(self, key: str, binary: bytes) -> None:
        """Keep a binary, and remove what was not used for longest where all are too many. Raises CacheError."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with replacing(self.path(key)) as temporary:
                temporary.write_bytes(MAGIC + hashlib.sha256(binary).digest() + binary)
            self.trim()
        except OSError as error:
            raise CacheError(f"{self.folder} cannot be written: {error.strerror or error}") from error

    def discard(self, key: str) -> None:
        """Remove an entry, where that is possible."""
        try:
            self.path(key).unlink(missing_ok=True)
        except OSError:
            pass

    def files(self, pattern: str) -> list[tuple[float, int, Path]]:
        """(time of last use, bytes, file) of each file, the oldest first; those that others remove are left out."""
        found = []
        for path in self.folder.glob(pattern):
            try:
                status = path.stat()
            except FileNotFoundError:
                continue
            found.append((status.st_mtime, status.st_size, path))
        return sorted(found)

    def entries(self) -> list[tuple[float, int, Path]]:
        return self.files(f"[!.]*{SUFFIX}")

    def trim(self) -> None:
        """Remove the oldest entries beyond the limit, and what killed writers left."""
        entries = self.entries()
        kept = sum(size for _, size, _ in entries)
        for _, size, path in entries:
            if kept <= self.limit:
                break
            path.unlink(missing_ok=True)
            kept -= size
        for written, _, path in self.files(f".*{SUFFIX}"):
            if time.time() - written > ABANDONED:
                path.unlink(missing_ok=True)


def open_cache() -> KernelCache | None:
    """The user's cache, None where it is turned off."""
    folder = cache_folder()
    return None if folder is None else KernelCache(folder)


def describe_cache() -> dict:
    """What `isophote devices` says: folder (None: off), entries, bytes and limit in bytes."""
    cache = open_cache()
    sizes = [size for _, size, _ in cache.entries()] if cache else []
    return {"folder": str(cache.folder) if cache else None, "entries": len(sizes), "bytes": sum(sizes), "limit": LIMIT}
