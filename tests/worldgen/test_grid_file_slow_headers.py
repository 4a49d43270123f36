"""Headers that would keep tomllib busy for hours are refused before it reads them."""

import tomllib

import pytest

from tests.worldgen.test_grid_file_hostile import complaint

_LONG = 1_000_000


_SLOW_FOR_TOML = {
    "brackets": "a = " + _LONG * "[",
    "tables": "a = " + _LONG // 4 * "{a= ",
    "dotted key": "a" + _LONG // 2 * ".a" + " = 1",
    "dotted table": "[a" + _LONG // 2 * ".a" + "]",
    "quoted dotted key": _LONG // 4 * '"a".' + "a = 1",
    "digits": "a = 1" + _LONG * "0",
    "underscores": "a = 1" + _LONG // 2 * "_0",
    "quotes": _LONG * '"',
    "open strings": 'a = """' + _LONG // 4 * '"" ',
    "deep keys": "".join(f"a{20 * '.a'}.b{k} = 1\n" for k in range(15_000)),
    "many tables": "".join(f"[a{k}]\n" for k in range(90_000)),
}


_IN_LINEAR_TIME = {"quotes", "open strings", "deep keys", "many tables"}  # tomllib may read these


@pytest.mark.gate
@pytest.mark.parametrize("name", _SLOW_FOR_TOML)
def test_a_header_that_takes_tomllib_quadratic_time_is_refused_before_tomllib_reads_it(
    name, monkeypatch
):
    read = []
    monkeypatch.setattr(
        tomllib, "loads", lambda text, loads=tomllib.loads: read.append(text) or loads(text)
    )
    assert (
        complaint(f"%worldgen-grid 1\n{_SLOW_FOR_TOML[name]}\n%cells\n.\n%end\n".encode()).line == 2
    )
    assert bool(read) == (name in _IN_LINEAR_TIME)
