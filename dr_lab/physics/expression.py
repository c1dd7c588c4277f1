"""Expressions that a user writes: parsed, checked, and evaluated on arrays."""

import ast
import keyword
import re
from collections.abc import Callable, Mapping
from types import CodeType

import numpy as np

from dr_lab.errors import ConfigError
from dr_lab.trajectory import Array

FUNCTIONS: Mapping[str, Callable[..., Array]] = {
    name: getattr(np, name)
    for name in ("abs", "sign", "sin", "cos", "tan", "exp", "log", "sqrt", "tanh", "arctan", "minimum", "maximum")
}
_NODES = (
    ast.Expression, ast.BinOp, ast.UnaryOp, ast.Call, ast.Name, ast.Load, ast.Constant,
    ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.UAdd, ast.USub,
)  # fmt: skip


def spelt(name: str) -> str:
    """How an expression spells the name of a joint or actuator: what Python cannot have in a name becomes ``_``."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return f"_{plain}" if not plain or plain[0].isdigit() or keyword.iskeyword(plain) else plain


def dotted_names(text: str) -> tuple[str, ...]:
    """The names with a dot in a formula, as ``arm.q``, in the order of the alphabet; none where it cannot be read."""
    try:
        nodes = [*ast.walk(_Dotted().visit(ast.parse(text.strip(), mode="eval")))]
    except SyntaxError:
        return ()
    return tuple(sorted({node.id for node in nodes if isinstance(node, ast.Name) and "." in node.id}))


class Expression:
    """A formula of named numbers; nothing but arithmetic and the functions listed here can be written in it.

    Args:
        text: the formula, in Python's notation, as ``-k * q * abs(q)``.
        names: the names it may use; they may have dots, as ``pole.mass``.

    Raises:
        ConfigError: it cannot be read, uses another name, function or construct, or one of `names` never.
    """

    def __init__(self, text: str, names: tuple[str, ...]) -> None:
        self.text = text
        self._code = _compiled(text, names)
        self.used = frozenset(self._code.co_names) - FUNCTIONS.keys()

    def __call__(self, values: Mapping[str, Array | float]) -> Array:
        """The formula's value; arrays broadcast, what is not a number there stays not a number."""
        with np.errstate(all="ignore"):
            return np.asarray(eval(self._code, {"__builtins__": {}, **FUNCTIONS}, dict(values)))


class _Dotted(ast.NodeTransformer):
    """Takes ``pole.mass`` for one name."""

    def visit_Attribute(self, node: ast.Attribute) -> ast.Name:
        return ast.copy_location(ast.Name(ast.unparse(node), node.ctx), node)


def _compiled(text: str, names: tuple[str, ...]) -> CodeType:
    try:
        tree = _Dotted().visit(ast.parse(text.strip(), mode="eval"))
    except SyntaxError as error:
        raise ConfigError(f"Formula {text!r} cannot be read: {error.msg}. Write it as -k * q * abs(q).") from error
    for node in ast.walk(tree):
        _require_allowed(node, text, names)
    return compile(tree, "<formula>", "eval")


def _require_allowed(node: ast.AST, text: str, names: tuple[str, ...]) -> None:
    known = f"Names: {', '.join(names)}. Functions: {', '.join(FUNCTIONS)}. Operators: + - * / **."
    if not isinstance(node, _NODES):
        raise ConfigError(f"Formula {text!r} holds {type(node).__name__}, which formulas cannot. {known}")
    if isinstance(node, ast.Name) and node.id not in names and node.id not in FUNCTIONS:
        raise ConfigError(f"Formula {text!r} holds {node.id!r}, which is not known. {known}")
    if isinstance(node, ast.Call) and (not isinstance(node.func, ast.Name) or node.func.id not in FUNCTIONS):
        raise ConfigError(f"Formula {text!r} calls {ast.unparse(node.func)!r}, which is no function of it. {known}")
    if isinstance(node, ast.Constant) and (isinstance(node.value, bool) or not isinstance(node.value, int | float)):
        raise ConfigError(f"Formula {text!r} holds {node.value!r}, which is not a number. {known}")
