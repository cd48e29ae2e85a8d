"""libtypodont.so and its structs. The declarations are read from the installed C headers."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, TypeVar

import cffi
import numpy as np

_HERE = Path(__file__).resolve().parent
_HEADERS = ("typodont.h", "typodont_sound.h", "typodont_calibration.h")


class Error(Exception):
    """A call failed. The text gives the reason."""


class BadInput(Error, ValueError):
    """An argument, a file or a pose is not valid."""


class Closed(Error):
    """The object is closed, or another thread is using it."""


def _declarations(folder: Path) -> str:
    """Returns the headers' declarations for cffi, without directives and markers."""
    text = ""
    for name in _HEADERS:
        header = (folder / name).read_text()
        header = re.sub(r"/\*.*?\*/", "", header, flags=re.S)
        header = re.sub(r'#ifdef __cplusplus.*?#endif', "", header, flags=re.S)
        text += re.sub(r"^#.*$", "", header, flags=re.M)
    return re.sub(r"\bTYPODONT_(API|REALTIME)\b", "", text)


def _open() -> tuple[Any, Any]:
    """Opens the library: from the installation $TYPODONT_PREFIX, else from this package, else from the system."""
    prefix = os.environ.get("TYPODONT_PREFIX")
    if prefix:
        found = sorted(Path(prefix).glob("lib*/**/libtypodont.so.0"))
        if not found:
            raise ImportError(f"{prefix}: no libtypodont.so.0 below it, which TYPODONT_PREFIX says")
        library, headers = str(found[0]), Path(prefix) / "include"
    elif (_HERE / "native" / "lib" / "libtypodont.so.0").exists():
        library, headers = str(_HERE / "native" / "lib" / "libtypodont.so.0"), _HERE / "native" / "include"
    else:
        library, headers = "libtypodont.so.0", Path("/usr/include")
    ffi = cffi.FFI()
    ffi.cdef(_declarations(headers))
    return ffi, ffi.dlopen(library)


ffi, lib = _open()
VERSION: str = ffi.string(lib.typodont_version()).decode()

_EXCEPTIONS = {
    lib.TYPODONT_BAD_INPUT: BadInput,
    lib.TYPODONT_BAD_HANDLE: Closed,
    lib.TYPODONT_BUSY: Closed,
    lib.TYPODONT_NO_MEMORY: MemoryError,
}


def text(pointer: Any) -> str:
    return str(ffi.string(pointer).decode(errors="replace")) if pointer else ""


def check(result: int) -> int:
    """Raises the exception for a failed result. Returns TYPODONT_OK or TYPODONT_END."""
    if result in (lib.TYPODONT_OK, lib.TYPODONT_END):
        return result
    why = "it was closed" if result == lib.TYPODONT_BAD_HANDLE else text(lib.typodont_error())
    raise _EXCEPTIONS.get(result, Error)(why)


def bytes_of(value: str | os.PathLike[str] | None) -> Any:
    return ffi.NULL if value is None else os.fsencode(value)


def struct(name: str, **values: Any) -> Any:
    """Returns a pointer to a new struct with struct_size set."""
    pointer = ffi.new(f"typodont_{name} *", values)
    pointer.struct_size = ffi.sizeof(pointer[0])
    return pointer


def _dtype(ctype: Any) -> Any:
    if ctype.kind == "array":
        return np.dtype((_dtype(ctype.item), (ctype.length,)))
    if ctype.kind == "struct":
        fields = [(name, field) for name, field in ctype.fields if name != "reserved"]
        return np.dtype(
            {
                "names": [name for name, _ in fields],
                "formats": [_dtype(field.type) for _, field in fields],
                "offsets": [field.offset for _, field in fields],
                "itemsize": ffi.sizeof(ctype),
            }
        )
    return np.dtype(ctype.cname.removesuffix("_t").replace("double", "float64").replace("float64", "f8")
                    if ctype.cname != "float" else "f4")


def dtype(name: str) -> Any:
    """Returns the NumPy type of a struct of the C interface. The bytes are the same, so that arrays need no copies."""
    return _dtype(ffi.typeof(f"typodont_{name}"))


_H = TypeVar("_H", bound="Handle")


class Handle:
    """An object of the library. The end of `with`, or of its last reference, closes it."""

    _kind = ""

    def __init__(self, handle: Any) -> None:
        self._handle = handle

    def close(self) -> None:
        """Frees the object now. Any later use raises Closed."""
        handle, self._handle = getattr(self, "_handle", ffi.NULL), ffi.NULL
        if handle != ffi.NULL:
            check(getattr(lib, f"typodont_{self._kind}_free")(handle))

    def __enter__(self: _H) -> _H:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __del__(self) -> None:
        try:
            self.close()
        except Exception:  # the constructor failed, or the interpreter is ending
            pass


def made(kind: str, call: Any, *arguments: Any) -> Any:
    """Calls a function whose last argument receives a new handle. Returns the handle."""
    place = ffi.new(f"typodont_{kind} **")
    check(call(*arguments, place))
    return place[0]
