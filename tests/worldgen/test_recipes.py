"""Recipes: families from TOML, parsed strictly, and recreated from their worlds alone."""

import dataclasses
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.compose.recipe import family_from_recipe
from worldgen.compose.recipe_run import MOST_WORK, RecipeCells
from worldgen.compose.sizes import TooLarge
from worldgen.errors import FormatError, GenerationFailed, InvalidParameter, WorldgenError
from worldgen.family import FAMILIES
from worldgen.files.grid import dumps, loads, world_digest, write_world
from worldgen.generation import generate
from worldgen.reach import check_certificate, witness_margin
from worldgen.testing import CHECKS, FAMILY_CHECKS

EXAMPLES = sorted(Path("examples/recipes").glob("*.toml"))
every_example = pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)

SMALL = """recipe = "small"
about = "A box with a stone."

[parameters]
size = { default = 12, least = 6, most = 40, help = "Cells a side." }
side = { default = "left", choices = ["left", "right"] }

[[part]]
name = "stone"
rows = \"\"\"
##
##
\"\"\"

[[part]]
name = "room"
box = ["= size", "= size"]
steps = [
  { border = 1 },
  { start = [2.5, 2.5] },
  { target = ["= size - 0.5", "= size - 0.5"] },
  { place = "stone", at = [{ from = 5, to = "= size - 5" }, 5], how = "union" },
]
"""

# For seed 7: the layout's id, 16 digits. If it changes, raise VERSION in
# worldgen/compose/recipe.py.
GOLDEN = {
    "double-comb": "e98d1765f5940f07",
    "gauntlet": "01941b600bb430a5",
    "office-wing": "e57011afac9107d7",
    "trap-in-maze": "e01e00d0daaa01bf",
    "walled-garden": "ab63b50977f6ac91",
}


@pytest.mark.gate
@every_example
def test_an_example_makes_a_world_that_the_independent_checker_accepts(path):
    for seed in range(3):
        assert check_certificate(generate(str(path), seed)).valid


@pytest.mark.gate
@every_example
def test_a_recipes_world_is_made_again_from_its_file_alone(path):
    world = loads(dumps(generate(str(path), 5)))
    made = world.provenance
    assert made.family == f"recipe:{path.stem}"
    assert dumps(generate(made.family, made.seed, **made.params)) == dumps(world)


@every_example
def test_a_seed_of_a_recipe_yields_the_layout_it_always_yielded(path):
    layout = dataclasses.replace(generate(str(path), 7), certificate=None)
    assert world_digest(layout)[:16] == GOLDEN[path.stem]


def test_what_a_part_draws_does_not_move_what_another_draws():
    more = SMALL.replace(
        '[[part]]\nname = "room"',
        '[[part]]\nname = "x"\nfamily = "trap"\n\n[[part]]\nname = "room"',
    )
    assert world_digest(generate(family_from_recipe(more), 3)) == world_digest(
        generate(family_from_recipe(SMALL), 3)
    )


def test_parameters_of_a_recipe_are_parameters_of_its_family():
    made = family_from_recipe(SMALL)
    assert (made.name, made.version, made.description) == ("recipe:small", 1, "A box with a stone.")
    assert made.defaults() == {
        "size": 12, "side": "left", "cell_size": 0.1, "robot_radius": 0.07, "robot_speed": 2.0,
    }  # fmt: skip
    assert made.parameters[0].help == "Cells a side." and made.parameters[1].choices == (
        "left",
        "right",
    )
    assert generate(made, 1, size=20, robot_radius=0.05).width == 22


def test_a_recipe_whose_parts_change_is_told_from_one_that_stands_still_and_gets_its_margin():
    office, maze = (
        family_from_recipe(Path(f"examples/recipes/{name}.toml"))
        for name in ("office-wing", "trap-in-maze")
    )
    assert office.changes and not maze.changes
    world = generate(office, 1, margin=2.0)
    assert witness_margin(world, world.certificate) >= 2.0


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"size": 5}, {"code": "out-of-range", "name": "size", "value": 5, "low": 6}),
        ({"side": "top"}, {"code": "unknown-name", "name": "side", "value": "top"}),
        ({"sise": 5}, {"code": "unknown-name", "name": "sise", "owner": "recipe:small"}),
        (
            {"recipe": "another"},
            {
                "code": "other-version",
                "name": "recipe",
                "family": "recipe:small",
                "value": "another",
            },
        ),
        ({"made_with": {"compose": 0}}, {"code": "other-version", "name": "made_with"}),
    ],
)
def test_what_a_recipe_does_not_take_is_refused(params, expected):
    with raises(InvalidParameter, **expected):
        generate(family_from_recipe(SMALL), 1, **params)


def test_another_recipe_under_the_name_is_noticed():
    world = generate(family_from_recipe(SMALL), 1)
    params = {**world.provenance.params, "recipe": SMALL.replace('"small"', '"other"')}
    with raises(InvalidParameter, "other-recipe", name="recipe:small", other="recipe:other"):
        generate("recipe:small", 1, **params)


def test_a_recipe_without_chance_that_cannot_be_solved_says_that_no_seed_helps():
    walled = SMALL.replace('[{ from = 5, to = "= size - 5" }, 5]', "[1, 1]").replace(
        "[2.5, 2.5]", "[1.5, 1.5]"
    )
    walled = walled.replace("##\n##", "_##\n__#\n###")
    with raises(GenerationFailed, "not-reachable", name="small", result="blocked"):
        generate(family_from_recipe(walled), 1)


def test_steps_as_tables_of_their_own_are_the_same_recipe():
    inline = SMALL[SMALL.index("steps = [") :]
    table = """[[part.steps]]
border = 1
[[part.steps]]
start = [2.5, 2.5]
[[part.steps]]
target = ["= size - 0.5", "= size - 0.5"]
[[part.steps]]
place = "stone"
at = [{ from = 5, to = "= size - 5" }, 5]
how = "union"
"""
    apart = family_from_recipe(SMALL.replace(inline, table))
    assert world_digest(generate(apart, 3)) == world_digest(generate(family_from_recipe(SMALL), 3))


def test_a_map_that_a_recipe_reads_travels_with_its_worlds(tmp_path):
    write_world(generate("rooms", 3, size=24), tmp_path / "office.grid")
    text = 'recipe = "on-a-map"\n[[part]]\nname = "office"\nfile = "office.grid"\n'
    (tmp_path / "r.toml").write_text(text)
    world = generate(str(tmp_path / "r.toml"), 1)
    (tmp_path / "office.grid").unlink()
    made = world.provenance
    assert dumps(generate(made.family, made.seed, **made.params)) == dumps(world)


def test_a_foreign_map_travels_as_its_digest_and_a_change_is_noticed(tmp_path, monkeypatch):
    data = Path("corpora/maps/maze-32-32-2.map").read_text()
    (tmp_path / "m.map").write_text(data)
    (tmp_path / "r.toml").write_text('recipe = "maze"\n[[part]]\nname = "m"\nfile = "m.map"\n')
    made = generate(str(tmp_path / "r.toml"), 1, robot_radius=0.04).provenance
    assert made.params["files"]["m.map"].startswith("sha256:")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.map").write_text(data.replace(".", "@", 1))
    with raises(FormatError, "file-changed", path="m.map", place="part 'm'"):
        generate(made.family, made.seed, **made.params)


def test_a_set_on_a_foreign_map_is_made_from_another_folder(tmp_path):
    (tmp_path / "m.map").write_bytes(Path("corpora/maps/maze-32-32-2.map").read_bytes())
    (tmp_path / "r.toml").write_text('recipe = "maze"\n[[part]]\nname = "m"\nfile = "m.map"\n')
    made = ("compose", tmp_path / "r.toml", "--radius", 0.04, "--seed", 1)
    assert worldgen(*made, "--count", 2, "--out", tmp_path / "set").code == 0
    again = (
        "regenerate",
        tmp_path / "set",
        "--out",
        tmp_path / "again",
        "--family",
        tmp_path / "r.toml",
    )
    assert worldgen(*again).code == 0


def test_a_map_whose_cells_lie_in_another_file_is_noticed_when_they_change(tmp_path, monkeypatch):
    for name in ("mrpt-uwb-demo.yaml", "mrpt-uwb-demo.pgm"):
        (tmp_path / name).write_bytes(Path("corpora/maps", name).read_bytes())
    lines = (
        'recipe = "hall"',
        "[parameters]",
        "cell_size = 0.04",
        "robot_radius = 0.2",
        "[[part]]",
        'name = "m"',
    )
    (tmp_path / "r.toml").write_text("\n".join((*lines, 'file = "mrpt-uwb-demo.yaml"', "")))
    made = generate(str(tmp_path / "r.toml"), 1).provenance
    monkeypatch.chdir(tmp_path)
    pixels = bytearray((tmp_path / "mrpt-uwb-demo.pgm").read_bytes())
    pixels[len(pixels) // 2] ^= 0xFF
    (tmp_path / "mrpt-uwb-demo.pgm").write_bytes(pixels)
    with raises(FormatError, "file-changed"):
        generate(made.family, made.seed, **made.params)


def edited(old, new):
    assert old in SMALL
    return SMALL.replace(old, new)


FAULTS = {
    "no-toml": ("recipe = small", {"code": "not-toml", "line": 1, "noun": "the recipe"}),
    "no-name": (
        "[[part]]\nname = 'a'\nbox = [5, 5]",
        {"code": "not-a-name", "line": 1, "place": "recipe"},
    ),
    "no-part": ('recipe = "a"\n', {"code": "empty"}),
    "key": (
        edited("about =", "abuot ="),
        {"code": "unknown-name", "line": 1, "name": "abuot", "near": "about"},
    ),
    "parameter": (
        edited("least = 6", 'least = "six"'),
        {
            "code": "wrong-type",
            "line": 5,
            "name": "least",
            "value": "six",
            "place": "parameters.size",
        },
    ),
    "default": (
        edited("default = 12", "default = 2"),
        {"code": "out-of-range", "line": 5, "default": 2, "place": "parameters.size"},
    ),
    "choices": (
        edited('["left"', '["lift"'),
        {"code": "unknown-name", "line": 6, "default": "left", "place": "parameters.side"},
    ),
    "taken": (edited("side =", "seed ="), {"code": "wrong-declaration", "name": "seed"}),
    "keyword": (
        edited("side =", "class ="),
        {"code": "not-a-name", "line": 6, "place": "parameters.class"},
    ),
    "stream": (
        edited("side =", "rng ="),
        {"code": "not-a-name", "line": 6, "place": "parameters.rng"},
    ),
    "help": (edited("side =", "help ="), {"code": "wrong-declaration", "name": "help"}),
    "source": (
        edited('box = ["= size", "= size"]', ""),
        {"code": "wrong-count", "line": 15, "made_of": "nothing", "place": "part 'room'"},
    ),
    "part-key": (
        edited("rows =", "row ="),
        {"code": "wrong-count", "line": 8, "made_of": "nothing", "place": "part 'stone'"},
    ),
    "formula": (
        edited('box = ["= size"', 'box = ["= syze"'),
        {
            "code": "unknown-name",
            "line": 17,
            "name": "syze",
            "text": "syze",
            "place": "part 'room', box",
        },
    ),
    "power": (
        edited('box = ["= size"', 'box = ["= size ** 9"'),
        {"code": "wrong-form", "came": "'*'"},
    ),
    "verb": (
        edited("border", "boarder"),
        {"code": "unknown-name", "line": 18, "place": "part 'room', step 1"},
    ),
    "option": (edited("how =", "hwo ="), {"code": "unknown-name", "name": "hwo", "near": "how"}),
    "later": (
        edited('place = "stone"', 'place = "stones"'),
        {"code": "unknown-name", "name": "stones"},
    ),
    "value": (
        edited("{ from = 5", "{ form = 5"),
        {"code": "wrong-type", "value": "a table of form, to"},
    ),
    "twice": (edited('name = "room"', 'name = "stone"'), {"code": "twice", "name": "stone"}),
    "world": (
        edited("about =", 'world = "hall"\nabout ='),
        {"code": "unknown-name", "line": 2, "name": "hall", "place": "world"},
    ),
    "family": (
        edited("rows = ", "family = 'tarp' #"),
        {"code": "unknown-name", "name": "tarp", "noun": "family", "near": "trap"},
    ),
    "code": (
        edited("rows = ", "family = './x.py:y' #"),
        {"code": "unknown-name", "name": "./x.py:y"},
    ),
    "elsewhere": (
        edited("rows = ", "file = '../w.grid' #"),
        {"code": "outside-folder", "text": "../w.grid"},
    ),
    "drawing": (
        edited("##\n##", "##\n#"),
        {"code": "ragged-rows", "line": 10, "row": 2, "signs": 1, "width": 2},
    ),
    "absent": (
        edited("rows = ", "file = 'w.grid' #"),
        {"code": "unreadable", "place": "part 'stone'"},
    ),
}


@pytest.mark.parametrize(("text", "expected"), FAULTS.values(), ids=FAULTS)
def test_a_fault_in_a_recipe_is_one_message_with_its_place(text, expected, tmp_path):
    if '#"""' in text:
        text = text.replace('##\n##\n"""\n', "")
    (tmp_path / "r.toml").write_text(text)
    with raises(WorldgenError, **expected) as caught:
        family_from_recipe(tmp_path / "r.toml")
    # A fault in a formula is followed by the formula and a mark.
    first, *marked = str(caught.value).splitlines()
    assert first and (not marked or marked[1].strip() == "^")


UNFIT = {
    "size": (
        "{ border = 1 }",
        "{ border = -1 }",
        {
            "code": "not-a-number",
            "name": "border",
            "value": -1,
            "place": "part 'room', step 1 (border)",
        },
    ),
    "axis": (
        "{ border = 1 }",
        '{ mirror = "z" }',
        {"code": "unknown-name", "name": "mirror", "value": "z"},
    ),
    "huge": (
        "{ border = 1 }",
        "{ tile = [9999, 9999] }",
        {"code": "too-large", "what": "tile", "width": 119988, "height": 119988},
    ),
    "work": (
        "{ border = 1 }",
        "{ scale = 300 }, { keep = 'walls' }" + ", { fill = 'free' }" * 3,
        {"code": "too-large", "most": 64000000},
    ),
    "range": ("from = 5", "from = 50", {"code": "empty-range", "low": 50, "high": 7}),
    "zero": ("size - 5", "size // 0", {"code": "division-by-zero", "text": "size // 0"}),
    "grows": ("size - 5", "size * 9e99", {"code": "too-large", "text": "size * 9e99"}),
    "word": (
        "size - 5",
        "side",
        {"code": "not-a-number", "name": "side", "text": "side", "value": "left"},
    ),
    "shape": ("[2.5, 2.5]", "[2.5]", {"code": "wrong-form", "name": "start"}),
    "bits": ("from = 5", "from = -9223372036854775808", {"code": "too-large"}),
    "anchor": ('how = "union"', "anchor = [1]", {"code": "wrong-type", "name": "anchor"}),
    "mark": (
        "{ border = 1 }",
        "{ mark = [1], at = [1, 1] }",
        {"code": "wrong-type", "name": "mark"},
    ),
    "forget": ("{ border = 1 }", "{ forget = [[1]] }", {"code": "wrong-type", "name": "forget"}),
    "outside": ("[2.5, 2.5]", "[99, 1]", {"code": "outside-grid", "name": "start"}),
}


@pytest.mark.gate
@pytest.mark.parametrize(("old", "new", "expected"), UNFIT.values(), ids=UNFIT)
def test_what_does_not_fit_is_said_with_its_place(old, new, expected):
    with raises(InvalidParameter, **expected):
        generate(family_from_recipe(edited(old, new)), 1)


ROOM = 'name = "room"\nbox = ["= size", "= size"]'

BOUNDS = {
    "family": (
        'name = "room"\nfamily = "maze"\nparams = { size = 20000 }',
        {"code": "too-large", "what": "maze of size=20000", "width": 20000, "height": 20000},
    ),
    "draw": (
        'name = "room"\nfamily = "maze"\nparams = { size = { from = 19000, to = 20000 } }',
        {"code": "too-large"},
    ),
    "row": (
        f'name = "slab"\nbox = [200, 400]\n[[part]]\nname = "room"\nbeside = {["slab"] * 100}',
        {"code": "too-large", "most": 64000000, "place": "part 'room'"},
    ),
}


@pytest.mark.parametrize(("part", "expected"), BOUNDS.values(), ids=BOUNDS)
def test_too_many_cells_are_refused_before_they_are_made(part, expected):
    made_by = family_from_recipe(edited(ROOM, part))
    for _ in range(2):
        with raises(TooLarge, **expected) as refusal:
            generate(made_by, 1)
        assert "\n" not in str(refusal.value)


def test_a_recipe_asks_for_cells_before_it_makes_them_and_counts_those_that_are_made():
    work = RecipeCells()
    work.check(MOST_WORK)
    work.spend(MOST_WORK - 10)
    work.check(10)
    with raises(TooLarge, "too-large", most=64000000):
        work.check(11)


@given(
    st.integers(0, len(SMALL)),
    st.integers(0, 30),
    st.text(st.sampled_from('[]{}="\n#.,_$0123456789aepr\x00é'), max_size=8),
)
def test_a_damaged_recipe_makes_a_world_or_one_line(at, length, rubbish):
    try:
        generate(family_from_recipe(SMALL[:at] + rubbish + SMALL[at + length :] + "\n"), 1)
    except WorldgenError as error:
        assert "\n" not in str(error)


scalars = st.one_of(
    st.integers(-(2**70), 2**70), st.integers(-3, 12), st.floats(), st.booleans(), st.text(max_size=5),
    st.sampled_from(["stone", "= size", "= -1", "way", "anywhere", "x", "centre", "walls", "solid", "grow", "piece"]),
)  # fmt: skip
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.fixed_dictionaries({"from": inner, "to": inner})
        | st.fixed_dictionaries({"any": st.lists(inner, max_size=2)})
    ),
    max_leaves=5,
)


@given(st.data())
def test_steps_with_any_values_make_a_world_or_one_line(data):
    from worldgen.compose.recipe_text import VERBS
    from worldgen.files.grid.toml_text import value_text

    verb = data.draw(st.sampled_from(sorted(VERBS)))
    step = {
        key: data.draw(values, label=key)
        for key in (verb, *VERBS[verb])
        if key == verb or data.draw(st.booleans())
    }
    try:
        text = edited("{ border = 1 }", "{ border = 1 }, " + value_text(step, "step"))
        tomllib.loads(text)
        generate(family_from_recipe(text), 1)
    except WorldgenError as error:
        assert "\n" not in str(error)


def test_the_command_takes_a_recipes_parameters_as_options(tmp_path):
    out = tmp_path / "w.grid"
    done = worldgen("compose", EXAMPLES[0], "--seed", 7, "--teeth", 3, "--out", out)
    assert done.code == 0 and "recipe:double-comb 29 x 14 cells" in done.err
    again = worldgen(EXAMPLES[0], "--seed", 7, "--teeth", 3)
    assert again.out == out.read_text()


def test_help_of_a_recipe_lists_its_parameters():
    shown = worldgen("compose", EXAMPLES[0], "--help")
    assert (
        "--teeth INTEGER" in shown.out
        and "Teeth of each comb." in shown.out
        and "--recipe" not in shown.out
    )


def test_a_recipe_that_is_not_there_is_one_line():
    done = worldgen("compose", "absent.toml", "--seed", 1)
    assert done.code == 2 and done.error_code == "unreadable" and "Traceback" not in done.err


def test_a_recipe_is_found_among_the_families_and_read_afresh(tmp_path):
    (tmp_path / "r.toml").write_text(SMALL)
    first = FAMILIES.get(str(tmp_path / "r.toml"))
    (tmp_path / "r.toml").write_text(edited('"small"', '"smaller"'))
    assert (first.name, FAMILIES.get(str(tmp_path / "r.toml")).name) == (
        "recipe:small",
        "recipe:smaller",
    )


def test_a_set_of_a_recipes_worlds_is_made_again_from_its_manifest(tmp_path):
    folder = tmp_path / "set"
    done = worldgen("compose", EXAMPLES[0], "--seed", 7, "--count", 2, "--out", folder)
    assert done.code == 0 and (folder / "recipe-double-comb-8.grid").is_file()
    again = worldgen("regenerate", folder, "--out", tmp_path / "again")
    assert again.code == 0
    for file in folder.glob("*.grid"):
        assert (tmp_path / "again" / file.name).read_bytes() == file.read_bytes()


@pytest.mark.parametrize(
    "constraint", [(), ("--where", "detour > 1.1")], ids=["rising", "searched"]
)
def test_a_sets_manifest_has_the_text_of_its_recipe_once(constraint, tmp_path):
    folder = tmp_path / "set"
    done = worldgen("compose", EXAMPLES[0], "--seed", 7, "--count", 3, *constraint, "--out", folder)
    text = (folder / "manifest.jsonl").read_text()
    assert done.code == 0 and text.count('"recipe": ') == 1 and len(text.splitlines()) == 4
    assert worldgen("regenerate", folder / "manifest.jsonl", "--out", tmp_path / "again").code == 0
    for file in folder.glob("*.grid"):
        assert (tmp_path / "again" / file.name).read_bytes() == file.read_bytes()


def test_what_is_no_recipe_by_its_name_is_refused():
    done = worldgen("compose", "recipe.txt", "--seed", 1)
    assert done.code == 2 and done.error_code == "wrong-suffix"


@pytest.mark.parametrize("check", [*FAMILY_CHECKS, *CHECKS], ids=str)
def test_a_recipe_keeps_what_every_family_promises(check):
    check(FAMILIES.get("examples/recipes/trap-in-maze.toml"), {"size": 30, "trap": 12})
