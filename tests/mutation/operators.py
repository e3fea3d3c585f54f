"""Small faults that a programmer makes, one at a time, in the syntax tree of a module."""

import ast
from collections import Counter
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
    name : function, and the expression before and after, which one where there are several: what a list of survivors
        says, whatever its line.
    line : of the source.
    tree : of the whole module.
    of_module : whether a constant of the module is another one.
    recompiled : the module's compiled functions that it changes.
    """

    name: str
    line: int
    tree: ast.Module
    of_module: bool
    recompiled: set[str]


def mutants(source: str) -> Iterator[Mutant]:
    """Every mutant of a module."""
    whole = ast.parse(source)
    names, left_alone, shown = _functions(whole), _left_alone(whole), _shown(whole)
    seen: Counter[str] = Counter()
    for place, node in enumerate(ast.walk(whole)):
        for variant in range(0 if id(node) in left_alone else 2):
            if _change(node, variant) is None:
                continue
            tree = ast.parse(source)
            nodes = [*ast.walk(tree)]
            around = nodes[shown[place]]
            before, change = ast.unparse(around), _change(nodes[place], variant)
            change()
            name = f"{names[place]}: {before} → {ast.unparse(around)}"
            seen[name] += 1
            if seen[name] > 1:
                name += f" ({seen[name]})"
            of_module, recompiled = names[place] == "module", _recompiled(whole, names[place])
            yield Mutant(name, node.lineno, ast.fix_missing_locations(tree), of_module, recompiled)


def _recompiled(tree: ast.Module, function: str) -> set[str]:
    """Compiled functions that a change in a function changes: constants, and what only they call, are a part of all."""
    decorated = {
        node.name: {
            of.func.id for of in node.decorator_list if isinstance(of, ast.Call) and isinstance(of.func, ast.Name)
        }
        for node in tree.body
        if isinstance(node, ast.FunctionDef)
    }
    compiled = {name for name, by in decorated.items() if by & {"kernel", "inner"}}
    shared = function == "module" or "inner" in decorated.get(function, ())
    return compiled if shared else compiled & {function}


def _shown(tree: ast.Module) -> list[int]:
    """Of each node the place in ``ast.walk`` of what a name tells: of a constant, what it is a part of."""
    nodes = [*ast.walk(tree)]
    places = {id(node): place for place, node in enumerate(nodes)}
    above = {id(child): node for node in nodes for child in ast.iter_child_nodes(node)}
    around = ast.expr | ast.keyword | ast.Assign | ast.AugAssign | ast.AnnAssign
    return [
        places[id(above[id(node)] if isinstance(node, ast.Constant) and isinstance(above[id(node)], around) else node)]
        for node in nodes
    ]


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
