"""SceneBuilder: a scene written in Python, with the elements and attributes of the scene language."""

import functools
import json
import math
import os
import sys
from xml.sax.saxutils import escape, quoteattr

from . import _cogrsim as _c
from ._errors import CompileError


@functools.lru_cache(maxsize=1)
def _language():
    """The elements by name; of two with one name, one is under (name, the attribute that calls for it)."""
    elements = json.loads(_c._schema())["elements"]
    return {(e["name"], e["when"]) if "when" in e else e["name"]: e for e in elements}


def _nearest(text, names):
    import difflib
    found = difflib.get_close_matches(text, names, 1)
    return f"; did you mean {found[0]!r}?" if found else ""


class SceneElement:
    """One element of a scene. Each element of the language that may stand in it is a method.

    The method's first argument is the name (of elements that have one), keywords are attributes, with "_" for
    "-" and a trailing "_" after a word of Python: `box("crate", size=(0.2, 0.2, 0.2), mass="1 kg")`,
    `for_(var="i", in_="0 .. 3")`. Values are texts as in XML, numbers (SI), booleans, sequences of these, and
    elements, which stand for their names. The new element is returned; it serves in a `with` too.
    Raises AttributeError: no such element here; TypeError: no such attribute, or a value that is none;
    ValueError: a number that is not finite, an element without a name or of another scene.
    """

    def __init__(self, tag, attributes, parent, line):
        self._tag = tag
        self._attributes = attributes
        self._parent = parent
        self._line = line
        self._children = []
        self._text = ""

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        return None

    @property
    def name(self):
        """Name of the element in its scope."""
        if "name" not in self._attributes:
            raise ValueError(f"this <{self._tag}> has no name; give it one as the first argument")
        return self._attributes["name"]

    @property
    def path(self):
        """Dotted name in the scene."""
        above = self._parent
        while above is not None and above._tag not in ("assembly", "template", "prototype"):
            above = above._parent
        return self.name if above is None else f"{above.path}.{self.name}"

    def _allowed(self):
        # Elements such as <for> may contain what the element around them may.
        around = self
        while _language()[around._tag].get("flow") and around._parent is not None:
            around = around._parent
        children = _language()[around._tag].get("children", [])
        flow = [e["name"] for e in _language().values() if e.get("flow")] if children else []
        return [*children, *(name for name in flow if name not in children)]

    def __dir__(self):
        return [*super().__dir__(), *(c.replace("-", "_") for c in self._allowed())]

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        tag = name.rstrip("_").replace("_", "-")
        allowed = self._allowed()
        if tag not in allowed:
            known = "is no element of the scene language" if tag not in _language() else "may not stand here"
            raise AttributeError(f"<{tag}> {known}; <{self._tag}> may contain {', '.join(allowed) or 'nothing'}"
                                 + _nearest(tag, allowed))
        return functools.partial(self._add, tag)

    def _add(self, tag, /, *args, **attributes):
        info = next((_language()[tag, key] for key in attributes if (tag, key) in _language()), _language()[tag])
        known = [a["name"] for a in info["attributes"]]
        if len(args) > 1 or (args and "name" not in known and not info.get("text")):
            raise TypeError(f"<{tag}> takes attributes by keyword only"
                            if not args or "name" not in known else
                            f"<{tag}> takes its name only without a keyword")
        text = ""
        if args and "name" in known:
            if "name" in attributes:
                raise TypeError(f"<{tag}> is given two names, {args[0]!r} and {attributes['name']!r}")
            if not isinstance(args[0], str):
                raise TypeError(f"<{tag}>: expected a name, a text, as the first argument, found "
                                f"{type(args[0]).__name__}")
            attributes = {"name": args[0], **attributes}
        elif args:
            text = self._value(tag, "text", args[0])
        if "text" in attributes and "text" not in known and info.get("text"):
            text = self._value(tag, "text", attributes.pop("text"))
        out = {}
        for key, value in attributes.items():
            if value is None:
                continue
            attribute = key
            if not info.get("open_attributes") or key.rstrip("_").replace("_", "-") in known:
                attribute = key.rstrip("_").replace("_", "-")
                if attribute not in known and not info.get("open_attributes"):
                    raise TypeError(f"<{tag}> has no attribute {attribute!r}; it has {', '.join(known)}"
                                    + _nearest(attribute, known))
            if attribute in out:
                raise TypeError(f"<{tag}> is given the attribute {attribute!r} twice")
            out[attribute] = self._value(tag, attribute, value)
        frame = sys._getframe(1)
        element = SceneElement(tag, out, self, (frame.f_code.co_filename, frame.f_lineno))
        element._text = text
        self._children.append(element)
        return element

    def _root(self):
        return self if self._parent is None else self._parent._root()

    def _value(self, tag, attribute, value):
        place = f"attribute {attribute!r} of <{tag}>"
        if isinstance(value, str):
            value.encode()  # UnicodeEncodeError, a ValueError: half of a surrogate pair
            return value
        if isinstance(value, SceneElement):
            if value._root() is not self._root():
                raise ValueError(f"{place}: {value!r} is of another scene, {value._root()._attributes['name']!r}")
            path, scope = value.path, self
            while scope is not None and scope._tag not in ("assembly", "template", "prototype"):
                scope = scope._parent
            start = "" if scope is None else scope.path + "."
            return path[len(start):] if path.startswith(start) else path
        if hasattr(value, "dtype") and not getattr(value, "shape", ()):
            value = value.item()
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, (int, float)):
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f"{place}: expected finite numbers, found {value!r}")
            return repr(value)
        if hasattr(value, "__iter__") and not isinstance(value, (bytes, dict, set, frozenset)):
            return " ".join(self._value(tag, attribute, entry) for entry in value)
        raise TypeError(f"{place}: expected a text, a number, a boolean, an element or a sequence of these, found "
                        f"{type(value).__name__}")

    def _write(self, lines, places, depth):
        blanks = "  " * depth
        start = blanks + "<" + self._tag + "".join(f" {k}={quoteattr(v)}" for k, v in self._attributes.items())
        places.append(self._line)
        if not self._children and not self._text:
            lines.append(start + "/>")
            return
        lines.append(start + ">" + escape(self._text))
        places.extend([self._line] * self._text.count("\n"))
        if not self._children:
            lines[-1] += f"</{self._tag}>"
            return
        for child in self._children:
            child._write(lines, places, depth + 1)
        lines.append(f"{blanks}</{self._tag}>")
        places.append(self._line)

    def __repr__(self):
        return f"<{self._tag}" + "".join(f" {k}={quoteattr(v)}" for k, v in self._attributes.items()) + ">"


class SceneBuilder(SceneElement):
    """A scene, built element by element.

        scene = cg.SceneBuilder("ramp")
        scene.plane("floor")
        with scene.assembly("cart", xyz=(0, 0, 0.1)) as cart:
            base = cart.box("base", size=(0.4, 0.2, 0.05), mass="1 kg")
            wheel = cart.cylinder("wheel", radius="5 cm", length="2 cm", rpy="90 0 0 deg")
            cart.hinge("axle", parent=base, child=wheel, axis=(0, 0, 1))
        sim = cg.Simulation(scene.compile(), backend="bullet")
    """

    def __init__(self, name):
        if not isinstance(name, str):
            raise TypeError(f"name: expected a text, found {type(name).__name__}")
        name.encode()
        frame = sys._getframe(1)
        super().__init__("scene", {"name": name, "version": "1"}, None,
                         (frame.f_code.co_filename, frame.f_lineno))

    @property
    def path(self):
        """Dotted name of the scene itself: ''."""
        return ""

    def _source(self):
        lines, places = [], []
        self._write(lines, places, 0)
        return "\n".join(lines) + "\n", places

    @property
    def xml(self):
        """The scene as XML."""
        return self._source()[0]

    def save(self, path):
        """Write the XML to a file, which must not exist. Raises FileExistsError, OSError."""
        with open(os.fspath(path), "x", encoding="utf-8") as file:
            file.write(self.xml)

    def compile(self, *, set=None, seed=None, plugin_path=(), library_path=()):
        """Compile the scene, with arguments as those of compile_string().

        Raises CompileError: as compile(), with the line of Python that made each element.
        """
        text, places = self._source()
        try:
            return _c.compile_string(text, self._attributes["name"], set=set, seed=seed,
                                     plugin_path=plugin_path, library_path=library_path)
        except CompileError as error:
            made = []
            for d in error.diagnostics:
                if 0 < d.line <= len(places) and d.severity == "error":
                    file, line = places[d.line - 1]
                    made.append(f"{file}:{line}: made the element of line {d.line}")
            if not made:
                raise
            raise CompileError("\n".join([str(error), *made]), error.diagnostics) from None
