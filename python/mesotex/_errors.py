"""The error of every reader."""


class DataError(ValueError):
    """A file does not hold what it should: which file, where in it, what was found and expected."""

    def __init__(self, path, place, found, expected):
        super().__init__(f"{path}: {place}: {found}; expected {expected}")
        self.path = path
        self.place = place
        self.found = found
        self.expected = expected


def check(is_sound, path, place, found, expected):
    """Raises a DataError unless the condition holds."""
    if not is_sound:
        raise DataError(path, place, found, expected)


def check_format(path, description, name, version=1):
    """Checks the `format` and `version` of a description."""
    found = description.get("format")
    check(found == name, path, "format", repr(found), repr(name))
    found = description.get("version")
    check(found == version, path, "version", repr(found), repr(version))
