"""Why there are no triangles: the one exception that the runner turns into words for the user."""


class Refusal(Exception):
    """What is wrong, and where.

    kind: "script", "parameter", "file", "size", "no-solid" or "environment".
    """

    def __init__(self, kind, message, hint=None, parameter=None):
        super().__init__(message)
        self.kind = kind
        self.hint = hint
        self.parameter = parameter

    def to_json(self):
        named = {"kind": self.kind, "message": str(self), "hint": self.hint, "parameter": self.parameter}
        return {key: value for key, value in named.items() if value is not None}
