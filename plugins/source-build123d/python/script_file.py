"""A build123d script: its parameters are set, it runs, and leaves `result`.

A parameter is a name that the script assigns at top level; the recipe's value takes the place of what the script assigns,
so that the same file also runs by itself. A name that is not assigned there is an error, which catches misspellings.
"""

import ast
import difflib
import linecache
import random
import sys
import traceback
import types

from refusal import Refusal

# Not "__main__": what a script does only when run by itself, e.g. showing the part, is left out.
MODULE = "__fibar__"


def run(path, request):
    """The script's `result`."""
    shown = request["shown"]
    source = read(path, shown)
    try:
        tree = ast.parse(source, filename=shown)
    except SyntaxError as error:
        raise Refusal("script", f"{shown}:{error.lineno}: {type(error).__name__}: {error.msg}{quoted(error.text)}")
    for name, value in request["parameters"].items():
        assign(tree, name, value)
    return execute(compile(tree, shown, "exec"), source, shown)


def read(path, shown):
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refusal("script", f"{shown} is not UTF-8 text: {error.reason} at byte {error.start}")


def assign(tree, name, value):
    """Puts the value in the place of what the script first assigns to the name."""
    known = {}
    for statement in tree.body:
        targets = getattr(statement, "targets", None) or [getattr(statement, "target", None)]
        if isinstance(statement, (ast.Assign, ast.AnnAssign)) and len(targets) == 1 and isinstance(targets[0], ast.Name):
            known.setdefault(targets[0].id, statement)
    if name not in known:
        near = difflib.get_close_matches(name, known, 1)
        hint = f"did you mean `{near[0]}`?" if near else f"it assigns: {', '.join(known) or 'nothing'}"
        raise Refusal("parameter", f"the script assigns no `{name}` at top level", hint, name)
    statement = known[name]
    statement.value = ast.copy_location(literal(name, value, statement.value), statement.value)
    ast.fix_missing_locations(statement)


def literal(name, value, old):
    """The value as an expression, of the kind that stood there before."""
    try:
        before = ast.literal_eval(old)
    except ValueError:
        before = None
    kinds = {bool: "true or false", int: "a number", float: "a number", str: "a text", list: "a list", tuple: "a list"}
    if before is not None and kinds.get(type(before)) not in (None, kinds[type(value)]):
        raise Refusal("parameter", f"`{name}` is {kinds[type(before)]} in the script, not {value!r}", None, name)
    if isinstance(before, float):
        value = float(value)
    return ast.parse(repr(value), mode="eval").body


def execute(code, source, shown):
    module = types.ModuleType(MODULE)
    module.__file__ = shown
    sys.modules[MODULE] = module
    sys.argv = [shown]
    linecache.cache[shown] = (len(source), None, source.splitlines(keepends=True), shown)
    random.seed(0)
    try:
        exec(code, module.__dict__)
    except SystemExit as error:
        raise Refusal("script", f"{place(error, shown)}the script called exit({error.code!r})", "end it by setting `result`")
    except BaseException as error:
        # Without this function's own frame.
        traceback.print_exception(type(error), error, error.__traceback__.tb_next)
        raise Refusal("script", f"{place(error, shown)}{described(error)}{line_of(error, shown)}", hint_for(error))
    return result_of(module.__dict__, shown)


def result_of(names, shown):
    if "result" in names:
        return names["result"]
    shapes = [name for name, value in names.items() if hasattr(value, "wrapped") and hasattr(value, "solids")]
    builders = [name for name, value in names.items() if hasattr(value, "part") and hasattr(value, "to_combine")]
    candidates = shapes + builders
    hint = f"add `result = {candidates[-1]}`" if candidates else "end it with `result = ` and a solid, a list, or a dict of names"
    raise Refusal("script", f"{shown}: the script sets no `result`", hint)


def described(error):
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def frames(error, shown):
    return [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == shown]


def place(error, shown):
    """File and line of the innermost step inside the user's own file."""
    own = frames(error, shown)
    if not own:
        return f"{shown}: "
    function = "" if own[-1].name == "<module>" else f"in {own[-1].name}: "
    return f"{shown}:{own[-1].lineno}: {function}"


def line_of(error, shown):
    own = frames(error, shown)
    return quoted(own[-1].line if own else None)


def quoted(line):
    return f", at `{line.strip()}`" if line and line.strip() else ""


def hint_for(error):
    if isinstance(error, ModuleNotFoundError):
        return "only build123d and what it brings can be imported; guard viewers with `if __name__ == \"__main__\":`"
    if isinstance(error, FileNotFoundError):
        return "a script sees no files beside it: name them in the recipe, `files = { NAME = \"…\" }`"
    return None
