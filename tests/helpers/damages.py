"""Ways to damage a file; a reader must answer each with an error message."""

from hypothesis import strategies as st

# Words that formats trip over: bad numbers, ends of text, paths out of a folder, bombs.
WORDS = (
    b"", b"\0", b"-1", b"0", b"1e999", b"nan", b"99999999999999999999", b"4294967296", b"0x10", b"1_0", b"\xff\xfe",
    b"\xef\xbb\xbf", b"\r", b"\r\n", b"\n\n\n", b"\t", b"[[[[[[[[", b"{{{{{{{{", b"]", b"}", b'"', b"'", b"&a [", b"*a",
    b"<<: *a", b"!!python/object:os.system", b"<!DOCTYPE a [<!ENTITY b SYSTEM "
                                             b"'file:///etc/hostname'>]>", b"&b;", b"<",
    b"</world>", b"<!--", b"../../../etc/hostname", b"/dev/zero", b"\xc3\xa9", b"#", b"%", b"null", b"true", b"1/0",
)  # fmt: skip


@st.composite
def damages(draw):
    """A way to damage bytes: replace, cut or double them, or insert a word."""
    at = draw(st.floats(0, 1))
    length = draw(st.integers(0, 40))
    kind = draw(st.sampled_from(["cut", "flip", "drop", "double", "word", "number"]))
    word = draw(st.sampled_from(WORDS))
    bit = draw(st.integers(0, 7))

    def damage(data):
        place = int(at * len(data))
        before = data[:place]
        part = data[place : place + length]
        after = data[place + length :]
        if kind == "cut":
            return before
        if kind == "flip":
            return before + bytes([byte ^ (1 << bit) for byte in part[:1]]) + part[1:] + after
        if kind == "drop":
            return before + after
        if kind == "double":
            return before + part + part + after
        if kind == "number":
            return _with_number(data, place, word)
        return before + word + part + after

    return damage


def _with_number(data, place, word):
    """Replace the first number after a place with a word."""
    digits = b"0123456789.-"
    begin = next((at for at in range(place, len(data)) if data[at] in digits), len(data))
    end = next((at for at in range(begin, len(data)) if data[at] not in digits), len(data))
    return data[:begin] + word + data[end:]
