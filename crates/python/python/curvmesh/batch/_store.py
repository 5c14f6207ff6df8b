"""Storage of files: folders of this machine, or any file system of fsspec."""

from __future__ import annotations

import hashlib
import os
import shutil
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from .._errors import OptionError, ReadError, WriteError

#: The suffix of unfinished files, before a unique number.
PART = ".part-"

#: Stores in which a file appears only when it is complete; elsewhere files are moved into place.
_WHOLE = {"s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "adl", "oss", "memory"}


@dataclass(frozen=True)
class Found:
    """A file: its size in bytes, and a value that changes with its content."""

    bytes: int
    changed: str


def is_url(path: str) -> bool:
    """Whether a path needs fsspec."""
    return "://" in path


def file_system(url: str) -> tuple[Any, str]:
    """The file system of a URL, and the path in it.

    Raises
    ------
    OptionError
        fsspec, or what it needs for this kind of URL, is not installed.
    """
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        raise OptionError(f"{url}: URLs need fsspec", cure="pip install fsspec") from None
    try:
        fs, path = url_to_fs(url)
    except (ImportError, ValueError) as error:
        raise OptionError(f"{url}: {error}") from None
    return fs, path


def found(info: dict[str, Any]) -> Found:
    """The description of a file by a file system."""
    changed = next((info[k] for k in ("ETag", "etag", "mtime", "LastModified", "created") if k in info), "")
    return Found(int(info.get("size") or 0), str(changed))


def look(path: str) -> Found | None:
    """The file at a path or URL, if it exists."""
    if is_url(path):
        fs, inside = file_system(path)
        try:
            info = fs.info(inside)
        except OSError:
            return None
        return found(info) if info.get("type") == "file" else None
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    return Found(status.st_size, str(status.st_mtime_ns))


def fetch(path: str, folder: str) -> str:
    """A local file with the content of a path or URL.

    Raises
    ------
    ReadError
        It is not accessible.
    """
    if not is_url(path):
        return path
    fs, inside = file_system(path)
    target = os.path.join(folder, os.path.basename(inside) or "input")
    try:
        fs.get_file(inside, target)
    except Exception as error:
        raise ReadError(f"{path}: {type(error).__name__}: {error}", path=path) from error
    return target


def digest(path: str) -> str:
    """SHA-256 of a local file."""
    total = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            total.update(block)
    return total.hexdigest()


class Store:
    """A folder for results, local or at a URL. Files appear in it whole or not at all."""

    def __init__(self, root: str) -> None:
        self.root = root.rstrip("/") or "/"
        self._fs: Any = None
        self._inside = self.root
        if is_url(root):
            self._fs, self._inside = file_system(self.root)

    def path(self, name: str) -> str:
        """The path or URL of a file."""
        return f"{self.root}/{name}"

    def _in(self, name: str) -> str:
        return f"{self._inside}/{name}"

    def put(self, source: str, name: str) -> None:
        """Copies a local file.

        Raises
        ------
        WriteError
            There is no space or no permission.
        """
        target = self._in(name)
        part = f"{target}{PART}{uuid.uuid4().hex}"
        try:
            if self._fs is None:
                os.makedirs(os.path.dirname(target), exist_ok=True)
                try:
                    shutil.copyfile(source, part)
                    os.replace(part, target)
                except BaseException:
                    _forget(part)
                    raise
            else:
                self._fs.makedirs(os.path.dirname(target), exist_ok=True)
                names = self._fs.protocol
                if _WHOLE.isdisjoint([names] if isinstance(names, str) else names):
                    self._fs.put_file(source, part)
                    self._fs.mv(part, target)
                else:
                    self._fs.put_file(source, target)
        except Exception as error:
            raise WriteError(f"{self.path(name)}: {error}", path=self.path(name)) from error

    def put_text(self, text: str, name: str, folder: str) -> None:
        """Writes text, via a local temporary file."""
        path = os.path.join(folder, f"{uuid.uuid4().hex}.text")
        with open(path, "wb") as file:
            file.write(text.encode("utf-8", "replace"))
        self.put(path, name)
        os.unlink(path)

    def text(self, name: str) -> str | None:
        """The content of a file, if it exists."""
        content = self.content(name)
        return None if content is None else content.decode("utf-8", "replace")

    def content(self, name: str) -> bytes | None:
        """The bytes of a file, if it exists."""
        try:
            if self._fs is None:
                with open(self._in(name), "rb") as file:
                    return file.read()
            read: bytes = self._fs.cat_file(self._in(name))
            return read
        except OSError:
            return None

    def bytes(self, name: str) -> int | None:
        """The size of a file, if it exists."""
        here = look(self.path(name))
        return None if here is None else here.bytes

    def remove(self, name: str) -> None:
        """Removes a file, if it exists."""
        if self._fs is None:
            _forget(self._in(name))
        else:
            try:
                self._fs.rm_file(self._in(name))
            except OSError:
                pass

    def files(self) -> Iterator[tuple[str, int]]:
        """All files below, with their sizes."""
        if self._fs is None:
            for folder, _, names in os.walk(self.root):
                for name in names:
                    path = os.path.join(folder, name)
                    here = look(path)
                    if here is not None:
                        yield os.path.relpath(path, self.root).replace(os.sep, "/"), here.bytes
            return
        try:
            inside = self._fs.find(self._inside, detail=True)
        except OSError:
            return
        start = len(self._inside.rstrip("/")) + 1
        for path, info in inside.items():
            yield path[start:], found(info).bytes


def _forget(path: str) -> None:
    try:
        os.unlink(path)
    except OSError:
        pass
