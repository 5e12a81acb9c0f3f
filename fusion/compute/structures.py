"""Kernels that take structures: a few named tuples of arrays and numbers, `blocks.keys`, in place of many arguments.

A structure is a NamedTuple whose fields are annotated as a kernel's arguments are. A back end is given the same kernel
with one argument for each field, and a first statement that puts them together again while it reads the source: so
neither Taichi nor Quadrants has to know of structures (Taichi's own, argument packs, Quadrants has not), compiled code
is the same to the last instruction, and a call costs no more than taking the tuple apart. Each line keeps its number,
for messages.
"""

import ast
import inspect
import linecache
from collections.abc import Callable
from types import FunctionType
from typing import Any, get_type_hints


def structures(function: Callable[..., None]) -> dict[str, type]:
    """Of a kernel's arguments those that are structures: their classes by name."""
    found = inspect.signature(function).parameters
    return {name: p.annotation for name, p in found.items() if hasattr(p.annotation, "_fields")}


def flattened(function: Callable[..., None]) -> FunctionType:
    """The same function with an argument for each field of each structure.

    Raises:
        SyntaxError: it has no docstring, whose place the first statement takes.
    """
    assert isinstance(function, FunctionType)
    lines, first = inspect.getsourcelines(function)
    indent = len(lines[0]) - len(lines[0].lstrip())
    node = ast.parse("".join(line[indent:] if line.strip() else line for line in lines)).body[0]
    assert isinstance(node, ast.FunctionDef)
    text = node.body[0]
    if not (isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) and len(node.body) > 1):
        raise SyntaxError(f"kernel {function.__name__} takes structures and has no docstring")
    taken: list[str] = []
    put: list[str] = []
    annotations: dict[str, Any] = {}
    for name, parameter in inspect.signature(function).parameters.items():
        fields = {name: parameter.annotation}
        if name in structures(function):
            kinds = get_type_hints(parameter.annotation)
            fields = {f"{name}_{field}_": kinds[field] for field in parameter.annotation._fields}
            kind = parameter.annotation.__name__
            put.append(f"{name} = ti.static({kind}({', '.join(fields)}))")
            function.__globals__.setdefault(kind, parameter.annotation)
        taken += fields
        annotations |= fields
    start, stop = node.lineno - 1, text.end_lineno
    assert stop is not None
    made = [f"def {function.__name__}({', '.join(taken)}):\n", *["\n"] * (stop - start)]
    made[text.lineno - 1 - start] = f"{' ' * node.body[1].col_offset}{'; '.join(put)}\n"
    whole = ["\n"] * (first - 1 + start) + made[: stop - start] + [line[indent:] or "\n" for line in lines[stop:]]
    file = f"{function.__code__.co_filename}:{function.__name__}"
    linecache.cache[file] = (sum(map(len, whole)), None, whole, file)
    scope: dict[str, Any] = {}
    exec(compile("".join(whole), file, "exec"), scope)
    flat = FunctionType(scope[function.__name__].__code__, function.__globals__, function.__name__)
    flat.__annotations__ = annotations
    return flat


def apart(args: tuple[Any, ...]) -> tuple[Any, ...]:
    """Arguments with the fields of structures in their places."""
    found: list[Any] = []
    for value in args:
        if isinstance(value, tuple):
            found += value
        else:
            found.append(value)
    return tuple(found)
