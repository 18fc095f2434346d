"""Writes docs/api.md from the sources and stubs of the package, without importing it: `python python/tools/make_api.py`.

`--check` only says whether the page is current.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from inspect import cleandoc
from pathlib import Path
from typing import TypeAlias

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python/sinew"
PAGE = ROOT / "docs/api.md"
MODULES = (
    "sinew", "sinew.batch", "sinew.gym", "sinew.gym.stable_baselines3", "sinew.jax", "sinew.mjx", "sinew.mujoco", "sinew.study",
    "sinew.warp", "sinew.warp.gym",
)  # fmt: skip

Definition: TypeAlias = ast.ClassDef | ast.FunctionDef


def source_of(module: str) -> Path:
    """The file of a module."""
    place = PACKAGE.joinpath(*module.split(".")[1:])
    candidates = (place / "__init__.py", place.with_suffix(".py"), place.with_suffix(".pyi"))
    return next(path for path in candidates if path.is_file())


def parsed(path: Path) -> ast.Module:
    """The syntax of a file; Python 3.11 does not know the statement `type`, which stubs use."""
    return ast.parse(re.sub(r"^type (\w+) =", r"\1 =", path.read_text(), flags=re.MULTILINE))


def definitions(module: str) -> dict[str, tuple[str, ast.stmt]]:
    """What a module defines or imports from the package, by name, with the module that defines it."""
    found: dict[str, tuple[str, ast.stmt]] = {}
    for node in parsed(source_of(module)).body:
        match node:
            case ast.ClassDef(name=name) | ast.FunctionDef(name=name):
                found[name] = (module, node)
            case ast.ImportFrom(module=source, level=level) if level:
                base = module.split(".")
                base = base[: len(base) - level + (source_of(module).name == "__init__.py")]
                inner = ".".join([*base, *(source.split(".") if source else [])])
                if source is None:
                    continue
                names = definitions(inner)
                found |= {alias.asname or alias.name: names[alias.name] for alias in node.names if alias.name in names}
    return found


def public_names(module: str) -> list[str]:
    """The names in `__all__`; without it, those that do not begin with an underscore and are defined here."""
    for node in parsed(source_of(module)).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == "__all__":
            return [name for name in ast.literal_eval(node.value) if name != "__version__"]
    return [name for name, (home, _) in definitions(module).items() if home == module and not name.startswith("_")]


def signature(function: ast.FunctionDef, name: str, *, method: bool) -> str:
    arguments = function.args
    if method and arguments.args and not any(_is(decorator, "staticmethod") for decorator in function.decorator_list):
        arguments.args = arguments.args[1:]
    text = f"{name}({ast.unparse(arguments)})"
    if function.returns is not None and not name[0].isupper():
        text += f" -> {ast.unparse(function.returns)}"
    return text


def _is(decorator: ast.expr, name: str) -> bool:
    return isinstance(decorator, ast.Name) and decorator.id == name


def documentation(node: Definition) -> str:
    paragraphs = cleandoc(ast.get_docstring(node) or "").split("\n\n")
    # An example is no quotation.
    fenced = [f"```pycon\n{text}\n```" if text.startswith(">>>") else text for text in paragraphs]
    return "\n\n".join(fenced) + "\n" if paragraphs[0] else ""


def members(module: str, node: ast.ClassDef) -> dict[str, ast.stmt]:
    """Members of a class and of its bases of this package, those of the class last."""
    found: dict[str, ast.stmt] = {}
    for base in node.bases:
        home, inner = None, None
        if isinstance(base, ast.Attribute) and isinstance(base.value, ast.Name) and base.value.id == "_sinew":
            home, inner = definitions("sinew._sinew").get(base.attr, (None, None))
        elif isinstance(base, ast.Name):
            home, inner = definitions(module).get(base.id, (None, None))
        if home is not None and isinstance(inner, ast.ClassDef):
            found |= members(home, inner)
    for statement in node.body:
        if isinstance(statement, ast.FunctionDef):
            # What sets a property says nothing that its getter does not.
            if not any(isinstance(decorator, ast.Attribute) for decorator in statement.decorator_list):
                found[statement.name] = statement
        elif isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
            found[statement.target.id] = statement
    return found


def class_text(module: str, node: ast.ClassDef, name: str) -> Iterator[str]:
    inside = members(module, node)
    maker = inside.get("__new__") or inside.get("__init__")
    if isinstance(maker, ast.FunctionDef):
        yield f"### `{signature(maker, name, method=True)}`\n"
    else:
        fields = [ast.unparse(s) for s in inside.values() if isinstance(s, ast.AnnAssign)]
        yield f"### `{name}({', '.join(fields)})`\n" if fields else f"### `{name}`\n"
    yield documentation(node)
    for member, statement in inside.items():
        if member.startswith("_") or not isinstance(statement, ast.FunctionDef):
            continue
        is_property = any(_is(decorator, "property") for decorator in statement.decorator_list)
        returned = "" if statement.returns is None else f": {ast.unparse(statement.returns)}"
        head = f"{member}{returned}" if is_property else signature(statement, member, method=True)
        text = " ".join(documentation(statement).split("\n\n")[0].split())
        yield f"- `{head}`: {text}" if text else f"- `{head}`"
    yield ""


def page() -> str:
    """The whole page."""
    lines = ["# Reference of the Python package\n", "Made by `python python/tools/make_api.py` from sources and stubs.\n"]
    for module in MODULES:
        tree = parsed(source_of(module))
        lines += [f"## `{module}`\n", cleandoc(ast.get_docstring(tree) or "") + "\n"]
        known = definitions(module)
        for name in sorted(public_names(module), key=str.lower):
            home, node = known[name]
            if isinstance(node, ast.ClassDef):
                lines += class_text(home, node, name)
            elif isinstance(node, ast.FunctionDef):
                lines += [f"### `{signature(node, name, method=False)}`\n", documentation(node)]
    return "\n".join(lines).rstrip() + "\n"


def main() -> int:
    if "--check" in sys.argv[1:]:
        if not PAGE.is_file() or PAGE.read_text() != page():
            print(f"{PAGE.relative_to(ROOT)} is not current: expected what python/tools/make_api.py writes")
            return 1
        return 0
    PAGE.write_text(page())
    return 0


if __name__ == "__main__":
    sys.exit(main())
