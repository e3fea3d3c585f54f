"""Small faults that a programmer makes, one at a time, in the syntax tree of a module."""

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass

_COMPARISONS = {
    ast.Lt: (ast.LtE, ast.GtE), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.LtE), ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.In: (ast.NotIn,), ast.NotIn: (ast.In,),
    ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,),
}  # fmt: skip
_ARITHMETIC = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult,
    ast.Pow: ast.Mult, ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr, ast.BitXor: ast.BitOr,
    ast.LShift: ast.RShift, ast.RShift: ast.LShift,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """A module with one fault.

    Attributes
    ----------
    name : function, and the expression before and after: what a list of survivors says, whatever its line.
    line : of the source.
    tree : of the whole module.
    """

    name: str
    line: int
    tree: ast.Module


def mutants(source: str) -> Iterator[Mutant]:
    """Every mutant of a module."""
    whole = ast.parse(source)
    names, left_alone = _functions(whole), _left_alone(whole)
    for place, node in enumerate(ast.walk(whole)):
        for variant in range(0 if id(node) in left_alone else 2):
            tree = ast.parse(source)
            changed = next(node for at, node in enumerate(ast.walk(tree)) if at == place)
            change = _change(changed, variant)
            if change is not None:
                change()
                name = f"{names[place]}: {ast.unparse(node)} → {ast.unparse(changed)}"
                yield Mutant(name, changed.lineno, _without_cache(ast.fix_missing_locations(tree)))


def _functions(tree: ast.Module) -> list[str]:
    """The name of the function around each node, in the order of ``ast.walk``."""
    around: dict[int, str] = {}
    for node in ast.walk(tree):
        inside = node.name if isinstance(node, ast.FunctionDef | ast.ClassDef) else around.get(id(node), "module")
        around.setdefault(id(node), inside)
        for child in ast.iter_child_nodes(node):
            around[id(child)] = inside
    return [around[id(node)] for node in ast.walk(tree)]


def _left_alone(tree: ast.Module) -> set[int]:
    """Types, decorators, docstrings and the words of errors, which no test is to hold."""
    roots: list[ast.AST] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            roots += [*node.decorator_list, *([node.returns] if node.returns else [])]
        elif isinstance(node, ast.ClassDef):
            roots += node.decorator_list
        elif isinstance(node, ast.arg | ast.AnnAssign) and node.annotation:
            roots.append(node.annotation)
        elif isinstance(node, ast.Raise | ast.JoinedStr) or _is_docstring(node):
            roots.append(node)
    return {id(inside) for root in roots for inside in ast.walk(root)}


def _change(node: ast.AST, variant: int) -> Callable[[], None] | None:
    """What makes the fault; None where there is no such one."""
    match node:
        case ast.Compare() if variant < len(others := _COMPARISONS[type(node.ops[0])]):
            return lambda: node.ops.__setitem__(0, others[variant]())
        case ast.BinOp() if variant == 0 and type(node.op) in _ARITHMETIC:
            return lambda: setattr(node, "op", _ARITHMETIC[type(node.op)]())
        case ast.BoolOp() if variant == 0:
            return lambda: setattr(node, "op", ast.Or() if isinstance(node.op, ast.And) else ast.And())
        case ast.UnaryOp(op=ast.Not()) if variant == 0:
            return lambda: setattr(node, "operand", ast.UnaryOp(ast.Not(), node.operand))
        case ast.UnaryOp(op=ast.USub()) if variant == 0:
            return lambda: setattr(node, "op", ast.UAdd())
        case ast.Constant(value=bool() as value) if variant == 0:
            return lambda: setattr(node, "value", not value)
        case ast.Constant(value=(int() | float()) as value) if variant == 0:
            return lambda: setattr(node, "value", value + 1)
        case ast.Constant(value=str() as value) if variant == 0 and value and " " not in value:
            return lambda: setattr(node, "value", f"{value}x")
        case ast.Return(value=ast.expr() as value) if variant == 0 and not _is_none(value):
            return lambda: setattr(node, "value", ast.Constant(None))
    return None


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_none(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and value.value is None


def _without_cache(tree: ast.Module) -> ast.Module:
    """Numba's cache does not see a constant that is another one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "njit":
            node.keywords = [keyword for keyword in node.keywords if keyword.arg != "cache"]
    return tree
