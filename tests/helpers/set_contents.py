"""The contents of a set, byte for byte."""


def contents(place):
    """Names and bytes of all files of a set, or the bytes of an archive."""
    if place.is_file():
        return place.read_bytes()
    return {
        path.relative_to(place).as_posix(): path.read_bytes()
        for path in place.rglob("*")
        if path.is_file()
    }
