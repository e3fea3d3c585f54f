"""A stand-in for Unreal's Python module: it knows the names, arguments and properties that the engine's stubs know.

Whatever a script asks for that they do not have raises an ``AttributeError`` or a ``TypeError``, as in the editor.
"""

import ast
import inspect
import re
from functools import cached_property

NUMBERS = {"bool": bool, "float": (int, float), **dict.fromkeys(("int", "int32", "uint8"), int)}
TEXTS = ("str", "Name", "Text")


class Root:
    """Of all classes: values are kept under the editor's names for them."""

    editor, known, plugin, is_enum = None, {}, None, False

    def __init__(self):
        self.values = {}

    @classmethod
    def property_type(cls, name):
        for kind in cls.__mro__:
            if name in vars(kind).get("known", {}):
                return kind.known[name]
        raise AttributeError(f"{cls.__name__} has no property '{name}'")

    def set_editor_property(self, name, value):
        kind, access = self.property_type(name)
        if access != "Read-Write" or not self.editor.fits(value, kind):
            raise TypeError(f"{type(self).__name__}.{name} ({kind}, {access}) takes no {value!r}")
        self.values[name] = value

    def get_editor_property(self, name):
        kind, _ = self.property_type(name)
        return self.values.get(name, self.editor.made(kind, ()))


class Editor:
    """The module ``unreal``.

    Parameters
    ----------
    stubs : text of the engine's stubs.
    answers : functions that are called instead of those of their names, with the arguments.
    """

    def __init__(self, stubs, answers):
        self._stubs, self._answers = stubs, answers
        self.calls, self.classes = [], {}

    def __getattr__(self, name):
        if name in self._places:
            node = self._node(name)
            return self._class(node) if isinstance(node, ast.ClassDef) else self._callable(node, skip=0)
        raise AttributeError(f"module 'unreal' has no attribute '{name}'")

    @cached_property
    def _places(self):
        found = [*re.finditer(r"^(?:class|def) (\w+)", self._stubs, re.MULTILINE)]
        ends = [*(match.start() for match in found[1:]), len(self._stubs)]
        return {match[1]: (match.start(), end) for match, end in zip(found, ends, strict=True)}

    def _node(self, name):
        start, end = self._places[name]
        return ast.parse(self._stubs[start:end]).body[0]

    def _class(self, node):
        if node.name in self.classes:
            return self.classes[node.name]
        bases = [base.id for base in node.bases if base.id in self._places]
        description = ast.get_docstring(node) or ""
        rows = re.findall(r"^- ``(\w+)`` \((.*?)\):\s+\[([\w-]+)\]", description, re.MULTILINE)
        body = {"editor": self, "known": {name: (kind, access) for name, kind, access in rows}}
        body["plugin"] = next(iter(re.findall(r"\*\*Plugin\*\*: (\w+)", description)), None)
        for entry in node.body:
            if isinstance(entry, ast.FunctionDef) and not entry.name.startswith("_") and not hasattr(Root, entry.name):
                of_class = any(getattr(word, "id", "") == "classmethod" for word in entry.decorator_list)
                method = self._callable(entry, skip=1)
                body[entry.name] = (staticmethod if of_class else bound)(method)
        kind = type(node.name, tuple(getattr(self, base) for base in bases) or (Root,), body)
        self.classes[node.name] = kind
        for entry in node.body:
            if isinstance(entry, ast.AnnAssign) and "EnumBase" in bases:
                setattr(kind, entry.target.id, kind())
        return kind

    def _callable(self, node, skip):
        words = node.args.args[skip:]
        defaults = [inspect.Parameter.empty] * (len(words) - len(node.args.defaults)) + node.args.defaults
        kinds = {word.arg: ast.unparse(word.annotation) for word in words}
        signature = inspect.Signature(
            [
                inspect.Parameter(word.arg, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=default)
                for word, default in zip(words, defaults, strict=True)
            ]
        )

        def call(*arguments, **named):
            given = signature.bind(*arguments, **named).arguments
            for name, value in given.items():
                if not self.fits(value, kinds[name]):
                    raise TypeError(f"{node.name}: {name} ({kinds[name]}) takes no {value!r}")
            self.calls.append((node.name, given))
            if node.name in self._answers:
                return self._answers[node.name](*given.values())
            return self.made(ast.unparse(node.returns), given.values())

        return call

    def fits(self, value, kind):
        """Whether a value is of a type, by the type's name in the stubs."""
        outer, _, inner = kind.partition("[")
        if outer in ("Optional", "Union"):
            return (value is None and outer == "Optional") or any(self.fits(value, one) for one in parts(inner[:-1]))
        if outer == "Array":
            return isinstance(value, list) and all(self.fits(one, inner[:-1]) for one in value)
        if outer in ("Class", "type"):
            return isinstance(value, type) and issubclass(value, Root)
        if kind in TEXTS or kind in NUMBERS:
            return isinstance(value, NUMBERS.get(kind, str)) and (kind == "bool" or not isinstance(value, bool))
        return kind in ("Any", "object") or isinstance(value, getattr(self, kind))

    def made(self, kind, given):
        """An answer of a type; a class among what was given says which of its kind."""
        asked = next((value for value in given if isinstance(value, type)), None)
        if asked is not None:
            return asked()
        if kind == "bool":
            return True
        if kind.startswith("Array["):
            return []
        return getattr(self, kind)() if kind in self._places else None


def bound(method):
    """A method whose text takes no ``self``."""
    return lambda _, *arguments, **named: method(*arguments, **named)


def parts(text):
    """``A, B[C, D]`` at its outer commas."""
    return re.findall(r"(?:[^,\[]|\[[^\]]*\])+", text.replace(", ", ","))
