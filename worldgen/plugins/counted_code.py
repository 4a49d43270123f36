"""Count how often the statements of a loaded module's functions run.

The module's text is compiled again with a counter before each statement, and its functions get
that code for a while. So its top level runs only once, ordinary runs are as fast as before, and
neither a trace function nor a monitor is needed, which a debugger or coverage may already use.
"""

from __future__ import annotations

import ast
import contextlib
import gc
import importlib.util
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import TypeAlias

from worldgen.errors import InvalidParameter
from worldgen.plugins.registry import user_code
from worldgen.plugins.user_modules import digest_of_source, sources_read

# A name with two underscores at both ends is neither mangled in a class nor taken for its state.
_COUNTS = "__worldgen_counts__"
_RUNS = "__worldgen_runs__"

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class CodeFunction:
    """A function or method of a file.

    Args:
        name: Its name, without its class.
        first: Its first line, from 1; its decorators are not part of it.
        last: Its last line.
        body: The first line after its docstring.
        names: The names and attributes in it.
        fields: The attributes in it of other things than its first parameter, ``self``.
        unpacked: The names that its last parameter is unpacked into, as by ``left, side = memory``;
            empty if it isn't.
    """

    name: str
    first: int
    last: int
    body: int
    names: frozenset[str]
    fields: frozenset[str]
    unpacked: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class CountedCode:
    """A module that counts how often its statements run.

    Args:
        file: Its file.
        source: The lines of its file.
        counts: By line, how often the statement that begins there has run; index 0 is unused.
        statements: The lines of each statement, by its first line; of one that contains others,
            only those before them.
        reads: By the same line, what the statement reads: names, attributes without their object,
            subscripts such as ``['left']``, and for a number of its function's last parameter
            ``memory[3]``, whatever its name.
        functions: Its functions, in order.
        constants: By name, the line of a value outside its functions.
    """

    file: Path
    source: list[str]
    counts: list[int]
    statements: dict[int, range]
    reads: dict[int, frozenset[str]]
    functions: list[CodeFunction]
    constants: dict[str, int]


@contextlib.contextmanager
def counted_module(module: ModuleType) -> Iterator[CountedCode]:
    """Let the functions of a module count their statements for a while.

    Args:
        module: A module with a source file.

    Raises:
        InvalidParameter: If its source cannot be read, or has been edited since it was loaded.
    """
    # Read the file and insert the counters.
    file, data = _source_of(module)
    with user_code(f"{file}: reading it to count its lines"):
        source = importlib.util.decode_source(data).splitlines()
        tree = ast.parse(data, str(file))
        functions = [_described(node) for node in _functions(tree)]
        constants = _constants(tree)
        reads = _reads(tree)
        statements = _insert_counters(tree, _COUNTS)
        code = compile(tree, str(file), "exec", dont_inherit=True)

    # The counters stay in the module: a function that was made in the meantime may be called later.
    counts = [0] * (len(source) + 2)
    vars(module)[_COUNTS] = counts
    before: list[_Replaced] = []
    try:
        before = _with_code(module, code)
        yield CountedCode(file, source, counts, statements, reads, functions, constants)
    finally:
        _restore(before)


class LineWatch:
    """Notes which statements of a module's functions run, until it is stopped.

    Only statements that are not known to run get a counter, so a line that runs often costs nothing
    once it is known.

    Args:
        module: A module with a source file.
        known: First lines of statements that are known to run.

    Attributes:
        module: The module.
        file: Its file.
        known: See above.
        statements: The lines of each statement in a function, by its first line.
        functions: Its functions, in order.

    Raises:
        InvalidParameter: If its source cannot be read, or has been edited since it was loaded.
    """

    def __init__(self, module: ModuleType, known: Collection[int] = ()) -> None:
        self.module = module
        self.known = frozenset(known)
        self.file, data = _source_of(module)
        with user_code(f"{self.file}: reading it to see which lines run"):
            tree = ast.parse(data, str(self.file))
            self.functions = [_described(node) for node in _functions(tree)]
            self.statements = _insert_counters(tree, _RUNS, self.known)
            code = compile(tree, str(self.file), "exec", dont_inherit=True)
        self._counts = [0] * (len(data) + 2)
        vars(module)[_RUNS] = self._counts
        self._before = _with_code(module, code)

    def clear(self) -> None:
        """Forget what has run so far."""
        for line in self.statements:
            self._counts[line] = 0

    def ran(self) -> frozenset[int]:
        """Return the first lines of the statements that have run and were not known to."""
        return frozenset(line for line in self.statements if self._counts[line])

    def stop(self) -> None:
        """Give its functions their own code back."""
        _restore(self._before)
        self._before = []


def _source_of(module: ModuleType) -> tuple[Path, bytes]:
    """Return a module's file and its bytes.

    Raises:
        InvalidParameter: If it cannot be read, or has been edited since it was loaded.
    """
    file = Path(module.__file__ or "")
    try:
        data = file.read_bytes()
    except OSError:
        raise InvalidParameter("no-source", "{file} cannot be read", file=str(file)) from None
    if sources_read().get(str(file), digest_of_source(data)) != digest_of_source(data):
        raise InvalidParameter("edited", "{file} was edited after it was loaded", file=str(file))
    return file, data


_Replaced: TypeAlias = tuple[FunctionType, CodeType]


def _with_code(module: ModuleType, code: CodeType) -> list[_Replaced]:
    """Give a module's functions other code; return them with the code that they had."""
    counting = _codes_in(code)
    before = []
    for function in _functions_of(module):
        new = counting.get(_key_of(function.__code__))
        if new is not None and new.co_freevars == function.__code__.co_freevars:
            before.append((function, function.__code__))
            function.__code__ = new
    return before


def _restore(before: list[_Replaced]) -> None:
    for function, old in before:
        function.__code__ = old


def _functions_of(module: ModuleType) -> list[FunctionType]:
    """Return all functions of a module that exist, also those behind decorators and in closures."""
    names = vars(module)
    return [
        one for one in gc.get_objects() if type(one) is FunctionType and one.__globals__ is names
    ]


def _codes_in(code: CodeType) -> dict[tuple[str, int], CodeType]:
    """Return the code of all functions in a module's code."""
    found: dict[tuple[str, int], CodeType] = {}
    twice = set()
    rest = [code]
    while rest:
        for one in rest.pop().co_consts:
            if isinstance(one, CodeType):
                twice |= {_key_of(one)} & found.keys()
                found[_key_of(one)] = one
                rest.append(one)
    # Two lambdas in one line cannot be told apart, and contain no statements.
    return {key: one for key, one in found.items() if key not in twice}


def _key_of(code: CodeType) -> tuple[str, int]:
    return code.co_qualname, code.co_firstlineno


def _functions(tree: ast.AST) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
    found = [node for node in ast.walk(tree) if isinstance(node, _FUNCTIONS)]
    return sorted(found, key=lambda node: node.lineno)


def _described(node: ast.FunctionDef | ast.AsyncFunctionDef) -> CodeFunction:
    after = node.body[1:] if ast.get_docstring(node, clean=False) is not None else node.body
    names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
    attributes = [one for one in ast.walk(node) if isinstance(one, ast.Attribute)]
    names |= {one.attr for one in attributes}
    own = [one.arg for one in node.args.args[:1] if one.arg == "self"]
    fields = {
        one.attr
        for one in attributes
        if not (isinstance(one.value, ast.Name) and one.value.id in own)
    }
    last = node.end_lineno or node.lineno
    body = after[0].lineno if after else last
    return CodeFunction(
        node.name, node.lineno, last, body, frozenset(names), frozenset(fields), _unpacked(node)
    )


def _unpacked(function: ast.FunctionDef | ast.AsyncFunctionDef) -> tuple[str, ...]:
    parameters = [one.arg for one in function.args.args]
    for node in ast.walk(function):
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Name):
            target = node.targets[0]
            names = target.elts if isinstance(target, ast.Tuple | ast.List) else []
            if names and node.value.id in parameters[-1:]:
                return tuple(ast.unparse(one) for one in names)
    return ()


def _constants(tree: ast.Module) -> dict[str, int]:
    """Return the lines of the values that a module and its classes name."""
    found = {}
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    for block in (tree.body, *(one.body for one in classes)):
        for node in block:
            if isinstance(node, ast.Assign) or (isinstance(node, ast.AnnAssign) and node.value):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = [one.id for one in targets if isinstance(one, ast.Name)]
                found.update(dict.fromkeys(names, node.lineno))
    return found


def _reads(tree: ast.Module) -> dict[int, frozenset[str]]:
    """Return what each statement in a function reads, without the statements that it contains."""
    found: dict[int, frozenset[str]] = {}
    for function in _functions(tree):
        memory = [one.arg for one in function.args.args[-1:]]
        for block in _blocks(function):
            for node in block:
                read = found.get(node.lineno, frozenset())
                found[node.lineno] = read | frozenset(_read_by(node, memory))
    return found


def _read_by(statement: ast.stmt, memory: list[str]) -> Iterator[str]:
    rest: list[ast.AST] = [statement]
    while rest:
        node = rest.pop()
        rest += [
            one
            for one in ast.iter_child_nodes(node)
            if not isinstance(one, ast.stmt | ast.ExceptHandler | ast.match_case)
        ]
        if not isinstance(node, ast.Name | ast.Attribute | ast.Subscript):
            continue
        # What `+=` changes is read, too.
        if not isinstance(node.ctx, ast.Load) and not isinstance(statement, ast.AugAssign):
            continue
        if isinstance(node, ast.Name):
            yield node.id
        elif isinstance(node, ast.Attribute):
            yield node.attr
        else:
            place = f"[{ast.unparse(node.slice)}]"
            yield place
            if ast.unparse(node.value) in memory:
                yield f"memory{place}"


def _insert_counters(
    tree: ast.Module, counts: str, known: Collection[int] = ()
) -> dict[int, range]:
    """Insert a counter before each statement in a function, in place; return their lines.

    Args:
        tree: The module.
        counts: Name of the list of counters.
        known: First lines of statements that get no counter; their lines are returned, too.
    """
    statements: dict[int, range] = {}
    for function in _functions(tree):
        for block in _blocks(function):
            counted: list[ast.stmt] = []
            for node in block:
                # A docstring must stay the first statement. Of several statements on one line, the
                # first counts.
                is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
                if not is_text and node.lineno not in statements:
                    statements[node.lineno] = _own_lines(node)
                    if node.lineno not in known:
                        counted.append(_counter(node, counts))
                counted.append(node)
            block[:] = counted
    return statements


def _blocks(function: ast.AST) -> list[list[ast.stmt]]:
    """Return all lists of statements in a function, except those of functions within it."""
    found = []
    rest: list[ast.AST] = [function]
    while rest:
        node = rest.pop()
        for name in ("body", "orelse", "finalbody"):
            block = getattr(node, name, None)
            # The body of a lambda or of a conditional expression is no list.
            if isinstance(block, list) and block:
                found.append(block)
                rest += [one for one in block if not isinstance(one, _FUNCTIONS)]
        rest += getattr(node, "handlers", [])
        rest += getattr(node, "cases", [])
    return found


def _own_lines(node: ast.stmt) -> range:
    """Return the lines of a statement before the statements that it contains."""
    last = node.end_lineno or node.lineno
    if isinstance(node, ast.Match):
        last = max(node.cases[0].pattern.lineno - 1, node.lineno)
    elif body := getattr(node, "body", None):
        last = max(body[0].lineno - 1, node.lineno)
    return range(node.lineno, last + 1)


def _counter(node: ast.stmt, counts: str) -> ast.stmt:
    counter = ast.parse(f"{counts}[{node.lineno}] += 1").body[0]
    for part in ast.walk(counter):
        ast.copy_location(part, node)
    return counter
